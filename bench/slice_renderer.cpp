#include "slice_renderer.h"

#include <recede/geometry/error.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

namespace recede::bench {
namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();
constexpr int k_band_rows = 16;

/// Half of a slice or of a face.
struct SliceTriangle {
  int slab = 0, quad = 0;
  std::array<Vec3, 3> locals, places;
  std::array<double, 3> depths;
  // Weights of the second and third corner, and of the first, at a pixel: c + x dx + y dy.
  std::array<Vec3, 3> weights;
  int top = 0, bottom = -1;  // rows that it may cover
};

template <typename Value>
Value trilinear(const std::array<Value, 8>& corners, const Vec3& at) {
  Value sum = Value::Zero();
  for (std::size_t c = 0; c < 8; ++c) {
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) weight *= ((c >> axis) & 1) != 0 ? at[axis] : 1 - at[axis];
    sum += weight * corners[c];
  }
  return sum;
}

/// Change of a corner's value along an axis of the slab.
Vec3 derivative(const std::array<Vec3, 8>& corners, const Vec3& at, int axis) {
  Vec3 low = at, high = at;
  low[axis] = 0;
  high[axis] = 1;
  return trilinear(corners, high) - trilinear(corners, low);
}

double depth_of(const SliceView& view, const Vec3& point) {
  return (point - view.frame.position).dot(view.frame.forward);
}

Vec2 screen_of(const SliceView& view, const Vec3& point, double depth) {
  const Vec3 off = point - view.frame.position;
  const double side = view.is_parallel ? view.frame.pixel : view.frame.pixel * depth;
  return view.frame.middle + Vec2(off.dot(view.frame.right), -off.dot(view.frame.up)) / side;
}

