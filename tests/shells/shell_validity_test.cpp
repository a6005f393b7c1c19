#include "shell_layers.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <filesystem>
#include <limits>

namespace recede {
namespace {

using test::check;
using test::Layer;
using Pairs = ShellValidity::Pairs;

Layer flat_sheet(Index n, double height) {
  return test::sheet_layer(n, n, [&](Index i, Index j, Index r) { return Vec3(i, j, height * r); });
}

TEST(ShellValidity, NothingAndOneRightPrismAreValid) {
  EXPECT_TRUE(check({}).is_valid());
  const Layer prism{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}, {0, 1, 2}};
  EXPECT_TRUE(check(prism).is_valid());
  const ShellValidity inward = check(prism, {.is_inward = true});
  EXPECT_EQ(inward.inverted, std::vector<Index>{0});
  EXPECT_FALSE(inward.is_valid());
  EXPECT_TRUE(inward.has_valid_base());
}

TEST(ShellValidity, AFoldOfTheTopIsFound) {
  Layer sheet = flat_sheet(4, 1);
  EXPECT_TRUE(check(sheet).is_valid());
  sheet.top[12] += Vec3(1.5, 0, 0);  // the vertex in the middle, over the next one to the right
  const ShellValidity found = check(sheet);
  EXPECT_FALSE(found.is_valid());
  EXPECT_TRUE(found.has_valid_base());
  EXPECT_FALSE(found.top_contacts.empty());
  EXPECT_TRUE(found.layer_contacts.empty());
  EXPECT_TRUE(found.wall_contacts.empty());
  EXPECT_FALSE(found.inverted.empty());
}

TEST(ShellValidity, ATopOnTheBottomIsInvertedEverywhere) {
  const ShellValidity found = check(flat_sheet(3, 0));
  EXPECT_EQ(found.inverted.size(), 18u);
  EXPECT_GE(found.layer_contacts.size(), 18u);
  EXPECT_TRUE(found.has_valid_base());
}

TEST(ShellValidity, ABaseThatMeetsItselfIsSaid) {
  // The second triangle stands through the first.
  Layer layer{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, -1}, {1, 1, 1}, {2, 1, -1}}, {}, {0, 1, 2, 3, 4, 5}};
  for (std::size_t v = 0; v < 6; ++v)
    layer.top.push_back(layer.bottom[v] + Vec3(0, v < 3 ? 0 : 0.1, v < 3 ? 0.1 : 0));
  const ShellValidity found = check(layer);
  EXPECT_TRUE(found.inverted.empty());
  EXPECT_EQ(found.bottom_contacts, (Pairs{{0, 1}}));
  EXPECT_FALSE(found.has_valid_base());
}

TEST(ShellValidity, SpheresHaveLayersOnBothSides) {
  for (const double scale : {1.0, 1e-9, 1e9}) {
    for (const double height : {1.01, 1.5, 100.0}) {
      EXPECT_TRUE(check(test::sphere_layer(3, scale, 0.02, height, 1)).is_valid()) << scale << ' ' << height;
    }
    for (const double height : {0.99, 0.5, 0.01}) {
      const Layer layer = test::sphere_layer(3, scale, 0.02, height, 1);
      EXPECT_TRUE(check(layer, {.is_inward = true}).is_valid()) << scale << ' ' << height;
      EXPECT_EQ(check(layer).inverted.size(), layer.n_triangles()) << scale << ' ' << height;
    }
  }
  // Whole coordinates survive the way to another place.
  const auto far = [](const Vec3& p) { return Vec3(p + Vec3(1e6, -1e6, 1e6)); };
  EXPECT_TRUE(check(test::moved(test::whole(test::sphere_layer(2, 1000, 0.02, 1.5, 1)), far)).is_valid());
}

