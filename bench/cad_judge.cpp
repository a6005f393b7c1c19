#include "cad_judge.h"

#include <recede/geometry/bezier_patches.h>

#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <ElSLib.hxx>
#include <GeomAPI_ProjectPointOnSurf.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <ShapeAnalysis_Surface.hxx>
#include <Standard_Failure.hxx>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>

namespace recede::bench {
namespace {

constexpr double k_same_point = 1e-9;    // of the diagonal
constexpr double k_over = 1 + 1e-6;      // times the deflection; for rounding
constexpr double k_same_surface = 2e-7;  // of the diagonal; offset surfaces are imported within 1e-7

Vec3 to_vec(const gp_XYZ& xyz) { return {xyz.X(), xyz.Y(), xyz.Z()}; }

/// The file's surface of a face. Not for several threads.
class FileSurface {
 public:
  FileSurface(const TopoDS_Face& face, const NurbsSurface* patch, double diagonal)
      : surface_(BRep_Tool::Surface(face)), adaptor_(surface_), diagonal_(diagonal) {
    if (patch == nullptr) return;
    patch_.emplace(*patch);
    BRepTools::UVBounds(face, range_[0].begin, range_[0].end, range_[1].begin, range_[1].end);
    nearest_ = new ShapeAnalysis_Surface(surface_);
  }

  /// The point at parameters of a triangle.
  Vec3 at(const Vec2& uv) {
    const Vec2 place = to_file(uv);
    return to_vec(adaptor_.Value(place[0], place[1]).XYZ());
  }

  Vec3 normal(const Vec2& uv) {
    const Vec2 place = to_file(uv);
    gp_Pnt point;
    gp_Vec du, dv;
    adaptor_.D1(place[0], place[1], point, du, dv);
    return to_vec(du.Crossed(dv).XYZ());
  }

  double largest_gap() const { return largest_gap_; }

 private:
  /// A patch has the file's points, most with the same parameters; arcs run otherwise there.
  Vec2 to_file(const Vec2& uv) {
    if (!patch_) return uv;
    const Vec3 point = patch_->evaluate(uv);
    Vec2 place = uv;
    double gap = gap_at(place, point);
    if (gap > k_same_surface * diagonal_) {
      const gp_Pnt2d found = parameters_of({point.x(), point.y(), point.z()});
      place = {found.X(), found.Y()};
      gap = gap_at(place, point);
    }
    if (gap > k_same_surface * diagonal_) gap = search(point, gap, place);
    largest_gap_ = std::max(largest_gap_, gap);
    return place;
  }

  /// Among all foot points: the quick search may end at another one.
  double search(const Vec3& point, double gap, Vec2& place) const {
    try {
      const GeomAPI_ProjectPointOnSurf feet({point.x(), point.y(), point.z()}, surface_, range_[0].begin,
                                            range_[0].end, range_[1].begin, range_[1].end);
      if (feet.NbPoints() == 0 || feet.LowerDistance() >= gap) return gap;
      feet.LowerDistanceParameters(place[0], place[1]);
      return feet.LowerDistance();
    } catch (const Standard_Failure&) {
      return gap;
    }
  }

  double gap_at(const Vec2& place, const Vec3& point) const {
    return (to_vec(adaptor_.Value(place[0], place[1]).XYZ()) - point).norm();
  }

  gp_Pnt2d parameters_of(const gp_Pnt& point) {
    double u = 0, v = 0;
    switch (adaptor_.GetType()) {
      case GeomAbs_Cylinder:
        ElSLib::Parameters(adaptor_.Cylinder(), point, u, v);
        break;
      case GeomAbs_Cone:
        ElSLib::Parameters(adaptor_.Cone(), point, u, v);
        break;
      case GeomAbs_Sphere:
        ElSLib::Parameters(adaptor_.Sphere(), point, u, v);
        break;
      case GeomAbs_Torus:
        ElSLib::Parameters(adaptor_.Torus(), point, u, v);
        break;
      default:
        return nearest_->ValueOfUV(point, k_same_point * diagonal_);
    }
    return {u, v};
  }

