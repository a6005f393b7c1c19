#include <recede/geometry/atomic_file.h>
#include <recede/geometry/detail/number_bytes.h>
#include <recede/geometry/error.h>
#include <recede/render/detail/half_numbers.h>
#include <recede/render/detail/local_pca_bytes.h>
#include <recede/render/local_pca.h>

#include <bit>
#include <cmath>
#include <string>
#include <string_view>

namespace recede {
namespace {

using detail::append_bytes;
using detail::number_at;

constexpr std::string_view k_head = "recede local pca 1\n";
constexpr std::size_t k_start = k_head.size() + 3 * sizeof(std::uint64_t) + 2 * sizeof(std::uint32_t);
constexpr std::uint64_t k_most = std::uint64_t{1}
                                 << 40;  // of dimensions and vectors: sizes stay far from 2^64

struct Counts {
  std::uint64_t dimension = 0, clusters = 0, vectors = 0;
  std::uint32_t components = 0;

  std::uint64_t parts() const { return dimension * clusters * (components + 1); }
  std::uint64_t bytes_of_cluster() const { return clusters > 256 ? 2 : 1; }
  std::uint64_t bytes_of_vector() const { return bytes_of_cluster() + 2 * components; }
  std::uint64_t bytes() const { return k_start + 2 * parts() + vectors * bytes_of_vector(); }
};

Counts counts_of(const LocalPca& pca) {
  return {.dimension = pca.dimension,
          .clusters = pca.cluster_count(),
          .vectors = pca.vector_count(),
          .components = static_cast<std::uint32_t>(pca.components)};
}

/// Reads numbers one after the other, and knows where a bad one stood.
class Numbers {
 public:
  Numbers(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  template <class Unsigned>
  Unsigned next() {
    last_ = at_;
    at_ += sizeof(Unsigned);
    return number_at<Unsigned>(bytes_, last_);
  }
  float next_half() {
    const float number = detail::from_half(next<std::uint16_t>());
    require(std::isfinite(number), "a number isn't finite");
    return number;
  }
  void require(bool good, const char* reason) const {
    if (!good) throw InputError::at_byte(name_, last_, reason);
  }

 private:
  std::string_view bytes_;
  const std::string& name_;
  std::size_t at_ = k_head.size(), last_ = 0;
};

Counts read_counts(Numbers& numbers) {
  Counts counts;
  counts.dimension = numbers.next<std::uint64_t>();
  numbers.require(counts.dimension > 0 && counts.dimension < k_most, "a count out of range");
  counts.clusters = numbers.next<std::uint64_t>();
  numbers.require(counts.clusters > 0 && counts.clusters <= 65'536, "a count out of range");
  counts.vectors = numbers.next<std::uint64_t>();
  numbers.require(counts.vectors > 0 && counts.vectors < k_most, "a count out of range");
  counts.components = numbers.next<std::uint32_t>();
  numbers.require(counts.components <= 64, "a count out of range");
  return counts;
}

}  // namespace

std::size_t bytes(const LocalPca& pca) { return counts_of(pca).bytes(); }

namespace detail {

std::string bytes_of(const LocalPca& pca, const std::string& name) {
  const Counts counts = counts_of(pca);
  if (counts.vectors == 0 || counts.parts() == 0 || pca.parts.size() != counts.parts() ||
      pca.weights.size() != counts.vectors * counts.components)
    throw InputError::in_file(name, "the clusters must have all their parts, and each vector its weights");
  std::string bytes(k_head);
  bytes.reserve(counts.bytes());
  append_bytes(bytes, counts.dimension);
  append_bytes(bytes, counts.clusters);
  append_bytes(bytes, counts.vectors);
  append_bytes(bytes, counts.components);
  append_bytes(bytes, std::bit_cast<std::uint32_t>(pca.scale));
  for (const float part : pca.parts) append_bytes(bytes, detail::to_half(part / pca.scale));
  for (std::size_t vector = 0; vector < pca.vector_count(); ++vector) {
    if (counts.bytes_of_cluster() == 1)
      append_bytes(bytes, static_cast<std::uint8_t>(pca.clusters[vector]));
    else
      append_bytes(bytes, pca.clusters[vector]);
    for (std::uint32_t c = 0; c < counts.components; ++c)
      append_bytes(bytes, detail::to_half(pca.weights[vector * counts.components + c]));
  }
  return bytes;
}

LocalPca local_pca_of(std::string_view bytes, const std::string& name) {
  if (!bytes.starts_with(k_head) || bytes.size() < k_start)
    throw InputError::in_file(name, "this is no local PCA");
  Numbers numbers(bytes, name);
  const Counts counts = read_counts(numbers);
  LocalPca pca{.dimension = counts.dimension, .components = static_cast<int>(counts.components)};
  pca.scale = std::bit_cast<float>(numbers.next<std::uint32_t>());
  int exponent = 0;
  numbers.require(std::isnormal(pca.scale) && std::frexp(pca.scale, &exponent) == 0.5F,
                  "the scale isn't a power of two");
  if (bytes.size() != counts.bytes())
    throw InputError::in_file(name, "the file is longer or shorter than its numbers");
  pca.parts.resize(counts.parts());
  for (float& part : pca.parts) part = pca.scale * numbers.next_half();
  pca.clusters.resize(counts.vectors);
  pca.weights.reserve(counts.vectors * counts.components);
  for (std::uint16_t& cluster : pca.clusters) {
    cluster = counts.bytes_of_cluster() == 1 ? numbers.next<std::uint8_t>() : numbers.next<std::uint16_t>();
    numbers.require(cluster < counts.clusters, "a cluster that isn't there");
    for (std::uint32_t c = 0; c < counts.components; ++c) pca.weights.push_back(numbers.next_half());
  }
  return pca;
}

}  // namespace detail

void write_local_pca(const std::filesystem::path& path, const LocalPca& pca) {
  write_file_atomically(path, detail::bytes_of(pca, path.string()));
}

LocalPca read_local_pca(const std::filesystem::path& path) {
  return detail::local_pca_of(read_whole_file(path), path.string());
}

}  // namespace recede