TEST(ShellValidity, ASpherePulledThroughItsCentreIsInverted) {
  // All steps meet in the centre, where the Jacobian is 0 without changing its sign.
  Layer layer = test::whole(test::sphere_layer(2, 256, 0, 1, 1));
  for (std::size_t v = 0; v < layer.top.size(); ++v) layer.top[v] = -0.5 * layer.bottom[v];
  const ShellValidity found = check(layer, {.is_inward = true});
  EXPECT_EQ(found.inverted.size(), layer.n_triangles());
  EXPECT_TRUE(found.top_contacts.empty() && found.layer_contacts.empty() && found.has_valid_base());
  // Turned as well, the tops pass the centre at a distance: there it is 0 only across the axis.
  for (std::size_t v = 0; v < layer.top.size(); ++v) {
    const Vec3& p = layer.bottom[v];
    layer.top[v] = -0.5 * Vec3(p.x() - 0.25 * p.y(), p.y() + 0.25 * p.x(), p.z());
  }
  const ShellValidity turned = check(layer, {.is_inward = true});
  EXPECT_GT(turned.inverted.size(), 0u);
  EXPECT_LT(turned.inverted.size(), layer.n_triangles() / 2);
  EXPECT_TRUE(turned.top_contacts.empty() && turned.layer_contacts.empty());
  // However the tops are moved, some prism shows it.
  std::mt19937 random(7);
  std::uniform_real_distribution<double> noise(-1, 1);
  for (int round = 0; round < 100; ++round) {
    Layer moved = test::sphere_layer(1, 1, 0, -0.5, 1);
    for (Vec3& p : moved.top) p += 0.004 * round * Vec3(noise(random), noise(random), noise(random));
    EXPECT_FALSE(check(moved, {.is_inward = true}).inverted.empty()) << round;
  }
}

TEST(ShellValidity, APieceInTheLayerOfAnotherIsNested) {
  const Layer large = test::sphere_layer(2, 10, 0.02, 2, 1);
  const auto small_at = [](const Vec3& center) {
    return test::moved(test::sphere_layer(1, 1, 0.02, 1.5, 2),
                       [&](const Vec3& p) { return Vec3(p + center); });
  };
  const auto first_of_second = static_cast<Index>(large.n_triangles());
  EXPECT_TRUE(check(test::joined(large, small_at({0, 0, 0}))).is_valid()) << "in the hollow";
  EXPECT_TRUE(check(test::joined(large, small_at({30, 0, 0}))).is_valid()) << "outside";
  for (const Vec3& center : {Vec3(15, 0, 0), Vec3(-15, 0, 0), Vec3(0, 0, 14), Vec3(9, -8, 8)}) {
    const ShellValidity found = check(test::joined(large, small_at(center)));
    EXPECT_EQ(found.nested_pieces, (Pairs{{first_of_second, 0}})) << center;
    EXPECT_TRUE(found.inverted.empty() && found.layer_contacts.empty() && found.has_valid_base()) << center;
    EXPECT_FALSE(found.is_valid()) << center;
    EXPECT_EQ(check(test::joined(small_at(center), large)).nested_pieces.size(), 1u) << center;
  }
  // The same where the large one has walls, and where the small one has.
  const Layer sheet = test::moved(flat_sheet(4, 1), [](const Vec3& p) { return Vec3(10 * p); });
  EXPECT_EQ(check(test::joined(sheet, small_at({20, 20, 5}))).nested_pieces, (Pairs{{32, 0}}));
  EXPECT_EQ(check(test::joined(sheet, small_at({19, 17, 5}))).nested_pieces, (Pairs{{32, 0}}));
  EXPECT_TRUE(check(test::joined(sheet, small_at({20, 20, -5}))).is_valid());
  EXPECT_TRUE(check(test::joined(sheet, small_at({-20, 20, 5}))).is_valid());
  const Layer patch = test::moved(flat_sheet(2, 0.5), [](const Vec3& p) { return Vec3(p + Vec3(14, 0, 0)); });
  EXPECT_EQ(check(test::joined(large, patch)).nested_pieces, (Pairs{{first_of_second, 0}}));
}

