// What a layer promises beside triangles over which none is valid.
#pragma once

#include <recede/shells/shell.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace recede::test {

/// That the layer over all triangles but the excused ones is valid by itself, as an independent check sees
/// it, and that every fault in the report is one of excused triangles among themselves.
inline void expect_valid_elsewhere(const Shell& shell, const ShellLayer& layer, bool is_inward) {
  EXPECT_TRUE(layer.is_valid_elsewhere);
  std::vector<Index> all_excused = layer.excused;
  all_excused.insert(all_excused.end(), layer.given_up.begin(), layer.given_up.end());
  std::sort(all_excused.begin(), all_excused.end());
  EXPECT_EQ(std::adjacent_find(all_excused.begin(), all_excused.end()), all_excused.end());
  EXPECT_EQ(layer.validity.is_valid(), all_excused.empty());
  const auto is_excused = [&](Index t) {
    return std::binary_search(all_excused.begin(), all_excused.end(), t);
  };
  std::vector<Index> rest;
  for (std::size_t t = 0; t < shell.base.n_faces(); ++t) {
    if (is_excused(static_cast<Index>(t))) continue;
    for (const Index v : shell.base.face(t)) rest.push_back(v);
  }
  ShellCheckOptions inward;
  inward.is_inward = is_inward;
  EXPECT_TRUE(check_shell(shell.base.positions, layer.tops, rest, inward).is_valid());
  const ShellValidity all = check_shell(shell.base.positions, layer.tops, shell.base.corner_vertices, inward);
  EXPECT_EQ(all, layer.validity) << "the report is of the layer that it comes with";
  for (const Index t : all.inverted) EXPECT_TRUE(is_excused(t)) << t << " is inverted";
  for (const ShellValidity::Pairs* pairs :
       {&all.bottom_contacts, &all.overlapping_neighbours, &all.top_contacts, &all.layer_contacts}) {
    for (const auto& [a, b] : *pairs) EXPECT_TRUE(is_excused(a) && is_excused(b)) << a << " meets " << b;
  }
  for (const WallContact& contact : all.wall_contacts) {
    const Index other = contact.part == ShellPart::wall ? contact.other / 3 : contact.other;
    EXPECT_TRUE(is_excused(contact.corner / 3) && is_excused(other)) << "a wall meets " << other;
  }
}

}  // namespace recede::test
