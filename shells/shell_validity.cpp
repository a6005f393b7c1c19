#include <recede/geometry/error.h>
#include <recede/shells/detail/layer_boundary.h>
#include <recede/shells/detail/layer_check.h>
#include <recede/shells/detail/prism.h>
#include <recede/shells/detail/shell_excuses.h>
#include <recede/shells/shell_validity.h>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>

namespace recede {
namespace {

using detail::BoxTree;
using detail::LayerBoundary;

void check_input(std::span<const Vec3> bottom, std::span<const Vec3> top, std::span<const Index> triangles,
                 const ShellCheckOptions& options) {
  const std::size_t n = bottom.size();
  if (n != top.size()) {
    throw InputError(
        fmt::format("a shell needs a top for each of its {} bottom positions, not {}", n, top.size()));
  }
  // Five parts of a boundary for each triangle need numbers.
  constexpr std::size_t k_most = std::numeric_limits<Index>::max() / 5;
  if (n > k_most || triangles.size() / 3 > k_most) throw InputError("a shell this large has too many parts");
  if (triangles.size() % 3 != 0) throw InputError("the last triangle of a shell hasn't three vertices");
  for (std::size_t c = 0; c < triangles.size(); ++c) {
    if (triangles[c] >= n) {
      throw InputError(fmt::format("triangle {} of a shell uses vertex {} of {}", c / 3, triangles[c], n));
    }
  }
  for (std::size_t v = 0; v < n; ++v) {
    if (!bottom[v].allFinite() || !top[v].allFinite()) {
      throw InputError(fmt::format("vertex {} of a shell has a position that isn't finite", v));
    }
  }
  if (!options.changed_vertices) return;
  for (const Index v : *options.changed_vertices) {
    if (v >= n) throw InputError(fmt::format("changed vertex {} of a shell of {} vertices", v, n));
  }
}

LayerBoundary layer_of(std::span<const Vec3> bottom, std::span<const Vec3> top,
                       std::span<const Index> triangles, const ShellCheckOptions& options) {
  check_input(bottom, top, triangles, options);
  LayerBoundary layer;
  layer.points.assign(bottom.begin(), bottom.end());
  layer.points.insert(layer.points.end(), top.begin(), top.end());
  layer.triangles = triangles;
  layer.pieces = detail::find_shell_pieces(bottom.size(), triangles);
  return layer;
}

/// Which triangles are to be looked at.
class Selection {
 public:
  Selection(const LayerBoundary& layer, const ShellCheckOptions& options) {
    if (!options.changed_vertices) return;
    is_everything_ = false;
    std::vector<char> is_changed(layer.n_vertices(), 0);
    for (const Index v : *options.changed_vertices) is_changed[v] = 1;
    triangles_.resize(layer.n_triangles());
    pieces_.resize(layer.pieces.n_pieces());
    for (std::size_t c = 0; c < layer.triangles.size(); ++c) {
      if (is_changed[layer.triangles[c]] == 0) continue;
      triangles_[c / 3] = 1;
      pieces_[layer.pieces.piece_of_triangle[c / 3]] = 1;
    }
  }

  bool is_everything() const { return is_everything_; }
  bool has(Index triangle) const { return is_everything_ || triangles_[triangle] != 0; }
  bool has_piece(Index piece) const { return is_everything_ || pieces_[piece] != 0; }

 private:
  bool is_everything_ = true;
  std::vector<char> triangles_, pieces_;
};

bool is_inverted(const LayerBoundary& layer, Index triangle, bool is_inward) {
  detail::Prism prism;
  for (std::size_t k = 0; k < 3; ++k) {
    const Index vertex = layer.triangles[3 * std::size_t{triangle} + k];
    prism.bottom[k] = layer.points[vertex];
    prism.top[k] = layer.points[vertex + layer.n_vertices()];
  }
  return !detail::has_one_orientation(prism, is_inward);
}

std::vector<Index> find_inverted(const LayerBoundary& layer, const Selection& selection, bool is_inward) {
  std::vector<char> inverted_here(layer.n_triangles(), 0);
  tbb::parallel_for(tbb::blocked_range<Index>(0, layer.n_triangles()), [&](const auto& range) {
    for (Index t = range.begin(); t < range.end(); ++t)
      inverted_here[t] = selection.has(t) && !layer.is_excused(t) && is_inverted(layer, t, is_inward);
  });
  std::vector<Index> inverted;
  for (Index t = 0; t < layer.n_triangles(); ++t) {
    if (inverted_here[t] != 0) inverted.push_back(t);
  }
  return inverted;
}

/// Adds a contact of two parts to the list that it belongs to.
void add_contact(const LayerBoundary& layer, Index a, Index b, ShellValidity& found) {
  if (a > b) std::swap(a, b);
  const Index n = layer.n_triangles();
  if (layer.is_wall(b)) {
    const Index corner = layer.wall_corner(b);
    if (layer.is_wall(a)) {
      found.wall_contacts.push_back({layer.wall_corner(a), ShellPart::wall, corner});
    } else {
      found.wall_contacts.push_back({corner, a < n ? ShellPart::bottom : ShellPart::top, layer.triangle(a)});
    }
  } else if (b < n) {
    found.bottom_contacts.emplace_back(a, b);
  } else if (a < n) {
    found.layer_contacts.emplace_back(a, b - n);
  } else {
    found.top_contacts.emplace_back(a - n, b - n);
  }
}

template <typename List>
void move_sorted(List& from, List& to) {
  std::sort(from.begin(), from.end());
  to = std::move(from);
}

/// Tests pairs of parts in parallel and collects the contacts.
class ContactSearch {
 public:
  ContactSearch(const LayerBoundary& layer, Progress* progress) : layer_(layer), progress_(progress) {}