TEST(ShellValidity, LayersThatGrowTowardsEachOtherMayPassCompletely) {
  // A body in a room: neither starts in the layer of the other, but both end there.
  const Layer body = test::sphere_layer(2, 1, 0.02, 3, 1);
  const auto room = [](double height) {
    Layer layer = test::sphere_layer(2, 4, 0.02, height, 2);
    for (std::size_t t = 0; t < layer.triangles.size(); t += 3)
      std::swap(layer.triangles[t], layer.triangles[t + 1]);
    return layer;
  };
  EXPECT_TRUE(check(test::joined(body, room(0.9))).is_valid());
  const ShellValidity found = check(test::joined(body, room(0.5)));
  EXPECT_TRUE(found.inverted.empty() && found.top_contacts.empty() && found.layer_contacts.empty());
  EXPECT_EQ(found.nested_pieces, (Pairs{{0, 128}, {128, 0}}));
}

TEST(ShellValidity, FaultsOfPiecesAreFoundAtTheirVertices) {
  const Layer large = test::sphere_layer(2, 10, 0.02, 2, 1);
  Layer small = test::sphere_layer(1, 1, 0.02, 1.5, 2);
  small = test::moved(small, [](const Vec3& p) { return Vec3(p + Vec3(15, 0, 0)); });
  const Layer apart = test::moved(small, [](const Vec3& p) { return Vec3(p + Vec3(30, 0, 0)); });
  const Layer all = test::joined(test::joined(large, small), apart);
  const auto n_large = static_cast<Index>(large.bottom.size());
  const auto n_small = static_cast<Index>(small.bottom.size());
  for (const Index v : {Index{0}, n_large, n_large + n_small - 1}) {
    const std::array<Index, 1> changed{v};
    EXPECT_EQ(check(all, {.changed_vertices = changed}), check(all)) << v;
  }
  const std::array<Index, 1> changed{n_large + n_small};
  EXPECT_TRUE(check(all, {.changed_vertices = changed}).is_valid());
  EXPECT_TRUE(check(all, {.changed_vertices = std::span<const Index>()}).is_valid());
}

TEST(ShellValidity, PrismsOverlapAtAnEdgeWithThreeTriangles) {
  // Two triangles to the right of a side, one to the left; all prisms rise.
  Layer layer{{{0, 0, 0}, {0, 4, 0}, {4, 2, 0}, {4, 2, 3}, {-4, 2, 0}}, {}, {1, 0, 2, 1, 0, 3, 0, 1, 4}};
  for (const Vec3& p : layer.bottom) layer.top.push_back(p + Vec3(-0.1, 0, 1));
  const ShellValidity found = check(layer);
  EXPECT_TRUE(found.inverted.empty());
  EXPECT_EQ(found.overlapping_neighbours, (Pairs{{0, 1}}));
  EXPECT_FALSE(found.has_valid_base());
}

TEST(ShellValidity, AClosedFanLeavesNoSpaceAtItsVertex) {
  // Four triangles around the origin, and one more that hangs down from there.
  Layer layer{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {-4, 0, 0}, {0, -4, 0}, {1, 1, -4}, {-1, 1, -4}}, {}, {}};
  layer.triangles = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1, 0, 6, 5};
  for (const Vec3& p : layer.bottom) layer.top.push_back(p + Vec3(0, 0.2, 1));
  const ShellValidity found = check(layer);
  EXPECT_TRUE(found.bottom_contacts.empty());
  EXPECT_EQ(found.overlapping_neighbours, (Pairs{{0, 4}}));
  // Open fans may share a vertex.
  layer.triangles = {0, 1, 2, 0, 3, 4};
  EXPECT_TRUE(check(layer).is_valid());
}

TEST(ShellValidity, TwoSheetsMayBeAsCloseAsNumbersAre) {
  const Layer lower = flat_sheet(4, 1);
  for (const double gap : {0x1p-52, 1e-9, 0.5}) {
    const auto raised = [&](const Vec3& p) { return Vec3(p + Vec3(0.3, 0.2, 1 + gap)); };
    EXPECT_TRUE(check(test::joined(lower, test::moved(lower, raised))).is_valid()) << gap;
    const auto sunk = [&](const Vec3& p) { return Vec3(p + Vec3(0.3, 0.2, 1 - gap)); };
    const ShellValidity found = check(test::joined(lower, test::moved(lower, sunk)));
    EXPECT_FALSE(found.is_valid()) << gap;
    EXPECT_TRUE(found.has_valid_base()) << gap;
  }
}

