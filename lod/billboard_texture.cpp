#include <recede/geometry/atlas_packing.h>
#include <recede/geometry/error.h>
#include <recede/lod/billboard_budget.h>
#include <recede/lod/detail/billboard_rays.h>
#include <recede/lod/detail/billboard_texels.h>
#include <recede/lod/detail/map_texels.h>
#include <recede/lod/detail/masked_area.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede {

namespace {

using detail::BillboardRays;
using detail::BillboardSample;

// As they are averaged; heights in object units.
using Values = detail::TexelValues;

struct Sums {
  int n = 0;
  Values values = Values::Zero();

  void add(const BillboardSample& sample, const Billboard& billboard) {
    ++n;
    Values here;
    here << sample.color.cast<float>(), static_cast<float>(sample.normal.dot(billboard.axis_u)),
        static_cast<float>(sample.normal.dot(billboard.axis_v)),
        static_cast<float>(sample.normal.dot(billboard.normal())), static_cast<float>(sample.height);
    values += here;
  }
  void add(const Sums& other) {
    n += other.n;
    values += other.values;
  }
};

// Row by row, the upper one first.
struct TexelBlock {
  int width = 0, height = 0;
  std::vector<float> opacity;
  std::vector<Values> values;
};

void check(const BillboardTextureOptions& options) {
  if (!(options.texels_per_error > 0) || !std::isfinite(options.texels_per_error))
    throw OptionError("texels of billboards need a size above 0");
  if (options.samples < 1 || options.samples > 64)
    throw OptionError("a texel of a billboard has 1 to 64 samples along each side");
  if (options.overlap < 0 || options.gutter < 0)
    throw OptionError("overlap and gutter of billboards are texels, 0 or more");
}

Eigen::Vector2i size_in_texels(const Billboard& billboard, double texel) {
  // Sides that are whole numbers of texels but for rounding don't take one more.
  constexpr double k_room = 1e-6;
  const auto along = [&](double half) {
    return std::max(1, static_cast<int>(std::ceil(2 * half / texel - k_room)));
  };
  return {along(billboard.half_sizes.x()), along(billboard.half_sizes.y())};
}

constexpr double k_most_texels = 1 << 28;

double texels_at_most(const BillboardCloud& cloud, double texel) {
  double total = 0;
  for (const Billboard& billboard : cloud.billboards) {
    total += std::ceil(2 * billboard.half_sizes.x() / texel + 1) *
             std::ceil(2 * billboard.half_sizes.y() / texel + 1);
  }
  return total;
}

// Texels that are near to others, along both axes.
std::vector<char> near_to(const std::vector<Sums>& sums, int width, int height, int distance) {
  std::vector<char> along(sums.size(), 0), result(sums.size(), 0);
  const auto at = [&](int x, int y) { return static_cast<std::size_t>(y * width + x); };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int k = std::max(0, x - distance); k <= std::min(width - 1, x + distance); ++k)
        along[at(x, y)] |= static_cast<char>(sums[at(k, y)].n > 0);
    }
  }
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int k = std::max(0, y - distance); k <= std::min(height - 1, y + distance); ++k)
        result[at(x, y)] |= along[at(x, k)];
    }
  }
  return result;
}

class BillboardBaker {
 public:
  BillboardBaker(const BillboardRays& rays, const std::vector<Billboard>& billboards, double texel,
                 const BillboardTextureOptions& options)
      : rays_(rays), billboards_(billboards), texel_(texel), options_(options) {}

  TexelBlock bake(std::size_t number) const {
    TexelBlock block;
    const Eigen::Vector2i size = size_in_texels(billboards_[number], texel_);
    block.width = size.x();
    block.height = size.y();
    const auto n = static_cast<std::size_t>(block.width) * static_cast<std::size_t>(block.height);
    std::vector<Sums> own(n), others(n);
    for (std::size_t i = 0; i < n; ++i) sample_texel(number, block, i, own[i], others[i]);
    const std::vector<char> is_near = near_to(own, block.width, block.height, options_.overlap);
    std::vector<char> known(n, 0);
    block.opacity.assign(n, 0.0f);
    block.values.assign(n, Values::Zero());
    for (std::size_t i = 0; i < n; ++i) {
      Sums sums = own[i];
      if (is_near[i] != 0) sums.add(others[i]);
      if (sums.n == 0) continue;
      known[i] = 1;
      block.opacity[i] = static_cast<float>(sums.n) / static_cast<float>(options_.samples * options_.samples);
      block.values[i] = sums.values / static_cast<float>(sums.n);
    }
    if (std::find(known.begin(), known.end(), 1) == known.end()) return block;
    detail::keep_thin_parts(block.opacity, block.width, block.height);
    detail::fill_holes(block.values, std::move(known), block.width, block.height);
    return block;
  }

