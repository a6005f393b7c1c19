#include <recede/geometry/closest_point.h>
#include <recede/geometry/texture.h>
#include <recede/lod/billboard_level.h>
#include <recede/render/shell_level.h>
#include <recede/shells/detail/volume_sampler.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede {
namespace {

// What is seen of a shell from above one of its places.
struct Seen {
  Vec3 place = Vec3::Zero();  ///< in space
  Rgb color = Rgb::Zero();    ///< times the cosine of normal and director
  double area = 0;
};

class ViewFromAbove {
 public:
  ViewFromAbove(const TexturedShell& textured, const Rgb& matter_color)
      : textured_(textured),
        base_(textured.shell->base),
        textures_(base_.materials),
        layer_(textured.layer()),
        texture_(textured.texture->surfaces.front()),
        matter_color_(matter_color),
        is_inward_(textured.side == ShellSide::interior) {}

  // At one place of a triangle, evenly spread from number to number.
  Seen at(Index triangle, std::size_t number) const {
    const double u = std::fmod(0.5 + 0.7548776662466927 * static_cast<double>(number), 1.0),
                 v = std::fmod(0.5 + 0.5698402909980532 * static_cast<double>(number), 1.0);
    const bool is_mirrored = u + v > 1;
    const Vec3 weights = is_mirrored ? Vec3(u + v - 1, 1 - u, 1 - v) : Vec3(1 - u - v, u, v);
    Vec2 uv = Vec2::Zero();
    for (std::size_t k = 0; k < 3; ++k)
      uv += weights[static_cast<int>(k)] * base_.corner_uvs[3 * triangle + k];
    const Vec2 st = textured_.coordinates.of(uv);

    Seen seen{.area = vector_area(base_, triangle).norm()};
    ShellPlace place{triangle, weights, is_inward_ ? 1.0 : 0.0};
    seen.color = color_of_base(triangle, weights, uv);
    // Steps of half a texel; then the place where opacity is a half.
    const int steps = 2 * texture_.size[2];
    const auto at_depth = [&](double depth) { return Vec3(st.x(), st.y(), is_inward_ ? depth : 1 - depth); };
    const auto is_inside = [&](double depth) { return opacity_at(texture_, at_depth(depth)) >= 0.5; };
    for (int step = 0; step <= steps; ++step) {
      double inside = static_cast<double>(step) / steps;
      if (!is_inside(inside)) continue;
      double outside = std::max(0, step - 1) / static_cast<double>(steps);
      for (int halving = 0; halving < 8 && step > 0; ++halving) {
        const double middle = (outside + inside) / 2;
        (is_inside(middle) ? inside : outside) = middle;
      }
      const Vec3 met = at_depth(inside);
      place.height = met.z();
      seen.color = color_of_matter(met) * shading(place, met, step == 0);
      break;
    }
    seen.place = shell_point(*textured_.shell, layer_, place);
    return seen;
  }

 private:
  // As scenes draw it: vertex colours are factors.
  Rgb color_of_base(Index triangle, const Vec3& weights, const Vec2& uv) const {
    const bool has_factors = !base_.vertex_colors.empty();
    const Index material = base_.face_materials.empty() ? k_no_index : base_.face_materials[triangle];
    Vec3 color = material != k_no_index ? Vec3(base_.materials[material].base_color.head<3>())
                 : has_factors          ? Vec3(Vec3::Ones())
                                        : Vec3(Material{}.base_color.head<3>());
    if (const Texture* texture = textures_.of(material)) color = color.cwiseProduct(texture->color_at(uv));
    if (!has_factors) return color.cast<float>();
    Vec3 factor = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k)
      factor += weights[static_cast<int>(k)] *
                base_.vertex_colors[base_.corner_vertices[3 * triangle + k]].head<3>();
    color = color.cwiseProduct(factor);
    return color.cast<float>();
  }

  Rgb color_of_matter(const Vec3& place) const {
    if (texture_.colors.empty()) return matter_color_;
    return detail::sampled_color(texture_, place).cast<float>();
  }

