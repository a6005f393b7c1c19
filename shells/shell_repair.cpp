#include <recede/shells/detail/director_cuts.h>
#include <recede/shells/detail/layer_check.h>
#include <recede/shells/detail/shell_excuses.h>
#include <recede/shells/detail/shell_pieces.h>
#include <recede/shells/detail/shell_repair.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace recede::detail {

namespace {

constexpr double k_shorter = 0.85, k_longer = 1 / k_shorter;
// Sheets a millionth apart, or sharper than that, need other orders of magnitude.
constexpr int k_gentle_rounds = 50;
constexpr double k_much_shorter = 0.4;
// What is left of a director is then one part in 3e13: of anything shorter, rounding decides the direction.
constexpr int k_most_rounds = 75;
constexpr int k_regrowths = 4;
constexpr int k_most_retreats = 4;
// Towards the normal. Neighbours that turn differently invert each other, so only what is at fault however
// short it gets turns: below a share of its length.
constexpr double k_straighter = 0.7, k_short = 0.25;

class LayerRepair {
 public:
  LayerRepair(const ShellSurface& surface, double side, ShellLayer& layer, Progress* progress)
      : surface_(surface),
        side_(side),
        layer_(layer),
        progress_(progress),
        scales_(surface.positions.size(), 1.0),
        leans_(surface.positions.size(), 1.0) {}

  void run(bool may_change) {
    layer_.tops = layer_.traced;
    layer_.validity = check_without({});
    layer_.inverted_before = layer_.validity.inverted.size();
    layer_.contacts_before = layer_.validity.top_contacts.size() + layer_.validity.layer_contacts.size() +
                             layer_.validity.wall_contacts.size();
    layer_.shortened = 0;
    layer_.repair_rounds = 0;
    layer_.excused = find_excused_triangles(surface_, layer_.validity);
    layer_.given_up.clear();
    ShellValidity found = layer_.excused.empty() ? layer_.validity : check_without(layer_.excused);
    if (may_change && !found.is_valid()) {
      find_neighbours();
      found = repair(std::move(found));
      for (int i = 0; i < k_most_retreats && !found.is_valid(); ++i) {
        found = repair(give_up_on(found));
      }
      const bool is_sound = found.is_valid() && layer_.excused.empty() && layer_.given_up.empty();
      layer_.validity = is_sound ? ShellValidity{} : check_shell_as_it_is();
    }
    layer_.is_valid_elsewhere = found.is_valid();
    layer_.shortened = static_cast<std::size_t>(
        std::count_if(scales_.begin(), scales_.end(), [](double scale) { return scale < 1; }));
  }

 private:
  // `found` is of the whole layer as it was traced. Returns what is left of the faults.
  ShellValidity repair(ShellValidity found) {
    std::vector<Index> doubtful = offenders_of(found);
    cut_at_surface(found);
    for (int round = 0; round < k_most_rounds && !found.is_valid(); ++round, ++layer_.repair_rounds) {
      const std::vector<Index> vertices = offenders_of(found);
      const double share = round < k_gentle_rounds ? k_shorter : k_much_shorter;
      for (const Index v : vertices) {
        scales_[v] *= share;
        if (scales_[v] < k_short) leans_[v] *= k_straighter;
        place(v);
      }
      found = check_->check_moved(layer_.tops, with_slopes(vertices));
    }
    if (!found.is_valid()) return found;
    regrow();
    // Each round looked at what it moved. That the layer is valid shall not depend on their having missed
    // nothing together: all that was at fault or moved since the whole was checked is looked at once more.
    for (Index v = 0; v < layer_.tops.size(); ++v) {
      if (layer_.tops[v] != layer_.traced[v]) doubtful.push_back(v);
    }
    return check_->check_moved(layer_.tops, doubtful);
  }

