// Meshes in chunks: cells, files of chunks, what is left of them, how far that is off, and whole hierarchies.
#include "error_text.h"
#include "meshes.h"
#include "soups.h"
#include "temp_folder.h"
#include <recede/geometry/mesh_distance.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/detail/chunk_distance.h>
#include <recede/lod/detail/reduce_chunks.h>
#include <recede/lod/detail/soup_pieces.h>
#include <recede/lod/out_of_core.h>

#include <gmock/gmock.h>

#include <numeric>
#include <random>

namespace recede {
namespace {

using detail::ChunkFiles;
using detail::SpaceCells;
using test::TempFolder;

std::vector<Vec3> random_points(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < n; ++i) points.emplace_back(unit(random), unit(random), 0.1 * unit(random));
  return points;
}

TEST(SpaceCells, HoldAtMostSoManyPoints) {
  for (const double share : {0.5, 0.37}) {
    const std::vector<Vec3> points = random_points(5000, 1);
    const SpaceCells cells(points, 300, share);
    std::vector<std::size_t> counts(cells.size(), 0);
    for (const Vec3& p : points) ++counts[cells.find(p)];
    for (const std::size_t n : counts) {
      EXPECT_LE(n, 300u);
      EXPECT_GT(n, 0u);
    }
  }
}

TEST(SpaceCells, PointsAtOnePlaceStayTogether) {
  std::vector<Vec3> points(1000, Vec3(1, 2, 3));
  points.insert(points.end(), 10, Vec3(1, 2, 4));
  const SpaceCells cells(points, 50, 0.5);
  EXPECT_EQ(cells.size(), 2u);
  EXPECT_NE(cells.find({1, 2, 3}), cells.find({1, 2, 4}));
}

TEST(SpaceCells, ManyPointsAtOnePlaceDontKeepOthersTogether) {
  std::vector<Vec3> points(1000, Vec3::Zero());
  for (int i = 1; i <= 300; ++i) points.emplace_back(i, 0, 0);
  const SpaceCells cells(points, 50, 0.5);
  std::vector<std::size_t> counts(cells.size(), 0);
  for (const Vec3& p : points) ++counts[cells.find(p)];
  std::sort(counts.begin(), counts.end());
  EXPECT_EQ(counts.back(), 1000u);
  EXPECT_LE(counts[counts.size() - 2], 50u);
}

TEST(SpaceCells, PiecesOfATriangleCoverItEachInItsCell) {
  const SpaceCells cells(random_points(2000, 2), 100, 0.4);
  const std::vector<Vec3> corners = random_points(300, 3);
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    const Triangle whole{corners[i], corners[i + 1], corners[i + 2]};
    Vec3 area = Vec3::Zero();
    cells.cut(whole, [&](Index cell, const Triangle& t) {
      area += 0.5 * (t.b - t.a).cross(t.c - t.a);
      EXPECT_EQ(cells.find((t.a + t.b + t.c) / 3), cell);
    });
    const Vec3 expected = 0.5 * (whole.b - whole.a).cross(whole.c - whole.a);
    EXPECT_LT((area - expected).norm(), 1e-13);  // rounding of coordinates of about 1
  }
}

TEST(SoupPieces, BytesKeepWhatASoupHas) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    PolygonSoup soup = test::random_soup(seed, {.scalars = true});
    PolygonSoup back = detail::soup_from_bytes(detail::to_bytes(soup));
    soup.materials.clear();
    soup.feature_edges.clear();
    test::expect_equal(back, soup);
  }
}

TEST(SoupPieces, WhatOnePartLacksIsFilledIn) {
  PolygonSoup soup = test::two_triangles(), more = test::two_triangles();
  more.vertex_colors.assign(4, Vec4(0.5, 0, 0, 1));
  more.corner_uvs.assign(6, Vec2(1, 2));
  more.vertex_scalars = {{"heat", {1, 2, 3, 4}}};
  detail::append(soup, more);
  detail::append(soup, test::two_triangles());
  EXPECT_NO_THROW(validate(soup, "parts"));
  EXPECT_EQ(soup.n_faces(), 6u);
  EXPECT_EQ(soup.vertex_colors[0], Vec4(1, 1, 1, 1));
  EXPECT_EQ(soup.vertex_colors[5], Vec4(0.5, 0, 0, 1));
  EXPECT_EQ(soup.corner_uvs[6], Vec2(1, 2));
  EXPECT_EQ(soup.corner_uvs[12], Vec2(0, 0));
  EXPECT_EQ(soup.vertex_scalars[0].values[7], 4);
  EXPECT_EQ(soup.vertex_scalars[0].values[8], 0);
}