TEST(ShellValidity, WallsThatMeetAreSaid) {
  // Two sheets side by side: their walls touch at the last one of these distances.
  const Layer sheet = flat_sheet(2, 1);
  for (const double gap : {0.5, 0x1p-40, 0.0}) {
    const auto aside = [&](const Vec3& p) { return Vec3(p + Vec3(2 + gap, 0.5, 0.25)); };
    const ShellValidity found = check(test::joined(sheet, test::moved(sheet, aside)));
    EXPECT_EQ(found.is_valid(), gap > 0) << gap;
    EXPECT_EQ(found.wall_contacts.empty(), gap > 0) << gap;
  }
  const auto inside = [](const Vec3& p) { return Vec3(p + Vec3(1.75, 0.5, 0.25)); };
  bool has_part[3] = {};
  for (const WallContact& wall : check(test::joined(sheet, test::moved(sheet, inside))).wall_contacts) {
    has_part[static_cast<std::size_t>(wall.part)] = true;
    EXPECT_LT(wall.corner, 48u);
    EXPECT_LT(wall.other, wall.part == ShellPart::wall ? 48u : 16u);
  }
  EXPECT_TRUE(has_part[0] && has_part[1] && has_part[2]);
}

/// How many (place, height) of a layer lie at `x`, and how near to the border of a prism the closest one is.
struct Preimages {
  std::size_t count = 0;
  double margin = 1;
};

Preimages preimages(const Layer& layer, const Vec3& x) {
  Preimages found;
  for (std::size_t t = 0; t < layer.triangles.size(); t += 3) {
    const auto corner = [&](std::size_t k, double r) {
      const Index v = layer.triangles[t + k];
      return Vec3((1 - r) * layer.bottom[v] + r * layer.top[v]);
    };
    const auto side = [&](double r) {
      return (corner(1, r) - corner(0, r)).cross(corner(2, r) - corner(0, r)).dot(x - corner(0, r));
    };
    // A cubic polynomial of the height: steps as short as these part its roots, or nearly always.
    constexpr int k_steps = 64;
    for (int k = 0; k < k_steps; ++k) {
      double low = static_cast<double>(k) / k_steps, high = static_cast<double>(k + 1) / k_steps;
      const bool is_below = side(low) < 0;
      if (is_below == (side(high) < 0)) continue;
      for (int step = 0; step < 50; ++step) {
        const double middle = 0.5 * (low + high);
        ((side(middle) < 0) == is_below ? low : high) = middle;
      }
      const Vec3 a = corner(0, low), normal = (corner(1, low) - a).cross(corner(2, low) - a);
      const double area = normal.squaredNorm();
      const double v = (x - a).cross(corner(2, low) - a).dot(normal) / area;
      const double w = (corner(1, low) - a).cross(x - a).dot(normal) / area;
      const double least = std::min({v, w, 1 - v - w});
      found.margin = std::min(found.margin, std::abs(least));
      found.count += least > 0 ? 1 : 0;
    }
  }
  return found;
}

/// The most places of the layer that random points of it have in common.
std::size_t most_preimages(const Layer& layer, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::size_t most = 0;
  for (int i = 0; i < 300; ++i) {
    const std::size_t t = 3 * (random() % layer.n_triangles());
    const double r = 0.02 + 0.96 * unit(random), v = unit(random), w = (1 - v) * unit(random);
    const double weights[] = {1 - v - w, v, w};
    Vec3 x(0, 0, 0);
    for (std::size_t k = 0; k < 3; ++k) {
      const Index vertex = layer.triangles[t + k];
      x += weights[k] * ((1 - r) * layer.bottom[vertex] + r * layer.top[vertex]);
    }
    const Preimages found = preimages(layer, x);
    if (found.margin < 1e-6) continue;  // rounding decides in which of two neighbours it lies
    most = std::max(most, found.count);
  }
  return most;
}

