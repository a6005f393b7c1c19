// Options that the tests of their commands leave alone: each must change what comes out.
#include "control_meshes.h"
#include "run_recede.h"
#include "uv_sheet.h"
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/raster.h>
#include <recede/geometry/sample_models.h>

#include <cmath>
#include <map>

namespace recede::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Words = std::vector<std::string>;

/// A wavy sheet with seams of texture coordinates and of normals across it, colours, a scalar, and two
/// materials that don't follow the seams.
PolygonSoup make_sheet() {
  PolygonSoup sheet = uv_sheet(16);
  sheet.vertex_scalars.push_back({"heat", {}});
  for (Vec3& p : sheet.positions) {
    p.z() = 0.1 * std::sin(5 * p.x()) * std::cos(4 * p.y());
    sheet.vertex_colors.emplace_back(0.5 + 0.5 * std::sin(7 * p.y()), 0.5, 0.2, 1);
    sheet.vertex_scalars[0].values.push_back(std::cos(6 * p.x() + 2 * p.y()));
  }
  sheet.materials = {{"left", {1, 0, 0, 1}, ""}, {"right", {0, 0, 1, 1}, ""}};
  for (std::size_t f = 0; f < sheet.n_faces(); ++f) {
    const bool right = f % 16 >= 8, back = f / 16 >= 8;
    sheet.face_materials.push_back(f % 3 == 0 ? 1 : 0);
    for (Index c = sheet.face_offsets[f]; c < sheet.face_offsets[f + 1]; ++c) {
      sheet.corner_uvs[c] = 0.4 * sheet.corner_uvs[c] + Vec2(right ? 0.5 : 0, 0);
      const double lean = std::sin(3 * sheet.positions[sheet.corner_vertices[c]].x());
      sheet.corner_normals.push_back(Vec3(lean, back ? 0.4 : -0.4, 1).normalized());
    }
  }
  return sheet;
}

/// Two sheets, a large one and a small one, a little apart.
PolygonSoup make_parts() {
  PolygonSoup parts = uv_sheet(8), small = uv_sheet(4);
  parts.corner_uvs.clear();
  const auto first = static_cast<Index>(parts.positions.size());
  for (Vec3& p : parts.positions) p.z() = 0.2 * p.x() * p.x();
  for (const Vec3& p : small.positions) parts.positions.emplace_back(p.x() / 4 + 1.3, p.y() / 4, 0.2);
  for (std::size_t f = 0; f < small.n_faces(); ++f) {
    std::size_t k = 0;
    std::array<Index, 4> face{};
    for (const Index v : small.face(f)) face[k++] = first + v;
    parts.add_face(face);
  }
  return parts;
}

Raster make_waves() {
  Raster waves{.width = 32, .height = 32, .channels = 1, .bits = 8, .srgb = false, .samples = {}};
  for (int k = 0; k < 32 * 32; ++k)
    waves.samples.push_back(static_cast<std::uint16_t>(std::lround(127 + 120 * std::sin(k % 32 * 0.9))));
  return waves;
}

/// What to run before: the words of a command. In all words `IN/` is the folder of the inputs, `OUT/` that of
/// what comes out.
struct Acting {
  const char* name;
  std::vector<Words> before;
  Words command, option;
  friend std::ostream& operator<<(std::ostream& out, const Acting& acting) { return out << acting.name; }
};

void write_inputs(const TempFolder& folder) {
  write_sphere(folder, 600);
  write_soup(folder / "quads.ply", make_displaced_sphere(600, false));
  write_soup(folder / "sheet.ply", make_sheet());
  write_soup(folder / "sheet.glb", make_sheet());
  write_soup(folder / "parts.ply", make_parts());
  write_soup(folder / "cube.obj", charted_cube());
  write_soup(folder / "square.obj", uv_sheet(1));
  folder.write("waves.png", encode_png(make_waves()));
  Raster sky{.width = 4, .height = 2, .channels = 3, .bits = 8, .srgb = true, .samples = {}};
  for (int k = 0; k < 8 * 3; ++k) sky.samples.push_back(static_cast<std::uint16_t>(10 * k));
  folder.write("sky.png", encode_png(sky));
}

