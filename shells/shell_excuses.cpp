#include <recede/geometry/detail/plane_predicates.h>
#include <recede/shells/detail/shell_excuses.h>

#include <algorithm>

namespace recede::detail {

namespace {

// Exact, as that of prisms is.
bool has_area(const Vec3& a, const Vec3& b, const Vec3& c) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto flat = [&](const Vec3& p) { return Vec2(p[(axis + 1) % 3], p[(axis + 2) % 3]); };
    if (orientation(flat(a), flat(b), flat(c)) != 0) return true;
  }
  return false;
}

}  // namespace

std::vector<Index> find_excused_triangles(const ShellSurface& surface, const ShellValidity& validity) {
  const std::size_t n = surface.triangles.size() / 3;
  // Around a hopeless vertex no prisms fit together, in whatever direction they stand.
  std::vector<unsigned char> is_excused(n, 0), is_hopeless(surface.positions.size(), 0);
  for (const ShellValidity::Pairs* pairs : {&validity.bottom_contacts, &validity.overlapping_neighbours}) {
    for (const auto& [a, b] : *pairs) {
      is_excused[a] = is_excused[b] = 1;
      // Two that meet beside a common vertex do so up to it: the triangles there run through each other.
      const std::span<const Index> own = surface.triangles.subspan(3 * std::size_t{a}, 3),
                                   others = surface.triangles.subspan(3 * std::size_t{b}, 3);
      for (const Index v : own) {
        if (std::find(others.begin(), others.end(), v) != others.end()) is_hopeless[v] = 1;
      }
    }
  }
  for (std::size_t t = 0; t < n; ++t) {
    const std::span<const Index> corners = surface.triangles.subspan(3 * t, 3);
    const Vec3 &a = surface.positions[corners[0]], &b = surface.positions[corners[1]],
               &c = surface.positions[corners[2]];
    if (!has_area(a, b, c)) is_excused[t] = 1;
    const Vec3 normal = (b - a).cross(c - a).stableNormalized();
    for (const Index v : corners) {
      if (!(normal.dot(surface.normals[v]) > 0)) is_hopeless[v] = 1;
    }
  }
  std::vector<Index> excused;
  for (std::size_t t = 0; t < n; ++t) {
    const std::span<const Index> corners = surface.triangles.subspan(3 * t, 3);
    const bool is_around =
        std::any_of(corners.begin(), corners.end(), [&](Index v) { return is_hopeless[v] != 0; });
    if (is_excused[t] != 0 || is_around) excused.push_back(static_cast<Index>(t));
  }
  return excused;
}

ExcusingCheck::ExcusingCheck(const ShellSurface& surface, double side, std::span<const Index> excused)
    : surface_(surface), side_(side) {
  if (excused.empty()) return;
  is_excused_.assign(surface.triangles.size() / 3, 0);
  for (const Index t : excused) is_excused_[t] = 1;
  for (std::size_t t = 0; t < is_excused_.size(); ++t) {
    if (is_excused_[t] != 0) continue;
    rest_.push_back(static_cast<Index>(t));
    for (std::size_t k = 0; k < 3; ++k) rest_corners_.push_back(surface.triangles[3 * t + k]);
  }
}

ShellValidity ExcusingCheck::operator()(std::span<const Vec3> tops, std::span<const Index> changed,
                                        Progress* progress) const {
  ShellCheckOptions options;
  options.is_inward = side_ < 0;
  if (!changed.empty()) options.changed_vertices = changed;
  ShellValidity found = check_shell(surface_.positions, tops, surface_.triangles, options, progress);
  if (is_excused_.empty()) return found;
  const auto is_excused = [&](Index triangle) { return is_excused_[triangle] != 0; };
  const auto are_excused = [&](const auto& pair) {
    return is_excused(pair.first) && is_excused(pair.second);
  };
  std::erase_if(found.inverted, is_excused);
  for (ShellValidity::Pairs* pairs :
       {&found.bottom_contacts, &found.overlapping_neighbours, &found.top_contacts, &found.layer_contacts})
    std::erase_if(*pairs, are_excused);
  std::erase_if(found.wall_contacts, [&](const WallContact& contact) {
    return is_excused(contact.corner / 3) &&
           is_excused(contact.part == ShellPart::wall ? contact.other / 3 : contact.other);
  });
  // Pieces are those of the rest: of what meets itself, a ray tells nothing.
  found.nested_pieces.clear();
  ShellValidity alone = check_shell(surface_.positions, tops, rest_corners_, options, progress);
  const auto corner_of = [&](Index corner) { return 3 * rest_[corner / 3] + corner % 3; };
  for (const auto& [a, b] : alone.nested_pieces) found.nested_pieces.emplace_back(rest_[a], rest_[b]);
  for (const WallContact& contact : alone.wall_contacts) {
    found.wall_contacts.push_back(
        {corner_of(contact.corner), contact.part,
         contact.part == ShellPart::wall ? corner_of(contact.other) : rest_[contact.other]});
  }
  std::sort(found.wall_contacts.begin(), found.wall_contacts.end());
  found.wall_contacts.erase(std::unique(found.wall_contacts.begin(), found.wall_contacts.end()),
                            found.wall_contacts.end());
  return found;
}

}  // namespace recede::detail
