// A part of a CAD model, prepared for all levels of detail, and its triangles at one of them.
#pragma once

#include <recede/geometry/cad_import.h>
#include <recede/lod/patch_tessellator.h>
#include <recede/lod/seam_front.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace recede {

struct SeamModel {
  std::vector<PatchSurface> surfaces;
  SeamGraph graph;
  SeamHierarchy hierarchy;
  std::vector<std::string> names;          ///< of patches
  std::vector<Index> materials;            ///< of patches
  std::vector<unsigned char> is_reversed;  ///< by patch: the front is where du x dv points away from
  std::size_t turned =
      0;            ///< patches whose front isn't the one that the file says, to agree with their neighbours
  double size = 0;  ///< the diagonal of the box of all sewing points
};

/// Of a tolerance: so little of it isn't worth closer bounds of surfaces.
inline constexpr double k_bounds_share = 0.02;

struct SeamModelOptions {
  SeamGraphOptions seams;
  SeamHierarchyOptions hierarchy;
};

/// Surfaces, Seam Graph and hierarchy. Neighbours get fronts that agree, where seams of two patches can tell;
/// the larger part of those that hang together keeps its own.
SeamModel build_seam_model(const CadPart& part, const SeamModelOptions& options = {},
                           Progress* progress = nullptr);

/// What an update of triangles did and what it reached.
struct SeamUpdate {
  FrontMoves moves;
  std::size_t triangles = 0;
  std::size_t patches = 0;      ///< that are left
  std::size_t tessellated = 0;  ///< patches triangulated anew
  std::size_t tightened =
      0;  ///< patches that needed finer seams than their tolerance: triangles turned over there
  std::size_t inverted = 0;  ///< triangles that are still turned over
  double error_bound = 0;    ///< of all patches, the largest, with what vanished
  /// Patches that couldn't be triangulated within their tolerance, as where it is below the error of the
  /// finest seams: triangles there may be coarser than those of other patches, for fine ones would be turned
  /// over beside a coarse border. Those whose loops cross have no triangles.
  std::vector<Index> refused;
};

/// How far samples of triangles, three on the sides and one within each, are from the surface at their
/// parameters.
struct SampledDeviation {
  double max = 0, rms = 0;  ///< weighted by area
  double area = 0;          ///< of the triangles
};

/// The triangles of a model at a level that can change from patch to patch, without a gap between patches.
class SeamTessellation {
 public:
  /// `model` must live as long.
  explicit SeamTessellation(const SeamModel& model);
  SeamTessellation(SeamTessellation&&) noexcept;
  SeamTessellation& operator=(SeamTessellation&&) noexcept;
  ~SeamTessellation();

  /// Brings each patch within its tolerance, in units of the model; only patches that change are
  /// triangulated.
  SeamUpdate update(std::span<const double> tolerance_of_patch);
  SeamUpdate update(double tolerance);

  const SeamModel& model() const;
  const SeamFront& front() const;
  /// Of a patch; empty: it has vanished.
  const PatchTriangles& triangles_of(std::size_t patch) const;

  SampledDeviation sampled_deviation() const;

  /// All triangles as one mesh over the sewing points that are used, with the surface's normals at corners
  /// and materials of patches.
  PolygonSoup soup() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace recede
