// A progressive mesh refined for a view: fine where errors would be seen, coarse elsewhere.
//
// H. Hoppe: View-Dependent Refinement of Progressive Meshes. SIGGRAPH 1997. See also vertex_hierarchy.h.
#pragma once

#include <recede/lod/progressive_mesh.h>
#include <recede/lod/view_settings.h>

#include <memory>
#include <optional>

namespace recede {

struct RefinementView {
  Vec3 position{0, 0, 3};
  Vec3 target = Vec3::Zero();
  Vec3 up = Vec3::UnitY();  ///< any direction but the view's own, need not be unit
  ViewSettings view;        ///< with the error in pixels that may be seen
  double aspect_ratio = 1;  ///< width of the image over its height
  bool cull = true;         ///< no detail outside the image
  /// Error in pixels for what faces away; unset: that of `view`. And for what may lie on a silhouette, no
  /// larger than the others; unset: the smaller of them.
  std::optional<double> back_pixel_error, silhouette_pixel_error;
  /// At most this many faces, but never fewer than the base has: then the largest errors in pixels go first.
  std::optional<std::size_t> faces;
};

/// What an update did.
struct RefinementReport {
  std::size_t faces = 0;
  std::size_t splits = 0;  ///< applied
  std::size_t forced = 0;  ///< those of them that only others needed
  std::size_t merges = 0;  ///< splits taken back
  /// No error that is left in the image is larger, pixels; with `faces` it is the largest. Infinite:
  /// detail is missing around the camera. 0 for updates by an error everywhere.
  double pixel_error = 0;
  double seconds = 0;
};

/// A progressive mesh with any splits applied that can be.
///
/// The error in pixels of a split that isn't applied is `ProgressiveMesh::level_errors` without it over the
/// length that a pixel covers (`pixel_footprint`) at the nearest point of a sphere around all faces that it
/// and the splits below it touch. Every face is one of some level whose error in pixels is at most that: with
/// proved errors, nothing in the image lies farther from the input than `RefinementReport::pixel_error` says.
class SelectiveMesh {
 public:
  /// Stands at the base. `mesh` must live as long and stay as it is.
  explicit SelectiveMesh(const ProgressiveMesh& mesh);
  SelectiveMesh(SelectiveMesh&&) noexcept;
  SelectiveMesh& operator=(SelectiveMesh&&) noexcept;
  ~SelectiveMesh();

  /// Refines and coarsens from where the last view left it. Without `faces` the result depends on the
  /// view alone. Throws `OptionError` for numbers out of range or a position at its target.
  RefinementReport update(const RefinementView& view);
  /// The level whose error is at most `error` everywhere, object units: `ProgressiveMesh::level_for_error`.
  RefinementReport update(double error);

  /// As polygons, in the order of the input; vertices without faces are left out. What `mending` puts back at
  /// the last step of the progressive mesh is left out too.
  PolygonSoup soup() const;

  // In the lists and numbers of `ProgressiveMesh`, for drawing without a copy.
  std::size_t n_faces() const { return faces().size(); }
  const std::vector<Index>& faces() const;  ///< in no order
  const std::vector<Vec3>& positions() const;
  const std::vector<Index>& corner_vertices() const;
  bool is_corner_alive(Index corner) const;
  bool is_applied(std::size_t split) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace recede
