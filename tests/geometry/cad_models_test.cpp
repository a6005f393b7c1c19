// Every CAD model of Debian's package occt-misc, against what OpenCASCADE itself makes of it.
#include "cad_bodies.h"
#include "cad_checks.h"
#include <recede/geometry/error.h>

#include <gmock/gmock.h>

namespace recede::test {
namespace {

namespace fs = std::filesystem;

const fs::path k_models = fs::path(RECEDE_DATA) / "cad";

std::vector<fs::path> models() {
  std::vector<fs::path> found;
  for (const char* folder : {"step", "iges", "occ"}) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(k_models / folder, ignored)) {
      if (is_cad_path(entry.path())) found.push_back(entry.path());
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

class CadModelFile : public testing::TestWithParam<fs::path> {};
INSTANTIATE_TEST_SUITE_P(OfThePackage, CadModelFile, testing::ValuesIn(models()), [](const auto& tested) {
  std::string name = tested.param.filename().string();
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
});
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(CadModelFile);

TEST_P(CadModelFile, BecomesPatchesWithEveryFaceThereOrNamed) {
  if (GetParam().stem() == "asahi" || GetParam().stem() == "edge") {
    EXPECT_THROW(read_cad(GetParam()), InputError) << "holds points or an edge alone";
    return;
  }
  const CadModel model = read_cad(GetParam());
  expect_well_formed(model);
  EXPECT_GT(count_patches(model), 0u);
  for (const CadPart& part : model.parts) {
    // Four tolerances; the widest of the files is 0.1 of a hammer of 40 000.
    EXPECT_LT(largest_gap(part), 1e-4 * std::max(1.0, std::abs(part.patches[0].surface.points[0].norm())));
  }
}

TEST_P(CadModelFile, HasThePointsOfItsFaces) {
  const std::vector<TopoDS_Shape> bodies = bodies_of(shape_of(GetParam()));
  if (bodies.empty()) return;
  const CadModel model = read_cad(GetParam());
  ASSERT_EQ(model.instances.size(), bodies.size());
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const std::vector<TopoDS_Face> faces = faces_of(bodies[b]);
    const CadPart& part = model.parts[model.instances[b].part];
    ASSERT_EQ(part.patches.size(), faces.size());
    const double size = size_of(bodies[b]);
    for (std::size_t i = 0; i < faces.size(); ++i) {
      const TopoDS_Face own = face_of_body(faces[i], bodies[b]);
      EXPECT_LT(distance_from_surface(part.patches[i], own), 1e-9 * size) << i + 1;
      // Twice where the file's tolerance is short; see k_tolerance_slack.
      EXPECT_LE(tolerances_from_edges(part.patches[i], own, 1e-9 * size), 2) << i + 1;
    }
  }
}

TEST(CadModels, AreClosedWhereTheFilesAre) {
  if (models().empty()) GTEST_SKIP() << "./dev data fetches the models";
  for (const char* name : {"step/linkrods.step", "step/screw.step", "occ/hammer.brep", "occ/Bottom.brep",
                           "occ/Top.brep", "occ/Motor-c.brep", "occ/bottle.brep"}) {
    for (const CadPart& part : read_cad(k_models / name).parts) EXPECT_TRUE(part.is_closed) << name;
  }
  EXPECT_EQ(read_cad(k_models / "occ/Motor-c.brep").parts.size(), 17u);
  EXPECT_EQ(count_patches(read_cad(k_models / "iges/bearing.iges")), 213u);
}

}  // namespace
}  // namespace recede::test