/// Without what differs from run to run.
json lasting(json value) {
  if (value.is_object()) {
    for (const char* time : {"seconds", "proof_seconds", "milliseconds", "median_milliseconds"})
      value.erase(time);
  }
  if (value.is_structured()) {
    for (json& item : value) item = lasting(item);
  }
  return value;
}

struct Outcome {
  json document;
  std::map<std::string, std::string> files;
  bool operator==(const Outcome&) const = default;
};

Outcome run_anew(const TempFolder& folder, Words words) {
  const fs::path out = folder / "out";
  fs::remove_all(out);
  fs::create_directory(out);
  words.emplace_back("--json");
  for (std::string& word : words) {
    if (word.starts_with("IN/")) word = (folder / word.substr(3)).string();
    if (word.starts_with("OUT/")) word = (out / word.substr(4)).string();
  }
  Outcome outcome{lasting(json_of(run_recede(words))), {}};
  for (const std::string& name : names_below(out)) {
    if (fs::is_regular_file(out / name)) outcome.files[name] = read_whole_file(out / name);
  }
  return outcome;
}

class ActingOption : public testing::TestWithParam<Acting> {};

TEST_P(ActingOption, ChangesWhatComesOut) {
  const TempFolder folder;
  write_inputs(folder);
  for (Words words : GetParam().before) {
    for (std::string& word : words) {
      if (word.starts_with("IN/")) word = (folder / word.substr(3)).string();
    }
    ASSERT_EQ(run_recede(words).code, 0);
  }
  const Outcome without = run_anew(folder, GetParam().command);
  EXPECT_TRUE(without == run_anew(folder, GetParam().command))
      << "what comes out is the same from run to run";
  Words words = GetParam().command;
  words.insert(words.end(), GetParam().option.begin(), GetParam().option.end());
  EXPECT_FALSE(without == run_anew(folder, words));
}

std::vector<Acting> with_all(const Words& command, const std::vector<std::pair<const char*, Words>>& options,
                             const std::vector<Words>& before = {}) {
  std::vector<Acting> all;
  for (const auto& [name, option] : options) all.push_back({name, before, command, option});
  return all;
}
const auto name_of = [](const auto& tested) { return std::string(tested.param.name); };

const Words k_simplify_sheet{"simplify", "IN/sheet.ply", "-o", "OUT/a.ply", "--ratio", "0.2", "--no-measure"};
const Words k_simplify_parts{"simplify", "IN/parts.ply", "-o", "OUT/a.ply", "--faces", "1", "--no-measure"};
const Words k_by_draws{"simplify", "IN/sphere.ply", "-o",     "OUT/a.ply",       "--ratio",
                       "0.2",      "--no-measure",  "--cost", "normal_deviation"};

INSTANTIATE_TEST_SUITE_P(Simplify, ActingOption,
                         testing::ValuesIn(with_all(k_simplify_sheet,
                                                    {{"Vertices", {"--vertices", "200"}},
                                                     {"Error", {"--error", "0.001"}},
                                                     {"FeatureAngle", {"--feature-angle", "10"}},
                                                     {"LockBorders", {"--lock-borders"}},
                                                     {"UvWeight", {"--uv-weight", "10"}},
                                                     {"NormalWeight", {"--normal-weight", "10"}},
                                                     {"ColorWeight", {"--color-weight", "10"}},
                                                     {"ScalarWeight", {"--scalar-weight", "heat", "10"}},
                                                     {"IgnoreUvSeams", {"--ignore-uv-seams"}},
                                                     {"IgnoreNormalSeams", {"--ignore-normal-seams"}},
                                                     {"IgnorePolygons", {"--ignore-polygons"}}})),
                         name_of);