/// The triangles of a picture, slab by slab from the nearest on, and which of them each band of rows sees.
class SliceGeometry {
 public:
  SliceGeometry(const std::vector<Slab>& slabs, const SliceView& view, int slices, bool with_sides,
                double border_offset)
      : view_(view), slices_(slices), with_sides_(with_sides), offset_(border_offset) {
    if (slices < 2) throw OptionError("a slab needs two slices and more");
    std::vector<double> depths;
    for (const Slab& slab : slabs) {
      double sum = 0;
      for (const Vec3& corner : slab.corners) {
        const double depth = depth_of(view, corner);
        if (!view.is_parallel && !(depth > 0)) throw InputError("a slab isn't in front of the camera");
        near_ = std::min(near_, depth);
        far_ = std::max(far_, depth);
        sum += depth;
      }
      depths.push_back(sum);
    }
    std::vector<std::size_t> order(slabs.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return depths[a] < depths[b]; });
    for (const std::size_t s : order) add_slab(slabs[s], static_cast<int>(s));
    bands_.resize(static_cast<std::size_t>((view.height + k_band_rows - 1) / k_band_rows));
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const SliceTriangle& triangle = triangles_[t];
      for (int band = triangle.top / k_band_rows;
           triangle.top <= triangle.bottom && band <= triangle.bottom / k_band_rows; ++band)
        bands_[static_cast<std::size_t>(band)].push_back(static_cast<std::uint32_t>(t));
    }
  }

  std::size_t n_bands() const { return bands_.size(); }
  double near() const { return near_; }
  double far() const { return far_; }

  /// `visit(pixel, triangle, weights, depth)` for each pixel's middle of a band that a triangle covers, from
  /// the nearest triangles on or from the farthest.
  template <typename Visit>
  void for_each_fragment(std::size_t band, bool from_far, Visit&& visit) const {
    const std::vector<std::uint32_t>& triangles = bands_[band];
    for (std::size_t n = 0; n < triangles.size(); ++n) {
      const SliceTriangle& triangle = triangles_[triangles[from_far ? triangles.size() - 1 - n : n]];
      const int first = static_cast<int>(band) * k_band_rows;
      const int bottom = std::min(triangle.bottom, first + k_band_rows - 1);
      for (int y = std::max(triangle.top, first); y <= bottom; ++y) draw_row(triangle, y, visit);
    }
  }

 private:
  template <typename Visit>
  void draw_row(const SliceTriangle& triangle, int y, Visit& visit) const {
    // So that a pixel whose middle is on the side of two triangles isn't missed by both.
    constexpr double k_rounding = 1e-9;
    std::array<double, 3> at_left;
    double from = 0, to = view_.width - 1;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& weight = triangle.weights[k];
      at_left[k] = weight.x() + 0.5 * weight.y() + (y + 0.5) * weight.z();
      const double end = (-k_rounding - at_left[k]) / weight.y();
      if (weight.y() > 0) {
        from = std::max(from, std::ceil(end));
      } else if (weight.y() < 0) {
        to = std::min(to, std::floor(end));
      } else if (at_left[k] < -k_rounding) {
        return;
      }
    }
    const int last = static_cast<int>(std::max(to, -1.0));
    for (int x = static_cast<int>(std::min<double>(from, view_.width)); x <= last; ++x) {
      std::array<double, 3> weights;
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        weights[k] = at_left[k] + x * triangle.weights[k].y();
        if (!view_.is_parallel) weights[k] /= triangle.depths[k];
        sum += weights[k];
      }
      double depth = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        weights[k] /= sum;
        depth += weights[k] * triangle.depths[k];
      }
      visit(static_cast<std::size_t>(y) * static_cast<std::size_t>(view_.width) + static_cast<std::size_t>(x),
            triangle, weights, depth);
    }
  }

  /// Across which slices lie: the mean of both ends' normals is nearest to the view.
  int pick_axis(const Slab& slab) const {
    const Vec3 center = trilinear(slab.corners, Vec3::Constant(0.5));
    const Vec3 along = view_.is_parallel ? view_.frame.forward : Vec3(center - view_.frame.position);
    int best = 0;
    double most = -1;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 normal = Vec3::Zero();
      for (const double end : {0.0, 1.0}) {
        Vec3 middle = Vec3::Constant(0.5);
        middle[axis] = end;
        normal += derivative(slab.corners, middle, (axis + 1) % 3)
                      .cross(derivative(slab.corners, middle, (axis + 2) % 3))
                      .stableNormalized();
      }
      const double facing = std::abs(normal.dot(along));
      if (facing > most) {
        most = facing;
        best = axis;
      }
    }
    return best;
  }

  void add_slab(const Slab& slab, int number) {
    const int axis = pick_axis(slab);
    const auto inwards = [&](double share) { return offset_ + (1 - 2 * offset_) * share; };
    std::array<double, 2> ends;
    for (const int end : {0, 1}) {
      Vec3 middle = Vec3::Constant(0.5);
      middle[axis] = end;
      ends[static_cast<std::size_t>(end)] = depth_of(view_, trilinear(slab.corners, middle));
    }
    for (int m = 0; m < slices_; ++m) {
      const int slice = ends[0] <= ends[1] ? m : slices_ - 1 - m;
      add_quad(slab, number, axis, inwards(static_cast<double>(slice) / (slices_ - 1)));
    }
    // The other two faces are slices.
    for (int side = 1; side <= 2 && with_sides_; ++side)
      for (const double end : {0.0, 1.0}) add_quad(slab, number, (axis + side) % 3, inwards(end));
  }

  void add_quad(const Slab& slab, int number, int axis, double share) {
    std::array<Vec3, 4> locals, points, places;
    std::array<double, 4> depths;
    std::array<Vec2, 4> screen;
    for (std::size_t c = 0; c < 4; ++c) {
      locals[c][axis] = share;
      locals[c][(axis + 1) % 3] = c == 1 || c == 2 ? 1 : 0;
      locals[c][(axis + 2) % 3] = c >= 2 ? 1 : 0;
      points[c] = trilinear(slab.corners, locals[c]);
      places[c] = trilinear(slab.places, locals[c]);
      depths[c] = depth_of(view_, points[c]);
      screen[c] = screen_of(view_, points[c], depths[c]);
    }
    for (const std::array<std::size_t, 3>& corners : {std::array<std::size_t, 3>{0, 1, 2}, {0, 2, 3}}) {
      SliceTriangle triangle;
      triangle.slab = number;
      triangle.quad = n_quads_;
      std::array<Vec2, 3> at;
      for (std::size_t k = 0; k < 3; ++k) {
        triangle.locals[k] = locals[corners[k]];
        triangle.places[k] = places[corners[k]];
        triangle.depths[k] = depths[corners[k]];
        at[k] = screen[corners[k]];
      }
      if (place_on_screen(at, triangle)) triangles_.push_back(triangle);
    }
    ++n_quads_;
  }

  /// False: seen from its side, or beside the picture.
  bool place_on_screen(const std::array<Vec2, 3>& at, SliceTriangle& triangle) const {
    const Vec2 u = at[1] - at[0], v = at[2] - at[0];
    const double area = u.x() * v.y() - u.y() * v.x();
    if (std::abs(area) <= 1e-12 * u.norm() * v.norm() || area == 0) return false;
    const Vec2 along_u = Vec2(v.y(), -v.x()) / area, along_v = Vec2(-u.y(), u.x()) / area;
    triangle.weights[1] = Vec3(-along_u.dot(at[0]), along_u.x(), along_u.y());
    triangle.weights[2] = Vec3(-along_v.dot(at[0]), along_v.x(), along_v.y());
    triangle.weights[0] = Vec3::UnitX() - triangle.weights[1] - triangle.weights[2];
    const double high = std::min({at[0].y(), at[1].y(), at[2].y()}),
                 low = std::max({at[0].y(), at[1].y(), at[2].y()}),
                 left = std::min({at[0].x(), at[1].x(), at[2].x()}),
                 right = std::max({at[0].x(), at[1].x(), at[2].x()});
    if (low < 0 || right < 0 || high > view_.height || left > view_.width) return false;
    triangle.top = static_cast<int>(std::max(0.0, std::floor(high - 0.5)));
    triangle.bottom = std::min(view_.height - 1, static_cast<int>(std::ceil(std::min(low, 1e9))));
    return true;
  }

  SliceView view_;
  int slices_;
  bool with_sides_;
  double offset_;
  double near_ = k_infinity, far_ = -k_infinity;
  int n_quads_ = 0;
  std::vector<SliceTriangle> triangles_;
  std::vector<std::vector<std::uint32_t>> bands_;
};

