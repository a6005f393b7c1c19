// A folder for files that nobody wants to keep.
#pragma once

#include <filesystem>
#include <string>

namespace recede::bench {

/// It goes with everything in it.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// The text with names of files alone where they had the folder's in front.
  std::string without_folder(std::string text) const;

 private:
  std::filesystem::path path_;
};

}  // namespace recede::bench
