#include <recede/geometry/error.h>

#include <fmt/format.h>

namespace recede {

InputError InputError::in_file(const std::string& path, const std::string& reason) {
  return InputError(fmt::format("{}: {}", path, reason));
}

InputError InputError::at_line(const std::string& path, std::size_t line, const std::string& reason) {
  return InputError(fmt::format("{}:{}: {}", path, line, reason));
}

InputError InputError::at_byte(const std::string& path, std::size_t offset, const std::string& reason) {
  return InputError(fmt::format("{}: byte {}: {}", path, offset, reason));
}

}  // namespace recede
