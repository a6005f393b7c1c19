#include <recede/geometry/atomic_file.h>
#include <recede/geometry/detail/number_bytes.h>
#include <recede/geometry/error.h>
#include <recede/render/reflectance_table.h>
#include <recede/render/scattering_table.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace recede {
namespace {

constexpr std::string_view k_head = "recede reflectance 1\n";
constexpr int k_most = 1024;  // of each count, as the options have it

/// Views, azimuths, light angles, light azimuths, orders of scattering; 0 orders: direct light without
/// shadows, one value for each pair of directions.
using Counts = std::array<int, 5>;

std::size_t value_count(const Counts& counts) {
  std::size_t count = static_cast<std::size_t>(counts[0] + 1);
  for (std::size_t i = 1; i < 4; ++i) count *= static_cast<std::size_t>(counts[i]);
  return count * static_cast<std::size_t>(std::max(counts[4], 1));
}

/// `extra` are numbers that stand before the values.
void write_table(const std::filesystem::path& path, const Counts& counts, std::span<const double> extra,
                 std::span<const double> values) {
  if (values.empty() || values.size() != value_count(counts))
    throw InputError::in_file(path.string(), "the table must have one value for each pair of directions");
  std::string bytes(k_head);
  for (const int count : counts) detail::append_bytes(bytes, static_cast<std::uint32_t>(count));
  for (const double value : extra) detail::append_bytes(bytes, std::bit_cast<std::uint64_t>(value));
  for (const double value : values) detail::append_bytes(bytes, std::bit_cast<std::uint64_t>(value));
  write_file_atomically(path, bytes);
}

struct Table {
  Counts counts{};
  std::vector<double> values;  // with those before them
};

/// `most_orders`: 0 for a table without orders.
Table read_table(const std::filesystem::path& path, int most_orders) {
  const std::string bytes = read_whole_file(path);
  const std::string name = path.string();
  Table table;
  const std::size_t start = k_head.size() + table.counts.size() * sizeof(std::uint32_t);
  if (!std::string_view(bytes).starts_with(k_head) || bytes.size() < start)
    throw InputError::in_file(name, "this is no reflectance table");
  for (std::size_t i = 0; i < table.counts.size(); ++i) {
    const std::size_t at = k_head.size() + sizeof(std::uint32_t) * i;
    const auto count = detail::number_at<std::uint32_t>(bytes, at);
    const int least = i == 2   ? 2
                      : i == 4 ? std::min(most_orders, 1)
                               : 1,
              most = i == 4 ? most_orders : k_most;
    if (count < static_cast<std::uint32_t>(least) || count > static_cast<std::uint32_t>(most))
      throw InputError::at_byte(name, at, i == 4 ? "another kind of table" : "a count out of range");
    table.counts[i] = static_cast<int>(count);
  }
  const std::size_t extra = most_orders > 0 ? 1 : 0;
  if (bytes.size() - start != (value_count(table.counts) + extra) * sizeof(double))
    throw InputError::in_file(name, "the file is longer or shorter than its table");
  for (std::size_t at = start; at < bytes.size(); at += sizeof(double)) {
    const auto value = std::bit_cast<double>(detail::number_at<std::uint64_t>(bytes, at));
    if (!(value >= 0) || !std::isfinite(value))
      throw InputError::at_byte(name, at, "a value is negative or not finite");
    table.values.push_back(value);
  }
  return table;
}

}  // namespace

void write_reflectance_table(const std::filesystem::path& path, const ReflectanceTable& table) {
  write_table(path, {table.views, table.azimuths, table.light_angles, table.light_azimuths, 0}, {},
              table.values);
}

ReflectanceTable read_reflectance_table(const std::filesystem::path& path) {
  Table table = read_table(path, 0);
  const auto [views, azimuths, light_angles, light_azimuths, orders] = table.counts;
  return {.views = views,
          .azimuths = azimuths,
          .light_angles = light_angles,
          .light_azimuths = light_azimuths,
          .values = std::move(table.values)};
}

void write_scattering_table(const std::filesystem::path& path, const ScatteringTable& table) {
  if (table.orders < 1 || table.orders > ScatteringTable::k_most_orders)
    throw InputError::in_file(path.string(), "the table must have one to eight orders");
  write_table(path, {table.views, table.azimuths, table.light_angles, table.light_azimuths, table.orders},
              std::array{table.hits_again}, table.values);
}

ScatteringTable read_scattering_table(const std::filesystem::path& path) {
  Table table = read_table(path, ScatteringTable::k_most_orders);
  const auto [views, azimuths, light_angles, light_azimuths, orders] = table.counts;
  ScatteringTable result{.views = views,
                         .azimuths = azimuths,
                         .light_angles = light_angles,
                         .light_azimuths = light_azimuths,
                         .orders = orders,
                         .hits_again = table.values.front()};
  if (result.hits_again > 1)
    throw InputError::in_file(path.string(), "more light meets the surface again than left");
  result.values.assign(table.values.begin() + 1, table.values.end());
  return result;
}

}  // namespace recede
