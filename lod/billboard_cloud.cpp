#include <recede/geometry/error.h>
#include <recede/lod/detail/face_clustering.h>
#include <recede/lod/detail/plane_cover.h>
#include <recede/lod/detail/simplified_cover.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede {

namespace {

constexpr std::array<double, 4> k_default_errors{0.005, 0.01, 0.02, 0.04};  // of the model's size

void check(const BillboardOptions& options) {
  double last = 0;
  for (const double error : options.errors) {
    if (!(error > last && std::isfinite(error)))
      throw OptionError("errors of billboard clouds are above 0 and increase");
    last = error;
  }
  if (!(options.largest_deviation >= 0 && options.largest_deviation <= std::numbers::pi))
    throw OptionError("the largest deviation of normals is between 0 and 180 degrees");
  if (!(options.largest_waste >= 1)) throw OptionError("the largest waste of billboards is at least 1");
  if (options.n_neighbours < 1) throw OptionError("faces need a neighbour at least");
}

std::vector<Billboard> billboards_on(const std::vector<detail::CoveringPlane>& planes,
                                     const detail::BillboardFaces& faces, bool is_two_sided) {
  std::vector<std::vector<Billboard>> of_planes(planes.size());
  tbb::parallel_for(std::size_t{0}, planes.size(), [&](std::size_t i) {
    for (const std::vector<Index>& region : detail::regions_of(faces, planes[i]))
      of_planes[i].push_back(billboard_facing(faces, region, planes[i].normal, is_two_sided));
  });
  std::vector<Billboard> billboards;
  for (const std::vector<Billboard>& of_plane : of_planes)
    billboards.insert(billboards.end(), of_plane.begin(), of_plane.end());
  return billboards;
}

// Those of some faces alone.
detail::BillboardFaces part_of(const detail::BillboardFaces& faces, const std::vector<Index>& members) {
  detail::BillboardFaces part;
  part.points = faces.points;
  part.center = faces.center;
  part.size = faces.size;
  for (const Index face : members) {
    const std::span<const Index> corners = faces.corners_of(face);
    part.corners.insert(part.corners.end(), corners.begin(), corners.end());
    part.offsets.push_back(static_cast<Index>(part.corners.size()));
    part.numbers.push_back(faces.numbers[face]);
    part.normals.push_back(faces.normals[face]);
    part.moments.push_back(faces.moments[face]);
  }
  return part;
}

// One for each triangle; what none may take is clustered.
std::vector<Billboard> billboards_at(const detail::SimplifiedCover& cover,
                                     const detail::BillboardFaces& faces, double error,
                                     const BillboardOptions& options) {
  std::vector<Billboard> at_triangles(cover.triangles.size());
  tbb::parallel_for(std::size_t{0}, cover.triangles.size(), [&](std::size_t i) {
    const detail::CoveringPlane& triangle = cover.triangles[i];
    at_triangles[i] = billboard_facing(faces, triangle.faces, triangle.normal, options.is_two_sided);
  });
  std::vector<Billboard> billboards;
  std::vector<Index> left_over = cover.left_over;
  for (std::size_t i = 0; i < at_triangles.size(); ++i) {
    // Beyond a right angle most faces may look to the back of their triangle.
    constexpr double k_rounding = 1e-9;  // of angles
    if (at_triangles[i].error <= error &&
        at_triangles[i].normal_deviation <= options.largest_deviation + k_rounding) {
      billboards.push_back(std::move(at_triangles[i]));
    } else {
      const std::vector<Index>& members = cover.triangles[i].faces;
      left_over.insert(left_over.end(), members.begin(), members.end());
    }
  }
  if (left_over.empty()) return billboards;
  std::sort(left_over.begin(), left_over.end());
  const std::array<double, 1> errors{error};
  const std::vector<std::vector<Billboard>> clusters =
      detail::cluster_faces(part_of(faces, left_over), options, errors);
  billboards.insert(billboards.end(), clusters.front().begin(), clusters.front().end());
  return billboards;
}

}  // namespace

std::vector<BillboardCloud> build_billboard_clouds(const PolygonSoup& model, const BillboardOptions& options,
                                                   Progress* progress) {
  check(options);
  const detail::BillboardFaces faces = detail::billboard_faces_of(model);
  std::vector<double> errors = options.errors;
  if (errors.empty()) {
    for (const double share : k_default_errors) errors.push_back(share * faces.size);
  }
  std::vector<BillboardCloud> clouds;
  const bool has_limit = options.method != BillboardMethod::plane_cover;
  for (const double error : errors) {
    clouds.push_back({error,
                      {},
                      faces.left_out,
                      options.is_two_sided,
                      has_limit ? options.largest_deviation : std::numbers::pi});
  }
  if (options.method == BillboardMethod::face_clustering) {
    std::vector<std::vector<Billboard>> clusters = cluster_faces(faces, options, errors, progress);
    for (std::size_t i = 0; i < clouds.size(); ++i) clouds[i].billboards = std::move(clusters[i]);
  } else if (options.method == BillboardMethod::simplification) {
    std::vector<double> shares;
    for (const double error : errors) shares.push_back(error / faces.size);
    const std::vector<detail::SimplifiedCover> covers =
        detail::cover_by_simplification(faces, shares, options, progress);
    for (std::size_t i = 0; i < clouds.size(); ++i)
      clouds[i].billboards = billboards_at(covers[i], faces, errors[i], options);
  } else {
    for (BillboardCloud& cloud : clouds) {
      cloud.billboards = billboards_on(cover_by_planes(faces, cloud.error / faces.size, progress), faces,
                                       options.is_two_sided);
    }
  }
  return clouds;
}

}  // namespace recede
