// The limit of uniform refinement by OpenSubdiv's masks: independent of patches, which Recede evaluates.
#pragma once

#include <recede/geometry/subdivision_surface.h>

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <memory>
#include <vector>

namespace recede::test {

inline std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> make_refiner(const PolygonSoup& control,
                                                                      const SubdivisionOptions& options) {
  namespace Far = OpenSubdiv::Far;
  namespace Sdc = OpenSubdiv::Sdc;
  std::vector<int> sizes, vertices(control.corner_vertices.begin(), control.corner_vertices.end()), ends;
  for (std::size_t f = 0; f < control.n_faces(); ++f) sizes.push_back(static_cast<int>(control.face_size(f)));
  std::vector<float> sharpness;
  for (const SubdivisionCrease& crease : options.creases) {
    ends.push_back(static_cast<int>(crease.first));
    ends.push_back(static_cast<int>(crease.second));
    sharpness.push_back(static_cast<float>(crease.sharpness));
  }
  Far::TopologyDescriptor mesh;
  mesh.numVertices = static_cast<int>(control.positions.size());
  mesh.numFaces = static_cast<int>(sizes.size());
  mesh.numVertsPerFace = sizes.data();
  mesh.vertIndicesPerFace = vertices.data();
  mesh.numCreases = static_cast<int>(sharpness.size());
  mesh.creaseVertexIndexPairs = ends.data();
  mesh.creaseWeights = sharpness.data();
  Sdc::Options rules;
  rules.SetVtxBoundaryInterpolation(options.boundary == SubdivisionBoundary::edge_only
                                        ? Sdc::Options::VTX_BOUNDARY_EDGE_ONLY
                                        : Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
  rules.SetCreasingMethod(options.creasing == Creasing::chaikin ? Sdc::Options::CREASE_CHAIKIN
                                                                : Sdc::Options::CREASE_UNIFORM);
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  const auto scheme = options.scheme == SubdivisionScheme::loop ? Sdc::SCHEME_LOOP : Sdc::SCHEME_CATMARK;
  return std::unique_ptr<Far::TopologyRefiner>(Factory::Create(mesh, Factory::Options(scheme, rules)));
}

struct LimitPoints {
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;  ///< unit length, or 0 on creases and borders, where there may be several
};

/// Limit positions of all vertices of a level from 1 on. Exact where no sharpness is left at it.
inline LimitPoints uniform_limit(const PolygonSoup& control, const SubdivisionOptions& options, int level) {
  struct Point {
    Vec3 at{0, 0, 0};
    void Clear() { at.setZero(); }
    void AddWithWeight(const Point& other, double weight) { at += weight * other.at; }
  };
  namespace Far = OpenSubdiv::Far;
  const auto refiner = make_refiner(control, options);
  Far::TopologyRefiner::UniformOptions levels(level);
  levels.fullTopologyInLastLevel = true;
  refiner->RefineUniform(levels);
  const Far::PrimvarRefinerReal<double> refine(*refiner);
  std::vector<Point> points(control.positions.size());
  for (std::size_t v = 0; v < points.size(); ++v) points[v].at = control.positions[v];
  for (int l = 1; l <= level; ++l) {
    std::vector<Point> next(static_cast<std::size_t>(refiner->GetLevel(l).GetNumVertices()));
    refine.Interpolate(l, points, next);
    points = std::move(next);
  }
  std::vector<Point> limit(points.size()), first(points.size()), second(points.size());
  refine.Limit(points, limit, first, second);
  const Far::TopologyLevel& last = refiner->GetLevel(level);
  LimitPoints result;
  for (std::size_t k = 0; k < points.size(); ++k) {
    result.positions.push_back(limit[k].at);
    bool is_smooth = true;
    const auto edges = last.GetVertexEdges(static_cast<int>(k));
    for (int e = 0; e < edges.size(); ++e)
      is_smooth = is_smooth && last.GetEdgeSharpness(edges[e]) == 0 && !last.IsEdgeBoundary(edges[e]);
    result.normals.push_back(is_smooth ? Vec3(first[k].at.cross(second[k].at).normalized()) : Vec3(0, 0, 0));
  }
  return result;
}

}  // namespace recede::test
