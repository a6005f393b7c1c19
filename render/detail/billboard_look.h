// Billboards as rays meet them.
#pragma once

#include <recede/render/billboards.h>
#include <recede/render/detail/billboard_view.h>
#include <recede/render/detail/user_geometry.h>
#include <recede/render/image.h>

#include <array>
#include <optional>

namespace recede::detail {

struct Hit;

/// A primitive for each billboard at each placement, those of a placement one after the other.
class BillboardLook {
 public:
  /// Heights reach as much farther than their range beyond the outer texels' middles.
  static constexpr double k_height_room = 1.25;

  /// `scale` and `center` are those of the scene.
  BillboardLook(const PlacedBillboards& billboards, const Vec3& center, double scale);
  BillboardLook(const BillboardLook&) = delete;
  BillboardLook& operator=(const BillboardLook&) = delete;

  std::size_t n_primitives() const { return frames_.size() * to_model_.size(); }
  /// In the scaled scene.
  Box3 bounds(std::uint32_t primitive) const;

  /// u and v are texels from the billboard's upper left corner, `front` the normal of the surface of heights.
  bool first_crossing(std::uint32_t primitive, const CrossingQuery& query, Crossing& crossing) const;

  /// Whether a ray that starts on one billboard can't meet another: itself, or with reflectance any of its
  /// placement, whose shadows are in the values already.
  bool is_passed(std::uint32_t from, std::uint32_t primitive) const {
    return from == primitive || (tables_ && from / frames_.size() == primitive / frames_.size());
  }

  bool has_reflectance() const { return tables_.has_value(); }
  /// What a hit sends back along its ray; there must be reflectance.
  BillboardView view_of(const Hit& hit, const Eigen::Vector3f& direction) const;

  /// Colour, and the unit normal in the scene, bilinear between texels.
  Rgb color_at(const Hit& hit) const;
  Eigen::Vector3f normal_at(const Hit& hit) const;
  /// Side of a texel in the scaled scene.
  double texel(std::uint32_t primitive) const { return texel_sizes_[primitive / frames_.size()]; }

 private:
  struct LocalRay;
  // Of a billboard in the model.
  struct Frame {
    Vec3 center, axis_u, axis_v, normal;
    double texel_u, texel_v;  // object units
    int width, height;        // texels
    std::size_t first;        // of its texels in the atlas

    // Along the axes and the normal, any length.
    Vec3 toward_viewer(const LocalRay& ray) const;
  };
  // The four texels around a place, and how near it is to the later ones.
  struct Cell {
    std::array<std::size_t, 4> texels;  // upper left, upper right, lower left, lower right
    float u, v;
  };

  const Frame& frame_of(std::uint32_t primitive) const { return frames_[primitive % frames_.size()]; }
  std::size_t texel_at(const Frame& frame, int x, int y) const;
  Cell cell_at(const Frame& frame, float x, float y) const;
  LocalRay local_ray(std::uint32_t primitive, const Eigen::Vector3f& origin,
                     const Eigen::Vector3f& direction) const;
  bool cross_plane(const Frame& frame, const LocalRay& ray, double least, double most,
                   Crossing& crossing) const;
  float see(const Frame& frame, float x, float y, const Vec3& toward_viewer, BillboardView& view) const;
  bool cross_cell(const Frame& frame, const LocalRay& ray, int column, int row, double from, double to,
                  Crossing& crossing) const;
  bool faces_best(std::uint32_t primitive, const Eigen::Vector3f& direction) const;
  void turn_to_scene(std::uint32_t primitive, Eigen::Vector3f& normal) const;
  template <typename Values>
  static auto blend(const Cell& cell, const Values& value);

  std::vector<Frame> frames_;
  int views_ = 0;                         // of an impostor, along each side
  std::size_t row_ = 0;                   // texels of the atlas
  double model_texel_ = 0, range_ = 0;    // object units
  std::vector<float> opacity_, heights_;  // of the atlas; heights in object units
  std::vector<std::array<std::uint8_t, 3>> colors_, normals_;
  // By placement, from and to the scaled scene.
  std::vector<Eigen::Affine3d> to_model_, to_scene_;
  std::vector<double> texel_sizes_;
  std::optional<ReflectanceTables> tables_;
};

/// Rays bring a `RayContext`. `look` stays in place.
RTCGeometry billboard_geometry(RTCDevice device, const BillboardLook& look);

}  // namespace recede::detail