 private:
  void sample_texel(std::size_t number, const TexelBlock& block, std::size_t texel, Sums& own,
                    Sums& others) const {
    const Billboard& billboard = billboards_[number];
    const auto width = static_cast<std::size_t>(block.width);
    const auto column = static_cast<double>(texel % width), row = static_cast<double>(texel / width);
    const auto n = static_cast<double>(options_.samples);
    for (int j = 0; j < options_.samples; ++j) {
      for (int i = 0; i < options_.samples; ++i) {
        const Vec2 place(2 * (column + (i + 0.5) / n) / block.width - 1,
                         1 - 2 * (row + (j + 0.5) / n) / block.height);
        const auto sample = rays_.sample(number, place.cwiseProduct(billboard.half_sizes));
        if (sample) (sample->is_own ? own : others).add(*sample, billboard);
      }
    }
  }

  const BillboardRays& rays_;
  const std::vector<Billboard>& billboards_;
  double texel_;
  const BillboardTextureOptions& options_;
};

// The same rectangle with the other axis first.
void turn(Billboard& billboard) {
  const Vec3 u = billboard.axis_u;
  billboard.axis_u = billboard.axis_v;
  billboard.axis_v = -u;
  std::swap(billboard.half_sizes.x(), billboard.half_sizes.y());
}

detail::BillboardRasters rasters_of(BillboardTextures& textures) {
  return {textures.color, textures.normal, textures.height};
}

// Where billboards stand in the atlas; turned as they stand there.
void pack_billboards(double texel, int gutter, BillboardTextures& textures) {
  std::vector<Eigen::Vector2i> sizes;
  for (const Billboard& billboard : textures.billboards) sizes.push_back(size_in_texels(billboard, texel));
  const PackedTexels packed = pack_texels(sizes, gutter);
  for (std::size_t b = 0; b < sizes.size(); ++b) {
    const PackedRectangles::Place& place = packed.places[b];
    if (place.turned) {
      turn(textures.billboards[b]);
      std::swap(sizes[b].x(), sizes[b].y());
    }
    textures.places.push_back({place.x, place.y, sizes[b].x(), sizes[b].y()});
  }
  rasters_of(textures).start(packed.width, packed.height);
}

// Which share of the atlas is drawn, where opacity is half and more, and which billboards take.
void count_texels(BillboardTextures& textures) {
  constexpr std::uint16_t k_half = 128;
  const auto n = static_cast<double>(textures.bytes() / 8);
  std::size_t drawn = 0;
  for (std::size_t i = 3; i < textures.color.samples.size(); i += 4) {
    if (textures.color.samples[i] >= k_half) ++drawn;
  }
  textures.covered = static_cast<double>(drawn) / n;
  textures.packed = static_cast<double>(textures.n_texels()) / n;
}

// Colours, normals and heights reach beyond billboards, so that filters find no others there.
void fill_atlas(const std::vector<TexelBlock>& blocks, BillboardTextures& textures) {
  const int width = textures.color.width, height = textures.color.height;
  const auto n = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  std::vector<Values> values(n, Values::Zero());
  std::vector<char> known(n, 0);
  std::vector<float> opacity(n, 0.0f);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const BillboardPlace& place = textures.places[b];
    for (int y = 0; y < place.height; ++y) {
      for (int x = 0; x < place.width; ++x) {
        const auto from = static_cast<std::size_t>(y * place.width + x);
        const auto to = static_cast<std::size_t>(place.y + y) * static_cast<std::size_t>(width) +
                        static_cast<std::size_t>(place.x + x);
        values[to] = blocks[b].values[from];
        opacity[to] = blocks[b].opacity[from];
        known[to] = 1;
      }
    }
  }
  detail::fill_holes(values, std::move(known), width, height);
  const auto range = static_cast<float>(textures.height_range);
  detail::BillboardRasters rasters = rasters_of(textures);
  for (std::size_t i = 0; i < n; ++i) {
    values[i][6] = 0.5f + 0.5f * values[i][6] / range;
    rasters.append(values[i], opacity[i]);
  }
  count_texels(textures);
}

}  // namespace

std::size_t BillboardTextures::n_texels() const {
  std::size_t n = 0;
  for (const BillboardPlace& place : places)
    n += static_cast<std::size_t>(place.width) * static_cast<std::size_t>(place.height);
  return n;
}

