#include <recede/geometry/error.h>
#include <recede/lod/detail/refined_graph.h>
#include <recede/lod/selective_mesh.h>

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>

namespace recede {
namespace {

using detail::RefinedGraph;
using detail::RefinementBounds;
using Clock = std::chrono::steady_clock;

double silhouette_pixel_error(const RefinementView& view) {
  const double front = view.view.pixel_error;
  return view.silhouette_pixel_error.value_or(std::min(front, view.back_pixel_error.value_or(front)));
}

void check(const RefinementView& view) {
  const auto require = [](bool holds, const char* what) {
    if (!holds) throw OptionError(what);
  };
  const auto is_positive = [](double value) { return value > 0 && std::isfinite(value); };
  require((view.position - view.target).norm() > 0 && view.position.allFinite() && view.target.allFinite(),
          "the position and the target of a view must be two finite points");
  require(view.up.allFinite(), "the upward direction of a view must be finite");
  require(is_positive(view.view.image_height), "the image height must be positive");
  require(view.view.field_of_view > 0 && view.view.field_of_view < std::numbers::pi,
          "the field of view must lie between 0 and 180 degrees");
  require(is_positive(view.aspect_ratio), "the aspect ratio must be positive");
  for (const auto& error :
       {std::optional(view.view.pixel_error), view.silhouette_pixel_error, view.back_pixel_error}) {
    require(!error || is_positive(*error), "errors in pixels must be positive");
  }
  const double silhouette = silhouette_pixel_error(view);
  require(silhouette <= view.view.pixel_error && silhouette <= view.back_pixel_error.value_or(silhouette),
          "the error in pixels on silhouettes must not be larger than elsewhere");
}

using Vec3f = Eigen::Vector3f;

/// A view's question to a split: how many pixels is the error, as a share of what may be seen?
class PixelCriterion {
 public:
  /// `origin`: see `HierarchyBounds`.
  PixelCriterion(const RefinementView& view, const Vec3& origin)
      : position_((view.position - origin).cast<float>()),
        pixels_per_length_(static_cast<float>(1 / pixel_footprint(1, view.view))),
        front_pixels_(static_cast<float>(view.view.pixel_error)),
        back_pixels_(static_cast<float>(view.back_pixel_error.value_or(view.view.pixel_error))),
        silhouette_pixels_(static_cast<float>(silhouette_pixel_error(view))),
        asks_direction_(silhouette_pixels_ != front_pixels_ || back_pixels_ != front_pixels_) {
    if (!view.cull) return;
    const Vec3 forward = (view.target - view.position).normalized();
    Vec3 right = forward.cross(view.up);
    constexpr double k_parallel = 1e-6;  // any direction serves then
    if (right.norm() <= k_parallel * view.up.norm()) right = forward.unitOrthogonal();
    right.normalize();
    const Vec3 up = right.cross(forward);
    const double half_height = std::tan(view.view.field_of_view / 2),
                 half_width = half_height * view.aspect_ratio;
    for (const Vec3& inward : {Vec3(half_width * forward + right), Vec3(half_width * forward - right),
                               Vec3(half_height * forward + up), Vec3(half_height * forward - up)}) {
      planes_[n_planes_++] = inward.normalized().cast<float>();
    }
  }

  /// Pixels of an error over those that are allowed; 0 outside the image, infinite around the eye.
  float share(const RefinementBounds& b) const {
    const Vec3f arm = Vec3f(b.center) - position_;
    const float distance = arm.norm();
    const float pixels = pixels_of(b, arm, distance);
    return pixels > 0 && std::isfinite(pixels) ? pixels / allowed(b, arm, distance) : pixels;
  }
  /// Pixels of an error; 0 outside the image, infinite around the eye.
  float pixels(const RefinementBounds& b) const {
    const Vec3f arm = Vec3f(b.center) - position_;
    return pixels_of(b, arm, arm.norm());
  }

