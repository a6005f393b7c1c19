#include <recede/geometry/error.h>
#include <recede/lod/detail/face_clustering.h>
#include <recede/lod/detail/plane_cover.h>

#include <tbb/parallel_for.h>

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
  const bool has_limit = options.method == BillboardMethod::face_clustering;
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
  } else {
    for (BillboardCloud& cloud : clouds) {
      cloud.billboards = billboards_on(cover_by_planes(faces, cloud.error / faces.size, progress), faces,
                                       options.is_two_sided);
    }
  }
  return clouds;
}

}  // namespace recede