  Handle(Geom_Surface) surface_;
  GeomAdaptor_Surface adaptor_;
  Handle(ShapeAnalysis_Surface) nearest_;
  std::optional<BezierPatches> patch_;
  std::array<ParameterRange, 2> range_;
  double diagonal_;
  double largest_gap_ = 0;
};

/// Barycentric places that fill a triangle evenly, however many are taken (Roberts 2018, the R2 sequence).
Vec3 place_in_triangle(std::size_t i) {
  const double n = static_cast<double>(i) + 0.5;
  double a = n * 0.7548776662466927, b = n * 0.5698402909980532;
  a -= std::floor(a);
  b -= std::floor(b);
  if (a + b > 1) {
    a = 1 - a;
    b = 1 - b;
  }
  return {a, b, 1 - a - b};
}

/// Of a triangle: from its plane, or from its longest side where it is as good as a line.
class TrianglePlane {
 public:
  TrianglePlane(const std::array<Vec3, 3>& corners, double diagonal) : origin_(corners[0]) {
    const Vec3 cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 side = corners[(k + 1) % 3] - corners[k];
      if (side.norm() > along_.norm()) along_ = side;
    }
    is_line_ = cross.norm() <= k_same_point * diagonal * along_.norm();
    if (!is_line_) normal_ = cross.normalized();
    if (along_.norm() > 0) along_.normalize();
  }
  double distance(const Vec3& point) const {
    const Vec3 to = point - origin_;
    return is_line_ ? (to - to.dot(along_) * along_).norm() : std::abs(to.dot(normal_));
  }

 private:
  Vec3 origin_, normal_ = Vec3::Zero(), along_ = Vec3::Zero();
  bool is_line_ = false;
};

struct FaceJudgement {
  double deviation = 0, gap = 0;
  std::size_t inverted = 0;
};

FaceJudgement judge_face(const CadFaceMesh& mesh, FileSurface& surface, const CadJudgeOptions& options,
                         double diagonal) {
  FaceJudgement result;
  const auto corners_of = [&](const std::array<Index, 3>& triangle) {
    return std::array<Vec3, 3>{mesh.positions[triangle[0]], mesh.positions[triangle[1]],
                               mesh.positions[triangle[2]]};
  };
  const auto cross_of = [&](const std::array<Vec3, 3>& at) -> Vec3 {
    return (at[1] - at[0]).cross(at[2] - at[0]);
  };
  double area = 0;
  for (const auto& triangle : mesh.triangles) area += cross_of(corners_of(triangle)).norm();
  std::vector<Vec3> normals;
  for (const Vec2& uv : mesh.uvs) normals.push_back(surface.normal(uv));
  std::size_t n = 0;
  for (const auto& triangle : mesh.triangles) {
    const std::array<Vec3, 3> corners = corners_of(triangle);
    const Vec3 cross = cross_of(corners);
    result.inverted += std::all_of(triangle.begin(), triangle.end(),
                                   [&](Index corner) { return normals[corner].dot(cross) < 0; });
    const double share = area > 0 ? cross.norm() / area : 0;
    const TrianglePlane plane(corners, diagonal);
    const auto samples =
        static_cast<std::size_t>(std::ceil(share * static_cast<double>(options.samples) + 0.5));
    for (std::size_t i = 0; i < samples; ++i) {
      const Vec3 at = place_in_triangle(n++);
      const Vec2 uv =
          at[0] * mesh.uvs[triangle[0]] + at[1] * mesh.uvs[triangle[1]] + at[2] * mesh.uvs[triangle[2]];
      result.deviation = std::max(result.deviation, plane.distance(surface.at(uv)));
    }
  }
  result.gap = surface.largest_gap();
  return result;
}

/// Points of all faces, numbered so that those at one place have one number.
class Welder {
 public:
  explicit Welder(double width) : width_(width) {}

  Index add(const Vec3& point) {
    const Eigen::Matrix<std::int64_t, 3, 1> cell =
        (point / (4 * width_)).array().floor().cast<std::int64_t>();
    for (std::int64_t x = -1; x <= 1; ++x) {
      for (std::int64_t y = -1; y <= 1; ++y) {
        for (std::int64_t z = -1; z <= 1; ++z) {
          const auto [first, last] =
              cells_.equal_range(key(cell + Eigen::Matrix<std::int64_t, 3, 1>(x, y, z)));
          for (auto at = first; at != last; ++at) {
            if ((points_[at->second] - point).norm() <= width_) return at->second;
          }
        }
      }
    }
    const auto number = static_cast<Index>(points_.size());
    points_.push_back(point);
    cells_.emplace(key(cell), number);
    return number;
  }

