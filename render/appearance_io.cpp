#include <recede/geometry/atomic_file.h>
#include <recede/geometry/detail/number_bytes.h>
#include <recede/geometry/error.h>
#include <recede/render/appearance.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

namespace recede {
namespace {

// A line of text, seven whole numbers of 32 bits, six doubles, and as doubles the shares of normals, the
// light of the bump map and the values of the shading, where there are some; all little-endian. Other tables
// are made from these.
constexpr std::string_view k_head = "recede appearance 1\n";
constexpr std::size_t k_counts = 7, k_lengths = 6;
constexpr std::uint32_t k_most = 1024;  // of each count, as the options have it

}  // namespace

void write_appearance(const std::filesystem::path& path, const Appearance& appearance) {
  const VisibleNormals& normals = appearance.normals();
  const ReflectanceTable& table = appearance.table();
  const std::optional<ReflectanceTable>& bump = appearance.tables().bump_light;
  const std::optional<ScatteringTable>& shading = appearance.tables().shading;
  std::string bytes(k_head);
  for (const int count : {normals.bins, normals.views, normals.azimuths, table.light_angles,
                          table.light_azimuths, bump ? 1 : 0, shading ? shading->orders : 0})
    detail::append_bytes(bytes, static_cast<std::uint32_t>(count));
  const MapStretch& stretch = appearance.stretch();
  for (const double length : {stretch.sides.x(), stretch.sides.y(), stretch.spread.x(), stretch.spread.y(),
                              appearance.wavelength(), shading ? shading->hits_again : 0.0})
    detail::append_bytes(bytes, std::bit_cast<std::uint64_t>(length));
  for (const double share : normals.shares) detail::append_bytes(bytes, std::bit_cast<std::uint64_t>(share));
  const auto append = [&](const std::vector<double>& values) {
    for (const double value : values) detail::append_bytes(bytes, std::bit_cast<std::uint64_t>(value));
  };
  if (bump) append(bump->values);
  if (shading) append(shading->values);
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
    const std::uint32_t least = i >= 5 ? 0 : i == 3 ? 2 : 1;
    const std::uint32_t most = i == 6 ? ScatteringTable::k_most_orders : i == 5 ? 1 : k_most;
    if (count < least || count > most) throw InputError::at_byte(name, at, "a count out of range");
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
  ReflectanceTable bump{
      .views = counts[1], .azimuths = counts[2], .light_angles = counts[3], .light_azimuths = counts[4]};
  ScatteringTable shading{.views = counts[1],
                          .azimuths = counts[2],
                          .light_angles = counts[3],
                          .light_azimuths = counts[4],
                          .orders = counts[6],
                          .hits_again = lengths[5]};
  const std::size_t lights = counts[5] == 0 ? 0 : shading.slice_count() * bump.slice_size();
  const std::size_t factors = shading.slice_count() * shading.slice_size();
  if (bytes.size() - start != (shares + lights + factors) * 8)
    throw InputError::in_file(name, "the file is longer or shorter than its distributions");
  std::size_t next = start;
  const auto read = [&](std::size_t count, std::vector<double>& values) {
    for (const std::size_t end = next + 8 * count; next < end; next += 8) {
      values.push_back(std::bit_cast<double>(detail::number_at<std::uint64_t>(bytes, next)));
      if (!(values.back() >= 0) || !std::isfinite(values.back()))
        throw InputError::at_byte(name, next, "a number is negative or not finite");
    }
  };
  read(shares, normals.shares);
  read(lights, bump.values);
  read(factors, shading.values);
  AppearanceTables tables{.stretch = {{lengths[0], lengths[1]}, {lengths[2], lengths[3]}},
                          .wavelength = lengths[4],
                          .normals = std::move(normals)};
  if (lights > 0) tables.bump_light = std::move(bump);
  if (factors > 0) tables.shading = std::move(shading);
  const AppearanceOptions options{.reflectance = {.light_angles = counts[3], .light_azimuths = counts[4]}};
  try {
    return std::make_shared<const Appearance>(std::move(tables), options);
  } catch (const InputError& error) {
    throw InputError::in_file(name, error.what());
  }
}

}  // namespace recede