  // Their triangles count as excused from now on, and the rest is repaired from the beginning: all around
  // them got as short as they. Returns its faults.
  ShellValidity give_up_on(const ShellValidity& found) {
    std::vector<Index>& left = layer_.given_up;
    left.insert(left.end(), found.inverted.begin(), found.inverted.end());
    for (const ShellValidity::Pairs* pairs : {&found.top_contacts, &found.layer_contacts}) {
      for (const auto& [a, b] : *pairs) left.insert(left.end(), {a, b});
    }
    for (const WallContact& contact : found.wall_contacts) {
      const bool is_wall = contact.part == ShellPart::wall;
      left.insert(left.end(), {contact.corner / 3, is_wall ? contact.other / 3 : contact.other});
    }
    std::erase_if(
        left, [&](Index t) { return std::binary_search(layer_.excused.begin(), layer_.excused.end(), t); });
    std::sort(left.begin(), left.end());
    left.erase(std::unique(left.begin(), left.end()), left.end());
    std::vector<Index> all = layer_.excused;
    all.insert(all.end(), left.begin(), left.end());
    std::sort(all.begin(), all.end());
    layer_.tops = layer_.traced;
    std::fill(scales_.begin(), scales_.end(), 1.0);
    std::fill(leans_.begin(), leans_.end(), 1.0);
    return check_without(all);
  }

  // Tops that all lie beyond the other side of a thin part meet nothing but at its rim, from where rounds
  // would go on ring by ring. Then finds what is at fault now.
  void cut_at_surface(ShellValidity& found) {
    constexpr double k_room = 0.45;   // what is on the other side needs as much
    constexpr double k_least = 1e-6;  // rounds do what is sharper
    const std::vector<double> shares = shares_before_surface(surface_, layer_.tops);
    std::vector<Index> cut;
    for (Index v = 0; v < shares.size(); ++v) {
      if (shares[v] >= 1) continue;
      scales_[v] = std::max(k_room * shares[v], k_least);
      place(v);
      cut.push_back(v);
    }
    if (cut.empty()) return;
    // What was at fault before may be so still, whether it moved or not.
    cut = with_slopes(cut);
    const std::vector<Index> offenders = offenders_of(found);
    cut.insert(cut.end(), offenders.begin(), offenders.end());
    found = check_->check_moved(layer_.tops, cut);
  }

  // Of the layer as it is, and from now on.
  ShellValidity check_without(std::span<const Index> excused) {
    check_.emplace(surface_.positions, layer_.tops, surface_.triangles, excused, side_ < 0, progress_);
    return check_->check_all();
  }

  // With what excused triangles do among themselves.
  ShellValidity check_shell_as_it_is() const {
    ShellCheckOptions options;
    options.is_inward = side_ < 0;
    return check_shell(surface_.positions, layer_.tops, surface_.triangles, options, progress_);
  }

  // Shorter, and at last nearer to the normal: a director that leans over one of its triangles is of no
  // length right.
  void place(Index v) {
    const Vec3 &from = surface_.positions[v], director = layer_.traced[v] - from;
    const Vec3 direction =
        leans_[v] * director.stableNormalized() + (1 - leans_[v]) * side_ * surface_.normals[v];
    layer_.tops[v] = from + scales_[v] * director.norm() * direction.stableNormalized();
  }