Vec3 blend(const std::array<Vec3, 3>& values, const std::array<double, 3>& weights) {
  return weights[0] * values[0] + weights[1] * values[1] + weights[2] * values[2];
}

/// Depths as a buffer of some bits has them.
class DepthBuffer {
 public:
  DepthBuffer(const SliceGeometry& geometry, const SliceView& view, int bits)
      : is_parallel_(view.is_parallel),
        bits_(bits),
        near_(geometry.near()),
        range_(is_parallel_ ? geometry.far() - near_ : 1 / near_ - 1 / geometry.far()) {}

  bool is_before(double depth, double stored) const {
    if (bits_ == 0) return depth < stored;
    const std::uint32_t dropped = (std::uint32_t{1} << (k_bits - bits_)) - 1;
    return steps(depth) < (steps(stored) & ~dropped);
  }

 private:
  static constexpr int k_bits = 24;

  std::uint32_t steps(double depth) const {
    const double share = (is_parallel_ ? depth - near_ : 1 / near_ - 1 / depth) / range_;
    return static_cast<std::uint32_t>(std::clamp(share, 0.0, 1.0) * ((1 << k_bits) - 1));
  }

  bool is_parallel_;
  int bits_;
  double near_, range_;
};

/// A gradient of texture coordinates as a normal in space.
Vec3 normal_of(const Slab& slab, const Vec3& local, const Vec3& gradient) {
  std::array<Vec3, 3> along;
  Vec3 rates;  // of opacity along the slab's axes
  for (int axis = 0; axis < 3; ++axis) {
    along[static_cast<std::size_t>(axis)] = derivative(slab.corners, local, axis);
    rates[axis] = derivative(slab.places, local, axis).dot(gradient);
  }
  Vec3 normal = Vec3::Zero();
  for (std::size_t axis = 0; axis < 3; ++axis)
    normal -= rates[static_cast<int>(axis)] * along[(axis + 1) % 3].cross(along[(axis + 2) % 3]);
  if (along[0].dot(along[1].cross(along[2])) < 0) normal = -normal;
  return normal.stableNormalized();
}