  /// All pairs in the tree.
  void among(const BoxTree& tree) {
    in_blocks(tree.n_leaves(), [&](std::size_t leaf, ShellValidity& found) {
      tree.visit_pairs(leaf, [&](Index a, Index b) { test(a, b, found); });
    });
  }

  /// The pairs with a selected part: those few make the tree that all parts search.
  void around(const std::vector<BoxTree::Box>& boxes, const Selection& selection) {
    std::vector<Index> parts;
    std::vector<BoxTree::Box> selected_boxes;
    for (std::size_t part = 0; part < boxes.size(); ++part) {
      if (!selection.has(layer_.triangle(static_cast<Index>(part)))) continue;
      parts.push_back(static_cast<Index>(part));
      selected_boxes.push_back(boxes[part]);
    }
    const BoxTree tree(selected_boxes);
    in_blocks(boxes.size(), [&](std::size_t part, ShellValidity& found) {
      const auto a = static_cast<Index>(part);
      const bool is_selected = selection.has(layer_.triangle(a));
      tree.visit_overlaps(boxes[part], [&](Index i) {
        const Index b = parts[i];
        // Two selected parts find each other.
        if (!is_selected || a < b) test(a, b, found);
      });
    });
  }

  /// The pairs with a part that moved, where `has_moved` says so of each part; in leaves that have some.
  void beside(const BoxTree& tree, std::span<const std::size_t> leaves,
              std::span<const unsigned char> has_moved) {
    in_blocks(leaves.size(), [&](std::size_t i, ShellValidity& found) {
      tree.visit_selected_pairs(
          leaves[i], [&](Index part) { return has_moved[part] != 0; },
          [&](Index a, Index b) { test(a, b, found); });
    });
  }

  void move_to(ShellValidity& validity) {
    ShellValidity all;
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    for (const ShellValidity& local : found_) {
      append(all.bottom_contacts, local.bottom_contacts);
      append(all.top_contacts, local.top_contacts);
      append(all.layer_contacts, local.layer_contacts);
      append(all.wall_contacts, local.wall_contacts);
    }
    move_sorted(all.bottom_contacts, validity.bottom_contacts);
    move_sorted(all.top_contacts, validity.top_contacts);
    move_sorted(all.layer_contacts, validity.layer_contacts);
    move_sorted(all.wall_contacts, validity.wall_contacts);
  }

 private:
  template <typename Search>
  void in_blocks(std::size_t n, Search&& search) {
    constexpr std::size_t k_blocks = 16;  // as often, progress is reported
    for (std::size_t block = 0; block < k_blocks; ++block) {
      report_progress(progress_, "find contacts", static_cast<double>(block) / k_blocks);
      const tbb::blocked_range<std::size_t> items(block * n / k_blocks, (block + 1) * n / k_blocks);
      tbb::parallel_for(items, [&](const auto& range) {
        ShellValidity& found = found_.local();
        for (std::size_t i = range.begin(); i < range.end(); ++i) search(i, found);
      });
    }
  }

  void test(Index a, Index b, ShellValidity& found) const {
    if (layer_.are_compared(a, b) && has_contact(layer_.points, layer_.simplex(a), layer_.simplex(b)))
      add_contact(layer_, a, b, found);
  }