 private:
  float pixels_of(const RefinementBounds& b, const Vec3f& arm, float distance) const {
    if (b.error == 0) return 0;
    for (std::size_t i = 0; i < n_planes_; ++i) {
      if (planes_[i].dot(arm) < -b.radius) return 0;
    }
    const float nearest = distance - b.radius;
    return nearest > 0 ? b.error * pixels_per_length_ / nearest : std::numeric_limits<float>::infinity();
  }
  float allowed(const RefinementBounds& b, const Vec3f& arm, float distance) const {
    if (!asks_direction_) return front_pixels_;
    // Normals lie within `angle` of the axis, and directions of view within that of the sphere.
    const float spread = b.angle + std::asin(b.radius / distance);
    constexpr float k_quarter = std::numbers::pi_v<float> / 2;
    if (spread >= k_quarter) return silhouette_pixels_;
    const float cosine = Vec3f(b.axis).dot(arm) / distance, limit = std::sin(spread);
    return cosine > limit ? back_pixels_ : cosine < -limit ? front_pixels_ : silhouette_pixels_;
  }

  Vec3f position_;
  float pixels_per_length_, front_pixels_, back_pixels_, silhouette_pixels_;
  bool asks_direction_;
  std::array<Vec3f, 4> planes_;  // inward normals, through the position
  std::size_t n_planes_ = 0;
};

}  // namespace

class SelectiveMesh::Impl {
 public:
  explicit Impl(const ProgressiveMesh& mesh)
      : mesh_(mesh), graph_(mesh), hierarchy_(detail::hierarchy_of(mesh)), front_(hierarchy_) {}

  RefinementReport update(const RefinementView& view) {
    const auto start = Clock::now();
    check(view);
    const PixelCriterion criterion(view, graph_.origin());
    if (view.faces) {
      const auto share = [&](Index split) { return criterion.share(graph_.bounds(split)); };
      const FrontMoves moves = front_.adapt_within(graph_, share, 1, *view.faces);
      return report(moves, largest_left(criterion), start);
    }
    float largest = 0;  // of those that were found small enough
    const FrontMoves moves = front_.adapt(graph_, [&](Index split) {
      const RefinementBounds& bounds = graph_.bounds(split);
      if (criterion.share(bounds) > 1) return true;
      largest = std::max(largest, criterion.pixels(bounds));
      return false;
    });
    return report(moves, static_cast<double>(largest), start);
  }

  RefinementReport update(double error) {
    const auto start = Clock::now();
    if (!(error >= 0)) throw OptionError("the error must not be negative");
    const FrontMoves moves =
        front_.adapt(graph_, [&](Index split) { return mesh_.level_errors[split] > error; });
    return report(moves, 0, start);
  }

  const RefinedGraph& graph() const { return graph_; }
  const VertexFront& front() const { return front_; }

 private:
  double largest_left(const PixelCriterion& criterion) const {
    float largest = 0;
    front_.each_next([&](Index split) {
      if (graph_.is_ready(split)) largest = std::max(largest, criterion.pixels(graph_.bounds(split)));
    });
    return static_cast<double>(largest);
  }

  RefinementReport report(const FrontMoves& moves, double pixel_error, Clock::time_point start) const {
    return {graph_.size(), moves.splits, moves.forced,
            moves.merges,  pixel_error,  std::chrono::duration<double>(Clock::now() - start).count()};
  }

  const ProgressiveMesh& mesh_;
  RefinedGraph graph_;
  VertexHierarchy hierarchy_;
  VertexFront front_;
};

SelectiveMesh::SelectiveMesh(const ProgressiveMesh& mesh) : impl_(std::make_unique<Impl>(mesh)) {}
SelectiveMesh::SelectiveMesh(SelectiveMesh&&) noexcept = default;
SelectiveMesh& SelectiveMesh::operator=(SelectiveMesh&&) noexcept = default;
SelectiveMesh::~SelectiveMesh() = default;

RefinementReport SelectiveMesh::update(const RefinementView& view) { return impl_->update(view); }
RefinementReport SelectiveMesh::update(double error) { return impl_->update(error); }
PolygonSoup SelectiveMesh::soup() const { return impl_->graph().state().soup(false); }
const std::vector<Index>& SelectiveMesh::faces() const { return impl_->graph().faces(); }
const std::vector<Vec3>& SelectiveMesh::positions() const { return impl_->graph().state().positions(); }
const std::vector<Index>& SelectiveMesh::corner_vertices() const {
  return impl_->graph().state().corner_vertices();
}
bool SelectiveMesh::is_corner_alive(Index corner) const {
  return impl_->graph().state().is_corner_alive(corner);
}
bool SelectiveMesh::is_applied(std::size_t split) const {
  return impl_->front().is_applied(static_cast<Index>(split));
}

}  // namespace recede
