#include <recede/geometry/detail/mapped_file.h>
#include <recede/geometry/error.h>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace recede::detail {

MappedFile::MappedFile(const std::filesystem::path& path) {
  const auto fail = [&](int error) { throw InputError::in_file(path.string(), std::strerror(error)); };
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) fail(errno);
  struct stat status {};
  const bool is_known = ::fstat(file, &status) == 0;
  int error = is_known ? 0 : errno;
  if (is_known && S_ISDIR(status.st_mode)) error = EISDIR;
  size_ = error == 0 ? static_cast<std::size_t>(status.st_size) : 0;
  if (size_ > 0) {
    void* const memory = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file, 0);
    if (memory == MAP_FAILED) error = errno;
    data_ = static_cast<char*>(memory);
  }
  ::close(file);
  if (error != 0) fail(error);
}

MappedFile::~MappedFile() {
  if (size_ > 0) ::munmap(data_, size_);
}

void MappedFile::release() const {
  if (size_ > 0) ::madvise(data_, size_, MADV_DONTNEED);
}

}  // namespace recede::detail
