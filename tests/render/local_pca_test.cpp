#include "cancelling.h"
#include <recede/geometry/error.h>
#include <recede/render/direction_grid.h>
#include <recede/render/filtered_reflectance.h>
#include <recede/render/local_pca.h>

#include <Eigen/SVD>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>
#include <vector>

namespace recede {
namespace {

using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Halves have 11 binary digits: means, directions and weights err by at most 2^-11 of each.
constexpr double k_half = 1.0 / 2048;

Rows random_rows(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> number(0, 1);
  Rows result(rows, columns);
  for (Eigen::Index row = 0; row < rows; ++row) {
    for (Eigen::Index column = 0; column < columns; ++column) result(row, column) = number(random);
  }
  return result;
}

VectorSource source_of(const Rows& rows) {
  return vectors_in({rows.data(), static_cast<std::size_t>(rows.size())},
                    static_cast<std::size_t>(rows.cols()));
}

Rows reconstructed(const LocalPca& pca) {
  Rows rows(static_cast<Eigen::Index>(pca.vector_count()), static_cast<Eigen::Index>(pca.dimension));
  for (Eigen::Index row = 0; row < rows.rows(); ++row)
    reconstruct(pca, static_cast<std::size_t>(row), {rows.row(row).data(), pca.dimension});
  return rows;
}

double rms(const Rows& difference) {
  return std::sqrt(difference.cast<double>().squaredNorm() / static_cast<double>(difference.size()));
}

/// Vectors of pieces in turn. Pieces are flat, of `flat` dimensions, and ten times as far from each other as
/// they are wide.
Rows flat_pieces(Eigen::Index count, Eigen::Index dimension, int pieces, Eigen::Index flat) {
  const Rows middles = 10 * random_rows(pieces, dimension, 1);
  const Rows weights = random_rows(count, flat, 2);
  std::vector<Rows> along;
  for (int piece = 0; piece < pieces; ++piece)
    along.push_back(random_rows(flat, dimension, 3 + static_cast<unsigned>(piece)) /
                    std::sqrt(static_cast<float>(flat)));
  Rows rows(count, dimension);
  for (Eigen::Index row = 0; row < count; ++row)
    rows.row(row) =
        middles.row(row % pieces) + weights.row(row) * along[static_cast<std::size_t>(row % pieces)];
  return rows;
}

/// Of all strengths: directions of variances that fall by a tenth each, with means that differ.
Rows mixed_vectors(Eigen::Index count, Eigen::Index dimension, int groups = 5) {
  Rows weights = random_rows(count, std::min<Eigen::Index>(dimension, 60), 5);
  for (Eigen::Index column = 0; column < weights.cols(); ++column)
    weights.col(column) *= std::pow(0.95F, static_cast<float>(column));
  Rows rows(count, dimension);
  for (int group = 0; group < groups; ++group) {
    const Rows along = random_rows(weights.cols(), dimension, 20 + static_cast<unsigned>(group));
    const Rows middle = 4 * random_rows(1, dimension, 40 + static_cast<unsigned>(group));
    for (Eigen::Index row = group; row < count; row += groups)
      rows.row(row) = middle + weights.row(row) * along;
  }
  return rows;
}

TEST(LocalPca, RecoversVectorsOfFlatPieces) {
  // In all of the space, in the span of all vectors, and in a part of it that is found.
  struct Case {
    Eigen::Index count, dimension;
  };
  for (const Case& c : {Case{90, 40}, Case{200, 400}, Case{900, 700}}) {
    const Rows rows = flat_pieces(c.count, c.dimension, 6, 3);
    const LocalPca pca = make_local_pca(source_of(rows), {.clusters = 6, .components = 3});
    ASSERT_EQ(pca.cluster_count(), 6U);
    for (std::size_t i = 0; i < pca.vector_count(); ++i)
      ASSERT_EQ(pca.clusters[i], pca.clusters[i % 6]) << "vector " << i << " is of its piece's cluster";
    // The largest numbers are 40, and mean, direction and weights are rounded.
    EXPECT_LT((reconstructed(pca) - rows).cwiseAbs().maxCoeff(), 3 * 50 * k_half) << c.dimension;
    const LocalPcaError error = measure_error(pca, source_of(rows));
    EXPECT_LT(error.rms, k_half);
    EXPECT_EQ(error.sample, pca.vector_count());
    EXPECT_NEAR(error.range, rows.maxCoeff() - rows.minCoeff(), 1e-5);
  }
}

TEST(LocalPca, IsPlainPrincipalComponentAnalysisForOneCluster) {
  struct Case {
    Eigen::Index count, dimension;
  };
  for (const Case& c : {Case{40, 50}, Case{300, 50}, Case{300, 200}, Case{200, 700}, Case{700, 500}}) {
    const Rows rows = mixed_vectors(c.count, c.dimension, 1);
    const Eigen::RowVectorXf mean = rows.colwise().mean();
    const Eigen::BDCSVD<Eigen::MatrixXf> exact(rows.rowwise() - mean,
                                               Eigen::ComputeThinU | Eigen::ComputeThinV);
    constexpr int k_components = 5;
    Rows best = exact.matrixU().leftCols(k_components) *
                exact.singularValues().head(k_components).asDiagonal() *
                exact.matrixV().leftCols(k_components).transpose();
    best.rowwise() += mean;
    const LocalPca pca = make_local_pca(source_of(rows), {.clusters = 1, .components = k_components});
    // No five directions lose less; rounding is far below what they lose.
    const double least = rms(best - rows), lost = rms(reconstructed(pca) - rows);
    EXPECT_GT(lost, (1 - 1e-5) * least) << c.count << " x " << c.dimension;
    EXPECT_LT(lost, 1.0005 * least) << c.count << " x " << c.dimension;
  }
}

TEST(LocalPca, LosesLessWithMoreComponentsAndWithMoreClusters) {
  const Rows rows = mixed_vectors(1200, 300, 12);
  const auto lost = [&](int clusters, int components) {
    const LocalPca pca = make_local_pca(source_of(rows), {.clusters = clusters, .components = components});
    return measure_error(pca, source_of(rows)).rms;
  };
  double last = 1;
  for (const int components : {0, 2, 4, 8, 16}) {
    const double error = lost(6, components);
    EXPECT_LT(error, last) << components << " components";
    last = error;
  }
  last = 1;
  for (const int clusters : {1, 3, 6, 12}) {
    const double error = lost(clusters, 4);
    EXPECT_LT(error, last) << clusters << " clusters";
    last = error;
  }
}

TEST(LocalPca, SortsVectorsToTheClusterThatLosesLeastOfThem) {
  // Two crossing flat pieces with the same middle: nearness to means can't tell them apart.
  const Rows first = random_rows(400, 2, 1) * random_rows(2, 60, 2);
  const Rows second = random_rows(400, 2, 3) * random_rows(2, 60, 4);
  Rows rows(800, 60);
  rows << first, second;
  const LocalPca pca = make_local_pca(source_of(rows), {.clusters = 2, .components = 2, .least_change = 0});
  ASSERT_EQ(pca.cluster_count(), 2U);
  std::size_t strays = 0;
  for (std::size_t i = 0; i < 800; ++i) strays += pca.clusters[i] != pca.clusters[i < 400 ? 0 : 400];
  EXPECT_LE(strays, 8U) << "but for those about the middle";
  EXPECT_LT(measure_error(pca, source_of(rows)).rms, 2 * k_half);
}

void expect_same(const LocalPca& a, const LocalPca& b, float times = 1) {
  EXPECT_EQ(a.dimension, b.dimension);
  EXPECT_EQ(a.components, b.components);
  EXPECT_EQ(a.scale * times, b.scale);
  EXPECT_EQ(a.clusters, b.clusters);
  EXPECT_EQ(a.weights, b.weights);
  ASSERT_EQ(a.parts.size(), b.parts.size());
  for (std::size_t i = 0; i < a.parts.size(); ++i) ASSERT_EQ(a.parts[i] * times, b.parts[i]) << i;
}

TEST(LocalPca, IsTheSameForAnyNumberOfThreads) {
  const Rows rows = mixed_vectors(1100, 500, 9);
  const LocalPcaOptions options{.clusters = 12, .components = 6, .training_vectors = 700};
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return make_local_pca(source_of(rows), options);
  };
  const LocalPca one = with_threads(1);
  expect_same(one, with_threads(2));
  expect_same(one, with_threads(3));
}

TEST(LocalPca, HasTheSameDigitsForVectorsOfAnySize) {
  const Rows rows = mixed_vectors(400, 300);
  const LocalPca pca = make_local_pca(source_of(rows), {.clusters = 5, .components = 4});
  for (const float times : {0x1p40F, 0x1p-60F}) {
    const Rows other = times * rows;
    expect_same(pca, make_local_pca(source_of(other), {.clusters = 5, .components = 4}), times);
  }
}

TEST(LocalPca, GivesSingleEntriesAsWholeVectors) {
  const Rows rows = mixed_vectors(50, 90);
  const LocalPca pca = make_local_pca(source_of(rows), {.clusters = 3, .components = 7});
  const Rows whole = reconstructed(pca);
  for (std::size_t vector = 0; vector < 50; ++vector) {
    for (std::size_t index = 0; index < 90; index += 3) {
      const float* expected = whole.row(static_cast<Eigen::Index>(vector)).data() + index;
      std::array<float, 3> three{};
      reconstruct(pca, vector, three, index);
      ASSERT_THAT(three, testing::ElementsAre(expected[0], expected[1], expected[2]));
      ASSERT_EQ(entry(pca, vector, index + 1), expected[1]);
    }
  }
}

TEST(LocalPca, OfOneVectorIsThatVector) {
  const Rows rows = random_rows(1, 300, 1);
  const LocalPca pca = make_local_pca(source_of(rows));
  EXPECT_EQ(pca.cluster_count(), 1U);
  EXPECT_EQ(pca.components, 0);
  EXPECT_LT((reconstructed(pca) - rows).cwiseAbs().maxCoeff(), 5 * k_half);
}

TEST(LocalPca, OfEqualVectorsIsOneCluster) {
  for (const float value : {0.0F, 0.3F, -1234.5F}) {
    const Rows rows = Rows::Constant(500, 300, value);
    const LocalPca pca = make_local_pca(source_of(rows));
    EXPECT_EQ(pca.cluster_count(), 1U) << value;
    EXPECT_LE((reconstructed(pca) - rows).cwiseAbs().maxCoeff(), std::abs(value) * k_half);
    const LocalPcaError error = measure_error(pca, source_of(rows));
    EXPECT_EQ(error.range, 0);
    EXPECT_EQ(error.rms, 0);
  }
}

TEST(LocalPca, HasNoMoreClustersThanThereAreDifferentVectors) {
  // Three vectors, many times each, and five vectors once each.
  const Rows three = random_rows(3, 300, 1), few = random_rows(5, 300, 2);
  Rows many(300, 300);
  for (Eigen::Index row = 0; row < 300; ++row) many.row(row) = three.row(row % 3);
  for (const Rows& rows : {many, few}) {
    const LocalPca pca = make_local_pca(source_of(rows), {.clusters = 8, .components = 2});
    EXPECT_EQ(pca.cluster_count(), rows.rows() == 5 ? 5U : 3U);
    EXPECT_LT((reconstructed(pca) - rows).cwiseAbs().maxCoeff(), 5 * k_half);
    EXPECT_THAT(pca.weights, testing::Each(0)) << "clusters of equal vectors need no directions";
  }
}

TEST(LocalPca, LeavesNoClusterEmpty) {
  const Rows rows = mixed_vectors(200, 40);
  for (const int clusters : {1, 7, 60, 150}) {
    const LocalPca pca = make_local_pca(source_of(rows), {.clusters = clusters, .components = 2});
    const std::set<std::uint16_t> used(pca.clusters.begin(), pca.clusters.end());
    EXPECT_EQ(used.size(), pca.cluster_count());
    EXPECT_EQ(*used.rbegin() + 1U, pca.cluster_count());
    EXPECT_LE(pca.cluster_count(), static_cast<std::size_t>(clusters));
  }
}

TEST(LocalPca, AsksForEachVectorTwiceAtMostAndForFewAtOnce) {
  const Rows rows = mixed_vectors(900, 20'000);
  std::vector<int> asked(900, 0);
  std::size_t most = 0;
  VectorSource source = source_of(rows);
  const VectorSource whole = source;
  source.read = [&](std::size_t first, std::span<float> values) {
    whole.read(first, values);
    most = std::max(most, values.size());
    for (std::size_t i = 0; i < values.size() / whole.dimension; ++i) ++asked[first + i];
  };
  make_local_pca(source, {.clusters = 3, .components = 2, .training_vectors = 100, .rounds = 2});
  EXPECT_LE(most * sizeof(float), std::size_t{64} << 20);
  EXPECT_EQ(std::count(asked.begin(), asked.end(), 2), 100);
  EXPECT_EQ(std::count(asked.begin(), asked.end(), 1), 800);
}

TEST(LocalPca, NamesTheVectorWhoseNumbersAreNoNumbers) {
  for (const float bad : {std::nanf(""), -std::numeric_limits<float>::infinity(), 1e30F}) {
    Rows rows = random_rows(300, 20, 1);
    rows(217, 4) = bad;
    try {
      make_local_pca(source_of(rows), {.clusters = 2, .components = 2, .training_vectors = 10});
      ADD_FAILURE() << bad;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("number 4 of vector 217 "));
    }
  }
}

TEST(LocalPca, RefusesWhatMakesNoSense) {
  const Rows rows = random_rows(10, 4, 1);
  const VectorSource source = source_of(rows);
  EXPECT_THROW(make_local_pca(source, {.clusters = 0}), OptionError);
  EXPECT_THROW(make_local_pca(source, {.clusters = 65'537}), OptionError);
  EXPECT_THROW(make_local_pca(source, {.components = -1}), OptionError);
  EXPECT_THROW(make_local_pca(source, {.components = 65}), OptionError);
  EXPECT_THROW(make_local_pca(source, {.training_vectors = 0}), OptionError);
  EXPECT_THROW(make_local_pca(source, {.rounds = 0}), OptionError);
  EXPECT_THROW(make_local_pca(source, {.least_change = std::nan("")}), OptionError);
  EXPECT_THROW(make_local_pca({.count = 0, .dimension = 4, .read = source.read}), InputError);
  EXPECT_THROW(make_local_pca({.count = 10, .dimension = 0, .read = source.read}), InputError);
  EXPECT_THROW(vectors_in({rows.data(), 40}, 7), InputError);
  const LocalPca pca = make_local_pca(source);
  EXPECT_THROW(measure_error(pca, source, 0), OptionError);
  EXPECT_THROW(measure_error(pca, {.count = 9, .dimension = 4, .read = source.read}), InputError);
}

TEST(LocalPca, StopsWhenAsked) {
  const Rows rows = mixed_vectors(500, 600);
  for (const char* stage : {"reading training vectors", "finding directions", "projecting vectors",
                            "drawing means", "sorting by means", "sorting by directions"}) {
    test::Cancelling cancelling(stage);
    EXPECT_THROW(make_local_pca(source_of(rows), {.clusters = 4, .components = 2}, &cancelling), Cancelled)
        << stage;
  }
}

TEST(LocalPca, StoresABumpySurfaceByViewAndLight) {
  // The reflectance of 16 x 16 texels of waves for 49 views and 49 lights.
  std::vector<float> heights;
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; ++x)
      heights.push_back(0.03F * static_cast<float>(std::sin(x * std::numbers::pi / 8) *
                                                   std::cos(y * std::numbers::pi / 4)));
  }
  const FacetLevels levels(DisplacementMap(16, 16, heights, MapBorder::periodic));
  const DirectionGrid grid;
  const FacetMaterial rough{.albedo = 0.4, .roughness = 0.5};
  Rows rows(256, 49 * 49);
  for (int texel = 0; texel < 256; ++texel) {
    const FacetDistribution facets = levels.texel(0, texel % 16, texel / 16).unpacked();
    for (std::size_t view = 0; view < 49; ++view) {
      for (std::size_t light = 0; light < 49; ++light) {
        const Vec3 toward_light = grid.direction(light);
        rows(texel, static_cast<Eigen::Index>(view * 49 + light)) = static_cast<float>(
            filtered_reflectance(facets, grid.direction(view), toward_light, rough) * toward_light.z());
      }
    }
  }
  const LocalPca pca = make_local_pca(source_of(rows), {.clusters = 8, .components = 4});
  const LocalPcaError error = measure_error(pca, source_of(rows));
  // 0.14 and 0.33 % of the range; starts are drawn, and processors round differently.
  EXPECT_LT(error.rms, 0.002);
  EXPECT_LT(error.worst_rms, 0.005);
  const LocalPca one = make_local_pca(source_of(rows), {.clusters = 1, .components = 4});
  EXPECT_LT(2 * error.rms, measure_error(one, source_of(rows)).rms) << "of one cluster";
  EXPECT_LT(bytes(pca), static_cast<std::size_t>(rows.size()) * 2 / 6) << "a sixth of the halves";
}

}  // namespace
}  // namespace recede
