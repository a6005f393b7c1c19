#include <recede/geometry/error.h>
#include <recede/lod/seam_viewer.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

namespace recede {

namespace {

constexpr double k_least_share = 0.1;    // of the finest seams' error
constexpr double k_ahead = 0.75;         // of what is tolerated: a step nearer needs nothing new
constexpr double k_much_finer = 0.5;     // triangles that fine are made anew
constexpr double k_for_rounding = 1e-6;  // radians

// The sides of the image as planes through the eye, normals inwards.
std::array<Vec3, 4> image_sides(const SeamView& view) {
  const Vec3 forward = (view.target - view.position).normalized();
  const Vec3 right = forward.cross(view.up).normalized(), up = right.cross(forward);
  const double half_height = std::tan(view.view.field_of_view / 2),
               half_width = half_height * view.aspect_ratio;
  return {forward * half_width + right, forward * half_width - right, forward * half_height + up,
          forward * half_height - up};
}

std::array<Vec3, 8> corners_of(const Box3& box) {
  std::array<Vec3, 8> corners;
  for (int i = 0; i < 8; ++i)
    corners[static_cast<std::size_t>(i)] = box.corner(static_cast<Box3::CornerType>(i));
  return corners;
}

void check(const SeamView& view) {
  if (!(view.view.pixel_error > 0 && view.view.image_height >= 1))
    throw OptionError("pixels of a view are above 0");
  if (!(view.view.field_of_view > 0 && view.view.field_of_view < std::numbers::pi))
    throw OptionError("the field of view lies between 0 and pi");
  if (!(view.aspect_ratio > 0)) throw OptionError("the aspect ratio is above 0");
  if (!(view.culled_factor >= 1)) throw OptionError("what is culled isn't finer than what is seen");
  const Vec3 forward = view.target - view.position;
  if (!(forward.norm() > 0) || !(forward.cross(view.up).norm() > 0))
    throw OptionError("a view needs a target beside its position and an up that isn't its direction");
}

}  // namespace

class SeamViewer::Impl {
 public:
  explicit Impl(const SeamModel& model) : model_(model), tessellation_(model) {
    is_closed_ = model.graph.report.free_edges == 0;
    const std::size_t n = model.graph.n_patches();
    for (std::size_t patch = 0; patch < n; ++patch) {
      ParameterBox part;
      for (std::size_t l = model.graph.patch_loops[patch]; l < model.graph.patch_loops[patch + 1]; ++l) {
        for (const SeamSlot& slot : model.graph.loop(l)) part.extend(slot.uv);
      }
      parts_.push_back(part);
      const SurfaceBounds& bounds = model.surfaces[patch].bounds;
      boxes_.push_back(part.isEmpty() ? Box3() : bounds.box(part));
      cones_.push_back(part.isEmpty() ? NormalCone() : bounds.normal_cone(part));
      if (model.is_reversed[patch]) cones_.back().axis *= -1;
    }
    is_culled_.assign(n, 0);
    tolerances_.assign(n, std::max(model.size, std::numeric_limits<double>::min()));
  }

  SeamFrame update(const SeamView& view) {
    check(view);
    const auto start = std::chrono::steady_clock::now();
    SeamFrame frame;
    cull(view);
    const std::vector<double> wanted = wanted_tolerances(view);
    choose(wanted, view, frame);
    frame.update = tessellation_.update(tolerances_);
    look(view, wanted, frame);
    frame.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return frame;
  }

  SeamTessellation& tessellation() { return tessellation_; }
  bool is_culled(std::size_t patch) const { return is_culled_[patch] != 0; }

 private:
  void cull(const SeamView& view) {
    const std::array<Vec3, 4> sides = image_sides(view);
    for (std::size_t patch = 0; patch < boxes_.size(); ++patch) {
      const std::array<Vec3, 8> corners = corners_of(boxes_[patch]);
      const auto is_outside = [&](const Vec3& side) {
        return std::all_of(corners.begin(), corners.end(),
                           [&](const Vec3& c) { return side.dot(c - view.position) < 0; });
      };
      is_culled_[patch] = std::any_of(sides.begin(), sides.end(), is_outside) ||
                          (is_closed_ && faces_away(cones_[patch], corners, view.position));
    }
  }

