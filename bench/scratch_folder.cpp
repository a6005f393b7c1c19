#include "scratch_folder.h"

#include <stdlib.h>

#include <cerrno>
#include <system_error>

namespace recede::bench {

ScratchFolder::ScratchFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "recede-bench-XXXXXX").string();
  if (::mkdtemp(pattern.data()) == nullptr)
    throw std::filesystem::filesystem_error("no folder", pattern, {errno, std::generic_category()});
  path_ = pattern;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string ScratchFolder::without_folder(std::string text) const {
  const std::string name = path_.string() + '/';
  for (std::size_t at; (at = text.find(name)) != text.npos;) text.erase(at, name.size());
  return text;
}

}  // namespace recede::bench
