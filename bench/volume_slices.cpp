// Volume textures drawn by slices through slabs and by rays.
#include "child_process.h"
#include "measurement.h"
#include "plot_sheet.h"
#include "shell_volumes.h"
#include "slice_renderer.h"
#include <recede/render/image_difference.h>
#include <recede/shells/procedural_volumes.h>

#include <fmt/format.h>
#include <malloc.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace recede::bench {
namespace {

constexpr double k_degree = std::numbers::pi / 180;

/// A large ball, and small ones at the corners of an icosahedron (figure 5.2 of the source), around the
/// middle of the unit cube.
double cluster_distance(const Vec3& point) {
  constexpr double k_ball = 0.24, k_small = 0.08, k_corners = 0.27;
  const double golden = std::numbers::phi, length = std::sqrt(1 + golden * golden);
  const Vec3 from_middle = point - Vec3::Constant(0.5);
  double inside = k_ball - from_middle.norm();
  for (int axis = 0; axis < 3; ++axis) {
    for (const double a : {-1.0, 1.0}) {
      for (const double b : {-golden, golden}) {
        Vec3 corner;
        corner[axis] = 0;
        corner[(axis + 1) % 3] = a;
        corner[(axis + 2) % 3] = b;
        inside = std::max(inside, k_small - (from_middle - k_corners / length * corner).norm());
      }
    }
  }
  return inside;
}

/// Of a texture in the cube from (-1, -1, 0) to (1, 1, 2): a quarter of a texel a step, and halving.
std::vector<SeenVolume> march(const VolumeTexture& texture, const Camera& camera) {
  const CameraFrame frame = frame_of(camera);
  const auto place_of = [](const Vec3& point) { return Vec3((point + Vec3(1, 1, 0)) / 2); };
  std::vector<SeenVolume> seen(static_cast<std::size_t>(camera.width) *
                               static_cast<std::size_t>(camera.height));
  const double step = 2 * 0.25 / texture.size[0];
  tbb::parallel_for(0, camera.height, [&](int y) {
    for (int x = 0; x < camera.width; ++x) {
      const Vec3 direction = frame.direction(x + 0.5, y + 0.5);
      const Vec3 low = (Vec3(-1, -1, 0) - frame.position).cwiseQuotient(direction),
                 high = (Vec3(1, 1, 2) - frame.position).cwiseQuotient(direction);
      const double last = low.cwiseMax(high).minCoeff();
      double distance = low.cwiseMin(high).maxCoeff();
      const auto is_inside = [&](double at) {
        return opacity_at(texture, place_of(frame.position + at * direction)) >= 0.5;
      };
      while (distance < last && !is_inside(distance)) distance += step;
      if (!(distance < last)) continue;
      double outside = distance - step, inside = distance;
      for (int round = 0; round < 30; ++round) {
        const double middle = (outside + inside) / 2;
        (is_inside(middle) ? inside : outside) = middle;
      }
      const Vec3 place = place_of(frame.position + inside * direction);
      seen[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) +
           static_cast<std::size_t>(x)] = {true, inside * direction.dot(frame.forward),
                                           -opacity_gradient(texture, place).normalized()};
    }
  });
  return seen;
}

std::vector<SeenVolume> seen_of(const SlicePicture& picture) {
  std::vector<SeenVolume> seen;
  for (const SlicePixel& pixel : picture.pixels) seen.push_back({pixel.is_hit, pixel.depth, pixel.normal});
  return seen;
}

/// Matt and white under a lamp beside the camera.
Image lit(const std::vector<SeenVolume>& seen, const Camera& camera) {
  const CameraFrame frame = frame_of(camera);
  const Vec3 lamp = (frame.right + frame.up - 2 * frame.forward).normalized();
  Image image(camera.width, camera.height);
  for (std::size_t p = 0; p < seen.size(); ++p)
    image.pixels[p] =
        Rgb::Constant(static_cast<float>(0.05 + 0.95 * std::max(0.0, seen[p].normal.dot(lamp))));
  return image;
}

/// Beside a reference. Normals and depths where both see the surface, and depths within `k_other_surface` of
/// each other.
struct SeenErrors {
  double image = 0;    // root mean square of sRGB-encoded values
  double normal = 0;   // degrees, root mean square
  double depth = 0;    // root mean square, lengths
  double missing = 0;  // share of the pixels with a surface in either that see none, or another one
};

