#include "slice_renderer.h"

#include <recede/geometry/error.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>

namespace recede::bench {
namespace {

/// From 0 to 1 in each coordinate, with places of the same numbers.
Slab unit_slab() {
  Slab slab;
  for (int c = 0; c < 8; ++c) {
    const auto corner = static_cast<std::size_t>(c);
    slab.corners[corner] = slab.places[corner] = Vec3(c & 1, (c >> 1) & 1, c >> 2);
  }
  return slab;
}

/// Parallel rays along -z from above, `n` pixels across the unit square.
SliceView from_above(int n) {
  return {
      {{0.5, 0.5, 2}, Vec3::UnitX(), Vec3::UnitY(), -Vec3::UnitZ(), 1.0 / n, {n / 2.0, n / 2.0}}, n, n, true};
}

constexpr double k_radius = 0.3;

/// A ball in the middle: opacity is 0.5 + 4 times the distance from its surface, inwards.
OpacityField ball_field() {
  return {[](const Vec3& place) { return 0.5 + 4 * (k_radius - (place - Vec3::Constant(0.5)).norm()); },
          [](const Vec3& place) { return Vec3(-4 * (place - Vec3::Constant(0.5)).normalized()); }};
}

struct BallErrors {
  double normal = 0, depth = 0;  // root mean squares; degrees, lengths
};

BallErrors ball_errors(int slices, SliceRefinement refinement) {
  constexpr int k_side = 150;
  const SlicePicture picture = draw_slices({unit_slab()}, ball_field(), from_above(k_side),
                                           {.slices = slices, .refinement = refinement});
  BallErrors sums;
  int count = 0;
  for (int y = 0; y < k_side; ++y) {
    for (int x = 0; x < k_side; ++x) {
      const double u = (x + 0.5) / k_side - 0.5, v = 0.5 - (y + 0.5) / k_side;
      const double height = std::sqrt(k_radius * k_radius - u * u - v * v);
      const SlicePixel& pixel = picture.pixels[static_cast<std::size_t>(y * k_side + x)];
      if (!(height > 0) || !pixel.is_hit) continue;
      const Vec3 normal = Vec3(u, v, height) / k_radius;
      const double angle =
          std::atan2(normal.cross(pixel.normal).norm(), normal.dot(pixel.normal)) * 180 / std::numbers::pi;
      sums.normal += angle * angle;
      sums.depth += std::pow(pixel.depth - (1.5 - height), 2);
      ++count;
    }
  }
  EXPECT_GT(count, 5000);
  return {std::sqrt(sums.normal / count), std::sqrt(sums.depth / count)};
}

// Checklist 20, table of 2.11: root mean squares over the ball's pixels.
TEST(SliceRenderer, ErrorsAreOfFirstOrderAndInterpolatedOnesOfSecond) {
  struct Line {
    int slices;
    double plain, coordinates, normals, plain_depth, depth;
  };
  BallErrors plain_before, before;
  for (const Line& line : {Line{8, 12.3, 1.20, 2.01, 0.0739, 0.0071},
                           {16, 5.67, 0.365, 0.516, 0.0410, 0.0021},
                           {32, 2.61, 0.080, 0.116, 0.0187, 0.00045},
                           {64, 1.24, 0.019, 0.028, 0.0091, 0.00011},
                           {128, 0.61, 0.005, 0.007, 0.0046, 0.000026}}) {
    const BallErrors plain = ball_errors(line.slices, SliceRefinement::none),
                     coordinates = ball_errors(line.slices, SliceRefinement::coordinates),
                     normals = ball_errors(line.slices, SliceRefinement::normals);
    EXPECT_NEAR(plain.normal / line.plain, 1, 0.05);
    EXPECT_NEAR(plain.depth / line.plain_depth, 1, 0.05);
    // What is left of the errors is that of pixels at the outline, of which a finer picture has more: up to
    // 1.9 times the table's with 128 slices, and never less than the table's.
    for (const double ratio : {coordinates.normal / line.coordinates, normals.normal / line.normals,
                               coordinates.depth / line.depth}) {
      EXPECT_GT(ratio, 0.99);
      EXPECT_LT(ratio, 1.9);
    }
    if (line.slices > 8) {
      EXPECT_NEAR(plain_before.normal / plain.normal, 2.1, 0.2);
      EXPECT_NEAR(plain_before.depth / plain.depth, 2, 0.2);
      EXPECT_GT(before.normal / coordinates.normal, 3);
      EXPECT_GT(before.depth / coordinates.depth, 3);
    }
    plain_before = plain;
    before = coordinates;
  }
  const BallErrors sixteen = ball_errors(16, SliceRefinement::coordinates),
                   many = ball_errors(128, SliceRefinement::none);
  EXPECT_LT(sixteen.normal, many.normal);
  EXPECT_LT(sixteen.depth, many.depth);
}

// Checklist 20.
TEST(SliceRenderer, ASliceOnTheSurfaceIsTheSurface) {
  const OpacityField half_space{[](const Vec3& place) { return 0.5 + (0.5 - place.z()); },
                                [](const Vec3&) { return Vec3(-Vec3::UnitZ()); }};
  const SlicePicture picture = draw_slices({unit_slab()}, half_space, from_above(8),
                                           {.slices = 17, .border_offset = 0, .keeps_fragments = true});
  for (std::size_t p = 0; p < picture.pixels.size(); ++p) {
    ASSERT_TRUE(picture.pixels[p].is_hit);
    EXPECT_EQ(picture.inside[p].opacity, 0.5);
    EXPECT_EQ(picture.pixels[p].place, picture.inside[p].place);
    EXPECT_EQ(picture.pixels[p].depth, 1.5);
  }
}

Camera aslant(int n) {
  return {.position = {2.4, -1.3, 2.9},
          .target = Vec3::Constant(0.5),
          .field_of_view = 0.6,
          .width = n,
          .height = n};
}

Vec3 point_at(const SliceView& view, std::size_t pixel, double depth) {
  const auto row = static_cast<std::size_t>(view.width);
  const double x = static_cast<double>(pixel % row) + 0.5, y = static_cast<double>(pixel / row) + 0.5;
  const Vec3 direction = view.frame.direction(x, y);
  return view.frame.position + depth / direction.dot(view.frame.forward) * direction;
}

// Checklist 20: also in perspective, where places are no linear functions of pixels.
TEST(SliceRenderer, FindsThePlaneOfALinearOpacity) {
  const Vec3 slope(-0.7, 0.4, -1.1);  // falls towards the camera
  const OpacityField plane{[&](const Vec3& place) { return 0.5 + slope.dot(place - Vec3(0.5, 0.45, 0.4)); },
                           [&](const Vec3&) { return slope; }};
  const SliceView view = slice_view(aslant(80));
  const SlicePicture picture =
      draw_slices({unit_slab()}, plane, view, {.slices = 5, .keeps_fragments = true});
  int found = 0;
  for (std::size_t p = 0; p < picture.pixels.size(); ++p) {
    const SlicePixel& pixel = picture.pixels[p];
    if (!pixel.is_hit || picture.outside[p].slab < 0) continue;
    EXPECT_NEAR(plane.opacity(pixel.place), 0.5, 1e-12);
    EXPECT_LT((point_at(view, p, pixel.depth) - pixel.place).norm(), 1e-9);  // weights may be 1e-9 below 0
    EXPECT_LT((pixel.normal + slope.normalized()).norm(), 1e-12);
    ++found;
  }
  EXPECT_GT(found, 800);
}

// Checklist 20: from pixel to pixel the nearest slice jumps, what is between slices doesn't.
TEST(SliceRenderer, IsContinuousWhereSlicesEnd) {
  constexpr int k_side = 200;
  const SlicePicture picture =
      draw_slices({unit_slab()}, ball_field(), from_above(k_side), {.keeps_fragments = true});
  double jump = 0, plain_jump = 0;
  for (int y = 0; y < k_side; ++y) {
    for (int x = 1; x < k_side; ++x) {
      const double u = (x + 0.5) / k_side - 0.5, v = (y + 0.5) / k_side - 0.5;
      if (std::hypot(u, v) > 0.2) continue;  // where the ball isn't steep: less than 0.9
      const auto p = static_cast<std::size_t>(y * k_side + x);
      jump = std::max(jump, std::abs(picture.pixels[p].place.z() - picture.pixels[p - 1].place.z()));
      plain_jump =
          std::max(plain_jump, std::abs(picture.inside[p].place.z() - picture.inside[p - 1].place.z()));
    }
  }
  EXPECT_NEAR(plain_jump, (1 - 2 * SliceOptions{}.border_offset) / 15, 1e-12);  // a slice
  EXPECT_LT(jump, 1.0 / k_side);  // the slope over a pixel, 0.0045, and what interpolation is off by
}

/// Cubes with bent sides that meet each other, and coordinates in them.
std::vector<Slab> random_slabs(std::mt19937& random) {
  std::uniform_real_distribution<double> number(-1, 1);
  const auto draw = [&] { return Vec3(number(random), number(random), number(random)); };
  std::vector<Slab> slabs;
  for (int n = 0; n < 3; ++n) {
    Slab slab = unit_slab();
    const Vec3 off = 0.5 * draw(), place = draw();
    for (std::size_t c = 0; c < 8; ++c) {
      slab.corners[c] += off + 0.15 * draw();
      slab.places[c] += place + 0.1 * draw();
    }
    slabs.push_back(slab);
  }
  return slabs;
}

OpacityField wavy_field() {
  return {[](const Vec3& place) {
            return 0.5 + 0.4 * std::sin(7 * place.x()) * std::sin(6 * place.y()) +
                   0.3 * std::sin(8 * place.z());
          },
          [](const Vec3&) { return Vec3(Vec3::UnitZ()); }};
}

/// All that a ray meets of slices and faces: made anew from their definition.
struct Meeting {
  int slab;
  double depth, opacity;
};

Vec3 mixed(const std::array<Vec3, 8>& corners, double u, double v, double w) {
  const auto along = [&](std::size_t c) { return Vec3((1 - u) * corners[c] + u * corners[c + 1]); };
  return (1 - w) * ((1 - v) * along(0) + v * along(2)) + w * ((1 - v) * along(4) + v * along(6));
}

std::optional<std::array<double, 3>> meet_triangle(const Vec3& from, const Vec3& direction,
                                                   const std::array<Vec3, 3>& at) {
  Eigen::Matrix3d columns;
  columns << at[1] - at[0], at[2] - at[0], -direction;
  const Vec3 solved = columns.inverse() * (from - at[0]);
  if (!(solved.x() >= 0) || !(solved.y() >= 0) || !(solved.x() + solved.y() <= 1)) return {};
  return std::array<double, 3>{solved.x(), solved.y(), solved.z()};
}

int axis_across(const Slab& slab, const Vec3& eye) {
  const Vec3 along = mixed(slab.corners, 0.5, 0.5, 0.5) - eye;
  std::array<double, 3> facing{};
  for (const double end : {0.0, 1.0}) {
    const auto slope = [&](int axis, int other) {
      // At the middle of the end across `other`.
      Vec3 low = Vec3::Constant(0.5);
      low[other] = end;
      Vec3 high = low;
      low[axis] = 0;
      high[axis] = 1;
      return Vec3(mixed(slab.corners, high.x(), high.y(), high.z()) -
                  mixed(slab.corners, low.x(), low.y(), low.z()));
    };
    for (int axis = 0; axis < 3; ++axis)
      facing[static_cast<std::size_t>(axis)] +=
          slope((axis + 1) % 3, axis).cross(slope((axis + 2) % 3, axis)).normalized().dot(along);
  }
  int best = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (std::abs(facing[static_cast<std::size_t>(axis)]) > std::abs(facing[static_cast<std::size_t>(best)]))
      best = axis;
  return best;
}

std::vector<Meeting> all_meetings(const std::vector<Slab>& slabs, const OpacityField& field, const Vec3& eye,
                                  const Vec3& direction, int slices) {
  constexpr double k_offset = 1e-4;
  std::vector<Meeting> meetings;
  for (std::size_t s = 0; s < slabs.size(); ++s) {
    const int across = axis_across(slabs[s], eye);
    for (int axis = 0; axis < 3; ++axis) {
      const int count = axis == across ? slices : 2;
      for (int m = 0; m < count; ++m) {
        const double share = k_offset + (1 - 2 * k_offset) * m / (count - 1);
        for (const bool is_second : {false, true}) {
          std::array<Vec3, 3> points, places;
          for (std::size_t k = 0; k < 3; ++k) {
            // Corners in turn are (0, 0), (1, 0), (1, 1), (0, 1).
            const std::size_t c = is_second && k > 0 ? k + 1 : k;
            Vec3 at;
            at[axis] = share;
            at[(axis + 1) % 3] = c == 1 || c == 2 ? 1 : 0;
            at[(axis + 2) % 3] = c >= 2 ? 1 : 0;
            points[k] = mixed(slabs[s].corners, at.x(), at.y(), at.z());
            places[k] = mixed(slabs[s].places, at.x(), at.y(), at.z());
          }
          if (const auto met = meet_triangle(eye, direction, points)) {
            const auto [u, v, depth] = *met;
            const Vec3 place = (1 - u - v) * places[0] + u * places[1] + v * places[2];
            meetings.push_back({static_cast<int>(s), depth, field.opacity(place)});
          }
        }
      }
    }
  }
  return meetings;
}

// Checklist 21.
TEST(SliceRenderer, PassesFindWhatEachRayMeets) {
  std::mt19937 random(4);
  int inside = 0, outside = 0;
  for (int round = 0; round < 3; ++round) {
    const std::vector<Slab> slabs = random_slabs(random);
    const OpacityField field = wavy_field();
    const SliceView view = slice_view(aslant(40));
    const SlicePicture picture = draw_slices(slabs, field, view, {.slices = 9, .keeps_fragments = true});
    for (std::size_t p = 0; p < picture.pixels.size(); ++p) {
      const Vec3 direction = point_at(view, p, 1) - view.frame.position;  // as long as a depth of 1
      const std::vector<Meeting> meetings = all_meetings(slabs, field, view.frame.position, direction, 9);
      Meeting nearest{-1, std::numeric_limits<double>::infinity(), 0}, farthest{-1, 0, 0};
      for (const Meeting& meeting : meetings)
        if (meeting.opacity >= 0.5 && meeting.depth < nearest.depth) nearest = meeting;
      for (const Meeting& meeting : meetings)
        if (meeting.opacity < 0.5 && meeting.depth < nearest.depth && meeting.depth > farthest.depth)
          farthest = meeting;
      ASSERT_EQ(picture.inside[p].slab, nearest.slab);
      if (nearest.slab < 0) continue;
      ++inside;
      EXPECT_NEAR(picture.inside[p].depth, nearest.depth, 1e-9);
      ASSERT_EQ(picture.outside[p].slab, farthest.slab);
      if (farthest.slab < 0) continue;
      ++outside;
      EXPECT_NEAR(picture.outside[p].depth, farthest.depth, 1e-9);
      EXPECT_NEAR(picture.outside[p].opacity, farthest.opacity, 1e-9);
    }
  }
  EXPECT_GT(inside, 500);
  EXPECT_GT(outside, 300);
}

// Checklist 21.
TEST(SliceRenderer, EightBitsOfDepthPickWrongFragments) {
  std::mt19937 random(5);
  const std::vector<Slab> slabs = random_slabs(random);
  const SliceView view = slice_view(aslant(80));
  const auto wrong = [&](int bits) {
    SliceOptions options{.slices = 256, .keeps_fragments = true};
    const SlicePicture exact = draw_slices(slabs, wavy_field(), view, options);
    options.depth_bits = bits;
    const SlicePicture picture = draw_slices(slabs, wavy_field(), view, options);
    int count = 0, all = 0;
    for (std::size_t p = 0; p < exact.pixels.size(); ++p) {
      if (exact.outside[p].slab < 0) continue;
      ++all;
      if (picture.outside[p].slab != exact.outside[p].slab ||
          picture.outside[p].depth != exact.outside[p].depth)
        ++count;
    }
    EXPECT_GT(all, 1000);
    return static_cast<double>(count) / all;
  };
  EXPECT_GT(wrong(8), 0.2);
  // 24 bits are steps of about 2e-7; slices are a 256th apart, steps of 8 bits a hundredth.
  EXPECT_LT(wrong(24), 0.001);
}

// Checklist 22.
TEST(SliceRenderer, WithoutSidesRaysThroughThemAreOff) {
  // A wall just behind the side at x = 1.
  const OpacityField wall{[](const Vec3& place) { return 0.5 + (0.99 - place.x()); },
                          [](const Vec3&) { return Vec3(-Vec3::UnitX()); }};
  const Camera camera{.position = {4.1, 0.5, 4.3},
                      .target = Vec3::Constant(0.5),
                      .field_of_view = 0.3,
                      .width = 120,
                      .height = 120};
  const SliceView view = slice_view(camera);
  const auto share_off = [&](bool with_sides) {
    const SlicePicture picture = draw_slices({unit_slab()}, wall, view, {.with_sides = with_sides});
    int through_side = 0, off = 0;
    for (std::size_t p = 0; p < picture.pixels.size(); ++p) {
      // Where the ray comes to the side and to the wall.
      const Vec3 step = point_at(view, p, 1) - view.frame.position;
      const auto at = [&](double x) {
        return Vec3(view.frame.position + (x - view.frame.position.x()) / step.x() * step);
      };
      const auto is_within = [](const Vec3& point) {
        return std::min(point.y(), point.z()) > 0.01 && std::max(point.y(), point.z()) < 0.99;
      };
      if (!is_within(at(1)) || !is_within(at(0.99))) continue;
      ++through_side;
      if (!picture.pixels[p].is_hit || std::abs(picture.pixels[p].place.x() - 0.99) > 1e-9) ++off;
    }
    EXPECT_GT(through_side, 300);
    return static_cast<double>(off) / through_side;
  };
  EXPECT_EQ(share_off(true), 0);
  // Slices are 1 / 15 apart. Between side and wall rays get down by 0.0106: 16 of 100 meet a slice there.
  EXPECT_NEAR(share_off(false), 0.84, 0.01);
}

// Checklist 22.
TEST(SliceRenderer, CoordinatesOfTwoTexturesArentMixed) {
  std::vector<Slab> slabs(2, unit_slab());
  for (Vec3& corner : slabs[1].corners) corner.x() += 1;
  for (Vec3& place : slabs[1].places) place.x() += 5;
  // A step up where the second one begins.
  const OpacityField steps{[](const Vec3& place) { return 0.5 + ((place.x() < 3 ? 0.3 : 0.7) - place.z()); },
                           [](const Vec3&) { return Vec3(-Vec3::UnitZ()); }};
  const Camera camera{
      .position = {-2, 0.5, 3}, .target = {1, 0.5, 0.5}, .field_of_view = 0.5, .width = 80, .height = 80};
  const auto mixed_pixels = [&] {
    int count = 0;
    for (const SlicePixel& pixel : draw_slices(slabs, steps, slice_view(camera)).pixels)
      if (pixel.is_hit && pixel.place.x() > 1 && pixel.place.x() < 5) ++count;
    return count;
  };
  EXPECT_GT(mixed_pixels(), 50);
  slabs[1].texture = 1;
  EXPECT_EQ(mixed_pixels(), 0);
}

// Checklist 27: opacity of a level of 16 texels, drawn with more or fewer slices.
TEST(SliceRenderer, BlendingGrowsWithSlicesUnlessItIsCorrected) {
  const auto opacity = [](const Vec3& place) { return 0.02 + 0.1 * place.z() * (1 - place.z()); };
  // Both ways across a period as far as a ray from aside goes.
  const SliceView view = slice_view({.position = {0.9, -0.2, 6},
                                     .target = Vec3::Constant(0.5),
                                     .field_of_view = 0.1,
                                     .width = 7,
                                     .height = 7});
  const auto middle = [&](int slices, int level) {
    return blend_slices({unit_slab()}, opacity, view, {.slices = slices, .slices_of_level = level})[24];
  };
  EXPECT_NEAR(blend_slices({unit_slab()}, [](const Vec3&) { return 0.1; }, view, {.slices = 8})[24],
              1 - std::pow(0.9, 8), 1e-12);
  double before = 0;
  for (const int slices : {8, 16, 24, 32, 64}) {
    EXPECT_GT(middle(slices, 0), before + 0.05);
    before = middle(slices, 0);
    // Ends count in full, so that fewer slices see more of them: the mean of z (1 - z) over 8 of them is
    // 0.143, over many 0.167.
    EXPECT_NEAR(middle(slices, 16), middle(16, 16), 0.02);
  }
}

TEST(SliceRenderer, SlabsAreThoseOfTheShell) {
  PolygonSoup square;
  square.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  square.add_face(std::array<Index, 4>{0, 1, 2, 3});
  square.corner_uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const auto shell =
      std::make_shared<const Shell>(build_shell(square, {.thickness = 1, .method = DirectorMethod::normals}));
  const auto texture =
      std::make_shared<const VolumeMipmap>(make_mipmap({.size = {1, 1, 1}, .opacity = {{1, 1, 1}, 0}}));
  const TexturedShell textured{
      .shell = shell, .texture = texture, .coordinates = {.repeat = {2, 1}, .offset = {0.5, 0}}};
  const std::vector<Slab> quads = slabs_of(textured, square), triangles = slabs_of(textured, shell->base);
  ASSERT_EQ(quads.size(), 1u);
  ASSERT_EQ(triangles.size(), 2u);
  for (std::size_t c = 0; c < 8; ++c) {
    EXPECT_LT((quads[0].corners[c] - unit_slab().corners[c]).norm(), 1e-12);
    const Vec3 place = unit_slab().places[c].cwiseProduct(Vec3(2, 1, 1)) + Vec3(0.5, 0, 0);
    EXPECT_LT((quads[0].places[c] - place).norm(), 1e-12);
  }
  // A bumpy top, seen through the quad and through its two triangles.
  const OpacityField bumps{
      [](const Vec3& place) { return 0.5 + 0.5 + 0.1 * std::sin(6 * place.x()) - place.z(); },
      [](const Vec3& place) { return Vec3(0.6 * std::cos(6 * place.x()), 0, -1); }};
  const SliceView view = slice_view(aslant(50));
  const SlicePicture one = draw_slices(quads, bumps, view), other = draw_slices(triangles, bumps, view);
  int count = 0;
  for (std::size_t p = 0; p < one.pixels.size(); ++p) {
    if (!one.pixels[p].is_hit || !other.pixels[p].is_hit || one.pixels[p].place.z() < 0.35) continue;
    EXPECT_NEAR(one.pixels[p].depth, other.pixels[p].depth, 0.01);  // walls between triangles are slices, too
    const Vec3 slope(-1.2 * std::cos(6 * other.pixels[p].place.x()), 0, 1);
    EXPECT_LT((other.pixels[p].normal - slope.normalized()).norm(), 1e-12);
    ++count;
  }
  EXPECT_GT(count, 300);
}

TEST(SliceRenderer, IsTheSameForAnyNumberOfThreadsAndRefusesWhatCannotBe) {
  std::mt19937 random(6);
  const std::vector<Slab> slabs = random_slabs(random);
  const SliceView view = slice_view(aslant(60));
  const SlicePicture picture = draw_slices(slabs, wavy_field(), view);
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const SlicePicture again = draw_slices(slabs, wavy_field(), view);
    EXPECT_EQ(again.fragments, picture.fragments);
    for (std::size_t p = 0; p < picture.pixels.size(); ++p) {
      EXPECT_EQ(again.pixels[p].depth, picture.pixels[p].depth);
      EXPECT_EQ(again.pixels[p].normal, picture.pixels[p].normal);
    }
  }
  EXPECT_THROW(draw_slices(slabs, wavy_field(), view, {.slices = 1}), OptionError);
  EXPECT_THROW(draw_slices(slabs, wavy_field(), view, {.depth_bits = 25}), OptionError);
  const SliceView within = slice_view({.position = Vec3::Constant(0.5), .target = Vec3::Zero()});
  EXPECT_THROW(draw_slices({unit_slab()}, wavy_field(), within), InputError);
}

}  // namespace
}  // namespace recede::bench
