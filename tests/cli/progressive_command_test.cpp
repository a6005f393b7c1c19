// `recede progressive` and `recede extract`, from a file through a .pmesh to files of levels.
#include "pictures.h"
#include "run_recede.h"
#include <recede/geometry/mesh_io.h>

#include <algorithm>

namespace recede::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr std::size_t k_faces = 3000;

json write_pmesh_of_sphere(const TempFolder& folder, const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{"progressive", write_sphere(folder, k_faces), "-o",
                                     folder / "sphere.pmesh", "--json"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return json_of(run_recede(arguments));
}

json extract(const TempFolder& folder, const std::vector<std::string>& level) {
  std::vector<std::string> arguments{"extract", folder / "sphere.pmesh", "-o", folder / "level.ply",
                                     "--json"};
  arguments.insert(arguments.end(), level.begin(), level.end());
  return json_of(run_recede(arguments));
}

/// Two-sided distance between the input and the level that was extracted last, as `recede compare` sees it.
double seen_error(const TempFolder& folder) {
  return json_of(run_recede({"compare", folder / "sphere.ply", folder / "level.ply", "--json"}))
      .at("error")
      .at("max");
}

TEST(ProgressiveCommand, GivesTheInputBackBitForBit) {
  const TempFolder folder;
  const json built = write_pmesh_of_sphere(folder, {"--keep-numbering"});
  EXPECT_EQ(built.at("bytes"), std::filesystem::file_size(folder / "sphere.pmesh"));
  const json full = extract(folder, {});
  EXPECT_EQ(full.at("splits"), built.at("splits"));
  EXPECT_EQ(full.at("level_error"), 0);
  const PolygonSoup input = read_soup(folder / "sphere.ply"), output = read_soup(folder / "level.ply");
  EXPECT_TRUE(input.positions == output.positions);
  EXPECT_EQ(input.face_offsets, output.face_offsets);
  EXPECT_EQ(input.corner_vertices, output.corner_vertices);
}

TEST(ProgressiveCommand, TheBaseHasTheFacesThatWereAskedFor) {
  const TempFolder folder;
  const json built = write_pmesh_of_sphere(folder, {"--faces", "100"});
  EXPECT_LE(built.at("base_faces"), 100);
  EXPECT_GE(built.at("base_faces"), 98) << "a collapse of a closed surface takes two triangles";
  EXPECT_EQ(extract(folder, {"--faces", "1"}).at("faces"), built.at("base_faces")) << "nothing is coarser";
}

TEST(ProgressiveCommand, ALevelByFacesIsTheFinestThatHasNoMore) {
  const TempFolder folder;
  const json built = write_pmesh_of_sphere(folder);
  for (const std::size_t faces : {200u, 1000u}) {
    const json level = extract(folder, {"--faces", std::to_string(faces)});
    EXPECT_LE(level.at("faces"), faces);
    EXPECT_GE(level.at("faces"), faces - 1) << "a split of a closed surface brings two triangles";
    EXPECT_EQ(read_soup(folder / "level.ply").n_faces(), level.at("faces"));
    EXPECT_TRUE(level.at("errors_are_proved").get<bool>());
    EXPECT_LE(seen_error(folder), level.at("level_error"));
    EXPECT_LE(level.at("level_error"), built.at("base_error"));
  }
  EXPECT_EQ(
      extract(folder, {"--ratio", "0.1"}).at("faces"),
      extract(folder, {"--faces", std::to_string(built.at("faces").get<std::size_t>() / 10)}).at("faces"));
}

TEST(ProgressiveCommand, ALevelByErrorIsTheCoarsestThatKeepsIt) {
  const TempFolder folder;
  const double base_error = write_pmesh_of_sphere(folder).at("base_error");
  const double limit = base_error / 4;
  const json level = extract(folder, {"--error", std::to_string(limit)});
  EXPECT_LE(level.at("level_error"), limit);
  EXPECT_LE(seen_error(folder), limit);
  const std::size_t faces = level.at("faces");
  const json coarser = extract(folder, {"--faces", std::to_string(faces - 1)});
  EXPECT_GT(coarser.at("level_error"), limit);
}

TEST(ProgressiveCommand, BitsMakeTheFileSmallerAndMoveVerticesByNoMoreThanItSays) {
  const TempFolder folder;
  const json lossless = write_pmesh_of_sphere(folder);
  const json quantised = write_pmesh_of_sphere(folder, {"--bits", "10"});
  EXPECT_EQ(lossless.at("largest_move"), 0);
  EXPECT_EQ(quantised.at("positions"), "quantised");
  EXPECT_LT(quantised.at("bytes"), lossless.at("bytes").get<double>() / 2);
  const double move = quantised.at("largest_move");
  EXPECT_GT(move, 0);
  const json full = extract(folder, {});
  EXPECT_EQ(full.at("faces"), lossless.at("faces"));
  EXPECT_LE(seen_error(folder), move);
  EXPECT_GE(full.at("level_error"), move) << "errors include what quantisation adds";
}

TEST(ProgressiveCommand, LevelsBringThePicturesOfTheInput) {
  const TempFolder folder;
  const std::string picture = encode_png(four_colors());
  folder.write("skin.png", picture);
  folder.write("skin.mtl", "newmtl skin\nmap_Kd skin.png\n");
  folder.write("square.obj",
               "mtllib skin.mtl\nusemtl skin\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n"
               "vt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n");
  std::filesystem::create_directory(folder / "levels");
  const std::string pmesh = folder / "levels/square.pmesh";
  EXPECT_EQ(run_recede({"progressive", folder / "square.obj", "-o", pmesh, "--json"}).remarks, "");
  EXPECT_EQ(read_whole_file(folder / "levels/skin.png"), picture);
  const std::vector<std::string> extract{"extract", pmesh, "-o", folder / "levels/level.glb", "--json"};
  EXPECT_EQ(run_recede(extract).remarks, "");
  EXPECT_EQ(*read_soup(folder / "levels/level.glb").materials.at(0).base_color_picture, picture);
  std::filesystem::remove(folder / "levels/skin.png");
  EXPECT_THAT(run_recede(extract).remarks, HasSubstr("no picture of texture skin.png"));
}

TEST(ProgressiveCommand, PartsOfTheFileMakeTheWhole) {
  const TempFolder folder;
  const json built = write_pmesh_of_sphere(folder, {"--keep-numbering"});
  std::size_t sum = 0;
  for (const char* part : {"connectivity", "position", "attribute", "error", "numbering", "base"})
    sum += built.at(std::string(part) + "_bytes").get<std::size_t>();
  EXPECT_LE(sum, built.at("bytes"));
  constexpr std::size_t k_most_of_headers = 200;
  EXPECT_GT(sum + k_most_of_headers, built.at("bytes").get<std::size_t>());
}

TEST(ProgressiveCommand, AGeomorphTurnsOneLevelIntoAnother) {
  const TempFolder folder;
  write_pmesh_of_sphere(folder);
  const json coarse = extract(folder, {"--faces", "200"});
  const std::size_t n_coarse = read_soup(folder / "level.ply").positions.size();
  const json fine = extract(folder, {"--faces", "1000"});
  const json morph = extract(folder, {"--faces", "1000", "--morph-faces", "200"});
  for (const char* field : {"faces", "vertices", "splits", "level_error"})
    EXPECT_EQ(morph.at(field), fine.at(field)) << field;
  EXPECT_EQ(morph.at("coarse_faces"), coarse.at("faces"));
  EXPECT_EQ(morph.at("coarse_splits"), coarse.at("splits"));
  EXPECT_EQ(morph.at("coarse_error"), coarse.at("level_error"));
  const PolygonSoup soup = read_soup(folder / "level.ply");
  double last_parent = 0;
  for (const VertexScalar& scalar : soup.vertex_scalars) {
    if (scalar.name == "parent") last_parent = *std::max_element(scalar.values.begin(), scalar.values.end());
  }
  EXPECT_EQ(last_parent, n_coarse - 1);
}

TEST(ProgressiveCommand, AViewGetsItsPixelErrorWithFewerFaces) {
  const TempFolder folder;
  const json built = write_pmesh_of_sphere(folder);
  const auto view = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"--eye", "0", "0", "40"});
    return extract(folder, more);
  };
  const json one = view({}), four = view({"--pixel-error", "4"});
  EXPECT_LT(one.at("faces"), built.at("faces"));
  EXPECT_LT(four.at("faces"), one.at("faces"));
  EXPECT_LE(one.at("pixel_error"), 1);
  EXPECT_GT(four.at("pixel_error"), 1);
  EXPECT_LE(four.at("pixel_error"), 4);
  EXPECT_EQ(view({"--look-at", "0", "0", "0"}).at("faces"), one.at("faces"))
      << "the middle of the box, nearly";
  EXPECT_LT(view({"--look-at", "0", "0", "80"}).at("faces"), four.at("faces")) << "behind the camera";
}