INSTANTIATE_TEST_SUITE_P(SimplifyParts, ActingOption,
                         testing::ValuesIn(with_all(k_simplify_parts,
                                                    {{"JoinDistance", {"--join-distance", "0.2"}},
                                                     {"DropParts", {"--drop-parts"}}})),
                         name_of);
INSTANTIATE_TEST_SUITE_P(SimplifyByDraws, ActingOption,
                         testing::ValuesIn(with_all(k_by_draws,
                                                    {{"Seed", {"--seed", "7"}},
                                                     {"NormalThreshold", {"--normal-threshold", "0.5"}},
                                                     {"CandidateShare", {"--candidate-share", "0.5"}}})),
                         name_of);

INSTANTIATE_TEST_SUITE_P(Progressive, ActingOption,
                         testing::ValuesIn(with_all({"progressive", "IN/sheet.ply", "-o", "OUT/a.pmesh",
                                                     "--no-measure", "--bits", "10"},
                                                    {{"Vertices", {"--vertices", "100"}},
                                                     {"FeatureAngle", {"--feature-angle", "10"}},
                                                     {"KeepOrder", {"--keep-order"}},
                                                     {"UvBits", {"--uv-bits", "8"}},
                                                     {"NormalBits", {"--normal-bits", "6"}},
                                                     {"ColorBits", {"--color-bits", "4"}},
                                                     {"ScalarBits", {"--scalar-bits", "5"}}})),
                         name_of);

const std::vector<Words> k_pmesh{{"progressive", "IN/sphere.ply", "-o", "IN/a.pmesh", "--no-measure"}};
INSTANTIATE_TEST_SUITE_P(ExtractView, ActingOption,
                         testing::ValuesIn(with_all({"extract", "IN/a.pmesh", "-o", "OUT/a.ply", "--eye",
                                                     "0.2", "0.1", "1.9"},
                                                    {{"LookAt", {"--look-at", "0.9", "0.1", "0.2"}},
                                                     {"FieldOfView", {"--field-of-view", "20"}},
                                                     {"ImageWidth", {"--image-width", "100"}},
                                                     {"ImageHeight", {"--image-height", "50"}},
                                                     {"PixelError", {"--pixel-error", "40"}},
                                                     {"BackPixelError", {"--back-pixel-error", "50"}},
                                                     {"Faces", {"--faces", "60"}}},
                                                    k_pmesh)),
                         name_of);
INSTANTIATE_TEST_SUITE_P(
    ExtractDistantView, ActingOption,
    testing::ValuesIn(with_all({"extract", "IN/a.pmesh", "-o", "OUT/a.ply", "--eye", "0", "0", "9",
                                "--pixel-error", "20"},
                               {{"SilhouettePixelError", {"--silhouette-pixel-error", "1"}}}, k_pmesh)),
    name_of);
// A strip that is wide and low.
INSTANTIATE_TEST_SUITE_P(
    ExtractStrip, ActingOption,
    testing::ValuesIn(with_all({"extract", "IN/a.pmesh", "-o", "OUT/a.ply", "--eye", "0", "0", "2",
                                "--field-of-view", "5", "--image-width", "9000"},
                               {{"Up", {"--up", "x"}}, {"NoCull", {"--no-cull"}}}, k_pmesh)),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    Atlas, ActingOption,
    testing::ValuesIn(with_all({"atlas", "IN/sheet.glb", "-o", "OUT/a.obj", "--bend-limit", "0.02"},
                               {{"Compactness", {"--compactness", "0"}},
                                {"IgnoreMaterials", {"--ignore-materials"}},
                                {"KeepUvSeams", {"--keep-uv-seams", "--ignore-materials"}},
                                {"Gutter", {"--gutter", "20"}}})),
    name_of);
INSTANTIATE_TEST_SUITE_P(AtlasOfASphere, ActingOption,
                         testing::ValuesIn(with_all({"atlas", "IN/sphere.ply", "-o", "OUT/a.obj"},
                                                    {{"Charts", {"--charts", "30"}},
                                                     {"StretchLimit", {"--stretch-limit", "1.01"}},
                                                     {"ScaleByStretch", {"--scale-by-stretch"}},
                                                     {"NoStraighten", {"--no-straighten"}}})),
                         name_of);