  const LayerBoundary& layer_;
  Progress* progress_;
  tbb::enumerable_thread_specific<ShellValidity> found_;
};

/// Keeps the pairs of which one is selected.
template <typename IsSelected>
ShellValidity::Pairs selected(ShellValidity::Pairs pairs, IsSelected&& is_selected) {
  std::erase_if(pairs,
                [&](const auto& pair) { return !is_selected(pair.first) && !is_selected(pair.second); });
  return pairs;
}

}  // namespace

bool ShellValidity::is_valid() const {
  return inverted.empty() && has_valid_base() && top_contacts.empty() && layer_contacts.empty() &&
         wall_contacts.empty() && nested_pieces.empty();
}

ShellValidity check_shell(std::span<const Vec3> bottom, std::span<const Vec3> top,
                          std::span<const Index> triangles, const ShellCheckOptions& options,
                          Progress* progress) {
  report_progress(progress, "check prisms", 0);
  const LayerBoundary layer = layer_of(bottom, top, triangles, options);
  const Selection selection(layer, options);
  ShellValidity validity;
  validity.inverted = find_inverted(layer, selection, options.is_inward);
  const std::vector<BoxTree::Box> boxes = detail::boxes_of_parts(layer);
  const bool has_several_pieces = layer.pieces.n_pieces() > 1;
  const BoxTree tree = selection.is_everything() || has_several_pieces ? BoxTree(boxes) : BoxTree({});
  ContactSearch search(layer, progress);
  if (selection.is_everything()) {
    search.among(tree);
  } else {
    search.around(boxes, selection);
  }
  search.move_to(validity);
  validity.overlapping_neighbours =
      selected(layer.pieces.overlapping_neighbours, [&](Index triangle) { return selection.has(triangle); });
  if (has_several_pieces) {
    validity.nested_pieces = selected(find_nested_pieces(layer, tree), [&](Index first_triangle) {
      return selection.has_piece(layer.pieces.piece_of_triangle[first_triangle]);
    });
  }
  report_progress(progress, "find contacts", 1);
  return validity;
}

namespace detail {

LayerCheck::LayerCheck(std::span<const Vec3> bottom, std::span<const Vec3> top,
                       std::span<const Index> triangles, std::span<const Index> excused, bool is_inward,
                       Progress* progress)
    : layer_(excusing(layer_of(bottom, top, triangles, {}), excused)),
      is_inward_(is_inward),
      progress_(progress),
      starts_(bottom.size() + 1, 0),
      around_(triangles.size()),
      tree_(boxes_of_parts(layer_)),
      has_moved_(layer_.n_parts(), 0) {
  for (const Index v : triangles) ++starts_[v + 1];
  for (std::size_t v = 0; v < bottom.size(); ++v) starts_[v + 1] += starts_[v];
  std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
  for (std::size_t c = 0; c < triangles.size(); ++c)
    around_[next[triangles[c]]++] = static_cast<Index>(c / 3);
}

void LayerCheck::add_nested_pieces(ShellValidity& validity) const {
  if (layer_.pieces.n_pieces() > 1) validity.nested_pieces = find_nested_pieces(layer_, tree_);
}

ShellValidity LayerCheck::check_all() const {
  ShellValidity validity;
  validity.inverted = find_inverted(layer_, Selection(layer_, {}), is_inward_);
  ContactSearch search(layer_, progress_);
  search.among(tree_);
  search.move_to(validity);
  validity.overlapping_neighbours = layer_.pieces.overlapping_neighbours;
  add_nested_pieces(validity);
  return validity;
}

ShellValidity LayerCheck::check_moved(std::span<const Vec3> top, std::span<const Index> vertices) {
  const Index n = layer_.n_triangles();
  std::vector<Index> triangles;
  for (const Index v : vertices) {
    layer_.points[layer_.n_vertices() + v] = top[v];
    triangles.insert(triangles.end(), around_.begin() + static_cast<std::ptrdiff_t>(starts_[v]),
                     around_.begin() + static_cast<std::ptrdiff_t>(starts_[v + 1]));
  }
  std::sort(triangles.begin(), triangles.end());
  triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
  std::vector<Index> moved;
  for (const Index t : triangles) {
    moved.push_back(n + t);
    const auto& walls = layer_.pieces.walls;
    for (auto wall = std::lower_bound(walls.begin(), walls.end(), 3 * t);
         wall != walls.end() && *wall / 3 == t; ++wall)
      moved.push_back(2 * n + static_cast<Index>(wall - walls.begin()));
  }
  std::vector<std::size_t> leaves;
  for (const Index part : moved) {
    has_moved_[part] = 1;
    tree_.move(part, box_of_part(layer_, part));
    leaves.push_back(tree_.leaf_of(part));
  }
  std::sort(leaves.begin(), leaves.end());
  leaves.erase(std::unique(leaves.begin(), leaves.end()), leaves.end());
  std::vector<char> inverted_here(triangles.size(), 0);
  tbb::parallel_for(std::size_t{0}, triangles.size(), [&](std::size_t i) {
    inverted_here[i] = !layer_.is_excused(triangles[i]) && is_inverted(layer_, triangles[i], is_inward_);
  });
  ShellValidity validity;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (inverted_here[i] != 0) validity.inverted.push_back(triangles[i]);
  }
  ContactSearch search(layer_, progress_);
  search.beside(tree_, leaves, has_moved_);
  search.move_to(validity);
  add_nested_pieces(validity);
  for (const Index part : moved) has_moved_[part] = 0;
  return validity;
}

}  // namespace detail

}  // namespace recede