SeenErrors compare(const std::vector<SeenVolume>& seen, const std::vector<SeenVolume>& reference,
                   const Camera& camera, double other_surface) {
  SeenErrors errors;
  double both = 0, any = 0;
  for (std::size_t p = 0; p < seen.size(); ++p) {
    const SeenVolume &a = seen[p], &b = reference[p];
    if (!a.is_hit && !b.is_hit) continue;
    ++any;
    if (a.is_hit != b.is_hit || std::abs(a.depth - b.depth) > other_surface) continue;
    ++both;
    const double angle = std::atan2(a.normal.cross(b.normal).norm(), a.normal.dot(b.normal)) / k_degree;
    errors.normal += angle * angle;
    errors.depth += std::pow(a.depth - b.depth, 2);
  }
  errors.image = compare_images(lit(seen, camera), lit(reference, camera)).rmse;
  errors.normal = std::sqrt(errors.normal / both);
  errors.depth = std::sqrt(errors.depth / both);
  errors.missing = 1 - both / any;
  return errors;
}

struct SliceRow {
  const char* name;
  int slices;
  SliceRefinement refinement;
};
constexpr SliceRow k_slice_rows[] = {{"16 slices", 16, SliceRefinement::none},
                                     {"64 slices", 64, SliceRefinement::none},
                                     {"128 slices", 128, SliceRefinement::none},
                                     {"16 slices, normals blended", 16, SliceRefinement::normals},
                                     {"16 slices, coordinates blended", 16, SliceRefinement::coordinates},
                                     {"64 slices, coordinates blended", 64, SliceRefinement::coordinates},
                                     {"128 slices, coordinates blended", 128, SliceRefinement::coordinates}};

const char* series_of(SliceRefinement refinement) {
  return refinement == SliceRefinement::none      ? "slices"
         : refinement == SliceRefinement::normals ? "normals blended"
                                                  : "coordinates blended";
}

/// How a picture was drawn, its errors and its cost.
void add_row(const std::string& experiment, const std::string& scene, const std::string& name,
             const SeenErrors& errors, double seconds, std::size_t fragments, BenchSection& section) {
  section.markdown +=
      fmt::format("| {} | {} | {:.4f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {} |\n", scene, name,
                  errors.image, errors.normal, 1e3 * errors.depth, 100 * errors.missing, seconds,
                  fragments > 0 ? fmt::format("{:.1f}", 1e-6 * static_cast<double>(fragments)) : "");
  section.rows.push_back({{"experiment", experiment},
                          {"scene", scene},
                          {"method", name},
                          {"image", errors.image},
                          {"normal_degrees", errors.normal},
                          {"depth", errors.depth},
                          {"other_surface_share", errors.missing},
                          {"seconds", seconds},
                          {"fragments", fragments}});
}

constexpr const char* k_header =
    "| texture | drawn by | picture | normals | depth | other surface | seconds | million fragments "
    "|\n|---|---|---|---|---|---|---|---|\n";

/// Of the processor. Long ones run once.
double seconds_of(const BenchOptions& options, const std::function<void()>& work) {
  const double once = median_seconds(1, work);
  return once > 1 || options.repeats < 2 ? once : median_seconds(options.repeats, work);
}

}  // namespace

void measure_volume_slices(const BenchOptions& options, BenchSection& section) {
  section.markdown += fmt::format(
      "\n### A cluster of balls\n\nA texture of 128^3 texels in a cube of sides 2, 800 x 800 pixels, all "
      "from the "
      "same texture; errors against rays of a quarter of a texel a step. Root mean squares: of the picture's "
      "encoded values, of normals in degrees, of depths in thousandths; % of pixels that see nothing or "
      "something "
      "more than 0.2 away\n\n{}",
      k_header);
  const Camera camera{.position = {1.6, -2.2, 7},
                      .target = {0, 0, 1},
                      .up = Vec3::UnitZ(),
                      .field_of_view = 0.3,
                      .width = 800,
                      .height = 800};
  for (const double ramp : {16.0, 2.0}) {
    const std::string scene = fmt::format("opacity over {} texels", 2 * ramp);
    const auto texture = finest_only(make_volume(
        cluster_distance,
        {.size = {128, 128, 128}, .extent = Vec3::Ones(), .is_periodic = false, .ramp_texels = ramp}));
    const PlacedVolume placed = place_volume(flat_square(), texture, 2, {1, 1});
    const VolumeTexture& finest = texture->surfaces.front();
    const std::vector<SeenVolume> reference = march(finest, camera);
    const std::vector<Slab> slabs = slabs_of(placed.textured, flat_square());
    constexpr double k_other_surface = 0.2;  // more than slices are apart
    Plot plot = log_plot("A cluster of balls, " + scene, "processor seconds", "RMS of the picture");
    const auto add = [&](const char* series, const char* name, const std::vector<SeenVolume>& seen,
                         double seconds, std::size_t fragments) {
      const SeenErrors errors = compare(seen, reference, camera, k_other_surface);
      add_row("cluster", scene, name, errors, seconds, fragments, section);
      add_point(plot, series, seconds, errors.image);
    };
    const Scene shown({}, std::span<const PlacedVolume>(&placed, 1));
    std::vector<SeenVolume> seen;
    const double ray_seconds = seconds_of(options, [&] { seen = trace_volumes(shown, camera); });
    add("rays", "**rays**", seen, ray_seconds, 0);
    for (const SliceRow& row : k_slice_rows) {
      SlicePicture picture;
      const double seconds = seconds_of(options, [&] {
        picture = draw_slices(slabs, field_of(finest), slice_view(camera),
                              {.slices = row.slices, .refinement = row.refinement});
      });
      add(series_of(row.refinement), row.name, seen_of(picture), seconds, picture.fragments);
    }
    section.curves.push_back(plot);
  }
}

