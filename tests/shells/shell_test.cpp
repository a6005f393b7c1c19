#include "uv_ball.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/shells/shell.h>

#include <gmock/gmock.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;

// A graph or any other sheet over n x n squares.
PolygonSoup sheet(int n, const std::function<Vec3(double, double)>& place) {
  PolygonSoup soup;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i)
      soup.positions.push_back(place(static_cast<double>(i) / n, static_cast<double>(j) / n));
  }
  const auto at = [&](int i, int j) { return static_cast<Index>(j * (n + 1) + i); };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      soup.add_face(std::array<Index, 3>{at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      soup.add_face(std::array<Index, 3>{at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return soup;
}

// The cube from -1 to 1 with 2 n^2 triangles a side.
PolygonSoup cube(int n) {
  PolygonSoup soup;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const PolygonSoup part = sheet(n, [&](double u, double v) {
        Vec3 at;
        at[axis] = side;
        at[(axis + 1) % 3] = side * (2 * u - 1);
        at[(axis + 2) % 3] = 2 * v - 1;
        return at;
      });
      const auto first = static_cast<Index>(soup.positions.size());
      soup.positions.insert(soup.positions.end(), part.positions.begin(), part.positions.end());
      for (std::size_t f = 0; f < part.n_faces(); ++f)
        soup.add_face(
            std::array<Index, 3>{first + part.face(f)[0], first + part.face(f)[1], first + part.face(f)[2]});
    }
  }
  merge_identical_vertices(soup);
  return soup;
}

// Around the z axis, closed both ways.
PolygonSoup torus(double large, double small, int n) {
  PolygonSoup soup = sheet(n, [&](double u, double v) {
    const double a = 2 * k_pi * std::fmod(u, 1.0), b = 2 * k_pi * std::fmod(v, 1.0);
    const double out = large + small * std::cos(b);
    return Vec3(out * std::cos(a), out * std::sin(a), small * std::sin(b));
  });
  merge_identical_vertices(soup);
  return soup;
}

// Two squares of side 2 that meet at the y axis and turn upwards by an angle.
PolygonSoup fold(double turning, int n) {
  return sheet(n, [&](double u, double v) {
    const double along = 2 * std::abs(2 * u - 1);
    const double side = u < 0.5 ? -1 : 1;
    return Vec3(side * along * std::cos(turning / 2), 4 * v - 2, along * std::sin(turning / 2));
  });
}

ShellOptions options_of(double thickness, ShellSide side = ShellSide::exterior,
                        DirectorMethod method = DirectorMethod::averaged_distance) {
  ShellOptions options;
  options.thickness = thickness;
  options.side = side;
  options.method = method;
  options.repair = false;
  return options;
}

const ShellLayer& only_layer(const Shell& shell) {
  return shell.exterior ? *shell.exterior : *shell.interior;
}

ShellThickness thickness_of(const Shell& shell) { return reached_thickness(shell, only_layer(shell)); }

std::size_t n_inverted(const PolygonSoup& surface, const ShellOptions& options) {
  return only_layer(build_shell(surface, options)).validity.inverted.size();
}

TEST(Shell, OverABallIsAsThickAsAskedFor) {
  const Shell shell = build_shell(uv_ball(36, 1), options_of(0.3));
  EXPECT_TRUE(shell.is_valid());
  // A ball of triangles is off a ball by some thousandths.
  EXPECT_NEAR(thickness_of(shell).least, 1, 0.005);
  EXPECT_NEAR(thickness_of(shell).most, 1, 0.005);
}

TEST(Shell, InsideABallIsCompressed) {
  // R (1 - exp(-h / R)) when all of the ball is seen: 0.8639 for h = 0.3; Euler's steps end a little farther.
  ShellOptions options = options_of(0.3, ShellSide::interior);
  options.step = 0.02;
  const Shell shell = build_shell(uv_ball(36, 1), options);
  EXPECT_TRUE(shell.is_valid());
  const double half = 0.5;  // the ball's radius
  const double exact = half * (1 - std::exp(-0.3 / half)) / 0.3;
  EXPECT_NEAR(thickness_of(shell).mean, exact, 0.02);
}

}  // namespace
}  // namespace recede
