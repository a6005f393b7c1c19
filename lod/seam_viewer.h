// A CAD part as a view needs it, from frame to frame: tolerances of patches in pixels, what can't be seen,
// and no more work in a frame than it may take.
//
// J. Meseth: Towards Predictive Rendering in Virtual Reality. Dissertation, Bonn 2008, sections 6.5 to 6.8.
#pragma once

#include <recede/lod/seam_model.h>
#include <recede/lod/view_settings.h>

#include <memory>
#include <optional>

namespace recede {

struct SeamView {
  Vec3 position{0, 0, 3};
  Vec3 target = Vec3::Zero();
  Vec3 up = Vec3::UnitY();  ///< any direction but the view's own, need not be unit
  ViewSettings view{.pixel_error = 0.5};
  double aspect_ratio = 1;  ///< width of the image over its height
  /// Patches outside of the image, and in closed models those that face away, may be this many times coarser.
  double culled_factor = 4;
  /// Triangles that a frame may make anew, about; patches that need it most come first, and what is culled
  /// last. Unset: all.
  std::optional<std::size_t> most_new_triangles;
};

/// What a frame took, and what is seen in it.
struct SeamFrame {
  SeamUpdate update;
  std::size_t drawn_patches = 0, drawn_triangles = 0;  ///< that aren't culled
  std::size_t culled_patches = 0;
  std::size_t postponed = 0;    ///< patches that the budget left as they were
  double finest_tolerance = 0;  ///< of a patch that is drawn, units of the model
  /// Largest of the drawn patches: what their triangles were made for, in pixels. A patch so near that it
  /// tolerates a tenth of the seams' error counts as if that were `view.pixel_error`.
  double pixel_error = 0;
  double seconds = 0;
};

class SeamViewer {
 public:
  /// `model` must live as long.
  explicit SeamViewer(const SeamModel& model);
  SeamViewer(SeamViewer&&) noexcept;
  SeamViewer& operator=(SeamViewer&&) noexcept;
  ~SeamViewer();

  /// Goes on from the last frame. A patch tolerates `view.pixel_error` times the length that a pixel covers
  /// at its nearest point, but at least a tenth of the error of the finest seams, below which borders don't
  /// go. What is made anew is made for three fourths of that, so that it serves for some frames. Throws
  /// `OptionError` for numbers out of range or a position at its target.
  SeamFrame update(const SeamView& view);

  const SeamTessellation& tessellation() const;
  bool is_culled(std::size_t patch) const;  ///< in the last frame

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace recede