class SlicePasses {
 public:
  SlicePasses(const std::vector<Slab>& slabs, const OpacityField& field, const SliceGeometry& geometry,
              const DepthBuffer& depths)
      : slabs_(slabs), field_(field), geometry_(geometry), depths_(depths) {}

  /// The nearest fragments inside. Returns how many fragments there are in all. Pixels count from `first` on.
  std::size_t find_inside(std::size_t band, std::size_t first, std::vector<SliceFragment>& inside) const {
    std::size_t count = 0;
    geometry_.for_each_fragment(
        band, false, [&](std::size_t pixel, const auto& triangle, const auto& weights, double depth) {
          ++count;
          SliceFragment& nearest = inside[pixel - first];
          if (nearest.slab >= 0 && depth >= nearest.depth) return;
          const Vec3 place = blend(triangle.places, weights);
          const double opacity = field_.opacity(place);
          if (opacity >= 0.5)
            nearest = {triangle.slab, blend(triangle.locals, weights), place, depth, opacity};
        });
    return count;
  }

  /// The farthest fragments outside that are in front of those.
  void find_outside(std::size_t band, std::size_t first, const std::vector<SliceFragment>& inside,
                    std::vector<SliceFragment>& outside) const {
    geometry_.for_each_fragment(
        band, true, [&](std::size_t pixel, const auto& triangle, const auto& weights, double depth) {
          const SliceFragment& end = inside[pixel - first];
          SliceFragment& farthest = outside[pixel - first];
          if (end.slab < 0 || (farthest.slab >= 0 && depth <= farthest.depth) ||
              !depths_.is_before(depth, end.depth))
            return;
          const Vec3 place = blend(triangle.places, weights);
          const double opacity = field_.opacity(place);
          if (opacity < 0.5)
            farthest = {triangle.slab, blend(triangle.locals, weights), place, depth, opacity};
        });
  }

  SlicePixel refine(const SliceFragment& inside, const SliceFragment& outside,
                    SliceRefinement refinement) const {
    if (inside.slab < 0) return {};
    const Slab& slab = slabs_[static_cast<std::size_t>(inside.slab)];
    double share = 0;  // of the outside fragment
    if (refinement != SliceRefinement::none && outside.slab >= 0 &&
        slabs_[static_cast<std::size_t>(outside.slab)].texture == slab.texture)
      share = (inside.opacity - 0.5) / (inside.opacity - outside.opacity);
    const Vec3 place = inside.place + share * (outside.place - inside.place);
    Vec3 gradient;
    if (refinement == SliceRefinement::normals && share > 0)
      gradient = (1 - share) * field_.gradient(inside.place) + share * field_.gradient(outside.place);
    else
      gradient = field_.gradient(place);
    Vec3 local = inside.local;
    if (share > 0 && outside.slab == inside.slab) local += share * (outside.local - inside.local);
    return {true, inside.depth + share * (outside.depth - inside.depth), place,
            normal_of(slab, local, gradient)};
  }

 private:
  const std::vector<Slab>& slabs_;
  const OpacityField& field_;
  const SliceGeometry& geometry_;
  const DepthBuffer& depths_;
};

}  // namespace

