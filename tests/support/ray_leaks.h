// Whether rays get out of closed surfaces.
#pragma once

#include <recede/render/displaced_mesh.h>

#include <tbb/parallel_for.h>

#include <atomic>
#include <random>

namespace recede::test {

inline Vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vec3(normal(random), normal(random), normal(random)).normalized();
}

/// How often rays from the middle of a closed surface, and from up to `around` beside it, aimed at its small
/// triangles' corners and sides and at random, get out.
inline std::size_t leaks(const DisplacedMesh& mesh, const Vec3& center, int rays, double around = 0.3) {
  const PolygonSoup small = mesh.tessellate();
  std::atomic<std::size_t> escaped{0};
  tbb::parallel_for(0, 64, [&](int part) {
    std::mt19937 random(static_cast<unsigned>(part));
    std::uniform_real_distribution<double> share(0, 1);
    for (int k = 0; k < rays / 64; ++k) {
      const std::size_t face = random() % small.n_faces(), corner = random() % 3;
      const Vec3& a = small.positions[small.corner_vertices[3 * face + corner]];
      const Vec3& b = small.positions[small.corner_vertices[3 * face + (corner + 1) % 3]];
      const Vec3 from = k % 2 == 0 ? center : Vec3(center + around * random_direction(random));
      Vec3 to = center + random_direction(random);
      if (k % 4 == 1) to = a;
      if (k % 4 >= 2) to = a + share(random) * (b - a);
      if (!mesh.first_hit(from, to - from)) ++escaped;
    }
  });
  return escaped;
}

}  // namespace recede::test