/// A soup in chunks of at most about `most` faces, added in pieces of `piece`.
struct Chunked {
  Chunked(const TempFolder& folder, const PolygonSoup& soup, std::size_t most, std::size_t piece)
      : sample(soup.n_faces()), files(folder.path(), cells(soup, most), 1000) {
    std::vector<Index> vertices;
    for (std::size_t first = 0; first < soup.n_faces(); first += piece) {
      std::vector<Index> faces(std::min(piece, soup.n_faces() - first));
      std::iota(faces.begin(), faces.end(), static_cast<Index>(first));
      files.add(detail::cut_out(soup, faces, vertices));
    }
    files.finish();
  }

  SpaceCells cells(const PolygonSoup& soup, std::size_t most) {
    sample.add(soup);
    return sample.cells(most, 0.5);
  }

  detail::MiddleSample sample;
  ChunkFiles files;
};

double total_area(const PolygonSoup& soup) {
  double area = 0;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) area += vector_area(soup, f).norm();
  return area;
}

TEST(ChunkFiles, HoldEveryFaceOnceAndKnowWhatTheyShare) {
  const TempFolder folder;
  const PolygonSoup ball = make_displaced_sphere(3000, false);
  const Chunked chunked(folder, ball, 200, 333);
  ASSERT_GT(chunked.files.n_chunks(), 10u);
  EXPECT_EQ(chunked.files.n_faces(), ball.n_faces());
  const auto less = [](const Vec3& p, const Vec3& q) {
    return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
  };
  std::map<Vec3, std::set<std::size_t>, decltype(less)> chunks_of(less);
  std::vector<detail::Chunk> chunks;
  double area = 0;
  for (std::size_t i = 0; i < chunked.files.n_chunks(); ++i) {
    chunks.push_back(chunked.files.load(i));
    ASSERT_EQ(chunks.back().soup.n_faces(), chunked.files.n_faces(i));
    for (const Vec3& p : chunks.back().soup.positions) {
      chunks_of[p].insert(i);
      EXPECT_TRUE(chunked.files.box(i).contains(p));
    }
    area += chunked.files.area(i);
  }
  EXPECT_EQ(chunks_of.size(), ball.positions.size());
  EXPECT_NEAR(area, total_area(ball), 1e-12 * area);  // sums in another order
  for (const detail::Chunk& chunk : chunks) {
    for (std::size_t v = 0; v < chunk.soup.positions.size(); ++v)
      EXPECT_EQ(chunk.shared[v] != 0, chunks_of[chunk.soup.positions[v]].size() > 1);
  }
}

detail::ReducedSurface reduce(const TempFolder& folder, const PolygonSoup& soup, std::size_t most_faces,
                              std::size_t chunk_faces, const SimplifyOptions& options = {}) {
  const Chunked chunked(folder, soup, chunk_faces, 1000);
  detail::ReducedSurface result =
      detail::reduce_chunks(chunked.files, most_faces, bounding_box(soup).sizes().maxCoeff(),
                            {folder.path(), chunk_faces, 1 << 20}, options, nullptr);
  merge_identical_vertices(result.soup);
  return result;
}

SimplifyOptions to_faces(std::size_t faces) {
  SimplifyOptions options;
  options.target.faces = faces;
  options.prove_error = false;
  return options;
}

/// Distances of what is left in chunks and of what `simplify` leaves, over each other.
void expect_nearly_as_good(const PolygonSoup& soup, const PolygonSoup& reduced) {
  const SimplifySoupResult whole = simplify(soup, to_faces(reduced.n_faces()));
  const MeshDistance ours = measure_distance(soup, reduced), theirs = measure_distance(soup, whole.soup);
  EXPECT_LE(ours.rms, 1.1 * theirs.rms);  // what docs/out-of-core.md measures is 1.02
}

TEST(ReduceChunks, AClosedSurfaceStaysClosedAndAsGood) {
  const TempFolder folder;
  const PolygonSoup ball = make_displaced_sphere(40000, true);
  const detail::ReducedSurface reduced = reduce(folder, ball, 8000, 4000);
  EXPECT_EQ(reduced.passes, 1u);
  EXPECT_LE(reduced.soup.n_faces(), 8000u);
  EXPECT_GT(reduced.soup.n_faces(), 7900u);
  for (const auto& [edge, count] : test::edge_counts(reduced.soup)) EXPECT_EQ(count, 2);
  test::expect_sound(test::mesh_of(reduced.soup));
  expect_nearly_as_good(ball, reduced.soup);
}

