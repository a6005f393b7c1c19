#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

namespace recede {

namespace fs = std::filesystem;

namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

[[noreturn]] void fail(const fs::path& path, int error) {
  throw InputError::in_file(path.string(), std::strerror(error));
}

}  // namespace

void write_file_atomically(const fs::path& path, std::string_view content) {
  // The process id keeps two writers of one target apart; the last rename wins, and both files were whole.
  const fs::path beside = path.string() + ".part" + std::to_string(::getpid());
  File file(std::fopen(beside.c_str(), "wb"));
  if (!file) fail(path, errno);
  // Of the first call that fails: a success may leave any number in errno.
  int error = std::fwrite(content.data(), 1, content.size(), file.get()) == content.size() ? 0 : errno;
  if (std::fclose(file.release()) != 0 && error == 0) error = errno;
  if (error != 0) {
    std::remove(beside.c_str());
    fail(path, error);
  }
  std::error_code renamed;
  fs::rename(beside, path, renamed);
  if (renamed) {
    std::remove(beside.c_str());
    throw InputError::in_file(path.string(), renamed.message());
  }
}

std::string read_whole_file(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) throw InputError::in_file(path.string(), "is a folder");
  File file(std::fopen(path.c_str(), "rb"));
  if (!file) fail(path, errno);
  std::string content;
  const auto size = fs::file_size(path, ignored);
  // A megabyte a read: few calls, little slack. Less where the file ends, which may also grow or have no
  // size.
  constexpr std::size_t k_block = std::size_t{1} << 20, k_least = 4096;
  const std::size_t expected = ignored ? 0 : size;
  content.reserve(expected + k_least);
  for (;;) {
    const std::size_t before = content.size(), left = expected - std::min(expected, before),
                      block = std::clamp(left, k_least, k_block);
    content.resize(before + block);
    const std::size_t got = std::fread(content.data() + before, 1, block, file.get());
    content.resize(before + got);
    if (got == 0) break;
  }
  if (std::ferror(file.get()) != 0) fail(path, errno);
  return content;
}

}  // namespace recede
