// Volume textures in shells as rays meet them.
#pragma once

#include <recede/render/detail/layer_cell.h>
#include <recede/render/detail/user_geometry.h>
#include <recede/render/shell_volume.h>
#include <recede/shells/detail/empty_regions.h>

#include <array>
#include <span>
#include <vector>

namespace recede::detail {

struct Hit;

/// A primitive for each cell of the layer: a hexahedron, or the prism over a triangle.
class VolumeLook {
 public:
  /// `scale` and `center` are those of the scene.
  VolumeLook(const PlacedVolume& placed, const Vec3& center, double scale);
  VolumeLook(const VolumeLook&) = delete;
  VolumeLook& operator=(const VolumeLook&) = delete;

  std::size_t n_primitives() const { return cells_.size(); }
  /// In the scaled scene.
  Box3 bounds(std::uint32_t primitive) const;

  /// u and v are those of `FacePlace`; `front` leads outwards, and of transparent matter is the mean, not
  /// unit.
  bool first_crossing(std::uint32_t primitive, const CrossingQuery& query, Crossing& crossing) const;

  Rgb color_at(const Hit& hit, const Eigen::Vector3f& direction) const;
  /// Side of a texel in the scaled scene, the shortest.
  double texel(std::uint32_t primitive) const { return static_cast<double>(texels_[primitive]); }

 private:
  // What a ray sees of the texture: a level of surfaces or of transparent matter.
  struct Choice {
    bool is_matter;
    int level;
  };
  // Six sides are met twelve times at most.
  using CellPassages = std::array<CellPassage, 6>;
  // Of a corner: how places move for steps in s and in t, at the surface and at the top.
  struct Frame {
    Eigen::Vector3f bottom_s{0, 0, 0}, bottom_t{0, 0, 0}, top_s{0, 0, 0}, top_t{0, 0, 0};

    void add(float weight, const Frame& other);
    void scale(float factor);
  };
  static bool is_alike(const Frame& a, float weight_a, const Frame& b, float weight_b);

  void set_frames();
  void set_texels();
  void set_cells(const Shell& shell, const ShellLayer& layer);
  LayerCell cell(std::uint32_t primitive) const;
  /// The prism over a triangle, whether it is a cell or not.
  LayerCell prism(std::uint32_t triangle) const;
  LayerCell cell_of(std::span<const std::uint32_t> corners) const;
  int find_passages(const LayerCell& cell, const VolumeRay& ray, CellPassages& passages) const;
  Choice choose(std::uint32_t primitive, const VolumeRay& ray, double distance) const;
  bool meet_surface(const LayerCell& cell, const VolumeRay& ray, const CellPassage& passage, int level,
                    double least, double most, Crossing& crossing) const;
  bool meet_matter(const LayerCell& cell, const VolumeRay& ray, const CellPassage& passage,
                   const Choice& choice, double least, double most, Crossing& crossing) const;
  Eigen::Matrix3d smooth_frame(const LayerCell& cell, const CellPlace& place) const;
  Eigen::Vector3f outward(const LayerCell& cell, const CellPlace& place, const Vec3& gradient) const;
  Eigen::Vector3f end_normal(const LayerCell& cell, const CellPlace& place, double height) const;
  Eigen::Vector3f entry_normal(const LayerCell& cell, const VolumeRay& ray, CellPassage::Side side,
                               const VolumeTexture& texture, const CellPlace& place) const;
  void set_crossing(const CellPlace& place, double distance, Crossing& crossing) const;

  std::shared_ptr<const VolumeMipmap> texture_;
  bool is_inward_ = false;
  Rgb color_;
  std::vector<Vec3> bottoms_, directors_;  // of vertices
  std::vector<std::uint32_t> triangles_;   // three vertices each
  std::vector<Vec2> places_;               // (s, t) of corners
  std::vector<Frame> frames_;              // of corners
  struct CellCorners {
    std::array<std::uint32_t, 4> corners{0, 0, 0, 0};  // of triangles
    std::uint32_t n = 3;
  };
  std::vector<CellCorners> cells_;
  std::vector<float> texels_,
      footprints_;                     // of cells: shortest side of a texel, mean one along the surface
  std::vector<std::uint8_t> borders_;  // of cells: bit k, no neighbour beyond the side from corner k
  std::vector<Vec3> slopes_;           // of levels of surfaces: most that opacity changes for a texel
  std::vector<EmptyRegions> empty_;    // of levels of surfaces
  std::optional<VolumeView> view_;     // in the scaled scene
};

/// `look` stays in place.
RTCGeometry volume_geometry(RTCDevice device, const VolumeLook& look);

}  // namespace recede::detail