TEST(ReduceChunks, SeveralPassesAreAsGood) {
  const TempFolder folder;
  const PolygonSoup ball = make_displaced_sphere(60000, true);
  const detail::ReducedSurface reduced = reduce(folder, ball, 1500, 5000);
  EXPECT_GT(reduced.passes, 1u);
  EXPECT_LE(reduced.soup.n_faces(), 1500u);
  for (const auto& [edge, count] : test::edge_counts(reduced.soup)) EXPECT_EQ(count, 2);
  expect_nearly_as_good(ball, reduced.soup);
}

TEST(ReduceChunks, WhatNearlyFitsIsReducedAsMuchAsNeeded) {
  const TempFolder folder;
  const PolygonSoup ball = make_displaced_sphere(5000, true);
  for (const std::size_t most : {ball.n_faces(), 2 * ball.n_faces() / 3, 2 * ball.n_faces() / 3 - 20}) {
    const detail::ReducedSurface reduced = reduce(folder, ball, most, 700);
    EXPECT_LE(reduced.soup.n_faces(), most);
    EXPECT_GE(reduced.soup.n_faces() + 2, most);
  }
}

/// Triangles over n x m squares whose corners `place` says.
template <typename Place>
PolygonSoup triangle_grid(int n, int m, Place&& place) {
  PolygonSoup grid;
  for (int x = 0; x <= n; ++x) {
    for (int y = 0; y <= m; ++y) grid.positions.push_back(place(x, y));
  }
  for (int x = 0; x < n; ++x) {
    for (int y = 0; y < m; ++y) {
      const auto at = [&](int i, int j) { return static_cast<Index>((x + i) * (m + 1) + y + j); };
      grid.add_face(std::vector<Index>{at(0, 0), at(1, 0), at(1, 1)});
      grid.add_face(std::vector<Index>{at(0, 0), at(1, 1), at(0, 1)});
    }
  }
  return grid;
}

/// Two rough strips, one close above the other, that meet at one end.
PolygonSoup folded_strip(int n) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  return triangle_grid(2 * n, 10, [&](int x, int y) {
    return Vec3(std::abs(x - n), y, 0.1 * unit(random) + (x < n ? 0 : 0.05));
  });
}

// In a chunk the strips are parts of their own; they aren't in the whole.
TEST(ReduceChunks, PartsOfAChunkAreNeitherDroppedNorJoined) {
  const TempFolder folder;
  const PolygonSoup strip = folded_strip(300);
  SimplifyOptions drop, join;
  drop.drop_parts = true;
  join.join_distance = 2;
  for (const SimplifyOptions& options : {drop, join}) {
    const PolygonSoup reduced = reduce(folder, strip, 1000, 1500, options).soup;
    EXPECT_LE(reduced.n_faces(), 1000u);
    // Without the roughness; a strip that is gone in one chunk of eight would be 6 %.
    EXPECT_NEAR(total_area(reduced), 2 * 300 * 10, 0.02 * 2 * 300 * 10);
  }
}

TEST(ReduceChunks, FacesThatOccurTwiceAreInNobodysWay) {
  const TempFolder folder;
  PolygonSoup twice = make_displaced_sphere(20000, true);
  detail::append(twice, PolygonSoup(twice));
  const PolygonSoup reduced = reduce(folder, twice, 3000, 2500).soup;
  EXPECT_LE(reduced.n_faces(), 3000u);
  for (const auto& [edge, count] : test::edge_counts(reduced)) EXPECT_EQ(count, 2);
}

TEST(ReduceChunks, UnitsDontMatter) {
  const TempFolder folder;
  const PolygonSoup ball = make_displaced_sphere(20000, true);
  PolygonSoup expected = reduce(folder, ball, 3000, 2500).soup;
  for (const int exponent : {-200, 200}) {  // the sixth power of which is no number
    PolygonSoup scaled = ball;
    for (Vec3& p : scaled.positions) p *= std::ldexp(1.0, exponent);
    PolygonSoup reduced = reduce(folder, scaled, 3000, 2500).soup;
    for (Vec3& p : reduced.positions) p *= std::ldexp(1.0, -exponent);
    test::expect_equal(reduced, expected);
  }
}

/// A square sheet that is flat on one half and rough on the other.
PolygonSoup half_rough_sheet(int n) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  return triangle_grid(n, n, [&](int x, int y) {
    return Vec3(x, y, 2 * x < n ? 0 : std::sin(0.7 * x) * std::cos(0.5 * y) + 0.05 * unit(random));
  });
}