std::vector<Slab> slabs_of(const TexturedShell& textured, const PolygonSoup& surface) {
  const std::vector<Vec3>& tops = textured.layer().tops;
  if (tops.size() != surface.positions.size() || surface.corner_uvs.empty())
    throw InputError("slabs need the shell's vertices and texture coordinates");
  std::vector<Slab> slabs;
  for (std::size_t f = 0; f < surface.n_faces(); ++f) {
    const auto vertices = surface.face(f);
    const std::size_t first = surface.face_offsets[f];
    if (vertices.size() > 4) throw InputError("slabs are over triangles and quads");
    Slab& slab = slabs.emplace_back();
    // Of a face's corners in turn.
    constexpr std::array<std::size_t, 4> k_bits{0, 1, 3, 2};
    for (std::size_t c = 0; c < 4; ++c) {
      const std::size_t corner = std::min(c, vertices.size() - 1);
      const Vec2 st = textured.coordinates.of(surface.corner_uvs[first + corner]);
      slab.corners[k_bits[c]] = surface.positions[vertices[corner]];
      slab.corners[k_bits[c] + 4] = tops[vertices[corner]];
      slab.places[k_bits[c]] = {st.x(), st.y(), 0};
      slab.places[k_bits[c] + 4] = {st.x(), st.y(), 1};
    }
  }
  return slabs;
}

OpacityField field_of(const VolumeTexture& texture) {
  return {[&texture](const Vec3& place) { return opacity_at(texture, place); },
          [&texture](const Vec3& place) { return opacity_gradient(texture, place); }};
}

SliceView slice_view(const Camera& camera) { return {frame_of(camera), camera.width, camera.height}; }

SlicePicture draw_slices(const std::vector<Slab>& slabs, const OpacityField& field, const SliceView& view,
                         const SliceOptions& options) {
  if (options.depth_bits < 0 || options.depth_bits > 24) throw OptionError("depths have up to 24 bits");
  const SliceGeometry geometry(slabs, view, options.slices, options.with_sides, options.border_offset);
  const DepthBuffer depths(geometry, view, options.depth_bits);
  const SlicePasses passes(slabs, field, geometry, depths);
  SlicePicture picture{view.width, view.height};
  const auto row = static_cast<std::size_t>(view.width);
  const std::size_t n = row * static_cast<std::size_t>(view.height);
  picture.pixels.resize(n);
  if (options.keeps_fragments) {
    picture.inside.resize(n);
    picture.outside.resize(n);
  }
  std::vector<std::size_t> counts(geometry.n_bands());
  tbb::parallel_for(std::size_t{0}, geometry.n_bands(), [&](std::size_t band) {
    const std::size_t first = band * k_band_rows * row, last = std::min(first + k_band_rows * row, n);
    std::vector<SliceFragment> inside(last - first), outside(last - first);
    counts[band] = passes.find_inside(band, first, inside);
    if (options.refinement != SliceRefinement::none || options.keeps_fragments)
      passes.find_outside(band, first, inside, outside);
    for (std::size_t p = first; p < last; ++p)
      picture.pixels[p] = passes.refine(inside[p - first], outside[p - first], options.refinement);
    if (!options.keeps_fragments) return;
    std::copy(inside.begin(), inside.end(), picture.inside.begin() + static_cast<std::ptrdiff_t>(first));
    std::copy(outside.begin(), outside.end(), picture.outside.begin() + static_cast<std::ptrdiff_t>(first));
  });
  picture.fragments = std::accumulate(counts.begin(), counts.end(), std::size_t{0});
  return picture;
}

std::vector<double> blend_slices(const std::vector<Slab>& slabs,
                                 const std::function<double(const Vec3& place)>& opacity,
                                 const SliceView& view, const BlendOptions& options) {
  const SliceGeometry geometry(slabs, view, options.slices, false, SliceOptions{}.border_offset);
  const double exponent =
      options.slices_of_level > 0 ? static_cast<double>(options.slices_of_level) / options.slices : 1;
  std::vector<double> open(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height), 1);
  std::vector<int> last_quads(open.size(), -1);
  tbb::parallel_for(std::size_t{0}, geometry.n_bands(), [&](std::size_t band) {
    geometry.for_each_fragment(
        band, true, [&](std::size_t pixel, const auto& triangle, const auto& weights, double) {
          // A quad's diagonal is in both of its halves.
          if (last_quads[pixel] == triangle.quad) return;
          last_quads[pixel] = triangle.quad;
          open[pixel] *= std::pow(1 - opacity(blend(triangle.places, weights)), exponent);
        });
  });
  for (double& share : open) share = 1 - share;
  return open;
}

}  // namespace recede::bench
