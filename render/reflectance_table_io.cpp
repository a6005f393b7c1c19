#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/render/detail/number_bytes.h>
#include <recede/render/reflectance_table.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

namespace recede {
namespace {

constexpr std::string_view k_head = "recede reflectance 1\n";
constexpr int k_most = 1024;  // of each count, as the options have it

std::size_t value_count(const ReflectanceTable& table) {
  return static_cast<std::size_t>(table.views + 1) * static_cast<std::size_t>(table.azimuths) *
         table.slice_size();
}

}  // namespace

void write_reflectance_table(const std::filesystem::path& path, const ReflectanceTable& table) {
  if (table.values.empty() || table.values.size() != value_count(table))
    throw InputError::in_file(path.string(), "the table must have one value for each pair of directions");
  std::string bytes(k_head);
  for (const int count : {table.views, table.azimuths, table.light_angles, table.light_azimuths, 0})
    detail::append_bytes(bytes, static_cast<std::uint32_t>(count));
  for (const double value : table.values) detail::append_bytes(bytes, std::bit_cast<std::uint64_t>(value));
  write_file_atomically(path, bytes);
}

ReflectanceTable read_reflectance_table(const std::filesystem::path& path) {
  const std::string bytes = read_whole_file(path);
  const std::string name = path.string();
  constexpr std::size_t k_counts = 5 * sizeof(std::uint32_t);
  if (!std::string_view(bytes).starts_with(k_head) || bytes.size() < k_head.size() + k_counts)
    throw InputError::in_file(name, "this is no reflectance table");
  int counts[4];
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t at = k_head.size() + 4 * i;
    const auto count = detail::number_at<std::uint32_t>(bytes, at);
    if (count < (i == 2 ? 2u : 1u) || count > k_most)
      throw InputError::at_byte(name, at, "a count out of range");
    counts[i] = static_cast<int>(count);
  }
  ReflectanceTable table{
      .views = counts[0], .azimuths = counts[1], .light_angles = counts[2], .light_azimuths = counts[3]};
  const std::size_t start = k_head.size() + k_counts;
  if (bytes.size() - start != value_count(table) * sizeof(double))
    throw InputError::in_file(name, "the file is longer or shorter than its table");
  for (std::size_t at = start; at < bytes.size(); at += sizeof(double)) {
    const auto value = std::bit_cast<double>(detail::number_at<std::uint64_t>(bytes, at));
    if (!(value >= 0) || !std::isfinite(value))
      throw InputError::at_byte(name, at, "a value is negative or not finite");
    table.values.push_back(value);
  }
  return table;
}

}  // namespace recede