// With the same share of the faces of each chunk, the flat half would keep a half of them.
TEST(ReduceChunks, FlatChunksGiveTheirFacesToRoughOnes) {
  const TempFolder folder;
  const PolygonSoup sheet = half_rough_sheet(120);
  const detail::ReducedSurface reduced = reduce(folder, sheet, 6000, 3000);
  std::size_t flat = 0;
  for (std::size_t f = 0; f < reduced.soup.n_faces(); ++f) {
    if (detail::middle_of(reduced.soup, f).x() < 58) ++flat;
  }
  EXPECT_LT(flat, reduced.soup.n_faces() / 20);
  expect_nearly_as_good(sheet, reduced.soup);
}

TEST(ReduceChunks, SameResultEachTime) {
  const TempFolder folder;
  const PolygonSoup ball = make_displaced_sphere(20000, true);
  test::expect_equal(reduce(folder, ball, 3000, 2500).soup, reduce(folder, ball, 3000, 2500).soup);
}

TEST(ReduceChunks, WhatCantBeReducedIsAnError) {
  const TempFolder folder;
  PolygonSoup leaves;  // single triangles
  for (const Vec3& p : random_points(3000, 7)) {
    const auto first = static_cast<Index>(leaves.positions.size());
    leaves.positions.insert(leaves.positions.end(), {p, p + Vec3(0.01, 0, 0), p + Vec3(0, 0.01, 0)});
    leaves.add_face(std::vector<Index>{first, first + 1, first + 2});
  }
  EXPECT_THAT(test::error_text([&] { reduce(folder, leaves, 100, 500); }),
              testing::HasSubstr("can't be brought to 100 faces, as many as memory allows: 3000 are left"));
}

TEST(ChunkDistance, IsThatToTheWholeSurface) {
  const TempFolder folder;
  const PolygonSoup ball = make_displaced_sphere(20000, true);
  const Chunked chunked(folder, ball, 1500, 1000);
  std::vector<PolygonSoup> levels;
  for (const std::size_t faces : {6000u, 400u, 20u}) levels.push_back(simplify(ball, to_faces(faces)).soup);
  const DistanceOptions options{.samples = 50'000, .bound_tolerance = 0.05};
  const std::vector<LevelError> errors =
      detail::measure_against_chunks(chunked.files, chunked.sample.points(), levels, options, nullptr);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const MeshDistance whole = measure_distance(ball, levels[i], options);
    EXPECT_NEAR(errors[i].rms, whole.rms, 0.01 * whole.rms);  // other samples of the same surfaces
    EXPECT_NEAR(errors[i].max, whole.max, 0.05 * whole.max);
    // Both intervals hold the true maximum.
    EXPECT_GE(errors[i].bound, whole.max_lower);
    EXPECT_GE(*whole.max_bound, errors[i].max);
    EXPECT_LE(errors[i].bound, 1.06 * *whole.max_bound);
  }
}

// The nearest points lie in cells that are far away.
TEST(ChunkDistance, LooksFartherWhereNothingIsNear) {
  const TempFolder folder;
  const PolygonSoup ball = make_displaced_sphere(5000, true);
  const Chunked chunked(folder, ball, 300, 1000);
  PolygonSoup far = ball;
  far.positions.resize(4);
  far.positions = {{-3, -3, 4}, {3, -3, 4}, {3, 3, 4}, {-3, 3, 4}};
  far.face_offsets = {0, 4};
  far.corner_vertices = {0, 1, 2, 3};
  const DistanceOptions options{.samples = 20'000, .bound_tolerance = 0.05};
  const LevelError error =
      detail::measure_against_chunks(chunked.files, chunked.sample.points(), {far}, options, nullptr)[0];
  const MeshDistance whole = measure_distance(ball, far, options);
  EXPECT_NEAR(error.max, whole.max, 1e-9);
  EXPECT_GE(error.bound, whole.max_lower);
  EXPECT_LE(error.bound, 1.06 * *whole.max_bound);
}

constexpr std::size_t k_least_memory = std::size_t{256} << 20;

HierarchyOptions by_ratios(std::vector<double> ratios) {
  HierarchyOptions options;
  options.ratios = std::move(ratios);
  return options;
}

TEST(OutOfCore, LevelsAreAsGoodAsInMemory) {
  const TempFolder folder;
  const PolygonSoup ball = make_displaced_sphere(400'000, true);
  write_soup(folder / "ball.ply", ball);
  const OutOfCoreHierarchy built = build_hierarchy_out_of_core(
      folder / "ball.ply", "ball", by_ratios({0.9, 0.1, 0.02}), {k_least_memory, folder.path()});
  EXPECT_EQ(built.left_out, std::vector<double>{std::floor(0.9 * double(ball.n_faces()))});
  EXPECT_GT(built.chunks, 1u);
  const LodHierarchy& h = built.hierarchy;
  EXPECT_EQ(h.source_faces, ball.n_faces());
  ASSERT_EQ(h.levels.size(), 3u);
  EXPECT_LT(h.levels[0].mesh.n_faces(), ball.n_faces());
  EXPECT_GT(h.levels[0].error.max, 0);
  const LodHierarchy whole = build_hierarchy(test::mesh_of(ball), "ball", by_ratios({0.1, 0.02}));
  for (std::size_t i = 1; i < 3; ++i) {
    const LodLevel &ours = h.levels[i], &theirs = whole.levels[i];
    EXPECT_EQ(ours.mesh.n_faces(), theirs.mesh.n_faces());
    EXPECT_LE(ours.error.rms, 1.1 * theirs.error.rms);
    EXPECT_LE(ours.error.bound, 1.2 * theirs.error.bound);  // of one spot, which differs from run to run
    EXPECT_LE(ours.error.max, ours.error.bound);
    EXPECT_DOUBLE_EQ(ours.switch_distance, switch_distance(ours.error.bound, h.view));
    test::expect_sound(ours.mesh);
  }
  // Nothing is left over, and what is written says what it was made from.
  std::size_t n_files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.path())) ++n_files;
  EXPECT_EQ(n_files, 1u);
  EXPECT_EQ(read_hierarchy(write_hierarchy(folder.path(), h).folder).source_faces, ball.n_faces());
}