BillboardTextures texture_billboards(const PolygonSoup& model, const BillboardCloud& cloud,
                                     const BillboardTextureOptions& options, Progress* progress) {
  check(options);
  BillboardTextures textures;
  textures.error = cloud.error;
  textures.texel = cloud.error / options.texels_per_error;
  if (const double total = texels_at_most(cloud, textures.texel); !(total < k_most_texels))
    throw OptionError(
        fmt::format("billboards of {:.3g} texels are too many: the error {:.3g} is too small for "
                    "this model",
                    total, cloud.error));
  textures.height_range = cloud.error;
  textures.is_impostor = cloud.is_impostor;
  textures.left_out = cloud.left_out;
  textures.billboards = cloud.billboards;
  pack_billboards(textures.texel, options.gutter, textures);
  BillboardCloud turned = cloud;
  turned.billboards = textures.billboards;
  const BillboardRays rays(model, turned, textures.texel / options.samples);
  const BillboardBaker baker(rays, textures.billboards, textures.texel, options);
  std::vector<TexelBlock> blocks(cloud.billboards.size());
  constexpr std::size_t k_at_once = 64;  // between two reports
  for (std::size_t first = 0; first < blocks.size(); first += k_at_once) {
    report_progress(progress, "textures", static_cast<double>(first) / static_cast<double>(blocks.size()));
    tbb::parallel_for(first, std::min(first + k_at_once, blocks.size()),
                      [&](std::size_t b) { blocks[b] = baker.bake(b); });
  }
  fill_atlas(blocks, textures);
  return textures;
}

std::size_t texture_bytes(const BillboardCloud& cloud, const BillboardTextureOptions& options) {
  check(options);
  const double texel = cloud.error / options.texels_per_error;
  if (!(texels_at_most(cloud, texel) < k_most_texels)) return std::numeric_limits<std::size_t>::max();
  BillboardTextures textures;
  textures.billboards = cloud.billboards;
  pack_billboards(texel, options.gutter, textures);
  return textures.bytes();
}

PolygonSoup quads_of(const BillboardTextures& textures) {
  PolygonSoup soup;
  const double width = textures.color.width, height = textures.color.height;
  for (std::size_t b = 0; b < textures.billboards.size(); ++b) {
    const Billboard& billboard = textures.billboards[b];
    const BillboardPlace& place = textures.places[b];
    const auto first = static_cast<Index>(soup.positions.size());
    for (const Vec2& corner : {Vec2(-1, -1), Vec2(1, -1), Vec2(1, 1), Vec2(-1, 1)}) {
      soup.positions.push_back(billboard.center + corner.x() * billboard.half_sizes.x() * billboard.axis_u +
                               corner.y() * billboard.half_sizes.y() * billboard.axis_v);
      soup.corner_uvs.emplace_back((place.x + (corner.x() + 1) / 2 * place.width) / width,
                                   1 - (place.y + (1 - corner.y()) / 2 * place.height) / height);
      soup.corner_normals.push_back(billboard.normal());
    }
    soup.add_face(std::array<Index, 4>{first, first + 1, first + 2, first + 3});
  }
  return soup;
}

bool place_billboards(const PolygonSoup& quads, BillboardTextures& textures) {
  if (quads.corner_uvs.empty()) return false;
  const double width = textures.color.width, height = textures.color.height;
  for (std::size_t b = 0; b < quads.n_faces(); ++b) {
    if (quads.face_size(b) != 4) return false;
    const std::size_t first = quads.face_offsets[b];
    const auto corner = [&](std::size_t k) -> const Vec3& {
      return quads.positions[quads.corner_vertices[first + k]];
    };
    const Vec3 u = corner(1) - corner(0), v = corner(3) - corner(0);
    if (!(u.norm() > 0) || !(v.norm() > 0)) return false;
    Billboard billboard;
    billboard.center = (corner(0) + corner(2)) / 2;
    billboard.axis_u = u.normalized();
    billboard.axis_v = v.normalized();
    billboard.half_sizes = Vec2(u.norm(), v.norm()) / 2;
    // Numbers of files have seven digits and more.
    constexpr double k_rounding = 1e-5;
    if (std::abs(billboard.axis_u.dot(billboard.axis_v)) > k_rounding) return false;
    if ((corner(2) - corner(1) - v).norm() > k_rounding * (u.norm() + v.norm())) return false;
    const Vec2 low = quads.corner_uvs[first], high = quads.corner_uvs[first + 2];
    const auto texel = [](double place) {
      return static_cast<int>(std::lround(std::clamp(place, -1.0, 1e6)));
    };
    const BillboardPlace place{texel(low.x() * width), texel((1 - high.y()) * height),
                               texel((high.x() - low.x()) * width), texel((high.y() - low.y()) * height)};
    if (place.x < 0 || place.y < 0 || place.width < 1 || place.height < 1 ||
        place.x + place.width > textures.color.width || place.y + place.height > textures.color.height)
      return false;
    textures.billboards.push_back(std::move(billboard));
    textures.places.push_back(place);
  }
  count_texels(textures);
  return true;
}

}  // namespace recede