INSTANTIATE_TEST_SUITE_P(Bake, ActingOption,
                         testing::ValuesIn(with_all({"bake", "IN/sheet.ply", "-o", "OUT/", "--ratios", "0.3",
                                                     "--no-report", "--maps", "normal,displacement",
                                                     "--map-size", "32"},
                                                    {{"MapNormalBits", {"--map-normal-bits", "16"}},
                                                     {"MapSeamWeight", {"--map-seam-weight", "1e4"}},
                                                     {"FeatureAngle", {"--feature-angle", "10"}},
                                                     {"LockBorders", {"--lock-borders"}}})),
                         name_of);

INSTANTIATE_TEST_SUITE_P(Billboards, ActingOption,
                         testing::ValuesIn(with_all({"billboards", "IN/sphere.ply", "--folder", "OUT/",
                                                     "--errors", "0.1"},
                                                    {{"Neighbours", {"--neighbours", "2"}},
                                                     {"Waste", {"--waste", "1.2"}},
                                                     {"TexelsPerError", {"--texels-per-error", "2"}},
                                                     {"Samples", {"--samples", "1"}},
                                                     {"Overlap", {"--overlap", "0"}},
                                                     {"Gutter", {"--gutter", "5"}},
                                                     {"FieldOfView", {"--field-of-view", "20"}},
                                                     {"ImageHeight", {"--image-height", "200"}}})),
                         name_of);

const Words k_render{"render", "IN/sphere.ply",  "-o", "OUT/a.png", "--image-width",
                     "24",     "--image-height", "24"};
Words rendered(const Words& more) {
  Words words = k_render;
  words.insert(words.end(), more.begin(), more.end());
  return words;
}
INSTANTIATE_TEST_SUITE_P(Render, ActingOption,
                         testing::ValuesIn(with_all(k_render, {{"Flat", {"--flat"}},
                                                               {"Samples", {"--samples", "9"}},
                                                               {"FieldOfView", {"--field-of-view", "30"}},
                                                               {"LookAt", {"--look-at", "0.5", "0", "0"}},
                                                               {"Up", {"--up", "x"}},
                                                               {"Ground", {"--ground"}}})),
                         name_of);
INSTANTIATE_TEST_SUITE_P(RenderInSunlight, ActingOption,
                         testing::ValuesIn(with_all(rendered({"--lighting", "direct", "--sun", "1", "1",
                                                              "1"}),
                                                    {{"SunColor", {"--sun-color", "3", "1", "1"}},
                                                     {"SunSize", {"--sun-size", "90"}},
                                                     {"Sky", {"--sky", "0.2", "0.3", "0.5"}},
                                                     {"Ambient", {"--ambient", "0.5"}},
                                                     {"GroundAlongZ", {"--ground", "--up", "z"}}})),
                         name_of);
INSTANTIATE_TEST_SUITE_P(
    RenderInASky, ActingOption,
    testing::ValuesIn(with_all(rendered({"--lighting", "path", "--environment", "IN/sky.png"}),
                               {{"EnvironmentRotation", {"--environment-rotation", "90"}},
                                {"LightSampling", {"--light-sampling", "surface"}}})),
    name_of);
INSTANTIATE_TEST_SUITE_P(RenderMaps, ActingOption,
                         testing::ValuesIn(with_all(
                             {"render", "IN/baked", "-o", "OUT/a.png", "--level", "1", "--image-width", "24",
                              "--image-height", "24", "--samples", "4"},
                             {{"NoMaps", {"--no-maps"}}, {"SubdivisionLevel", {"--subdivision-level", "1"}}},
                             {{"bake", "IN/sphere.ply", "-o", "IN/baked", "--ratios", "0.1", "--no-report",
                               "--maps", "normal,displacement", "--map-size", "32"}})),
                         name_of);
