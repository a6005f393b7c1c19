#include <recede/geometry/disjoint_sets.h>
#include <recede/geometry/error.h>
#include <recede/lod/detail/plane_cover.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace recede::detail {

namespace {

constexpr std::size_t k_directions = 400;  // over half of the sphere
constexpr double k_bins = 4;               // of offsets in an error

struct Plane {
  Vec3 normal = Vec3::UnitZ();
  double offset = 0;
};

// Along a spiral, equally dense everywhere.
std::vector<Vec3> half_sphere(std::size_t n) {
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  std::vector<Vec3> directions;
  for (std::size_t i = 0; i < n; ++i) {
    const double z = (static_cast<double>(i) + 0.5) / static_cast<double>(n),
                 around = golden * static_cast<double>(i), radius = std::sqrt(1 - z * z);
    directions.emplace_back(radius * std::cos(around), radius * std::sin(around), z);
  }
  return directions;
}

class PlaneCover {
 public:
  PlaneCover(const BillboardFaces& faces, double error)
      : faces_(faces), error_(error), directions_(half_sphere(k_directions)), is_covered_(faces.count(), 0) {
    double farthest = 0;
    for (const Index corner : faces.corners) farthest = std::max(farthest, faces.points[corner].norm());
    bin_ = error / k_bins;
    first_ = -farthest - bin_;
    const double n_bins = 2 * (farthest + bin_) / bin_ + 2;
    constexpr double k_most_sums = 1 << 27;  // a gibibyte
    if (!(n_bins * k_directions < k_most_sums))
      throw OptionError(fmt::format("an error of {:.3g} of the model's size is too small for planes", error));
    n_bins_ = static_cast<std::size_t>(n_bins);
    sums_.assign(directions_.size() * n_bins_, 0.0);
    for (Index face = 0; face < faces.count(); ++face) add(face, 1);
  }

  std::vector<CoveringPlane> run(Progress* progress) {
    std::size_t n_left = faces_.count();
    while (n_left > 0) {
      report_progress(progress, "planes",
                      1 - static_cast<double>(n_left) / static_cast<double>(faces_.count()));
      std::size_t n = cover(improved(best_bin()));
      if (n == 0) n = cover(plane_of(first_left()));
      if (n == 0) n = leave_alone(first_left());
      n_left -= n;
    }
    reduce();
    return assigned();
  }

 private:
  bool is_near(Index face, const Plane& plane) const {
    const FaceReach reach = reach_of(faces_, face, plane.normal);
    return reach.high - plane.offset <= error_ && plane.offset - reach.low <= error_;
  }

  double seen(Index face, const Vec3& normal) const {
    // A little for those on edge, so that they aren't left to the last.
    constexpr double k_on_edge = 1e-6;
    return faces_.moments[face].area * (std::abs(faces_.normals[face].dot(normal)) + k_on_edge);
  }

  // To the offsets along each direction with which a plane is near to the face.
  void add(Index face, double sign) {
    for (std::size_t d = 0; d < directions_.size(); ++d) {
      const FaceReach reach = reach_of(faces_, face, directions_[d]);
      if (reach.high - reach.low > 2 * error_) continue;
      const double area = sign * seen(face, directions_[d]);
      const auto begin =
          static_cast<std::size_t>(std::max(0.0, std::ceil((reach.high - error_ - first_) / bin_)));
      for (std::size_t i = begin; i < n_bins_ && offset_of(i) <= reach.low + error_; ++i)
        sums_[d * n_bins_ + i] += area;
    }
  }

  double offset_of(std::size_t bin) const { return first_ + bin_ * static_cast<double>(bin); }

  Plane best_bin() const {
    const auto best = static_cast<std::size_t>(std::max_element(sums_.begin(), sums_.end()) - sums_.begin());
    return {directions_[best / n_bins_], offset_of(best % n_bins_)};
  }

  double gain(const Plane& plane) const {
    double sum = 0;
    for (Index face = 0; face < faces_.count(); ++face) {
      if (!is_covered_[face] && is_near(face, plane)) sum += seen(face, plane.normal);
    }
    return sum;
  }

