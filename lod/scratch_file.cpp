#include <recede/geometry/error.h>
#include <recede/lod/detail/scratch_file.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace recede::detail {

ScratchFile::ScratchFile(const std::filesystem::path& folder) : folder_(folder) {
#ifdef O_TMPFILE  // Linux
  file_ = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (file_ >= 0) return;
#endif
  // Not everywhere: a name that is gone at once.
  std::string name = (folder / "recede.scratchXXXXXX").string();
  file_ = ::mkostemp(name.data(), O_CLOEXEC);
  if (file_ < 0) fail(errno);
  ::unlink(name.c_str());
}

ScratchFile::~ScratchFile() {
  if (file_ >= 0) ::close(file_);
}

void ScratchFile::fail(int error) const {
  throw InputError::in_file(folder_.string(), std::string("scratch file: ") + std::strerror(error));
}

ScratchFile::Extent ScratchFile::append(std::string_view bytes) {
  const Extent extent{size_, bytes.size()};
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(file_, bytes.data(), bytes.size(), static_cast<off_t>(size_));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail(written < 0 ? errno : ENOSPC);
    bytes.remove_prefix(static_cast<std::size_t>(written));
    size_ += static_cast<std::size_t>(written);
  }
  return extent;
}

std::string ScratchFile::read(const Extent& extent) const {
  std::string bytes(extent.size, '\0');
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t got =
        ::pread(file_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(extent.offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) fail(got < 0 ? errno : EIO);
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

}  // namespace recede::detail