  // All normals of the cone point away from the eye, wherever in the box they stand.
  static bool faces_away(const NormalCone& cone, const std::array<Vec3, 8>& corners, const Vec3& eye) {
    if (!(cone.angle + k_for_rounding < std::numbers::pi / 2)) return false;
    const double least = std::sin(cone.angle + k_for_rounding);
    return std::all_of(corners.begin(), corners.end(), [&](const Vec3& corner) {
      const Vec3 to = corner - eye;
      return cone.axis.dot(to) > least * to.norm();
    });
  }

  std::vector<double> wanted_tolerances(const SeamView& view) const {
    const double least = k_least_share * model_.graph.tolerance;
    std::vector<double> wanted(boxes_.size(), tolerances_.empty() ? 1.0 : tolerances_.front());
    for (std::size_t patch = 0; patch < boxes_.size(); ++patch) {
      if (boxes_[patch].isEmpty()) continue;
      double distance = std::sqrt(boxes_[patch].squaredExteriorDistance(view.position));
      // Near a large patch its box says little.
      if (distance < boxes_[patch].diagonal().norm())
        distance = std::max(distance, model_.surfaces[patch].bounds.distance(parts_[patch], view.position));
      const double pixel = pixel_footprint(distance, view.view);
      wanted[patch] =
          std::max(view.view.pixel_error * pixel * (is_culled_[patch] ? view.culled_factor : 1.0), least);
    }
    return wanted;
  }

  // Priorities of the source: what is farthest from what it should be, seen before culled.
  void choose(const std::vector<double>& wanted, const SeamView& view, SeamFrame& frame) {
    std::vector<std::pair<double, Index>> order;
    for (std::size_t patch = 0; patch < wanted.size(); ++patch) {
      if (tolerances_[patch] <= wanted[patch] && tolerances_[patch] >= k_much_finer * wanted[patch]) continue;
      const double p = std::max(tolerances_[patch] / wanted[patch], wanted[patch] / tolerances_[patch]);
      order.emplace_back(is_culled_[patch] ? 1 - 1 / p : p, static_cast<Index>(patch));
    }
    std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
      return a.first != b.first ? a.first > b.first : a.second < b.second;
    });
    double triangles = 0;
    for (const auto& [priority, patch] : order) {
      if (view.most_new_triangles && triangles > static_cast<double>(*view.most_new_triangles)) {
        ++frame.postponed;
        continue;
      }
      // About as many as there are, times the ratio of errors.
      const auto now = static_cast<double>(tessellation_.triangles_of(patch).triangles.size());
      triangles += std::max(2.0, now * tolerances_[patch] / wanted[patch]);
      tolerances_[patch] = k_ahead * wanted[patch];
    }
  }

  void look(const SeamView& view, const std::vector<double>& wanted, SeamFrame& frame) const {
    frame.finest_tolerance = std::numeric_limits<double>::infinity();
    for (std::size_t patch = 0; patch < wanted.size(); ++patch) {
      if (is_culled_[patch]) {
        ++frame.culled_patches;
        continue;
      }
      frame.pixel_error =
          std::max(frame.pixel_error, view.view.pixel_error * tolerances_[patch] / wanted[patch]);
      const std::size_t triangles = tessellation_.triangles_of(patch).triangles.size();
      if (triangles == 0) continue;
      ++frame.drawn_patches;
      frame.drawn_triangles += triangles;
      frame.finest_tolerance = std::min(frame.finest_tolerance, tolerances_[patch]);
    }
    if (frame.drawn_patches == 0) frame.finest_tolerance = 0;
  }

  const SeamModel& model_;
  SeamTessellation tessellation_;
  bool is_closed_ = false;
  std::vector<ParameterBox> parts_;  // around the loops of patches
  std::vector<Box3> boxes_;
  std::vector<NormalCone> cones_;
  std::vector<unsigned char> is_culled_;
  std::vector<double> tolerances_;  // for which patches were made
};

SeamViewer::SeamViewer(const SeamModel& model) : impl_(std::make_unique<Impl>(model)) {}
SeamViewer::SeamViewer(SeamViewer&&) noexcept = default;
SeamViewer& SeamViewer::operator=(SeamViewer&&) noexcept = default;
SeamViewer::~SeamViewer() = default;

SeamFrame SeamViewer::update(const SeamView& view) { return impl_->update(view); }
const SeamTessellation& SeamViewer::tessellation() const { return impl_->tessellation(); }
bool SeamViewer::is_culled(std::size_t patch) const { return impl_->is_culled(patch); }

}  // namespace recede
