// Room on the disk for what memory doesn't hold.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

namespace recede::detail {

/// A file without a name, which goes with the process, however that ends.
class ScratchFile {
 public:
  /// In a folder that exists. Throws `InputError` with the system's reason, as all functions do.
  explicit ScratchFile(const std::filesystem::path& folder);
  ~ScratchFile();
  ScratchFile(ScratchFile&& other) noexcept
      : folder_(std::move(other.folder_)), file_(std::exchange(other.file_, -1)), size_(other.size_) {}
  ScratchFile& operator=(ScratchFile&&) = delete;

  /// A place in the file.
  struct Extent {
    std::size_t offset = 0, size = 0;
  };
  Extent append(std::string_view bytes);
  std::string read(const Extent& extent) const;

 private:
  [[noreturn]] void fail(int error) const;
  std::filesystem::path folder_;
  int file_ = -1;
  std::size_t size_ = 0;
};

}  // namespace recede::detail