INSTANTIATE_TEST_SUITE_P(RenderAShell, ActingOption,
                         testing::ValuesIn(with_all(
                             {"render", "IN/a.shell", "-o", "OUT/a.png", "--image-width", "24",
                              "--image-height", "24", "--samples", "1"},
                             {{"MatterColor", {"--matter-color", "1", "0", "0"}}, {"NoMaps", {"--no-maps"}}},
                             {{"shell", "IN/sphere.ply", "-o", "IN/a.shell", "--thickness", "0.1",
                               "--texture", "chain-mail", "--texels", "8"}})),
                         name_of);

INSTANTIATE_TEST_SUITE_P(Dice, ActingOption,
                         testing::ValuesIn(with_all(
                             {"dice", "IN/square.obj", "-o", "OUT/a.ply", "--displacement-map",
                              "IN/waves.png", "--displacement-scale", "0.2", "--image-width", "40",
                              "--image-height", "40", "--eye", "0", "-1.2", "0.6", "--triangle-pixels", "3"},
                             {{"MapLevels", {"--map-levels", "least_volume"}},
                              {"Footprint", {"--footprint", "mean"}},
                              {"DepthRatio", {"--depth-ratio", "1.1"}},
                              {"Nearest", {"--nearest", "2"}},
                              {"Up", {"--up", "x"}}})),
                         name_of);

INSTANTIATE_TEST_SUITE_P(Subdivide, ActingOption,
                         testing::ValuesIn(with_all({"subdivide", "IN/sheet.ply", "-o", "OUT/a.ply",
                                                     "--subdivision-level", "1"},
                                                    {{"Border", {"--border", "edge-only"}},
                                                     {"UvInterpolation", {"--uv-interpolation", "smooth"}}})),
                         name_of);

INSTANTIATE_TEST_SUITE_P(Shell, ActingOption,
                         testing::ValuesIn(with_all({"shell", "IN/sheet.ply", "-o", "OUT/a.ply",
                                                     "--thickness", "0.1"},
                                                    {{"Directors", {"--directors", "exact"}},
                                                     {"Power", {"--power", "4"}},
                                                     {"Form", {"--form", "averaged"}},
                                                     {"Step", {"--step", "0.05"}},
                                                     {"BorderExtension", {"--border-extension", "0.5"}}})),
                         name_of);
Words textured(const char* texture) {
  return {"shell", "IN/square.obj", "-o",    "OUT/a.shell", "--thickness",
          "0.1",   "--texture",     texture, "--texels",    "8"};
}
INSTANTIATE_TEST_SUITE_P(ShellOfBubbles, ActingOption,
                         testing::ValuesIn(with_all(textured("bubbles"),
                                                    {{"TextureSeed", {"--texture-seed", "5"}},
                                                     {"TextureTime", {"--texture-time", "0.4"}},
                                                     {"Periods", {"--periods", "3"}}})),
                         name_of);
INSTANTIATE_TEST_SUITE_P(ShellOfBushes, ActingOption,
                         testing::ValuesIn(with_all(textured("bushes"),
                                                    {{"TextureGrowth", {"--texture-growth", "0.3"}}})),
                         name_of);

const std::vector<Words> k_solid{{"shell", "IN/square.obj", "-o", "IN/a.shell", "--thickness", "0.2",
                                  "--texture", "solid", "--texels", "64", "--layers", "4"}};
INSTANTIATE_TEST_SUITE_P(Carve, ActingOption,
                         testing::ValuesIn(with_all({"carve", "IN/a.shell", "-o", "OUT/a.shell", "--ball",
                                                     "0", "0", "0.1", "0.3"},
                                                    {{"Ramp", {"--ramp", "5"}},
                                                     {"Intersect", {"--operation", "intersect"}},
                                                     {"Cut", {"--operation", "cut"}},
                                                     {"Size", {"--size", "100", "100", "6"}}},
                                                    k_solid)),
                         name_of);

}  // namespace
}  // namespace recede::test