TEST(ProgressiveCommand, SaysInTextWhetherErrorsAreCertified) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 200), file = folder / "a.pmesh";
  EXPECT_THAT(run_recede({"progressive", sphere, "-o", file}).output, HasSubstr(" %), certified\n"));
  EXPECT_THAT(run_recede({"extract", file, "-o", folder / "a.ply"}).output,
              HasSubstr("error        0, certified\n"));
  EXPECT_THAT(run_recede({"progressive", sphere, "-o", file, "--no-measure"}).output,
              HasSubstr(" %), estimated\n"));
}

TEST(ProgressiveCommand, WithoutMeasuringErrorsAreEstimates) {
  const TempFolder folder;
  const json built = write_pmesh_of_sphere(folder, {"--no-measure"});
  EXPECT_FALSE(built.at("errors_are_proved").get<bool>());
  EXPECT_EQ(built.at("proof_seconds"), 0);
  EXPECT_FALSE(extract(folder, {"--ratio", "0.5"}).at("errors_are_proved").get<bool>());
}

TEST(ProgressiveCommand, NamesADamagedFileAndTheByte) {
  const TempFolder folder;
  write_pmesh_of_sphere(folder);
  std::string bytes = read_whole_file(folder / "sphere.pmesh");
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  const std::string damaged = folder.write("damaged.pmesh", bytes);
  const std::string complaint = complaint_of(run_recede({"extract", damaged, "-o", folder / "level.ply"}), 1);
  EXPECT_THAT(complaint, HasSubstr(damaged));
  EXPECT_THAT(complaint, HasSubstr("byte"));
  EXPECT_FALSE(std::filesystem::exists(folder / "level.ply"));
}

}  // namespace
}  // namespace recede::test
