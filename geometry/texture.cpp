#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/geometry/texture.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace recede {
namespace {

constexpr double k_most = 65535;

/// Linear light of every sample that a picture can have.
std::vector<std::uint16_t> linear_samples(int bits) {
  const std::size_t most = (std::size_t{1} << bits) - 1;
  std::vector<std::uint16_t> linear(most + 1);
  for (std::size_t sample = 0; sample <= most; ++sample) {
    const float encoded = static_cast<float>(sample) / static_cast<float>(most);
    linear[sample] =
        static_cast<std::uint16_t>(std::lround(k_most * static_cast<double>(decode_srgb(encoded))));
  }
  return linear;
}

}  // namespace

Texture::Texture(const Raster& picture) {
  const auto channels = static_cast<std::size_t>(picture.channels);
  const std::size_t texels =
      static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
  const bool is_possible = picture.width > 0 && picture.height > 0 && channels >= 1 && channels <= 4 &&
                           (picture.bits == 8 || picture.bits == 16);
  if (!is_possible || picture.samples.size() != texels * channels)
    throw InputError("a texture needs texels of 1 to 4 channels with 8 or 16 bits");
  const std::vector<std::uint16_t> linear = linear_samples(picture.bits);
  Level& level = levels_.emplace_back(Level{picture.width, picture.height, std::vector<Texel>(texels)});
  const bool is_grey = channels < 3;
  for (std::size_t t = 0; t < texels; ++t) {
    for (std::size_t c = 0; c < 3; ++c)
      level.texels[t][c] = linear[picture.samples[t * channels + (is_grey ? 0 : c)]];
  }
  while (levels_.back().width > 1 || levels_.back().height > 1) levels_.push_back(halved(levels_.back()));
}

Texture::Level Texture::halved(const Level& fine) {
  Level level{(fine.width + 1) / 2, (fine.height + 1) / 2, {}};
  level.texels.reserve(static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height));
  for (int y = 0; y < level.height; ++y) {
    for (int x = 0; x < level.width; ++x) {
      std::array<unsigned, 3> sum{};
      for (const int row : {2 * y, std::min(2 * y + 1, fine.height - 1)}) {
        for (const int column : {2 * x, std::min(2 * x + 1, fine.width - 1)}) {
          const Texel& texel =
              fine.texels[static_cast<std::size_t>(row) * static_cast<std::size_t>(fine.width) +
                          static_cast<std::size_t>(column)];
          for (std::size_t c = 0; c < 3; ++c) sum[c] += texel[c];
        }
      }
      Texel& mean = level.texels.emplace_back();
      for (std::size_t c = 0; c < 3; ++c) mean[c] = static_cast<std::uint16_t>((sum[c] + 2) / 4);
    }
  }
  return level;
}

Vec3 Texture::Level::color_at(const Vec2& uv) const {
  const double x = (uv.x() - std::floor(uv.x())) * width - 0.5,
               y = (std::ceil(uv.y()) - uv.y()) * height - 0.5;
  const double left = std::floor(x), top = std::floor(y), right_share = x - left, lower_share = y - top;
  const auto wrapped = [](double place, int count) {
    const int k = static_cast<int>(place);
    return static_cast<std::size_t>(k < 0 ? k + count : k >= count ? k - count : k);
  };
  const auto row_at = [&](double row) {
    const Texel* const texels_of_row = texels.data() + wrapped(row, height) * static_cast<std::size_t>(width);
    const Texel &a = texels_of_row[wrapped(left, width)], &b = texels_of_row[wrapped(left + 1, width)];
    return Vec3((1 - right_share) * Vec3(a[0], a[1], a[2]) + right_share * Vec3(b[0], b[1], b[2]));
  };
  return ((1 - lower_share) * row_at(top) + lower_share * row_at(top + 1)) / k_most;
}

Vec3 Texture::color_at(const Vec2& uv, double width) const {
  if (!uv.allFinite()) return levels_.back().color_at(Vec2::Zero());
  const double texels = width * std::sqrt(static_cast<double>(this->width()) * height());
  if (!(texels > 1)) return levels_.front().color_at(uv);
  const double place = std::min(std::log2(texels), static_cast<double>(levels_.size() - 1));
  const auto fine = static_cast<std::size_t>(place);
  const double share = place - static_cast<double>(fine);
  const Vec3 color = levels_[fine].color_at(uv);
  return share > 0 ? Vec3((1 - share) * color + share * levels_[fine + 1].color_at(uv)) : color;
}

bool has_textures(const std::vector<Material>& materials) {
  return std::any_of(materials.begin(), materials.end(), [](const Material& material) {
    return !material.base_color_texture.empty() || !material.normal_texture.empty();
  });
}

void drop_textures(std::vector<Material>& materials) {
  for (Material& material : materials) {
    material.base_color_texture.clear();
    material.normal_texture.clear();
    material.base_color_picture = material.normal_picture = nullptr;
  }
}

BaseColorTextures::BaseColorTextures(const std::vector<Material>& materials) {
  std::map<const std::string*, Index> known;
  for (const Material& material : materials) {
    const std::string* const bytes = material.base_color_picture.get();
    if (bytes == nullptr) {
      numbers_.push_back(k_no_index);
      continue;
    }
    const auto [number, is_new] = known.try_emplace(bytes, static_cast<Index>(textures_.size()));
    if (is_new) textures_.emplace_back(decode_picture(*bytes, material.base_color_texture));
    numbers_.push_back(number->second);
  }
}

std::filesystem::path picture_path(const std::filesystem::path& folder, const std::string& texture) {
  if (texture.find('\0') != texture.npos) throw InputError::in_file(texture.c_str(), "isn't a file's name");
  std::string slashed = texture;
  std::replace(slashed.begin(), slashed.end(), '\\', '/');
  return folder / slashed;
}

void PictureLoader::load(std::vector<Material>& materials) {
  for (Material& material : materials) {
    load(material.base_color_texture, material.base_color_picture);
    load(material.normal_texture, material.normal_picture);
  }
}

void PictureLoader::load(const std::string& name, PictureBytes& picture) {
  if (name.empty()) return;
  const auto [found, is_new] = known_.try_emplace({name, picture});
  if (is_new) found->second = checked(name, picture);
  picture = found->second;
}

PictureBytes PictureLoader::checked(const std::string& name, PictureBytes picture) {
  try {
    if (!picture) picture = std::make_shared<const std::string>(read_whole_file(picture_path(folder_, name)));
    decode_picture(*picture, name);
    return picture;
  } catch (const InputError& error) {
    reasons_.push_back(fmt::format("texture {}, of which only the name is left", error.what()));
    ++missing_;
    return nullptr;
  }
}

RepairStep PictureLoader::step() const {
  return {"load_pictures", missing_, fmt::format("{}", fmt::join(reasons_, "; "))};
}

}  // namespace recede