TEST(ShellValidity, PointsOfAValidLayerHaveOnePlace) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::size_t n_valid = 0, n_double = 0;
  for (int round = 0; round < 60; ++round) {
    Layer layer = round % 2 == 0 ? test::sphere_layer(1, 1, 0.1, 1.6, static_cast<unsigned>(round))
                                 : test::sheet_layer(4, 4, [](Index i, Index j, Index r) {
                                     return Vec3(0.5 * i, 0.5 * j, 0.2 * std::sin(i + 2.0 * j) + 0.7 * r);
                                   });
    const double noise = 0.012 * round;
    for (Vec3& p : layer.top) p += noise * Vec3(unit(random), unit(random), unit(random));
    const ShellValidity found = check(layer);
    const std::size_t most = most_preimages(layer, random);
    SCOPED_TRACE(round);
    if (found.is_valid()) {
      EXPECT_EQ(most, 1u);
      ++n_valid;
    }
    n_double += most > 1 ? 1 : 0;
  }
  EXPECT_GE(n_valid, 15u);
  EXPECT_GE(n_double, 10u);
  // What neither prisms nor contacts show.
  const Layer large = test::sphere_layer(1, 10, 0.02, 2, 1);
  const auto inside = [](const Vec3& p) { return Vec3(p + Vec3(14, 0, 0)); };
  EXPECT_GE(
      most_preimages(test::joined(large, test::moved(test::sphere_layer(1, 1, 0, 2, 1), inside)), random),
      2u);
}

TEST(ShellValidity, DoesntDependOnThreads) {
  Layer layer = test::sphere_layer(5, 1, 0.05, 1.05, 1);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> noise(-0.06, 0.06);
  for (Vec3& p : layer.top) p += Vec3(noise(random), noise(random), noise(random));
  const ShellValidity found = check(layer);
  EXPECT_GT(found.inverted.size(), 100u);
  EXPECT_GT(found.top_contacts.size(), 100u);
  EXPECT_GT(found.layer_contacts.size(), 100u);
  for (const std::size_t threads : {1u, 3u}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_EQ(check(layer), found) << threads;
  }
}

TEST(ShellValidity, ARealModelHasAThinLayer) {
  const std::filesystem::path path = RECEDE_DATA "/meshes/bunny00.off";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no models; ./dev data fetches them";
  PolygonSoup soup = read_soup(path);
  merge_identical_vertices(soup);
  Layer layer{soup.positions, soup.positions, triangulate(soup)};
  std::vector<Vec3> normals(soup.positions.size(), Vec3::Zero());
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    for (const Index v : soup.face(f)) normals[v] += vector_area(soup, f);
  }
  const auto raise = [&](double share) {
    const double height = share * bounding_box(soup).diagonal().norm();
    for (std::size_t v = 0; v < normals.size(); ++v) {
      layer.top[v] = layer.bottom[v] + height * normals[v].normalized();
    }
  };
  raise(5e-4);
  EXPECT_TRUE(check(layer).is_valid());
  raise(2e-2);  // normals cross in the folds
  const ShellValidity thick = check(layer);
  EXPECT_GT(thick.inverted.size(), 1000u);
  EXPECT_TRUE(thick.has_valid_base());
}

TEST(ShellValidity, BadInputIsRefused) {
  const Layer good = flat_sheet(1, 1);
  Layer bad = good;
  bad.top.pop_back();
  EXPECT_THROW(check(bad), InputError);
  bad = good;
  bad.triangles.pop_back();
  EXPECT_THROW(check(bad), InputError);
  bad = good;
  bad.triangles[4] = 4;
  EXPECT_THROW(check(bad), InputError);
  bad = good;
  bad.top[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(check(bad), InputError);
  const std::array<Index, 1> changed{4};
  EXPECT_THROW(check(good, {.changed_vertices = changed}), InputError);
}

TEST(ShellValidity, CanBeCancelled) {
  struct Impatient : Progress {
    void update(std::string_view, double) override { ++calls; }
    bool cancel_requested() const override { return calls > 3; }
    int calls = 0;
  };
  Impatient progress;
  const Layer layer = flat_sheet(8, 1);
  EXPECT_THROW(check_shell(layer.bottom, layer.top, layer.triangles, {}, &progress), Cancelled);
}

}  // namespace
}  // namespace recede
