#include <recede/geometry/detail/limit_surface.h>
#include <recede/geometry/error.h>

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <shared_mutex>

namespace recede::detail {
namespace {

namespace osd = OpenSubdiv;
using Refiner = osd::Far::TopologyRefiner;
using RefinerFactory = osd::Far::TopologyRefinerFactory<osd::Far::TopologyDescriptor>;
using Cache = osd::Bfr::SurfaceFactoryCacheThreaded<std::shared_mutex, std::shared_lock<std::shared_mutex>,
                                                    std::unique_lock<std::shared_mutex>>;
using Factory = osd::Bfr::RefinerSurfaceFactory<Cache>;
using Surface = osd::Bfr::Surface<double>;

// OpenSubdiv crashes above it. A grid of level 10 has its points still on corners of patches.
constexpr int k_deepest = 10;
// Patches this much below the level where a vertex becomes smooth have its normal to about 1e-5.
constexpr int k_smooth_depth = 6;

osd::Sdc::Options scheme_options(const SubdivisionOptions& options) {
  using Rules = osd::Sdc::Options;
  constexpr Rules::FVarLinearInterpolation k_uv_rules[] = {
      Rules::FVAR_LINEAR_NONE,          Rules::FVAR_LINEAR_CORNERS_ONLY, Rules::FVAR_LINEAR_CORNERS_PLUS1,
      Rules::FVAR_LINEAR_CORNERS_PLUS2, Rules::FVAR_LINEAR_BOUNDARIES,   Rules::FVAR_LINEAR_ALL};
  Rules rules;
  rules.SetVtxBoundaryInterpolation(options.boundary == SubdivisionBoundary::edge_only
                                        ? Rules::VTX_BOUNDARY_EDGE_ONLY
                                        : Rules::VTX_BOUNDARY_EDGE_AND_CORNER);
  rules.SetFVarLinearInterpolation(k_uv_rules[static_cast<std::size_t>(options.uv_interpolation)]);
  rules.SetCreasingMethod(options.creasing == Creasing::uniform ? Rules::CREASE_UNIFORM
                                                                : Rules::CREASE_CHAIKIN);
  return rules;
}

std::unique_ptr<Refiner> make_refiner(const ControlMesh& control, const SubdivisionOptions& options,
                                      bool with_uvs) {
  const PolygonSoup& soup = control.soup;
  std::vector<int> sizes, vertices(soup.corner_vertices.begin(), soup.corner_vertices.end());
  for (std::size_t f = 0; f < soup.n_faces(); ++f) sizes.push_back(static_cast<int>(soup.face_size(f)));
  std::vector<int> crease_ends, corners;
  std::vector<float> crease_sharpness, corner_sharpness;
  for (std::size_t e = 0; e < control.edges.n_edges(); ++e) {
    if (!(control.edge_sharpness[e] > 0)) continue;
    const Index side = control.edges.sides(e)[0];
    crease_ends.push_back(static_cast<int>(control.from(side)));
    crease_ends.push_back(static_cast<int>(control.to(side)));
    crease_sharpness.push_back(control.edge_sharpness[e]);
  }
  for (std::size_t v = 0; v < soup.positions.size(); ++v) {
    if (!(control.vertex_sharpness[v] > 0)) continue;
    corners.push_back(static_cast<int>(v));
    corner_sharpness.push_back(control.vertex_sharpness[v]);
  }
  osd::Far::TopologyDescriptor mesh;
  mesh.numVertices = static_cast<int>(soup.positions.size());
  mesh.numFaces = static_cast<int>(sizes.size());
  mesh.numVertsPerFace = sizes.data();
  mesh.vertIndicesPerFace = vertices.data();
  mesh.numCreases = static_cast<int>(crease_sharpness.size());
  mesh.creaseVertexIndexPairs = crease_ends.data();
  mesh.creaseWeights = crease_sharpness.data();
  mesh.numCorners = static_cast<int>(corners.size());
  mesh.cornerVertexIndices = corners.data();
  mesh.cornerWeights = corner_sharpness.data();
  const std::vector<int> uvs(control.corner_uv_numbers.begin(), control.corner_uv_numbers.end());
  osd::Far::TopologyDescriptor::FVarChannel channel;
  channel.numValues = static_cast<int>(control.n_uv_numbers);
  channel.valueIndices = uvs.data();
  if (with_uvs && !uvs.empty()) {
    mesh.numFVarChannels = 1;
    mesh.fvarChannels = &channel;
  }
  const auto scheme =
      options.scheme == SubdivisionScheme::loop ? osd::Sdc::SCHEME_LOOP : osd::Sdc::SCHEME_CATMARK;
  std::unique_ptr<Refiner> refiner(
      RefinerFactory::Create(mesh, RefinerFactory::Options(scheme, scheme_options(options))));
  if (!refiner) throw InputError("control mesh: OpenSubdiv can't hold it");
  return refiner;
}

/// A position as OpenSubdiv's refinement wants it.
struct RefinedPoint {
  Vec3 at{0, 0, 0};
  void Clear() { at.setZero(); }
  void AddWithWeight(const RefinedPoint& other, double weight) { at += weight * other.at; }
};

}  // namespace

struct LimitSurface::Data {
  const ControlMesh& control;
  std::unique_ptr<Refiner> refiner;
  std::unique_ptr<Factory> factory;
  std::vector<double> attributes;  // of all vertices
  std::size_t n_attributes = 0;
  std::vector<Vec2> uvs;  // by number
  std::vector<Vec3> vertex_normals, face_center_normals;

