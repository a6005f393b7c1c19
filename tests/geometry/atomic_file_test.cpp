#include "temp_folder.h"
#include <recede/geometry/atomic_file.h>

#include <gtest/gtest.h>

namespace recede {
namespace {

// Around the sizes in which a file is read.
TEST(AtomicFile, IsReadAsItWasWritten) {
  const test::TempFolder folder;
  constexpr std::size_t k_block = std::size_t{1} << 20;
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{4095}, std::size_t{4096},
                                 std::size_t{4097}, k_block - 1, k_block, k_block + 1, 3 * k_block + 7}) {
    std::string content(size, '\0');
    for (std::size_t i = 0; i < size; ++i) content[i] = static_cast<char>(i * i % 251);
    write_file_atomically(folder / "a", content);
    EXPECT_EQ(read_whole_file(folder / "a"), content) << size;
  }
}

// As those of the kernel have.
TEST(AtomicFile, IsReadWhenItSaysNoSize) {
  EXPECT_NE(read_whole_file("/proc/self/status").find("VmRSS"), std::string::npos);
}

}  // namespace
}  // namespace recede
