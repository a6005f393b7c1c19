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

// A line of text, six whole numbers of 32 bits, six doubles, the shares of normals and the values of the
// shading as doubles, all little-endian. Other tables are made from these.
constexpr std::string_view k_head = "recede appearance 1\n";
constexpr std::size_t k_counts = 6, k_lengths = 6;
constexpr std::uint32_t k_most = 1024;  // of each count, as the options have it

}  // namespace

void write_appearance(const std::filesystem::path& path, const Appearance& appearance) {
  const VisibleNormals& normals = appearance.normals();
  const ReflectanceTable& table = appearance.table();
  const std::optional<ScatteringTable>& shading = appearance.shading();
  std::string bytes(k_head);
  for (const int count : {normals.bins, normals.views, normals.azimuths, table.light_angles,
                          table.light_azimuths, shading ? shading->orders : 0})
    detail::append_bytes(bytes, static_cast<std::uint32_t>(count));
  const MapStretch& stretch = appearance.stretch();
  for (const double length : {stretch.sides.x(), stretch.sides.y(), stretch.spread.x(), stretch.spread.y(),
                              appearance.wavelength(), shading ? shading->hits_again : 0.0})
    detail::append_bytes(bytes, std::bit_cast<std::uint64_t>(length));
  for (const double share : normals.shares) detail::append_bytes(bytes, std::bit_cast<std::uint64_t>(share));
  if (shading) {
    for (const double value : shading->values)
      detail::append_bytes(bytes, std::bit_cast<std::uint64_t>(value));
  }
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
    const bool is_orders = i == k_counts - 1;
    const std::uint32_t least = is_orders ? 0 : i == 3 ? 2 : 1;
    if (count < least || count > (is_orders ? ScatteringTable::k_most_orders : k_most))
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
  ScatteringTable shading{.views = counts[1],
                          .azimuths = counts[2],
                          .light_angles = counts[3],
                          .light_azimuths = counts[4],
                          .orders = counts[5],
                          .hits_again = lengths[5]};
  const std::size_t factors = shading.slice_count() * shading.slice_size();
  if (bytes.size() - start != (shares + factors) * 8)
    throw InputError::in_file(name, "the file is longer or shorter than its distributions");
  const auto number = [&](std::size_t i) {
    return std::bit_cast<double>(detail::number_at<std::uint64_t>(bytes, start + 8 * i));
  };
  for (std::size_t i = 0; i < shares; ++i) normals.shares.push_back(number(i));
  for (std::size_t i = shares; i < shares + factors; ++i) {
    if (!(number(i) >= 0) || !std::isfinite(number(i)))
      throw InputError::at_byte(name, start + 8 * i, "a factor of light out of range");
    shading.values.push_back(number(i));
  }
  const MapStretch stretch{{lengths[0], lengths[1]}, {lengths[2], lengths[3]}};
  try {
    return std::make_shared<const Appearance>(
        stretch, lengths[4], std::move(normals),
        AppearanceOptions{.reflectance = {.light_angles = counts[3], .light_azimuths = counts[4]}},
        shading.orders > 0 ? std::optional(std::move(shading)) : std::nullopt);
  } catch (const InputError& error) {
    throw InputError::in_file(name, error.what());
  }
}

}  // namespace recede
