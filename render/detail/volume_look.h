// Volume textures in shells as rays meet them.
#pragma once

#include <recede/render/detail/user_geometry.h>
#include <recede/render/detail/volume_prism.h>
#include <recede/render/shell_volume.h>
#include <recede/shells/detail/empty_regions.h>

#include <array>
#include <vector>

namespace recede::detail {

struct Hit;

/// A primitive for each triangle of the shell's base: the prism over it.
class VolumeLook {
 public:
  /// `scale` and `center` are those of the scene.
  VolumeLook(const PlacedVolume& placed, const Vec3& center, double scale);
  VolumeLook(const VolumeLook&) = delete;
  VolumeLook& operator=(const VolumeLook&) = delete;

  std::size_t n_primitives() const { return triangles_.size() / 3; }
  /// In the scaled scene.
  Box3 bounds(std::uint32_t primitive) const;

  /// u and v are weights of the triangle's second and third corner; `front` leads outwards, and of
  /// transparent matter is the mean, not unit.
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
  // Five sides are met ten times at most.
  using PrismPassages = std::array<PrismPassage, 5>;
  // Of a corner: how places move for steps in s and in t, at the surface and at the top.
  struct Frame {
    Eigen::Vector3f bottom_s{0, 0, 0}, bottom_t{0, 0, 0}, top_s{0, 0, 0}, top_t{0, 0, 0};

    void add(float weight, const Frame& other);
    void scale(float factor);
  };
  static bool is_alike(const Frame& a, float weight_a, const Frame& b, float weight_b);

  void set_frames();
  void set_texels();
  VolumePrism prism(std::uint32_t primitive) const;
  int find_passages(const VolumePrism& prism, const VolumeRay& ray, PrismPassages& passages) const;
  Choice choose(std::uint32_t primitive, const VolumeRay& ray, double distance) const;
  bool meet_surface(const VolumePrism& prism, const VolumeRay& ray, const PrismPassage& passage, int level,
                    double least, double most, Crossing& crossing) const;
  bool meet_matter(const VolumePrism& prism, const VolumeRay& ray, const PrismPassage& passage,
                   const Choice& choice, double least, double most, Crossing& crossing) const;
  Eigen::Matrix3d smooth_frame(const VolumePrism& prism, const PrismPlace& place) const;
  Eigen::Vector3f outward(const VolumePrism& prism, const PrismPlace& place, const Vec3& gradient) const;
  Eigen::Vector3f end_normal(const VolumePrism& prism, const PrismPlace& place, double height) const;
  Eigen::Vector3f entry_normal(const VolumePrism& prism, const VolumeRay& ray, PrismPassage::Side side,
                               const VolumeTexture& texture, const PrismPlace& place) const;
  void set_crossing(const PrismPlace& place, double distance, Crossing& crossing) const;

  std::shared_ptr<const VolumeMipmap> texture_;
  bool is_inward_ = false;
  Rgb color_;
  std::vector<Vec3> bottoms_, directors_;  // of vertices
  std::vector<std::uint32_t> triangles_;   // three vertices each
  std::vector<Vec2> places_;               // (s, t) of corners
  std::vector<Frame> frames_;              // of corners
  std::vector<float> texels_,
      footprints_;                     // of triangles: shortest side of a texel, mean one along the surface
  std::vector<std::uint8_t> borders_;  // of triangles: bit k, no neighbour beyond the side from corner k
  std::vector<Vec3> slopes_;           // of levels of surfaces: most that opacity changes for a texel
  std::vector<EmptyRegions> empty_;    // of levels of surfaces
  std::optional<VolumeView> view_;     // in the scaled scene
};

/// `look` stays in place.
RTCGeometry volume_geometry(RTCDevice device, const VolumeLook& look);

}  // namespace recede::detail
