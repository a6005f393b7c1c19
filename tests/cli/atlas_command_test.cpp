// `recede atlas` from file to file.
#include "run_recede.h"
#include <recede/geometry/mesh_io.h>

namespace recede::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

TEST(AtlasCommand, GivesOneToOneTextureCoordinates) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 1000), out = folder / "atlas.obj";
  const json result = json_of(run_recede({"atlas", sphere, "-o", out, "--map-size", "512", "--json"}));
  EXPECT_EQ(result.at("flipped"), 0);
  EXPECT_EQ(result.at("map_size"), 512);
  EXPECT_GT(result.at("cut_length"), 0) << "a closed surface has to be cut";
  EXPECT_GE(result.at("stretch").at("l2"), 1);
  const json& charts = result.at("charts");
  EXPECT_GE(charts.size(), 2u);
  const PolygonSoup before = read_soup(sphere), soup = read_soup(out);
  std::size_t faces = 0;
  for (const json& chart : charts) faces += chart.at("faces").get<std::size_t>();
  EXPECT_EQ(faces, before.n_faces());
  EXPECT_EQ(soup.n_faces(), before.n_faces());
  ASSERT_EQ(soup.corner_uvs.size(), soup.n_corners());
  double area = 0;  // of the unit square
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    const Index c = soup.face_offsets[f];
    for (Index i = c + 1; i + 1 < soup.face_offsets[f + 1]; ++i) {
      const Vec2 a = soup.corner_uvs[i] - soup.corner_uvs[c], b = soup.corner_uvs[i + 1] - soup.corner_uvs[c];
      area += (a.x() * b.y() - a.y() * b.x()) / 2;
    }
  }
  EXPECT_GT(area, 0.2);
  EXPECT_LT(area, 1);
  const json fewer = json_of(run_recede({"atlas", sphere, "-o", out, "--bend-limit", "0.02", "--json"}));
  EXPECT_GT(fewer.at("charts").size(), charts.size());
}

TEST(AtlasCommand, RefusesWhatItCannotDo) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 100);
  EXPECT_THAT(complaint_of(run_recede({"atlas", sphere, "-o", folder / "a.xyz"}), 1),
              HasSubstr("unknown kind"));
  EXPECT_THAT(complaint_of(run_recede({"atlas", sphere, "-o", folder / "a.obj", "--map-size", "0"}), 2),
              HasSubstr("--map-size"));
  EXPECT_THAT(complaint_of(run_recede({"atlas", sphere, "-o", folder / "a.obj", "--bend-limit", "2"}), 2),
              HasSubstr("--bend-limit"));
}

}  // namespace
}  // namespace recede::test
