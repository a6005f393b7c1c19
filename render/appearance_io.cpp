#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/render/appearance.h>
#include <recede/render/detail/number_bytes.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

namespace recede {
namespace {

// A line of text, six whole numbers of 32 bits, five doubles and the shares of normals as doubles, all
// little-endian. Tables are made from these.
constexpr std::string_view k_head = "recede appearance 1\n";
constexpr std::size_t k_counts = 6, k_lengths = 5;
constexpr std::uint32_t k_most = 1024;  // of each count, as the options have it

}  // namespace

void write_appearance(const std::filesystem::path& path, const Appearance& appearance) {
  const VisibleNormals& normals = appearance.normals();
  const ReflectanceTable& table = appearance.table();
  std::string bytes(k_head);
  for (const int count :
       {normals.bins, normals.views, normals.azimuths, table.light_angles, table.light_azimuths, 0})
    detail::append_bytes(bytes, static_cast<std::uint32_t>(count));
  const MapStretch& stretch = appearance.stretch();
  for (const double length : {stretch.sides.x(), stretch.sides.y(), stretch.spread.x(), stretch.spread.y(),
                              appearance.wavelength()})
    detail::append_bytes(bytes, std::bit_cast<std::uint64_t>(length));
  for (const double share : normals.shares) detail::append_bytes(bytes, std::bit_cast<std::uint64_t>(share));
  write_file_atomically(path, bytes);
}

std::shared_ptr<const Appearance> read_appearance(const std::filesystem::path& path) {
  const std::string bytes = read_whole_file(path), name = path.string();
  const std::size_t start = k_head.size() + k_counts * 4 + k_lengths * 8;
  if (!std::string_view(bytes).starts_with(k_head) || bytes.size() < start)
    throw InputError::in_file(name, "this is no appearance");
  std::array<int, k_counts> counts{};
  for (std::size_t i = 0; i < k_counts; ++i) {
    const std::size_t at = k_head.size() + 4 * i;
    const auto count = detail::number_at<std::uint32_t>(bytes, at);
    if (i < k_counts - 1 ? count < (i == 3 ? 2u : 1u) || count > k_most : count != 0)
      throw InputError::at_byte(name, at, "a count out of range");
    counts[i] = static_cast<int>(count);
  }
  std::array<double, k_lengths> lengths{};
  for (std::size_t i = 0; i < k_lengths; ++i) {
    const std::size_t at = k_head.size() + 4 * k_counts + 8 * i;
    lengths[i] = std::bit_cast<double>(detail::number_at<std::uint64_t>(bytes, at));
    if (!(lengths[i] >= 0) || !std::isfinite(lengths[i]) || (i < 2 && lengths[i] == 0))
      throw InputError::at_byte(name, at, "a length out of range");
  }
  VisibleNormals normals{.bins = counts[0], .views = counts[1], .azimuths = counts[2]};
  const std::size_t shares = normals.slice_count() * normals.bin_count();
  if (bytes.size() - start != shares * 8)
    throw InputError::in_file(name, "the file is longer or shorter than its distributions");
  for (std::size_t i = 0; i < shares; ++i)
    normals.shares.push_back(std::bit_cast<double>(detail::number_at<std::uint64_t>(bytes, start + 8 * i)));
  const MapStretch stretch{{lengths[0], lengths[1]}, {lengths[2], lengths[3]}};
  try {
    return std::make_shared<const Appearance>(
        stretch, lengths[4], std::move(normals),
        AppearanceOptions{.reflectance = {.light_angles = counts[3], .light_azimuths = counts[4]}});
  } catch (const InputError& error) {
    throw InputError::in_file(name, error.what());
  }
}

}  // namespace recede
