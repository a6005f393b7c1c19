#include <recede/geometry/closest_point.h>
#include <recede/geometry/detail/nearest_points.h>
#include <recede/geometry/error.h>
#include <recede/lod/billboard_level.h>
#include <recede/lod/detail/hierarchy_options.h>
#include <recede/lod/detail/switch_distances.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace recede {

namespace {

// Of the texels that are drawn.
std::vector<Vec3> places_of(const BillboardTextures& textures) {
  constexpr int k_drawn = 128;
  std::vector<Vec3> places;
  for (std::size_t b = 0; b < textures.billboards.size(); ++b) {
    const Billboard& billboard = textures.billboards[b];
    const BillboardPlace& place = textures.places[b];
    for (int y = 0; y < place.height; ++y) {
      for (int x = 0; x < place.width; ++x) {
        if (textures.color.at(place.x + x, place.y + y, 3) < k_drawn) continue;
        const double height = 2 * textures.height.at(place.x + x, place.y + y) / 255.0 - 1;
        places.push_back(billboard.center +
                         (2 * (x + 0.5) / place.width - 1) * billboard.half_sizes.x() * billboard.axis_u +
                         (1 - 2 * (y + 0.5) / place.height) * billboard.half_sizes.y() * billboard.axis_v +
                         height * textures.height_range * billboard.normal());
      }
    }
  }
  return places;
}

// Middles of triangles, and of the parts of larger ones.
struct SurfaceSamples {
  std::vector<Vec3> places;
  std::vector<double> areas;

  void add(const Vec3& a, const Vec3& b, const Vec3& c, double longest) {
    const double area = (b - a).cross(c - a).norm() / 2;
    const double side = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const auto parts = static_cast<int>(std::clamp(std::ceil(side / longest), 1.0, 64.0));
    for (int i = 0; i < parts; ++i) {
      for (int j = 0; j < 2 * (parts - i) - 1; ++j) {
        // Triangles of a row, every other one upside down.
        const double third = j % 2 == 0 ? 1.0 / 3 : 2.0 / 3;
        const double u = (i + third) / parts, v = (j / 2 + third) / parts;
        places.push_back(a + u * (b - a) + v * (c - a));
        areas.push_back(area / (parts * parts));
      }
    }
  }
};

LevelError error_of(const PolygonSoup& model, const BillboardTextures& textures) {
  const std::vector<Index> triangles = triangulate(model);
  const std::vector<Vec3> drawn = places_of(textures);
  if (drawn.empty()) {  // as of something at the other end of the model
    const double size = bounding_box(model).diagonal().norm();
    return {size, size, std::max(size, textures.error)};
  }
  LevelError error;
  SurfaceSamples samples;
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
    samples.add(model.positions[triangles[t]], model.positions[triangles[t + 1]],
                model.positions[triangles[t + 2]], 2 * textures.texel);
  }
  const ClosestPointTree tree(model.positions, triangles);
  std::vector<double> from_drawn(drawn.size()), from_model(samples.places.size());
  tbb::parallel_for(std::size_t{0}, drawn.size(), [&](std::size_t i) {
    from_drawn[i] = std::sqrt(tree.closest(drawn[i]).squared_distance);
  });
  // A texel is drawn around its middle.
  const detail::NearestPoints nearest(drawn);
  const double around = textures.texel * std::sqrt(0.5);
  tbb::parallel_for(std::size_t{0}, samples.places.size(), [&](std::size_t i) {
    from_model[i] = std::max(0.0, nearest.distance(samples.places[i]) - around);
  });
  double squares = 0, weight = 0;
  for (const double distance : from_drawn) {
    error.max = std::max(error.max, distance);
    squares += distance * distance * textures.texel * textures.texel;
    weight += textures.texel * textures.texel;
  }
  for (std::size_t i = 0; i < from_model.size(); ++i) {
    error.max = std::max(error.max, from_model[i]);
    squares += from_model[i] * from_model[i] * samples.areas[i];
    weight += samples.areas[i];
  }
  error.rms = std::sqrt(squares / weight);
  error.bound = std::max(error.max, textures.error);
  return error;
}

}  // namespace

LodLevel billboard_level(const PolygonSoup& model, BillboardTextures textures, std::string reason,
                         Progress* progress) {
  report_progress(progress, "measure billboards", 0);
  LodLevel level;
  level.mesh = to_polygon_mesh(quads_of(textures));
  level.error = error_of(model, textures);
  level.stop_reason = std::move(reason);
  level.billboards = std::move(textures);
  return level;
}

void append_level(LodHierarchy& hierarchy, LodLevel level) {
  hierarchy.levels.push_back(std::move(level));
  detail::set_switch_distances(hierarchy);
}

LodHierarchy billboard_hierarchy(const PolygonSoup& model, const std::string& name,
                                 std::vector<BillboardTextures> clouds, const ViewSettings& view,
                                 Progress* progress) {
  if (clouds.empty()) throw OptionError("a hierarchy of billboards needs a cloud");
  detail::check(view);
  LodHierarchy hierarchy;
  hierarchy.name = name;
  hierarchy.view = view;
  detail::set_bounding_sphere(hierarchy, model.positions);
  for (BillboardTextures& cloud : clouds) {
    std::string reason = fmt::format("billboards of error {:.4g}", cloud.error);
    hierarchy.levels.push_back(billboard_level(model, std::move(cloud), std::move(reason), progress));
  }
  detail::set_switch_distances(hierarchy);
  return hierarchy;
}

}  // namespace recede
