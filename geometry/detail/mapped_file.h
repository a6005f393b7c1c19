// A file as memory that the system fills when it is looked at, and may take back.
#pragma once

#include <filesystem>
#include <string_view>

namespace recede::detail {

class MappedFile {
 public:
  /// Throws `InputError` with the system's reason.
  explicit MappedFile(const std::filesystem::path& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::string_view bytes() const { return {data_, size_}; }
  /// Gives the memory back. The bytes stay where they are and are read anew when they are looked at.
  void release() const;

 private:
  char* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace recede::detail
