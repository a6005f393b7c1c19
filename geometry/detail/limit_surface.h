// The limit surface of a control mesh, face by face: what Recede asks of OpenSubdiv.
#pragma once

#include <recede/geometry/detail/control_mesh.h>

#include <memory>
#include <span>

namespace recede::detail {

/// Serves any number of `FaceLimit` at once.
class LimitSurface {
 public:
  /// Exact at the points of grids up to `grid_level`. `control` must stay.
  LimitSurface(const ControlMesh& control, const SubdivisionOptions& options, int grid_level);
  ~LimitSurface();

  /// Normals where all edges are smooth, of unit length up to their sign; else (0,0,0).
  const std::vector<Vec3>& vertex_normals() const;       ///< V
  const std::vector<Vec3>& face_center_normals() const;  ///< F with Catmull-Clark, else none
  /// Colours, then scalars.
  std::size_t n_attributes() const;

  struct Data;
  const Data& data() const { return *data_; }

 private:
  std::unique_ptr<Data> data_;
};

/// Evaluates one face after the other.
class FaceLimit {
 public:
  explicit FaceLimit(const LimitSurface& surface);
  ~FaceLimit();

  struct Point {
    Vec3 position{0, 0, 0}, du{0, 0, 0}, dv{0, 0, 0};
  };
  void set_face(std::size_t face, bool with_attributes);
  Point at(const Vec2& coordinate) const;
  Vec3 position(const Vec2& coordinate) const;
  /// Needs `with_attributes`, like `uv`.
  void attributes(const Vec2& coordinate, std::span<double> values) const;
  Vec2 uv(const Vec2& coordinate) const;

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace recede::detail
