#include "layer_faults.h"

#include <algorithm>

namespace recede::bench {

std::size_t faults_beside_named(const Shell& shell, const ShellLayer& layer, ShellSide side) {
  std::vector<unsigned char> is_named(shell.base.n_faces(), 0);
  for (const std::vector<Index>* list : {&layer.excused, &layer.given_up})
    for (const Index triangle : *list) is_named[triangle] = 1;
  ShellCheckOptions options;
  options.is_inward = side == ShellSide::interior;
  const ShellValidity found =
      check_shell(shell.base.positions, layer.tops, shell.base.corner_vertices, options);
  std::size_t faults = 0;
  for (const Index triangle : found.inverted)
    if (is_named[triangle] == 0) ++faults;
  // What the named ones do among themselves is theirs; pieces that lie in others are told by one triangle of
  // each, which needn't be one of those.
  for (const ShellValidity::Pairs* pairs :
       {&found.bottom_contacts, &found.top_contacts, &found.layer_contacts, &found.overlapping_neighbours}) {
    for (const auto& [a, b] : *pairs)
      if (is_named[a] == 0 || is_named[b] == 0) ++faults;
  }
  for (const WallContact& contact : found.wall_contacts) {
    const Index other = contact.part == ShellPart::wall ? contact.other / 3 : contact.other;
    if (is_named[contact.corner / 3] == 0 || is_named[other] == 0) ++faults;
  }
  return faults;
}

}  // namespace recede::bench