  // Turned and moved as long as it sees more.
  Plane improved(Plane plane) const {
    constexpr double k_first_turn = 0.08, k_least_gain = 1.0001;
    constexpr int k_halvings = 6;
    double best = gain(plane), turn = k_first_turn, move = error_ / 2;
    for (int halving = 0; halving < k_halvings;) {
      const Vec3 u = plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
      bool is_better = false;
      for (const Vec3& step :
           {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)}) {
        const Vec3 normal = (plane.normal + turn * (step.x() * u + step.y() * v)).normalized();
        const Plane next{normal, plane.offset + move * step.z()};
        const double here = gain(next);
        if (here <= k_least_gain * best) continue;
        best = here;
        plane = next;
        is_better = true;
        break;
      }
      if (is_better) continue;
      turn /= 2;
      move /= 2;
      ++halving;
    }
    return plane;
  }

  Index first_left() const {
    return static_cast<Index>(std::find(is_covered_.begin(), is_covered_.end(), 0) - is_covered_.begin());
  }
  Plane plane_of(Index face) const {
    const Vec3& normal = faces_.normals[face];
    const FaceReach reach = reach_of(faces_, face, normal);
    return {normal, (reach.low + reach.high) / 2};
  }

  std::size_t cover(const Plane& plane) {
    std::size_t n = 0;
    for (Index face = 0; face < faces_.count(); ++face) {
      if (is_covered_[face] || !is_near(face, plane)) continue;
      is_covered_[face] = 1;
      add(face, -1);
      ++n;
    }
    if (n > 0) planes_.push_back(plane);
    return n;
  }

  // A face so bent that its own plane isn't near to all of it.
  std::size_t leave_alone(Index face) {
    is_covered_[face] = 1;
    add(face, -1);
    return 1;
  }

  // Planes go of which others are near to all faces, then those of which another one can take, turned, what
  // no third is near to.
  void reduce() {
    n_near_.assign(faces_.count(), 0);
    for (const Plane& plane : planes_) near_.push_back(faces_near(plane));
    drop_needless();
    // Of many, each has little to give.
    constexpr std::size_t k_most_joined = 256;
    while (planes_.size() <= k_most_joined && join_two()) drop_needless();
  }

  std::vector<Index> faces_near(const Plane& plane) {
    std::vector<Index> near;
    for (Index face = 0; face < faces_.count(); ++face) {
      if (!is_near(face, plane)) continue;
      near.push_back(face);
      ++n_near_[face];
    }
    return near;
  }

  void remove(std::size_t p) {
    for (const Index face : near_[p]) --n_near_[face];
    near_.erase(near_.begin() + static_cast<std::ptrdiff_t>(p));
    planes_.erase(planes_.begin() + static_cast<std::ptrdiff_t>(p));
  }

  // The last ones see least.
  void drop_needless() {
    for (std::size_t p = planes_.size(); p-- > 0;) {
      if (std::all_of(near_[p].begin(), near_[p].end(), [&](Index face) { return n_near_[face] > 1; }))
        remove(p);
    }
  }

  bool join_two() {
    for (std::size_t b = planes_.size(); b-- > 1;) {
      for (std::size_t a = b; a-- > 0;) {
        Plane plane;
        if (!fits(faces_of_two(a, b), plane)) continue;
        remove(b);
        remove(a);
        planes_.push_back(plane);
        near_.push_back(faces_near(plane));
        return true;
      }
    }
    return false;
  }

  // That no third plane is near to.
  std::vector<Index> faces_of_two(std::size_t a, std::size_t b) const {
    std::vector<Index> all, result;
    std::set_union(near_[a].begin(), near_[a].end(), near_[b].begin(), near_[b].end(),
                   std::back_inserter(all));
    for (const Index face : all) {
      const std::size_t n = std::binary_search(near_[a].begin(), near_[a].end(), face) +
                            std::binary_search(near_[b].begin(), near_[b].end(), face);
      if (n_near_[face] == n) result.push_back(face);
    }
    return result;
  }

  // A plane near to all of some faces.
  bool fits(const std::vector<Index>& members, Plane& plane) const {
    SurfaceMoments moments;
    for (const Index face : members) moments += faces_.moments[face];
    if (!(moments.area > 0)) return false;
    plane.normal = moments.axes().col(0);
    double width = spread(members, plane);
    double turn = std::max(2 * error_, 0.02);
    for (int halving = 0; halving < 6 && width > 2 * error_;) {
      const Vec3 u = plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
      bool is_better = false;
      for (const Vec2& step : {Vec2(1, 0), Vec2(-1, 0), Vec2(0, 1), Vec2(0, -1)}) {
        Plane next{(plane.normal + turn * (step.x() * u + step.y() * v)).normalized(), 0};
        const double here = spread(members, next);
        if (here >= width) continue;
        width = here;
        plane = next;
        is_better = true;
      }
      if (!is_better) {
        turn /= 2;
        ++halving;
      }
    }
    return width <= 2 * error_;
  }

