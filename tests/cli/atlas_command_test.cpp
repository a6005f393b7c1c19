// `recede atlas` from file to file.
#include "pictures.h"
#include "run_recede.h"
#include <recede/geometry/mesh_io.h>

namespace recede::test {
namespace {

using nlohmann::json;
using testing::AllOf;
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

TEST(AtlasCommand, CountsBordersApartFromEdgesOfThreeFaces) {
  const TempFolder folder;
  const std::string book =
      folder.write("book.obj", "v 0 0 0\nv 0 1 0\nv 1 0 0\nv -1 0 0\nv 0 0 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n");
  const json result = json_of(run_recede({"atlas", book, "-o", folder / "out.obj", "--json"}));
  EXPECT_EQ(result.at("border_edges"), 6);
  EXPECT_EQ(result.at("non_manifold_edges"), 1);
}

TEST(AtlasCommand, PrintsTheShareThatIsCoveredAndWhatIsLeftOut) {
  const TempFolder folder;
  folder.write("skin.png", encode_png(four_colors()));
  folder.write("skin.mtl", "newmtl skin\nmap_Kd skin.png\n");
  const std::string square =
      folder.write("square.obj",
                   "mtllib skin.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\n"
                   "vt 1 1\nvt 0 1\nusemtl skin\nf 1/1 2/2 3/3 4/4\n");
  const std::string out = folder / "out.stl";
  const CommandResult run = run_recede({"atlas", square, "-o", out});
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.remarks,
              AllOf(HasSubstr("square.obj: its textures don't fit the new coordinates and are left out"),
                    HasSubstr("out.stl: written without texture coordinates")));
  EXPECT_THAT(run.output, testing::ContainsRegex("texels       1024 a side, 9[0-9]\\.[0-9] % covered"));
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
