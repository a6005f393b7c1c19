// Many long vectors as few means and directions: local principal component analysis.
#pragma once

#include <recede/geometry/progress.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

namespace recede {

/// Vectors that needn't all be in memory at once.
struct VectorSource {
  std::size_t count = 0;
  std::size_t dimension = 0;  ///< numbers of each vector
  /// Writes vectors from `first` on, one after the other, into `values`, which has room for one or more.
  /// Calls come from one thread at a time. To be compressed, a vector is asked for twice at most, and to
  /// measure its error once more; it must be the same each time.
  std::function<void(std::size_t first, std::span<float> values)> read{};
};

/// Vectors of `dimension` numbers that lie one after the other in memory, which must stay there.
VectorSource vectors_in(std::span<const float> values, std::size_t dimension);

struct LocalPcaOptions {
  int clusters = 64;   ///< at most; 1 to 65 536. Up to 256 take one byte of each vector, more take two
  int components = 8;  ///< at most, of each cluster; 0 to 64
  /// Vectors, evenly taken from all, that give the space in which all are sorted into clusters; 1 or more.
  /// Twice `clusters` x (`components` + 1) are enough.
  int training_vectors = 4096;
  double least_change = 0.001;  ///< of the summed squares of errors by a round, below which no more follow
  int rounds = 30;              ///< at most; 1 or more
  std::uint64_t seed = 1;
};

/// Each vector is the mean of its cluster and a weighted sum of the cluster's components. All numbers are
/// such as the file has them, 16 bits each.
struct LocalPca {
  std::size_t dimension = 0;
  int components = 0;  ///< of each cluster; those that a cluster doesn't need are 0
  float scale = 1;     ///< a power of two; `parts` are halves (floats of 16 bits) times this
  /// By cluster and entry: the mean's number and one of each component, side by side, as `entry` needs them.
  std::vector<float> parts{};
  std::vector<std::uint16_t> clusters{};  ///< by vector
  std::vector<float> weights{};           ///< by vector and component: halves from -1 to 1

  std::size_t vector_count() const { return clusters.size(); }
  std::size_t parts_per_entry() const { return static_cast<std::size_t>(components) + 1; }
  std::size_t cluster_count() const {
    return parts.empty() ? 0 : parts.size() / (dimension * parts_per_entry());
  }
};

/// Clusters of vectors, each with its mean and the directions in which its vectors differ most (Kambhatla and
/// Leen 1997; for bidirectional texture functions Muller, Meseth and Klein 2003). From k-means with a drawn
/// start (k-means++, Arthur and Vassilvitskii 2007), each round gives vectors to the cluster that loses least
/// of them, and then clusters their means and leading eigenvectors. Clusters that vectors don't need, as
/// those of fewer or equal vectors, are left out.
///
/// Rounds see vectors in the space of the leading directions of the training vectors (found as in Halko,
/// Martinsson and Tropp 2011), of which there are as many as all clusters together have means and components,
/// from 256 to 1024. What lies outside of it is lost: with training vectors that are like all, and up to 1024
/// such directions, that is less than what the clusters themselves lose. All vectors count in all rounds.
///
/// Memory besides the result: 4 bytes x `dimension` x (`training_vectors` + 4 x directions), then 4 bytes x
/// (`dimension` + 2 x `count`) x directions and 64 MB. For 20 000 vectors of 14 455 numbers, 64 clusters and
/// 8 components that is 0.4 GB, for 100 000 vectors 0.6 GB.
///
/// The same result for any number of threads, on a processor of the same kind. Throws `OptionError` for
/// options out of range; `InputError` without vectors or numbers, and for a vector with a number that isn't
/// finite or is beyond 1e15, which it names; and `Cancelled`.
LocalPca make_local_pca(const VectorSource& vectors, const LocalPcaOptions& options = {},
                        Progress* progress = nullptr);

/// One number of a vector. `vector` and `index` must be there.
float entry(const LocalPca& pca, std::size_t vector, std::size_t index);

/// As many numbers of a vector as `values` holds, from the entry `first` on: the same as `entry` gives.
void reconstruct(const LocalPca& pca, std::size_t vector, std::span<float> values, std::size_t first = 0);

/// Size of the file: 2 bytes for each number of means, components and weights, 1 or 2 for each vector's
/// cluster, and 51.
std::size_t bytes(const LocalPca& pca);

/// How far vectors are from what is stored, over the range of the data: the largest less the smallest number.
struct LocalPcaError {
  std::size_t sample = 0;        ///< vectors that were looked at, evenly taken from all
  double range = 0;              ///< of their numbers
  double rms = 0;                ///< over all their numbers; 0 where the range is 0
  double worst_rms = 0;          ///< over the numbers of the worst vector
  std::size_t worst_vector = 0;  ///< of several the first
};

/// Looks at `sample` vectors, or at all if there are fewer. Throws `InputError` unless there are as many and
/// as long vectors as were compressed, and `OptionError` for a sample of 0.
LocalPcaError measure_error(const LocalPca& pca, const VectorSource& vectors, std::size_t sample = 1000);

/// Writes one file: "recede local pca 1" and a line break; dimension, clusters and vectors (64 bits each),
/// components (32 bits) and the scale (a float); `parts` over the scale as halves, by cluster and entry; and
/// for each vector its cluster (8 bits, or 16 for more than 256 clusters) and its weights as halves. All
/// little-endian. No half-written file is ever seen. Throws `InputError` when the file can't be written.
void write_local_pca(const std::filesystem::path& path, const LocalPca& pca);

/// The same, bit for bit. Throws `InputError` for anything else, and for numbers that aren't finite.
LocalPca read_local_pca(const std::filesystem::path& path);

}  // namespace recede