  // How far they reach along its normal; puts it into the middle.
  double spread(const std::vector<Index>& members, Plane& plane) const {
    FaceReach all;
    for (const Index face : members) {
      const FaceReach reach = reach_of(faces_, face, plane.normal);
      all.low = std::min(all.low, reach.low);
      all.high = std::max(all.high, reach.high);
    }
    plane.offset = (all.low + all.high) / 2;
    return all.high - all.low;
  }

  // Each face to the plane that sees it best; those to which none is near get their own.
  std::vector<CoveringPlane> assigned() const {
    std::vector<CoveringPlane> result(planes_.size()), alone;
    for (std::size_t p = 0; p < planes_.size(); ++p) result[p].normal = planes_[p].normal;
    for (Index face = 0; face < faces_.count(); ++face) {
      std::size_t best = 0;
      double most = -1;
      for (std::size_t p = 0; p < planes_.size(); ++p) {
        const double cosine = std::abs(faces_.normals[face].dot(planes_[p].normal));
        if (cosine <= most || !is_near(face, planes_[p])) continue;
        most = cosine;
        best = p;
      }
      if (most < 0)
        alone.push_back({faces_.normals[face], {face}});
      else
        result[best].faces.push_back(face);
    }
    std::erase_if(result, [](const CoveringPlane& plane) { return plane.faces.empty(); });
    result.insert(result.end(), alone.begin(), alone.end());
    return result;
  }

  const BillboardFaces& faces_;
  double error_;
  std::vector<Vec3> directions_;
  double bin_ = 0, first_ = 0;  // of offsets
  std::size_t n_bins_ = 0;
  std::vector<double> sums_;  // by direction and offset: the area that is seen
  std::vector<unsigned char> is_covered_;
  std::vector<Plane> planes_;
  std::vector<std::vector<Index>> near_;  // by plane: faces
  std::vector<std::size_t> n_near_;       // by face: planes
};

}  // namespace

std::vector<std::vector<Index>> regions_of(const BillboardFaces& faces, const CoveringPlane& plane) {
  // Faces that touch a cell of a grid belong together.
  constexpr int k_cells = 64;
  const Vec3 u = plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
  const auto box_of = [&](Index face) {
    Eigen::AlignedBox2d box;
    for (const Index corner : faces.corners_of(face))
      box.extend(Vec2(faces.points[corner].dot(u), faces.points[corner].dot(v)));
    return box;
  };
  Eigen::AlignedBox2d all;
  for (const Index face : plane.faces) all.extend(box_of(face));
  const double cell = std::max(all.sizes().maxCoeff() / k_cells, 1e-12);
  const auto cell_of = [&](const Vec2& point) {
    return Eigen::Vector2i(((point - all.min()) / cell).cast<int>());
  };
  std::vector<Index> first_in_cell((k_cells + 1) * (k_cells + 1), k_no_index);
  DisjointSets sets(plane.faces.size());
  for (std::size_t i = 0; i < plane.faces.size(); ++i) {
    const Eigen::AlignedBox2d box = box_of(plane.faces[i]);
    const Eigen::Vector2i low = cell_of(box.min()), high = cell_of(box.max());
    for (int x = low.x(); x <= high.x(); ++x) {
      for (int y = low.y(); y <= high.y(); ++y) {
        Index& first = first_in_cell[static_cast<std::size_t>(x * (k_cells + 1) + y)];
        if (first == k_no_index) first = static_cast<Index>(i);
        sets.unite(first, static_cast<Index>(i));
      }
    }
  }
  std::vector<std::vector<Index>> regions;
  std::vector<Index> number(plane.faces.size(), k_no_index);
  for (std::size_t i = 0; i < plane.faces.size(); ++i) {
    Index& region = number[sets.find(static_cast<Index>(i))];
    if (region == k_no_index) {
      region = static_cast<Index>(regions.size());
      regions.emplace_back();
    }
    regions[region].push_back(plane.faces[i]);
  }
  constexpr double k_worth = 0.9;  // of the area
  double parted = 0;
  for (const std::vector<Index>& region : regions)
    parted += billboard_facing(faces, region, plane.normal, true).area();
  if (parted > k_worth * billboard_facing(faces, plane.faces, plane.normal, true).area())
    return {plane.faces};
  return regions;
}

std::vector<CoveringPlane> cover_by_planes(const BillboardFaces& faces, double error, Progress* progress) {
  return PlaneCover(faces, error).run(progress);
}

}  // namespace recede::detail
