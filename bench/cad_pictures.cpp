#include "cad_meshers.h"
#include "cad_run.h"
#include <recede/geometry/atomic_file.h>
#include <recede/render/renderer.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

namespace recede::bench {
namespace {

using CadMeshes = std::vector<CadBodyMesh>;

/// Pixels that the diagonal covers, from near to far.
constexpr std::array<double, 4> k_sizes{300, 100, 30, 10};
constexpr std::array<const char*, 3> k_models{"linkrods.step", "Top.brep", "Motor-c.brep"};
constexpr int k_panel_width = 232, k_panel_height = 174, k_gap = 4, k_samples = 32;
constexpr double k_margin = 0.06;      // of a panel's half side
constexpr double k_seam_width = 1.7;   // pixels of a panel
constexpr double k_longest_piece = 8;  // of a seam, pixels
constexpr unsigned k_seam_color = 0xc22f12;
// Neighbours are mostly next to one another in the file.
constexpr std::array<unsigned, 6> k_face_colors{0xcfe3f5, 0xf6e7c4, 0xd9efd2, 0xe9dbf2, 0xd0efec, 0xf5dada};

struct Line {
  Vec3 from, to;
};

Material matt(unsigned color) {
  const Rgb rgb = rgb_from_hex(color);
  return {"", {rgb[0], rgb[1], rgb[2], 1}, ""};
}

/// Faces of all instances in the coordinates of the model.
std::vector<CadFaceMesh> placed_faces(const CadSubject& subject, const CadMeshes& meshes) {
  std::vector<CadFaceMesh> faces;
  for (const CadInstance& instance : subject.model.instances) {
    for (std::size_t b = 0; b < meshes.size(); ++b) {
      if (subject.bodies[b].part != instance.part) continue;
      for (const CadFaceMesh& face : meshes[b].faces) {
        for (Vec3& point : faces.emplace_back(face).positions) point = instance.placement * point;
      }
    }
  }
  return faces;
}

PolygonSoup surface_of(const std::vector<CadFaceMesh>& faces) {
  PolygonSoup soup;
  for (const unsigned color : k_face_colors) soup.materials.push_back(matt(color));
  for (const CadFaceMesh& face : faces) {
    const auto first = static_cast<Index>(soup.positions.size());
    soup.positions.insert(soup.positions.end(), face.positions.begin(), face.positions.end());
    for (std::array<Index, 3> triangle : face.triangles) {
      for (Index& corner : triangle) corner += first;
      soup.add_face(triangle);
      soup.face_materials.push_back(static_cast<Index>(face.face % k_face_colors.size()));
    }
  }
  return soup;
}

/// Sides of one triangle alone within a face: its trimming loops as far as they are left.
std::vector<Line> seams_of(const std::vector<CadFaceMesh>& faces) {
  std::vector<Line> lines;
  for (const CadFaceMesh& face : faces) {
    std::map<std::array<Index, 2>, int> uses;
    for (const std::array<Index, 3>& triangle : face.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Index from = triangle[k], to = triangle[(k + 1) % 3];
        ++uses[{std::min(from, to), std::max(from, to)}];
      }
    }
    for (const auto& [side, n] : uses) {
      if (n == 1) lines.push_back({face.positions[side[0]], face.positions[side[1]]});
    }
  }
  return lines;
}

/// Rods of six sides that are lit as if they faced the camera. They are cut into pieces which are so small
/// that the wireframe leaves them out.
PolygonSoup rods_along(const std::vector<Line>& lines, double radius, double longest,
                       const Vec3& toward_camera) {
  constexpr Index k_sides = 6;
  PolygonSoup soup;
  soup.materials.push_back(matt(k_seam_color));
  for (const Line& line : lines) {
    const Vec3 along = line.to - line.from;
    const double length = along.norm();
    if (!(length > 0)) continue;
    const Vec3 first = along.unitOrthogonal(), second = along.normalized().cross(first);
    const int pieces = static_cast<int>(std::ceil(length / longest));
    for (int ring = 0; ring <= pieces; ++ring) {
      const auto start = static_cast<Index>(soup.positions.size());
      for (Index side = 0; side < k_sides; ++side) {
        const double angle = 2 * std::numbers::pi * side / k_sides;
        soup.positions.push_back(line.from + along * ring / pieces +
                                 radius * (std::cos(angle) * first + std::sin(angle) * second));
        if (ring == 0) continue;
        const Index next = (side + 1) % k_sides;
        soup.add_face(std::array{start - k_sides + side, start - k_sides + next, start + next, start + side});
        soup.face_materials.push_back(0);
      }
    }
  }
  soup.corner_normals.assign(soup.n_corners(), toward_camera);
  return soup;
}

/// As far away as `pixel` says for the view of `ViewSettings`, but enlarged: the panel holds all points.
Camera enlarged_view(const PolygonSoup& surface, double pixel) {
  Box3 box;
  for (const Vec3& point : surface.positions) box.extend(point);
  Camera camera{.up = Vec3::UnitZ(), .width = k_panel_width, .height = k_panel_height};
  camera.target = box.center();
  const double distance = pixel / pixel_footprint(1, {});
  camera.position = camera.target + distance * view_from_front(camera.up);
  const CameraFrame frame = frame_of(camera);
  Eigen::AlignedBox2d seen;
  for (const Vec3& point : surface.positions) {
    const Vec3 away = point - camera.position;
    seen.extend(Vec2(away.dot(frame.right), away.dot(frame.up)) / away.dot(frame.forward));
  }
  const Vec2 middle = seen.center(), half = seen.sizes() / 2;
  camera.target += distance * (middle.x() * frame.right + middle.y() * frame.up);
  const double half_height = std::max(half.y(), half.x() * k_panel_height / k_panel_width);
  camera.field_of_view = 2 * std::atan((1 + k_margin) * half_height);
  return camera;
}

Image panel(const std::vector<CadFaceMesh>& faces, const Camera& camera) {
  const Vec3 toward_camera = camera.position - camera.target;
  const double pixel = frame_of(camera).pixel * toward_camera.norm();
  const PolygonSoup surface = surface_of(faces);
  const PolygonSoup seams = rods_along(seams_of(faces), k_seam_width / 2 * pixel, k_longest_piece * pixel,
                                       toward_camera.normalized());
  const Scene scene(std::array{surface, seams}, {.crease_angle = 0});
  RenderOptions options;
  options.samples_per_pixel = k_samples;
  options.background = rgb_from_hex(0xffffff);
  options.wireframe = Wireframe{.width = 0.7, .darkness = 0.55};
  return render(scene, camera, options);
}

/// Shades that a picture needs not have: its file is a third smaller without them.
Rgb rounded(const Rgb& color) {
  constexpr float k_steps = 20;
  return color.unaryExpr(
      [](float value) { return decode_srgb(std::round(k_steps * encode_srgb(value)) / k_steps); });
}

/// Panels on white, row by row.
Image montage(const std::vector<std::vector<Image>>& rows) {
  const int n_columns = static_cast<int>(rows.front().size()), n_rows = static_cast<int>(rows.size());
  Image result(n_columns * (k_panel_width + k_gap) - k_gap, n_rows * (k_panel_height + k_gap) - k_gap,
               Rgb::Ones());
  for (int row = 0; row < n_rows; ++row) {
    for (int column = 0; column < n_columns; ++column) {
      const Image& from = rows[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
      for (int y = 0; y < k_panel_height; ++y) {
        for (int x = 0; x < k_panel_width; ++x)
          result.at(column * (k_panel_width + k_gap) + x, row * (k_panel_height + k_gap) + y) =
              rounded(from.at(x, y));
      }
    }
  }
  return result;
}

std::size_t faces_left(const CadMeshes& meshes) {
  std::size_t n = 0;
  for (const CadBodyMesh& mesh : meshes) {
    n += static_cast<std::size_t>(
        std::count_if(mesh.faces.begin(), mesh.faces.end(),
                      [](const CadFaceMesh& face) { return !face.triangles.empty(); }));
  }
  return n;
}

std::string figures(const CadSubject& subject, const CadMeshes& meshes, double pixel, bool of_patches) {
  constexpr std::size_t k_judged = 4'000;
  const CadJudgement found =
      judge(subject, meshes, {.deflection = pixel / 2, .samples = k_judged, .of_patches = of_patches});
  return fmt::format(" {} ; {} ; {:.2f} ; {} |", found.triangles, faces_left(meshes), found.deviation / pixel,
                     found.closed_open_edges);
}

}  // namespace

BenchSection draw_cad(const BenchOptions& options) {
  std::filesystem::create_directories(options.out);
  std::string text =
      "| model, pixels of its diagonal | distance | BRepMesh: triangles ; faces ; deviation, pixels ; open "
      "edges | Recede |\n|---|---|---|---|\n";
  const std::vector<CadSource> sources = cad_sources(options.data.parent_path() / "cad");
  for (const char* name : k_models) {
    const auto source =
        std::find_if(sources.begin(), sources.end(), [&](const CadSource& one) { return one.name == name; });
    if (source == sources.end() || !is_wanted(name, options.models)) continue;
    const CadSubject subject = load_cad(*source);
    std::vector<double> deflections;
    for (const double size : k_sizes) deflections.push_back(subject.diagonal / size / 2);
    const std::vector<CadMeshes> peer = brep_meshes(subject, deflections),
                                 ours = recede_meshes(subject, deflections);
    std::vector<Image> above, below;
    for (std::size_t i = 0; i < k_sizes.size(); ++i) {
      const double pixel = 2 * deflections[i];
      const std::vector<CadFaceMesh> peer_faces = placed_faces(subject, peer[i]);
      const Camera camera = enlarged_view(surface_of(peer_faces), pixel);
      above.push_back(panel(peer_faces, camera));
      below.push_back(panel(placed_faces(subject, ours[i]), camera));
      text += fmt::format("| {}, {:.0f} | {:.3g} |{}{}\n", name, k_sizes[i],
                          pixel / pixel_footprint(1, {}) / subject.diagonal,
                          figures(subject, peer[i], pixel, false), figures(subject, ours[i], pixel, true));
    }
    const std::string stem = source->file.stem().string();
    write_png(options.out / fmt::format("cad-distances-{}.png", stem), montage({above, below}));
    fmt::print(stderr, "{} is done\n", name);
  }
  text += cad_distance_plots(options);
  write_file_atomically(options.out / "cad-distances.md", text);
  return {.markdown = text};
}

}  // namespace recede::bench