  // Cosine between the surface's normal and the director; 1 at the layer's end, which is cut through matter.
  float shading(const ShellPlace& place, const Vec3& texture_place, bool is_end) const {
    if (is_end) return 1;
    std::array<Vec3, 3> corners;
    Vec3 up = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const Index v = base_.corner_vertices[3 * place.triangle + k];
      const Vec3 director = layer_.tops[v] - base_.positions[v];
      corners[k] = base_.positions[v] + place.height * director;
      up += place.weights[static_cast<int>(k)] * director;
    }
    Eigen::Matrix2d flat;
    for (int k = 0; k < 2; ++k) {
      const std::size_t corner = 3 * place.triangle + static_cast<std::size_t>(k) + 1;
      flat.col(k) = (base_.corner_uvs[corner] - base_.corner_uvs[3 * place.triangle])
                        .cwiseProduct(textured_.coordinates.repeat);
    }
    Eigen::Matrix<double, 3, 2> sides;
    sides << corners[1] - corners[0], corners[2] - corners[0];
    Eigen::Matrix3d frame;
    frame << sides * flat.inverse(), up;
    const Vec3 normal =
        frame.transpose().partialPivLu().solve(opacity_gradient(texture_, texture_place)).stableNormalized();
    const double cosine = std::abs(normal.dot(up.stableNormalized()));
    return std::isfinite(cosine) ? static_cast<float>(cosine) : 1.0f;
  }

  const TexturedShell& textured_;
  const PolygonSoup& base_;
  BaseColorTextures textures_;
  const ShellLayer& layer_;
  const VolumeTexture& texture_;
  Rgb matter_color_;
  bool is_inward_;
};

// Several places of each triangle, more where there are few triangles.
std::vector<Seen> look_from_above(const TexturedShell& textured, const Rgb& matter_color) {
  constexpr std::size_t k_places = 200'000;
  const std::size_t n = textured.shell->base.n_faces(), of_each = std::max<std::size_t>(4, k_places / n);
  const ViewFromAbove view(textured, matter_color);
  std::vector<Seen> seen(n * of_each);
  tbb::parallel_for(std::size_t{0}, seen.size(),
                    [&](std::size_t i) { seen[i] = view.at(static_cast<Index>(i / of_each), i); });
  return seen;
}

Rgb mean_color(const std::vector<Seen>& seen) {
  Vec3 sum = Vec3::Zero();
  double area = 0;
  for (const Seen& place : seen) {
    sum += place.area * place.color.cast<double>();
    area += place.area;
  }
  return area > 0 ? Rgb((sum / area).cast<float>()) : Rgb::Ones();
}

// Of a level's base beyond its own error.
void add_layer(LevelError& error, const PolygonMesh& mesh, const std::vector<Seen>& seen, double longest) {
  const PolygonSoup soup = to_soup(mesh);
  const ClosestPointTree tree(soup.positions, triangulate(soup));
  std::vector<double> squares(seen.size());
  tbb::parallel_for(std::size_t{0}, seen.size(),
                    [&](std::size_t i) { squares[i] = tree.closest(seen[i].place).squared_distance; });
  double sum = 0, area = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    error.max = std::max(error.max, std::sqrt(squares[i]));
    sum += seen[i].area * squares[i];
    area += seen[i].area;
  }
  error.rms = std::max(error.rms, area > 0 ? std::sqrt(sum / area) : 0);
  error.bound += longest;
}

double longest_director(const TexturedShell& textured) {
  const PolygonSoup& base = textured.shell->base;
  double longest = 0;
  for (const Index v : base.corner_vertices)
    longest = std::max(longest, (textured.layer().tops[v] - base.positions[v]).norm());
  return longest;
}

}  // namespace

LodHierarchy shell_hierarchy(const TexturedShell& textured, const std::string& name,
                             const ShellLevelOptions& options, Progress* progress) {
  const double longest = longest_director(textured);
  const PolygonSoup& base = textured.shell->base;
  const std::vector<Seen> seen = look_from_above(textured, options.matter_color);
  const Rgb color = mean_color(seen);

  PolygonSoup plain = base;
  plain.corner_uvs.clear();
  plain.materials.clear();
  plain.face_materials.clear();
  plain.vertex_colors.assign(plain.positions.size(), Vec4(color.x(), color.y(), color.z(), 1));
  const HierarchyOptions bases{.ratios = options.ratios,
                               .errors = {},
                               .relative_errors = {},
                               .distances = {},
                               .view = options.view,
                               .simplify = options.simplify};
  LodHierarchy simplified =
      build_hierarchy(repair_to_polygon_mesh(std::move(plain)).mesh, name, bases, progress);

  LodHierarchy hierarchy = simplified;
  hierarchy.levels.clear();
  LodLevel shell;
  shell.mesh = repair_to_polygon_mesh(base).mesh;
  append_level(hierarchy, std::move(shell));
  for (std::size_t i = 0; i < simplified.levels.size(); ++i) {
    LodLevel& level = simplified.levels[i];
    add_layer(level.error, level.mesh, seen, longest);
    if (i == 0) level.stop_reason = fmt::format("the surface alone, under a layer {:.4g} thick", longest);
    append_level(hierarchy, std::move(level));
  }
  return hierarchy;
}

}  // namespace recede
