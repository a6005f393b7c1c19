// What tests of progressive meshes and of their files have in common.
#pragma once

#include "hard_cases.h"
#include "same_bits.h"
#include <recede/lod/detail/byte_streams.h>
#include <recede/lod/detail/pmesh_chunks.h>
#include <recede/lod/progressive_mesh.h>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace recede::test {

/// All lists bit by bit, the signs of zeros too.
inline void expect_same_bits(const PolygonSoup& a, const PolygonSoup& b) {
  EXPECT_EQ(first_difference(a, b), "");
}

inline ProgressiveOptions options_for(CostPolicy cost, VertexPlacement placement, bool prove = false) {
  ProgressiveOptions options;
  options.simplify.cost = cost;
  options.simplify.placement = placement;
  options.simplify.prove_error = prove;
  return options;
}

inline std::vector<ProgressiveOptions> all_ways() {
  using enum VertexPlacement;
  return {options_for(CostPolicy::volume, half_edge), options_for(CostPolicy::volume, midpoint),
          options_for(CostPolicy::volume, optimal), options_for(CostPolicy::normal_deviation, half_edge),
          options_for(CostPolicy::normal_deviation, midpoint)};
}

inline std::string case_name(const testing::TestParamInfo<HardCase>& info) {
  std::string name = info.param.name;
  for (char& c : name) {
    if (!isalnum(static_cast<unsigned char>(c))) c = '_';
  }
  return name;
}

/// Makes the checksums of a changed file right, as far as its parts can be told apart.
inline void repair_checksums(std::string& bytes) {
  std::size_t at = detail::k_pmesh_start;
  while (at + detail::k_chunk_header <= bytes.size()) {
    const std::size_t size = detail::read_u32(std::string_view(bytes).substr(at + 4));
    if (size > bytes.size() - at - detail::k_chunk_header) return;
    const std::uint32_t crc =
        detail::crc32(bytes.substr(at, 4) + bytes.substr(at + detail::k_chunk_header, size));
    for (std::size_t i = 0; i < 4; ++i) bytes[at + 8 + i] = static_cast<char>(crc >> (8 * i));
    at += detail::k_chunk_header + size;
  }
}

/// The polygons as lists of positions, wherever they start and in whatever order.
inline std::vector<std::vector<std::array<double, 3>>> polygons_of(const PolygonSoup& soup) {
  std::vector<std::vector<std::array<double, 3>>> polygons;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    auto& polygon = polygons.emplace_back();
    for (const Index v : soup.face(f)) {
      const Vec3& p = soup.positions[v];
      polygon.push_back({p.x(), p.y(), p.z()});
    }
    std::rotate(polygon.begin(), std::min_element(polygon.begin(), polygon.end()), polygon.end());
  }
  std::sort(polygons.begin(), polygons.end());
  return polygons;
}

}  // namespace recede::test
