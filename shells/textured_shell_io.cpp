#include <recede/geometry/atomic_file.h>
#include <recede/geometry/detail/number_bytes.h>
#include <recede/geometry/error.h>
#include <recede/shells/detail/hexahedra.h>
#include <recede/shells/detail/shell_cell.h>
#include <recede/shells/textured_shell_io.h>

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>

namespace recede {
namespace {

// A line of text, then one Zstandard frame with a checksum. In it all numbers are little-endian: counts of 32
// bits, lengths as doubles, texels as bytes.
constexpr std::string_view k_head = "recede textured shell 2\n";
constexpr std::string_view k_first_head = "recede textured shell 1\n";  // without quads
constexpr std::uint64_t k_most_bytes = std::uint64_t{1} << 36;  // of a whole file: texels are 2^31 at most
constexpr int k_level = 3;

class Writer {
 public:
  void count(std::size_t number) { detail::append_bytes(bytes_, static_cast<std::uint32_t>(number)); }
  void number(double number) { detail::append_bytes(bytes_, std::bit_cast<std::uint64_t>(number)); }
  template <typename Vector>
  void vectors(const std::vector<Vector>& vectors) {
    for (const Vector& vector : vectors)
      for (const double x : vector) number(x);
  }
  template <typename Texel>
  void texels(const BrickGrid<Texel>& grid) {
    const std::vector<Texel> dense = grid.to_dense();
    bytes_.append(reinterpret_cast<const char*>(dense.data()), dense.size() * sizeof(Texel));
  }

  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class Reader {
 public:
  Reader(std::string bytes, std::string name) : bytes_(std::move(bytes)), name_(std::move(name)) {}

  std::uint32_t count(std::uint32_t most) {
    need(4);
    const auto number = detail::number_at<std::uint32_t>(bytes_, at_);
    at_ += 4;
    if (number > most) refuse("a count out of range");
    return number;
  }
  double number() {
    need(8);
    const double number = std::bit_cast<double>(detail::number_at<std::uint64_t>(bytes_, at_));
    at_ += 8;
    if (!std::isfinite(number)) refuse("a number isn't finite");
    return number;
  }
  template <typename Vector>
  std::vector<Vector> vectors(std::size_t n) {
    need(8 * n * static_cast<std::size_t>(Vector::SizeAtCompileTime));
    std::vector<Vector> result(n);
    for (Vector& vector : result)
      for (double& x : vector) x = number();
    return result;
  }
  template <typename Texel>
  BrickGrid<Texel> texels(const std::array<int, 3>& size) {
    const std::size_t n = TexelBox{{0, 0, 0}, size}.n_texels();
    need(n * sizeof(Texel));
    const auto* first = reinterpret_cast<const Texel*>(bytes_.data() + at_);
    at_ += n * sizeof(Texel);
    return BrickGrid<Texel>::from_dense(size, {first, n});
  }
  void end() {
    if (at_ != bytes_.size()) refuse("more than a textured shell is in the file");
  }
  [[noreturn]] void refuse(const std::string& why) const { throw InputError::in_file(name_, why); }
  const std::string& name() const { return name_; }

 private:
  void need(std::size_t n) const {
    if (bytes_.size() - at_ < n) refuse("the file ends too early");
  }

  std::string bytes_, name_;
  std::size_t at_ = 0;
};

void write_shell(Writer& writer, const TexturedShell& textured, const ShellLayer& layer) {
  const PolygonSoup& base = textured.shell->base;
  writer.count(base.positions.size());
  writer.count(base.n_faces());
  writer.count(textured.side == ShellSide::interior ? 1 : 0);
  writer.count(base.vertex_colors.empty() ? 0 : 1);
  writer.vectors(base.positions);
  writer.vectors(layer.tops);
  for (const double thickness : textured.shell->thicknesses) writer.number(thickness);
  for (const Index v : base.corner_vertices) writer.count(v);
  writer.count(textured.shell->quads.size());
  for (const Index quad : textured.shell->quads) writer.count(quad);
  writer.vectors(base.corner_uvs);
  writer.vectors(base.vertex_colors);
}

// Each is a triangle and the next one, on both sides of a diagonal.
std::vector<Index> read_quads(Reader& reader, const PolygonSoup& base) {
  const auto n_triangles = static_cast<std::uint32_t>(base.n_faces());
  std::vector<Index> quads(reader.count(n_triangles / 2));
  for (std::size_t q = 0; q < quads.size(); ++q) {
    quads[q] = reader.count(n_triangles - 1);
    const bool is_behind = q == 0 || quads[q] >= quads[q - 1] + 2;
    if (!is_behind || quads[q] + 1 >= n_triangles || !detail::is_quad(base.corner_vertices, quads[q]))
      reader.refuse("what is no quad");
  }
  return quads;
}

std::shared_ptr<const Shell> read_shell(Reader& reader, bool has_quads, ShellSide& side, Progress* progress) {
  constexpr std::uint32_t k_most = 0xfffffffe / 3;
  auto shell = std::make_shared<Shell>();
  PolygonSoup& base = shell->base;
  const std::uint32_t n_vertices = reader.count(k_most), n_triangles = reader.count(k_most);
  if (n_vertices == 0 || n_triangles == 0) reader.refuse("a shell needs a triangle");
  side = reader.count(1) == 1 ? ShellSide::interior : ShellSide::exterior;
  const bool has_colors = reader.count(1) == 1;
  base.positions = reader.vectors<Vec3>(n_vertices);
  ShellLayer layer;
  layer.tops = reader.vectors<Vec3>(n_vertices);
  layer.traced = layer.tops;
  for (const auto& thickness : reader.vectors<Eigen::Matrix<double, 1, 1>>(n_vertices)) {
    if (!(thickness[0] > 0)) reader.refuse("a thickness isn't above 0");
    shell->thicknesses.push_back(thickness[0]);
  }
  for (std::uint32_t t = 0; t < n_triangles; ++t) {
    std::array<Index, 3> triangle{};
    for (Index& v : triangle) v = reader.count(n_vertices - 1);
    base.add_face(triangle);
  }
  if (has_quads) shell->quads = read_quads(reader, base);
  base.corner_uvs = reader.vectors<Vec2>(3 * std::size_t{n_triangles});
  if (has_colors) base.vertex_colors = reader.vectors<Vec4>(n_vertices);
  validate(base, reader.name());
  ShellCheckOptions options;
  options.is_inward = side == ShellSide::interior;
  layer.validity = check_shell(base.positions, layer.tops, base.corner_vertices, options, progress);
  layer.is_valid_elsewhere = layer.validity.is_valid();
  layer.hexahedra = detail::find_hexahedra(*shell, layer, options.is_inward, progress);
  (options.is_inward ? shell->interior : shell->exterior) = std::move(layer);
  return shell;
}

void write_texture(Writer& writer, const VolumeTexture& texture) {
  for (const int along : texture.size) writer.count(static_cast<std::size_t>(along));
  writer.count(texture.is_periodic ? 1 : 0);
  writer.count(texture.colors.empty() ? 0 : 1);
  for (const double length : texture.extent) writer.number(length);
  writer.number(texture.ramp);
  writer.texels(texture.opacity);
  writer.texels(texture.colors);
}

VolumeTexture read_texture(Reader& reader) {
  VolumeTexture texture;
  for (int& along : texture.size) along = static_cast<int>(reader.count(0x7fffffffu));
  check_texels(texture.size);
  texture.is_periodic = reader.count(1) == 1;
  const bool has_colors = reader.count(1) == 1;
  for (double& length : texture.extent) length = reader.number();
  texture.ramp = reader.number();
  texture.opacity = reader.texels<std::uint8_t>(texture.size);
  if (has_colors) texture.colors = reader.texels<std::array<std::uint8_t, 3>>(texture.size);
  validate(texture, reader.name());
  return texture;
}

std::string unpacked(const std::string& bytes, const std::string& name) {
  if (!std::string_view(bytes).starts_with(k_head) && !std::string_view(bytes).starts_with(k_first_head))
    throw InputError::in_file(name, "this is no textured shell");
  const char* frame = bytes.data() + k_head.size();
  const std::size_t n = bytes.size() - k_head.size();
  const unsigned long long size = ZSTD_getFrameContentSize(frame, n);
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN || size > k_most_bytes)
    throw InputError::in_file(name, "the file is damaged");
  // Memory follows what is there, not what the file says of itself.
  constexpr std::size_t k_first = std::size_t{1} << 20;
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
  std::string result;
  ZSTD_inBuffer in{frame, n, 0};
  std::size_t done = 0, left = 1;
  while (left > 0) {
    if (done == result.size()) result.resize(std::min<std::size_t>(size, std::max(k_first, 2 * done)));
    ZSTD_outBuffer out{result.data(), result.size(), done};
    const std::size_t taken = in.pos;
    left = ZSTD_decompressStream(context.get(), &out, &in);
    if (ZSTD_isError(left))
      throw InputError::in_file(name, fmt::format("the file is damaged: {}", ZSTD_getErrorName(left)));
    if (out.pos == done && in.pos == taken) break;  // it ends too early
    done = out.pos;
  }
  if (left > 0 || done != size || in.pos != n) throw InputError::in_file(name, "the file is damaged");
  return result;
}

}  // namespace

bool is_textured_shell(const std::filesystem::path& path) { return path.extension() == ".shell"; }

void write_textured_shell(const std::filesystem::path& path, const TexturedShell& textured) {
  Writer writer;
  write_shell(writer, textured, textured.layer());
  for (const Vec2& pair : {textured.coordinates.repeat, textured.coordinates.offset})
    for (const double x : pair) writer.number(x);
  write_texture(writer, textured.texture->surfaces.front());

  std::string bytes(k_head);
  bytes.resize(k_head.size() + ZSTD_compressBound(writer.bytes().size()));
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), ZSTD_freeCCtx);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, k_level);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
  const std::size_t n =
      ZSTD_compress2(context.get(), bytes.data() + k_head.size(), bytes.size() - k_head.size(),
                     writer.bytes().data(), writer.bytes().size());
  if (ZSTD_isError(n)) throw Error(fmt::format("{}: {}", path.string(), ZSTD_getErrorName(n)));
  bytes.resize(k_head.size() + n);
  write_file_atomically(path, bytes);
}

TexturedShell read_textured_shell(const std::filesystem::path& path, const ReadShellOptions& options,
                                  Progress* progress) {
  const std::string name = path.string();
  const std::string bytes = read_whole_file(path);
  Reader reader(unpacked(bytes, name), name);
  TexturedShell textured;
  textured.shell = read_shell(reader, bytes.starts_with(k_head), textured.side, progress);
  for (Vec2* pair : {&textured.coordinates.repeat, &textured.coordinates.offset})
    for (double& x : *pair) x = reader.number();
  if ((textured.coordinates.repeat.array() == 0).any()) reader.refuse("a texture that repeats 0 times");
  try {
    VolumeTexture texture = read_texture(reader);
    reader.end();
    textured.texture = options.make_mipmap ? std::make_shared<const VolumeMipmap>(make_mipmap(texture))
                                           : finest_only(std::move(texture));
  } catch (const OptionError& error) {
    reader.refuse(error.what());
  }
  return textured;
}

}  // namespace recede
