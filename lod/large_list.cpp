#include <recede/lod/detail/large_list.h>

#include <new>

#ifdef __linux__
#include <sys/mman.h>

#include <cstdint>
#endif

namespace recede::detail {

#ifdef __linux__

namespace {

constexpr std::size_t k_page = std::size_t{1} << 21;

/// Bytes that a list takes from the system: whole small pages.
std::size_t mapped_size(std::size_t bytes) { return (bytes + 4095) / 4096 * 4096; }

}  // namespace

void* allocate_bytes(std::size_t bytes) {
  if (bytes < k_page) return ::operator new(bytes);
  // Room to begin at a large page; what is left over at both ends goes back at once.
  const std::size_t size = mapped_size(bytes);
  void* memory = ::mmap(nullptr, size + k_page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  auto* const raw = static_cast<char*>(memory);
  const std::size_t skipped = (k_page - reinterpret_cast<std::uintptr_t>(raw) % k_page) % k_page;
  if (skipped > 0) ::munmap(raw, skipped);
  if (skipped < k_page) ::munmap(raw + skipped + size, k_page - skipped);
  // Only where large pages fit as a whole, so that none is wasted.
  ::madvise(raw + skipped, size / k_page * k_page, MADV_HUGEPAGE);
  return raw + skipped;
}

void free_bytes(void* memory, std::size_t bytes) {
  if (bytes < k_page) return ::operator delete(memory);
  ::munmap(memory, mapped_size(bytes));
}

#else

void* allocate_bytes(std::size_t bytes) { return ::operator new(bytes); }
void free_bytes(void* memory, std::size_t) { ::operator delete(memory); }

#endif

}  // namespace recede::detail