  // Vertices whose directors are at fault, each once.
  std::vector<Index> offenders_of(const ShellValidity& found) const {
    std::vector<Index> vertices;
    const auto add_corners = [&](std::size_t triangle) {
      for (std::size_t k = 0; k < 3; ++k) vertices.push_back(surface_.triangles[3 * triangle + k]);
    };
    for (const Index triangle : found.inverted) add_corners(triangle);
    for (const auto& [a, b] : found.top_contacts) {
      add_corners(a);
      add_corners(b);
    }
    for (const auto& [bottom, top] : found.layer_contacts) add_corners(top);
    const auto add_wall = [&](Index corner) {
      vertices.push_back(surface_.triangles[corner]);
      vertices.push_back(surface_.triangles[next_in_triangle(corner)]);
    };
    for (const WallContact& contact : found.wall_contacts) {
      add_wall(contact.corner);
      if (contact.part == ShellPart::top) add_corners(contact.other);
      if (contact.part == ShellPart::wall) add_wall(contact.other);
    }
    if (!found.nested_pieces.empty()) {
      // All of both pieces is at fault.
      const std::vector<Index>& piece_of = check_->pieces().piece_of_triangle;
      std::vector<unsigned char> is_nested(check_->pieces().n_pieces(), 0);
      for (const auto& [inner, outer] : found.nested_pieces)
        is_nested[piece_of[inner]] = is_nested[piece_of[outer]] = 1;
      for (std::size_t t = 0; t < piece_of.size(); ++t) {
        if (piece_of[t] != k_no_index && is_nested[piece_of[t]] != 0) add_corners(t);
      }
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    return vertices;
  }

  // Beside a director that got shorter the others may be longer by no more than a slope allows, or tops would
  // stand on edge and prisms there be the next ones inverted. Returns all that changed.
  std::vector<Index> with_slopes(std::vector<Index> vertices) {
    constexpr double k_steepest = 1;  // in lengths of directors as traced
    std::vector<unsigned char> is_listed(scales_.size(), 0);
    for (const Index v : vertices) is_listed[v] = 1;
    std::vector<Index> queue = vertices;
    for (std::size_t next = 0; next < queue.size(); ++next) {
      const Index v = queue[next];
      for (std::size_t i = starts_[v]; i < starts_[v + 1]; ++i) {
        const Index other = neighbours_[i];
        const double traced = (layer_.traced[other] - surface_.positions[other]).norm();
        const double way = (surface_.positions[other] - surface_.positions[v]).norm();
        const double most = scales_[v] + k_steepest * way / traced;
        if (!(scales_[other] > most)) continue;
        scales_[other] = most;
        place(other);
        queue.push_back(other);
        if (is_listed[other] == 0) vertices.push_back(other);
        is_listed[other] = 1;
      }
    }
    std::sort(vertices.begin(), vertices.end());
    return vertices;
  }

  void find_neighbours() {
    const std::span<const Index> triangles = surface_.triangles;
    starts_.assign(scales_.size() + 1, 0);
    for (const Index v : triangles) starts_[v + 1] += 2;
    for (std::size_t v = 0; v < scales_.size(); ++v) starts_[v + 1] += starts_[v];
    neighbours_.resize(starts_.back());
    std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
    for (std::size_t corner = 0; corner < triangles.size(); ++corner) {
      const std::size_t first = corner - corner % 3;
      for (std::size_t k = 1; k < 3; ++k)
        neighbours_[next[triangles[corner]]++] = triangles[first + (corner % 3 + k) % 3];
    }
  }

  // Neighbours of what was at fault got shorter with it: they try a step back.
  void regrow() {
    for (int round = 0; round < k_regrowths; ++round) {
      std::vector<Index> grown;
      const std::vector<double> before = scales_;
      for (Index v = 0; v < scales_.size(); ++v) {
        if (scales_[v] >= 1) continue;
        scales_[v] = std::min(1.0, scales_[v] * k_longer);
        place(v);
        grown.push_back(v);
      }
      if (grown.empty()) return;
      // Whatever is found has a part that grew, whose corners go back: that's what there is to look at next.
      std::vector<Index> moved = grown;
      for (ShellValidity found; !(found = check_->check_moved(layer_.tops, moved)).is_valid();) {
        moved.clear();
        for (const Index v : offenders_of(found)) {
          if (scales_[v] == before[v]) continue;
          scales_[v] = before[v];
          place(v);
          moved.push_back(v);
        }
        if (!moved.empty()) continue;
        // Nobody's own fault: all go back.
        for (const Index v : grown) {
          scales_[v] = before[v];
          place(v);
        }
        check_->check_moved(layer_.tops, grown);
        break;
      }
    }
  }

  const ShellSurface& surface_;
  double side_;
  ShellLayer& layer_;
  Progress* progress_;
  std::optional<LayerCheck> check_;
  std::vector<double> scales_;  // of lengths
  std::vector<double> leans_;   // 1: as traced, 0: along the normal
  std::vector<std::size_t> starts_;
  std::vector<Index> neighbours_;  // of each vertex, some twice
};

}  // namespace

void repair_layer(const ShellSurface& surface, double side, bool may_change, ShellLayer& layer,
                  Progress* progress) {
  LayerRepair(surface, side, layer, progress).run(may_change);
}

}  // namespace recede::detail
