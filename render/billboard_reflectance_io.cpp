#include <recede/geometry/atomic_file.h>
#include <recede/geometry/detail/number_bytes.h>
#include <recede/geometry/error.h>
#include <recede/render/billboard_reflectance.h>
#include <recede/render/detail/local_pca_bytes.h>

#include <algorithm>
#include <bit>
#include <string>
#include <string_view>

namespace recede {
namespace {

using detail::append_bytes;

constexpr std::string_view k_head = "recede billboard reflectance 1\n";

void append_error(std::string& bytes, const LocalPcaError& error) {
  append_bytes(bytes, std::uint64_t{error.sample});
  for (const double number : {error.range, error.rms, error.worst_rms})
    append_bytes(bytes, std::bit_cast<std::uint64_t>(number));
  append_bytes(bytes, std::uint64_t{error.worst_vector});
}

/// Reads what is there, and throws where that ends.
class Parts {
 public:
  Parts(std::string_view bytes, const std::string& name) : rest_(bytes), name_(name) {}

  template <class Unsigned>
  Unsigned next() {
    return detail::number_at<Unsigned>(next_bytes(sizeof(Unsigned)), 0);
  }
  std::string_view next_bytes(std::size_t size) {
    require(size <= rest_.size());
    const std::string_view part = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return part;
  }
  void require(bool good) const {
    if (!good) throw InputError::in_file(name_, "this is no reflectance of billboards");
  }
  LocalPcaError next_error() {
    LocalPcaError error;
    error.sample = next<std::uint64_t>();
    for (double* number : {&error.range, &error.rms, &error.worst_rms})
      *number = std::bit_cast<double>(next<std::uint64_t>());
    error.worst_vector = next<std::uint64_t>();
    return error;
  }
  std::size_t size() const { return rest_.size(); }

 private:
  std::string_view rest_;
  const std::string& name_;
};

int next_size(Parts& parts, std::uint32_t most) {
  const auto size = parts.next<std::uint32_t>();
  parts.require(size >= 1 && size <= most);
  return static_cast<int>(size);
}

}  // namespace

void write_billboard_reflectance(const std::filesystem::path& path, const BillboardReflectance& reflectance) {
  std::string bytes(k_head);
  for (const int size : {reflectance.view_side, reflectance.light_side, reflectance.width, reflectance.height,
                         reflectance.is_two_sided ? 2 : 1})
    append_bytes(bytes, static_cast<std::uint32_t>(size));
  append_error(bytes, reflectance.error);
  for (const std::uint32_t vector : reflectance.vectors) append_bytes(bytes, vector);
  bytes += detail::bytes_of(reflectance.radiance, path.string());
  bytes.append(reflectance.opacity.begin(), reflectance.opacity.end());
  write_file_atomically(path, bytes);
}

BillboardReflectance read_billboard_reflectance(const std::filesystem::path& path) {
  const std::string bytes = read_whole_file(path), name = path.string();
  Parts parts(bytes, name);
  parts.require(parts.next_bytes(std::min(bytes.size(), k_head.size())) == k_head);
  BillboardReflectance result;
  result.view_side = next_size(parts, 32);
  result.light_side = next_size(parts, 32);
  result.width = next_size(parts, 1u << 28);
  result.height = next_size(parts, 1u << 28);
  const int n_sides = next_size(parts, 2);
  result.is_two_sided = n_sides == 2;
  result.error = parts.next_error();
  const std::uint64_t n = static_cast<std::uint64_t>(n_sides) * static_cast<std::uint64_t>(result.width) *
                          static_cast<std::uint64_t>(result.height);
  parts.require(n <= parts.size() / sizeof(std::uint32_t));
  for (std::uint64_t i = 0; i < n; ++i) result.vectors.push_back(parts.next<std::uint32_t>());
  // Each vector has a view's opacities behind the local PCA, which checks its own size.
  std::uint32_t count = 0;
  for (const std::uint32_t vector : result.vectors)
    count = std::max(count, vector == BillboardReflectance::k_none ? 0 : vector + 1);
  const std::size_t n_views = result.views().size(), n_opacities = n_views * count;
  parts.require(n_opacities <= parts.size());
  result.radiance = detail::local_pca_of(parts.next_bytes(parts.size() - n_opacities), name);
  const std::string_view opacity = parts.next_bytes(n_opacities);
  result.opacity.assign(opacity.begin(), opacity.end());
  parts.require(result.vector_count() == count &&
                result.radiance.dimension == 3 * n_views * result.lights().size());
  return result;
}

}  // namespace recede
