// Where the splits of a progressive mesh act, and which way the surface faces there.
#pragma once

#include <recede/lod/progressive_mesh.h>

namespace recede::detail {

/// Of a split and all that come below it. Single precision, rounded to the safe side.
struct RefinementBounds {
  float center[3],
      radius;     ///< a sphere around all faces that are touched, relative to `HierarchyBounds::origin`
  float axis[3];  ///< unit; their normals lie within an angle around it
  float angle;    ///< radians; pi: anywhere
  float error;    ///< of the level without the split
};

struct HierarchyBounds {
  Vec3 origin = Vec3::Zero();  ///< the middle of the mesh, so that far from zero nothing is rounded away
  std::vector<RefinementBounds> splits;
  std::vector<unsigned char> starts;  ///< 1: the vertex that is split has no faces before
};

HierarchyBounds bound_hierarchy(const ProgressiveMesh& mesh);

}  // namespace recede::detail