namespace {

/// Around the z axis, of quads, with texture coordinates once around and along.
PolygonSoup open_cylinder(int around, int along, double radius, double height) {
  PolygonSoup cylinder;
  for (int j = 0; j <= along; ++j) {
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around;
      cylinder.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle),
                                      height * (static_cast<double>(j) / along - 0.5));
    }
  }
  const auto at = [&](int i, int j) { return static_cast<Index>(j * around + i % around); };
  for (int j = 0; j < along; ++j) {
    for (int i = 0; i < around; ++i) {
      cylinder.add_face(std::array{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      for (const auto& [di, dj] : {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)})
        cylinder.corner_uvs.emplace_back((i + di) * 1.0 / around, (j + dj) * 1.0 / along);
    }
  }
  return cylinder;
}

}  // namespace

void measure_chain_mail_slices(const BenchOptions& options, BenchSection& section) {
  constexpr double k_radius = 1, k_height = 3.6;
  const ProceduralVolume mail = chain_mail();
  const PolygonSoup cylinder = open_cylinder(96, 60, k_radius, k_height);
  // Periods as long along as around.
  const double periods = 30, period = 2 * std::numbers::pi * k_radius / periods,
               along = std::round(k_height / (period * mail.extent.y() / mail.extent.x()));
  const double thickness = period * mail.extent.z() / mail.extent.x();
  const auto texture = finest_only(make_volume(mail, 64));
  const PlacedVolume placed = place_volume(cylinder, texture, thickness, {periods, along});
  const VolumeTexture& finest = texture->surfaces.front();
  const Camera camera{.position = {0, -6, 1.2},
                      .target = Vec3::Zero(),
                      .up = Vec3::UnitZ(),
                      .field_of_view = 0.35,
                      .width = 800,
                      .height = 600};
  const std::vector<Slab> slabs = slabs_of(placed.textured, cylinder);
  const SliceView view = slice_view(camera);
  section.markdown += fmt::format(
      "\n### Chain mail around a cylinder\n\n{} slabs over quads, rays in prisms over their halves; {} x {} "
      "texels "
      "a period of {:.3f}, layer {:.3f} thick, {} x {} pixels; errors against 128 slices with coordinates "
      "blended, "
      "another surface is 0.1 of the layer away\n\n{}",
      slabs.size(), finest.size[0], finest.size[1], period, thickness, camera.width, camera.height, k_header);
  const std::vector<SeenVolume> reference =
      seen_of(draw_slices(slabs, field_of(finest), view, {.slices = 128}));
  const double other_surface = 0.1 * thickness;
  for (const SliceRow& row : k_slice_rows) {
    if (row.slices == 128) continue;
    SlicePicture picture;
    const double seconds = seconds_of(options, [&] {
      picture =
          draw_slices(slabs, field_of(finest), view, {.slices = row.slices, .refinement = row.refinement});
    });
    add_row("chain mail", "chain mail", row.name, compare(seen_of(picture), reference, camera, other_surface),
            seconds, picture.fragments, section);
  }
  const Scene shown({}, std::span<const PlacedVolume>(&placed, 1));
  std::vector<SeenVolume> seen;
  const double seconds = seconds_of(options, [&] { seen = trace_volumes(shown, camera); });
  add_row("chain mail", "chain mail", "**rays**", compare(seen, reference, camera, other_surface), seconds, 0,
          section);
}

namespace {

/// A hub with twisted blades between two rings, and cooling holes through the blades; in the unit cube.
double turbine_distance(const Vec3& point) {
  constexpr int k_blades = 24;
  const Vec3 at = point - Vec3::Constant(0.5);
  const double radius = std::hypot(at.x(), at.y());
  const auto tube = [&](double inner, double outer, double half_height) {
    return std::min({radius - inner, outer - radius, half_height - std::abs(at.z())});
  };
  const double twist = 1.2 * (radius - 0.15) + 1.5 * at.z();
  const double turn = (std::atan2(at.y(), at.x()) + twist) * k_blades / (2 * std::numbers::pi);
  const double aside = (turn - std::round(turn)) * 2 * std::numbers::pi / k_blades * radius;
  double blade = std::min({0.007 - std::abs(aside), 0.15 - std::abs(at.z()), radius - 0.1, 0.42 - radius});
  const double along = std::remainder(radius, 0.03), upwards = std::remainder(at.z(), 0.06);
  blade = std::min(blade, std::hypot(along, upwards) - 0.006);
  return std::max({tube(0.05, 0.14, 0.2), tube(0.41, 0.44, 0.16), blade});
}

double gib(std::size_t bytes) { return static_cast<double>(bytes) / (1 << 30); }

}  // namespace