  void gather_attributes();
  void find_normals(const SubdivisionOptions& options);
};

void LimitSurface::Data::gather_attributes() {
  const PolygonSoup& soup = control.soup;
  n_attributes = (soup.vertex_colors.empty() ? 0 : 4) + soup.vertex_scalars.size();
  for (std::size_t v = 0; v < soup.positions.size() && n_attributes > 0; ++v) {
    if (!soup.vertex_colors.empty()) {
      for (Eigen::Index i = 0; i < 4; ++i) attributes.push_back(soup.vertex_colors[v][i]);
    }
    for (const VertexScalar& scalar : soup.vertex_scalars) attributes.push_back(scalar.values[v]);
  }
  uvs.resize(control.n_uv_numbers);
  for (std::size_t c = 0; c < control.corner_uv_numbers.size(); ++c)
    uvs[control.corner_uv_numbers[c]] = soup.corner_uvs[c];
}

/// By the limit masks after one refinement, where all faces of Catmull-Clark are quads: at extraordinary
/// points the patches' derivatives are only near them.
void LimitSurface::Data::find_normals(const SubdivisionOptions& options) {
  const PolygonSoup& soup = control.soup;
  const std::unique_ptr<Refiner> once = make_refiner(control, options, false);
  Refiner::UniformOptions levels(1);
  levels.fullTopologyInLastLevel = true;
  once->RefineUniform(levels);
  const osd::Far::PrimvarRefinerReal<double> refine(*once);
  std::vector<RefinedPoint> points(soup.positions.size());
  for (std::size_t v = 0; v < points.size(); ++v) points[v].at = soup.positions[v];
  const auto n_refined = static_cast<std::size_t>(once->GetLevel(1).GetNumVertices());
  std::vector<RefinedPoint> refined(n_refined), limit(n_refined), first(n_refined), second(n_refined);
  refine.Interpolate(1, points, refined);
  refine.Limit(refined, limit, first, second);
  const auto normal = [&](int point) {
    const auto k = static_cast<std::size_t>(point);
    const Vec3 cross = first[k].at.cross(second[k].at);
    return cross.norm() > 0 ? Vec3(cross.normalized()) : Vec3(0, 0, 0);
  };
  std::vector<bool> is_smooth(soup.positions.size());
  for (std::size_t v = 0; v < soup.positions.size(); ++v) is_smooth[v] = control.vertex_sharpness[v] == 0;
  for (std::size_t e = 0; e < control.edges.n_edges(); ++e) {
    if (control.edge_sharpness[e] == 0 && !control.is_sharp(e)) continue;
    const Index side = control.edges.sides(e)[0];
    is_smooth[control.from(side)] = false;
    is_smooth[control.to(side)] = false;
  }
  const osd::Far::TopologyLevel& base = once->GetLevel(0);
  vertex_normals.assign(soup.positions.size(), Vec3(0, 0, 0));
  for (std::size_t v = 0; v < vertex_normals.size(); ++v) {
    if (is_smooth[v]) vertex_normals[v] = normal(base.GetVertexChildVertex(static_cast<int>(v)));
  }
  if (options.scheme == SubdivisionScheme::loop) return;
  for (std::size_t f = 0; f < soup.n_faces(); ++f)
    face_center_normals.push_back(normal(base.GetFaceChildVertex(static_cast<int>(f))));
}

LimitSurface::LimitSurface(const ControlMesh& control, const SubdivisionOptions& options, int grid_level)
    : data_(new Data{control, nullptr, nullptr, {}, 0, {}, {}, {}}) {
  data_->refiner = make_refiner(control, options, true);
  float sharpest = 0;        // of what becomes smooth
  bool has_endless = false;  // what stays sharp is the better the deeper where it ends
  const auto look_at = [&](float sharpness) {
    const bool is_endless = sharpness >= float{k_infinite_sharpness};
    has_endless = has_endless || is_endless;
    if (!is_endless) sharpest = std::max(sharpest, sharpness);
  };
  for (const float sharpness : control.edge_sharpness) look_at(sharpness);
  for (const float sharpness : control.vertex_sharpness) look_at(sharpness);
  const int least = sharpest > 0 ? static_cast<int>(std::ceil(sharpest)) + k_smooth_depth : 2;
  const int smooth = std::clamp(grid_level, std::min(least, k_deepest), k_deepest);
  const int sharp = has_endless ? k_deepest : std::max(smooth, k_smooth_depth);
  Factory::Options factory_options;
  factory_options.SetApproxLevelSmooth(smooth).SetApproxLevelSharp(sharp).SetDefaultFVarID(0);
  data_->factory = std::make_unique<Factory>(*data_->refiner, factory_options);
  data_->gather_attributes();
  data_->find_normals(options);
}

LimitSurface::~LimitSurface() = default;
const std::vector<Vec3>& LimitSurface::vertex_normals() const { return data_->vertex_normals; }
const std::vector<Vec3>& LimitSurface::face_center_normals() const { return data_->face_center_normals; }
std::size_t LimitSurface::n_attributes() const { return data_->n_attributes; }

struct FaceLimit::Scratch {
  const LimitSurface::Data& data;
  Surface shape, texture;
  std::vector<double> shape_points, attribute_points, texture_points;

