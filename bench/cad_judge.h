// How far triangles of CAD faces are from the file's own surfaces, and what is wrong with them, whoever made
// them.
#pragma once

#include "cad_models.h"

#include <array>
#include <vector>

namespace recede::bench {

/// Triangles of a face, counter-clockwise in the plane of (u, v).
struct CadFaceMesh {
  std::size_t face = 0;  ///< of its body
  std::vector<Vec2> uvs;
  std::vector<Vec3> positions;
  std::vector<std::array<Index, 3>> triangles;
};

struct CadBodyMesh {
  std::vector<CadFaceMesh> faces;
};

/// Numbers only, so that it crosses from process to process.
struct CadJudgement {
  std::size_t triangles = 0;
  double deviation = 0;        ///< largest distance of a sample of a surface from the plane of its triangle
  std::size_t faces_over = 0;  ///< farther than the deflection
  std::size_t faces_missing = 0;      ///< without a triangle
  std::size_t inverted = 0;           ///< triangles that all corners' normals of the surface point away from
  std::size_t open_edges = 0;         ///< sides of one triangle alone, after welding
  std::size_t closed_open_edges = 0;  ///< those of bodies that the file closes
  double surface_gap = 0;  ///< largest distance of patches from the file's surfaces, where they were sampled
};

struct CadJudgeOptions {
  double deflection = 0;
  /// Of a face, spread over triangles by area, one in each at least.
  std::size_t samples = 10'000;
  /// Parameters are those of the patches of the model, otherwise those of the file's surfaces.
  bool of_patches = false;
};

/// `meshes` are those of the bodies.
CadJudgement judge(const CadSubject& subject, const std::vector<CadBodyMesh>& meshes,
                   const CadJudgeOptions& options);

/// Triangles of all faces as they are, each face with points of its own.
PolygonSoup soup_of(const CadSubject& subject, const std::vector<CadBodyMesh>& meshes);

/// Sides of one triangle alone after points within 1e-9 of the diagonal are one.
std::size_t count_open_edges(const CadBodyMesh& mesh, double diagonal);

}  // namespace recede::bench
