// Views of what OpenCASCADE makes, and of CAD files of Debian's package occt-misc.
#include "cad_shapes.h"
#include "sanitized.h"
#include "seam_views.h"
#include "temp_folder.h"
#include <recede/geometry/cad_import.h>
#include <recede/lod/seam_viewer.h>

#include <gtest/gtest.h>

#include <functional>

namespace recede {
namespace {

namespace fs = std::filesystem;

struct Shape {
  std::string name;
  std::function<TopoDS_Shape()> make;
  int n_views = 200;
};

TEST(SeamViewerOfShapes, IsClosedAndWithinHalfAPixelForTwoHundredViews) {
  const std::vector<Shape> shapes{{"rounded box", [] { return test::cad_rounded_box(); }},
                                  {"bored sphere", test::cad_bored_sphere},
                                  {"torus", [] { return test::cad_torus(); }},
                                  {"cone", [] { return test::cad_cone(); }},
                                  {"wavy block", test::cad_wavy_block, 40},
                                  {"plate", [] { return test::cad_plate(3); }},
                                  {"screw", test::cad_screw}};
  for (const Shape& shape : shapes) {
    const test::TempFolder folder;
    test::write_brep(folder / "shape.brep", shape.make());
    const CadModel cad = read_cad(folder / "shape.brep");
    ASSERT_EQ(cad.parts.size(), 1u);
    ASSERT_TRUE(cad.parts[0].is_closed) << shape.name;
    SeamModelOptions options;
    options.seams.tolerance = 0.1;  // of some 30: coarse, so that near views take no time
    const SeamModel model = build_seam_model(cad.parts[0], options);
    test::expect_sound_views(shape.name, cad.parts[0].patches, model, test::k_sanitized ? 5 : shape.n_views);
  }
}

TEST(SeamViewerOfFiles, IsClosedAndWithinHalfAPixelForTwoHundredViews) {
  if (!fs::exists(RECEDE_DATA "/cad")) GTEST_SKIP() << "no models; ./dev data fetches them";
  if (test::k_sanitized) GTEST_SKIP() << "slow under sanitizers";
  for (const char* name : {"occ/bottle.brep", "step/screw.step"}) {
    const CadModel cad = read_cad(fs::path(RECEDE_DATA) / "cad" / name);
    for (const CadPart& part : cad.parts) {
      ASSERT_TRUE(part.is_closed) << name;
      test::expect_sound_views(name, part.patches, build_seam_model(part), 200);
    }
  }
}

}  // namespace
}  // namespace recede