  static void prepare(const Surface& surface, const double* mesh, int size, std::vector<double>& points) {
    points.resize(static_cast<std::size_t>(surface.GetNumPatchPoints() * size));
    surface.PreparePatchPoints(mesh, size, points.data(), size);
  }
};

FaceLimit::FaceLimit(const LimitSurface& surface)
    : scratch_(new Scratch{surface.data(), {}, {}, {}, {}, {}}) {}
FaceLimit::~FaceLimit() = default;

void FaceLimit::set_face(std::size_t face, bool with_attributes) {
  Scratch& s = *scratch_;
  const auto index = static_cast<int>(face);
  if (!s.data.factory->InitVertexSurface(index, &s.shape))
    throw InputError("control mesh: face " + std::to_string(face) + " has no limit surface");
  Scratch::prepare(s.shape, s.data.control.soup.positions[0].data(), 3, s.shape_points);
  if (!with_attributes) return;
  if (s.data.n_attributes > 0) {
    Scratch::prepare(s.shape, s.data.attributes.data(), static_cast<int>(s.data.n_attributes),
                     s.attribute_points);
  }
  if (s.data.uvs.empty()) return;
  if (!s.data.factory->InitFaceVaryingSurface(index, &s.texture))
    throw InputError("control mesh: face " + std::to_string(face) + " has no texture coordinates");
  Scratch::prepare(s.texture, s.data.uvs[0].data(), 2, s.texture_points);
}

FaceLimit::Point FaceLimit::at(const Vec2& coordinate) const {
  Point point;
  scratch_->shape.Evaluate(coordinate.data(), scratch_->shape_points.data(), 3, point.position.data(),
                           point.du.data(), point.dv.data());
  return point;
}

Vec3 FaceLimit::position(const Vec2& coordinate) const {
  Vec3 position;
  scratch_->shape.Evaluate(coordinate.data(), scratch_->shape_points.data(), 3, position.data());
  return position;
}

void FaceLimit::attributes(const Vec2& coordinate, std::span<double> values) const {
  scratch_->shape.Evaluate(coordinate.data(), scratch_->attribute_points.data(),
                           static_cast<int>(values.size()), values.data());
}

Vec2 FaceLimit::uv(const Vec2& coordinate) const {
  Vec2 uv;
  scratch_->texture.Evaluate(coordinate.data(), scratch_->texture_points.data(), 2, uv.data());
  return uv;
}

}  // namespace recede::detail