 private:
  static std::uint64_t key(const Eigen::Matrix<std::int64_t, 3, 1>& cell) {
    return static_cast<std::uint64_t>(cell[0]) * 0x9e3779b97f4a7c15u ^
           static_cast<std::uint64_t>(cell[1]) * 0xc2b2ae3d27d4eb4fu ^
           static_cast<std::uint64_t>(cell[2]) * 0x165667b19e3779f9u;
  }
  double width_;
  std::vector<Vec3> points_;
  std::unordered_multimap<std::uint64_t, Index> cells_;
};

}  // namespace

PolygonSoup soup_of(const CadSubject& subject, const std::vector<CadBodyMesh>& meshes) {
  PolygonSoup soup;
  for (std::size_t b = 0; b < meshes.size(); ++b) {
    for (const CadFaceMesh& face : meshes[b].faces) {
      const auto first = static_cast<Index>(soup.positions.size());
      const bool is_reversed = subject.bodies[b].faces[face.face].Orientation() == TopAbs_REVERSED;
      soup.positions.insert(soup.positions.end(), face.positions.begin(), face.positions.end());
      for (std::array<Index, 3> triangle : face.triangles) {
        if (is_reversed) std::swap(triangle[1], triangle[2]);
        for (Index& corner : triangle) corner += first;
        soup.add_face(triangle);
      }
    }
  }
  return soup;
}

std::size_t count_open_edges(const CadBodyMesh& mesh, double diagonal) {
  Welder welder(k_same_point * diagonal);
  std::vector<std::array<Index, 2>> sides;
  for (const CadFaceMesh& face : mesh.faces) {
    std::vector<Index> numbers;
    for (const Vec3& point : face.positions) numbers.push_back(welder.add(point));
    for (const auto& triangle : face.triangles) {
      const std::array<Index, 3> at{numbers[triangle[0]], numbers[triangle[1]], numbers[triangle[2]]};
      if (at[0] == at[1] || at[1] == at[2] || at[2] == at[0]) continue;
      for (std::size_t k = 0; k < 3; ++k)
        sides.push_back({std::min(at[k], at[(k + 1) % 3]), std::max(at[k], at[(k + 1) % 3])});
    }
  }
  std::sort(sides.begin(), sides.end());
  std::size_t open = 0;
  for (std::size_t i = 0; i < sides.size();) {
    const auto first = sides.begin() + static_cast<std::ptrdiff_t>(i);
    const auto end = std::upper_bound(first, sides.end(), *first);
    if (end - first == 1) ++open;
    i = static_cast<std::size_t>(end - sides.begin());
  }
  return open;
}

CadJudgement judge(const CadSubject& subject, const std::vector<CadBodyMesh>& meshes,
                   const CadJudgeOptions& options) {
  CadJudgement result;
  for (std::size_t b = 0; b < meshes.size(); ++b) {
    const CadBench& body = subject.bodies[b];
    const CadPart& part = subject.model.parts[body.part];
    const std::vector<CadFaceMesh>& faces = meshes[b].faces;
    std::vector<FaceJudgement> found(faces.size());
    tbb::parallel_for(std::size_t{0}, faces.size(), [&](std::size_t i) {
      const NurbsSurface* patch = options.of_patches ? &part.patches[i].surface : nullptr;
      FileSurface surface(body.faces[faces[i].face], patch, subject.diagonal);
      found[i] = judge_face(faces[i], surface, options, subject.diagonal);
    });
    std::vector<unsigned char> is_over(body.faces.size(), 0), is_there(body.faces.size(), 0);
    for (std::size_t i = 0; i < faces.size(); ++i) {
      result.triangles += faces[i].triangles.size();
      result.deviation = std::max(result.deviation, found[i].deviation);
      result.surface_gap = std::max(result.surface_gap, found[i].gap);
      result.inverted += found[i].inverted;
      if (found[i].deviation > k_over * options.deflection) is_over[faces[i].face] = 1;
      if (!faces[i].triangles.empty()) is_there[faces[i].face] = 1;
    }
    result.faces_over += static_cast<std::size_t>(std::count(is_over.begin(), is_over.end(), 1));
    result.faces_missing += static_cast<std::size_t>(std::count(is_there.begin(), is_there.end(), 0));
    const std::size_t open = count_open_edges(meshes[b], subject.diagonal);
    result.open_edges += open;
    if (part.is_closed) result.closed_open_edges += open;
  }
  return result;
}

}  // namespace recede::bench