TEST(OutOfCore, ErrorsThatAreAskedForAreKept) {
  const TempFolder folder;
  const PolygonSoup ball = make_displaced_sphere(300'000, true);
  write_soup(folder / "ball.stl", ball);
  HierarchyOptions options;
  options.errors = {1e-9, 0.004, 0.02};
  const OutOfCoreHierarchy built =
      build_hierarchy_out_of_core(folder / "ball.stl", "ball", options, {k_least_memory, folder.path()});
  EXPECT_EQ(built.left_out, std::vector<double>{1e-9});
  ASSERT_EQ(built.hierarchy.levels.size(), 3u);
  for (std::size_t i = 1; i < 3; ++i) {
    const LodLevel& level = built.hierarchy.levels[i];
    EXPECT_LE(level.error.bound, options.errors[i]);
    // Of the file, whose positions are floats: 1e-7 of about 1.
    const MeshDistance distance = measure_distance(ball, to_soup(level.mesh));
    EXPECT_LE(distance.max, options.errors[i] + 1e-6);
    EXPECT_GT(distance.max, 0.3 * options.errors[i]);
  }
}

TEST(OutOfCore, SaysWhatCantBe) {
  const TempFolder folder;
  write_soup(folder / "ball.ply", make_displaced_sphere(1000, true));
  write_soup(folder / "ball.obj", make_displaced_sphere(1000, true));
  const auto complaint = [&](const char* name, const HierarchyOptions& options, std::size_t memory) {
    return test::error_text([&] {
      build_hierarchy_out_of_core(folder / name, "ball", options, {memory, folder.path()});
    });
  };
  EXPECT_EQ(complaint("ball.ply", by_ratios({0.5}), 1000), "memory must be at least 256 MiB, not 1000 bytes");
  EXPECT_THAT(complaint("ball.obj", by_ratios({0.5}), k_least_memory),
              testing::HasSubstr("ball.obj: can't be read in pieces; binary PLY and binary STL can"));
  HierarchyOptions other = by_ratios({0.5});
  other.simplify.cost = CostPolicy::normal_deviation;
  EXPECT_THAT(complaint("ball.ply", other, k_least_memory), testing::HasSubstr("by the cost volume"));
  HierarchyOptions large;
  large.faces = {100'000'000};
  EXPECT_THAT(complaint("ball.ply", large, k_least_memory), testing::HasSubstr("no level is to have fewer"));
  large.faces = {1'000'000};
  EXPECT_THAT(complaint("ball.ply", large, k_least_memory), testing::HasSubstr("no level is to have fewer"));
  PolygonSoup point = test::two_triangles();
  point.positions.assign(4, Vec3(1, 2, 3));
  write_soup(folder / "point.ply", point);
  EXPECT_THAT(complaint("point.ply", by_ratios({0.5}), k_least_memory),
              testing::HasSubstr("point.ply: holds no faces after repair"));
  EXPECT_THAT(test::error_text([&] { needs_more_than(k_least_memory, folder / "missing.obj"); }),
              testing::HasSubstr("missing.obj: No such file"));
}

}  // namespace
}  // namespace recede