void measure_large_volume(const BenchOptions& options, BenchSection& section) {
  const int side = options.quick ? 128 : 512;
  section.markdown += fmt::format(
      "\n### A turbine of {0} x {0} x {0} texels\n\n800 x 800 pixels; memory at its highest above that "
      "before each "
      "step\n\n| step | seconds | GiB |\n|---|---|---|\n",
      side);
  const auto step = [&](const std::string& name, const std::function<void()>& work) {
    const std::size_t before = resident_bytes();
    forget_peak();
    const double seconds = median_seconds(1, work);
    const std::size_t added = peak_above(before);
    section.markdown += fmt::format("| {} | {:.2f} | {:.2f} |\n", name, seconds, gib(added));
    section.rows.push_back(
        {{"experiment", "turbine"}, {"side", side}, {"step", name}, {"seconds", seconds}, {"bytes", added}});
  };
  std::shared_ptr<const VolumeMipmap> texture;
  step("make_volume", [&] {
    texture = finest_only(make_volume(
        turbine_distance, {.size = {side, side, side}, .extent = Vec3::Ones(), .is_periodic = false}));
  });
  const Camera camera{.position = {2.2, -4, 5.5},
                      .target = {0, 0, 1},
                      .up = Vec3::UnitZ(),
                      .field_of_view = 0.36,
                      .width = 800,
                      .height = 800};
  PlacedVolume placed = place_volume(flat_square(), texture, 2, {1, 1});
  const VolumeTexture& finest = texture->surfaces.front();
  const std::vector<Slab> slabs = slabs_of(placed.textured, flat_square());
  SlicePicture sliced;
  for (const int slices : {128, 512}) {
    step(fmt::format("picture by {} slices, coordinates blended", slices),
         [&] { sliced = draw_slices(slabs, field_of(finest), slice_view(camera), {.slices = slices}); });
  }
  std::optional<Scene> scene;
  step("scene",
       [&] { scene.emplace(std::span<const PolygonSoup>{}, std::span<const PlacedVolume>(&placed, 1)); });
  std::vector<SeenVolume> seen;
  step("picture by rays", [&] { seen = trace_volumes(*scene, camera); });
  scene.reset();
  step("make_mipmap", [&] { make_mipmap(finest); });
  const SeenErrors errors = compare(seen_of(sliced), seen, camera, 0.02);
  section.markdown += fmt::format(
      "\n512 slices and rays see another surface, 0.02 away or more, in {:.2f} % of the pixels that see "
      "any.\n",
      100 * errors.missing);
}

void measure_volume_storage(BenchSection& section) {
  section.markdown +=
      "\n### What textures take\n\n256 x 256 x 64 texels; memory of all levels at its highest above that of "
      "the texture\n\n| texture | dense MiB | bricks MiB | seconds of its levels | MiB at the highest "
      "|\n|---|---|---|---|---|\n";
  const auto mib = [](std::size_t bytes) { return static_cast<double>(bytes) / (1 << 20); };
  for (const auto& [name, volume] :
       {std::pair(std::string("chain mail"), chain_mail()), std::pair(std::string("weave"), weave()),
        std::pair(std::string("bark"), bark())}) {
    const VolumeTexture texture =
        make_volume(volume.inside, {.size = {256, 256, 64}, .extent = volume.extent, .color = volume.color});
    const std::size_t dense = texture.n_texels() * (texture.colors.empty() ? 1 : 4),
                      bricks = texture.opacity.n_bytes() + texture.colors.n_bytes();
    ::malloc_trim(0);  // what is free already isn't what levels take
    const std::size_t before = resident_bytes();
    forget_peak();
    const double seconds = median_seconds(1, [&] { make_mipmap(texture); });
    const std::size_t added = peak_above(before);
    section.markdown += fmt::format("| {} | {:.1f} | {:.1f} | {:.1f} | {:.0f} |\n", name, mib(dense),
                                    mib(bricks), seconds, mib(added));
    section.rows.push_back({{"experiment", "storage"},
                            {"texture", name},
                            {"dense_bytes", dense},
                            {"brick_bytes", bricks},
                            {"seconds", seconds},
                            {"peak_bytes", added}});
  }
}

}  // namespace recede::bench
