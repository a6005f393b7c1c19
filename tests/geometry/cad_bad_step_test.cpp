// STEP files of which something is missing or makes no sense: it is named, and the rest is there.
#include "cad_checks.h"
#include "error_text.h"
#include <recede/geometry/detail/step_references.h>
#include <recede/geometry/error.h>

#include <gmock/gmock.h>

namespace recede::test {
namespace {

using detail::find_step_references;
using testing::HasSubstr;

TEST(StepReferences, NameWhatIsMissingAndWhoNeedsIt) {
  const detail::StepReferences found = find_step_references(
      "DATA;\n#1 = A('text with #77; and '' quotes',#2,(#3, #40));\n#2=B(#3);#3=C($,.T.,3.5);\n"
      "/* #5=D(#78); */ #4=(E(#40)F(#41));\nENDSEC;\n");
  ASSERT_EQ(found.missing.size(), 2u);
  EXPECT_EQ(found.missing[0].number, 40u);
  EXPECT_EQ(found.missing[0].user, 1u);
  EXPECT_EQ(found.missing[1].number, 41u);
  EXPECT_EQ(found.missing[1].user, 4u);
  EXPECT_FALSE(found.has_cycle);
}

TEST(StepReferences, SeeEntitiesThatNeedThemselves) {
  EXPECT_TRUE(find_step_references("#1=A(#1);").has_cycle);
  EXPECT_TRUE(find_step_references("#1=A(#2);#2=B(#3);#3=C(#1);#4=D();").has_cycle);
  EXPECT_FALSE(find_step_references("#1=A(#2,#2);#2=B(#3);#4=D(#3,#1);#3=C();").has_cycle);
  EXPECT_FALSE(find_step_references("").has_cycle);
  EXPECT_TRUE(find_step_references("#1=A('never closed #2);").missing.empty());
}

/// The STEP file of a plate with a hole, 7 faces, and where its entities are.
class BadStep : public testing::Test {
 protected:
  void SetUp() override {
    write_step(folder_ / "whole.step", cad_plate(1));
    text_ = read_whole_file(folder_ / "whole.step");
  }

  /// Begin and end of the statement of the entity of a kind, the first one.
  std::pair<std::size_t, std::size_t> statement(const std::string& kind) const {
    const std::size_t at = text_.find("= " + kind + "(");
    EXPECT_NE(at, text_.npos) << kind;
    const std::size_t begin = text_.rfind('#', at);
    return {begin, text_.find(';', at) + 1};
  }
  std::string number(const std::string& kind) const {
    const std::size_t begin = statement(kind).first;
    return text_.substr(begin, text_.find(' ', begin) - begin);
  }
  std::string without(const std::string& kind) const {
    const auto [begin, end] = statement(kind);
    return text_.substr(0, begin) + text_.substr(end);
  }

  CadModel read(const std::string& text) const { return read_cad(folder_.write("bad.step", text)); }

  TempFolder folder_;
  std::string text_;
};

TEST_F(BadStep, WholeItHasSevenFacesAndNothingLeftOut) {
  const CadModel model = read(text_);
  EXPECT_EQ(count_patches(model), 7u);
  EXPECT_TRUE(model.left_out.empty()) << list(model);
}

TEST_F(BadStep, WithoutAnEntityNamesItAndTheFaceThatIsMissing) {
  for (const char* kind : {"PLANE", "CYLINDRICAL_SURFACE"}) {
    const CadModel model = read(without(kind));
    expect_well_formed(model);
    EXPECT_EQ(count_patches(model), 6u) << kind;
    EXPECT_FALSE(model.parts[0].is_closed) << kind;
    ASSERT_EQ(model.left_out.size(), 2u) << kind;
    EXPECT_EQ(model.left_out[0].entity, number(kind));
    EXPECT_THAT(model.left_out[0].reason, HasSubstr("isn't in the file, though #"));
    EXPECT_THAT(model.left_out[1].entity, HasSubstr("face #"));
  }
  const CadModel model = read(without("ADVANCED_FACE"));
  EXPECT_EQ(count_patches(model), 6u);
  ASSERT_EQ(model.left_out.size(), 1u);
  EXPECT_EQ(model.left_out[0].entity, number("ADVANCED_FACE"));
}

TEST_F(BadStep, WithASurfaceOfAnUnknownKindNamesTheFace) {
  std::string text = text_;
  text.replace(text.find("= PLANE("), 8, "= WOBBLE(");
  const CadModel model = read(text);
  expect_well_formed(model);
  EXPECT_EQ(count_patches(model), 6u);
  ASSERT_EQ(model.left_out.size(), 1u);
  EXPECT_THAT(model.left_out[0].entity, HasSubstr("face #"));
  EXPECT_THAT(model.left_out[0].reason, HasSubstr("can't make a face"));
}

/// OpenCASCADE ended the process for some of them.
TEST_F(BadStep, WithoutAnyOneEntityIsReadOrRefusedByName) {
  for (const char* kind :
       {"EDGE_LOOP", "EDGE_CURVE", "VERTEX_POINT", "FACE_BOUND", "LINE", "CIRCLE", "CARTESIAN_POINT",
        "DIRECTION", "VECTOR", "CLOSED_SHELL", "MANIFOLD_SOLID_BREP", "ORIENTED_EDGE",
        "ADVANCED_BREP_SHAPE_REPRESENTATION", "PRODUCT_DEFINITION", "SHAPE_DEFINITION_REPRESENTATION"}) {
    try {
      const CadModel model = read(without(kind));
      expect_well_formed(model);
      ASSERT_FALSE(model.left_out.empty()) << kind;
      EXPECT_EQ(model.left_out[0].entity, number(kind));
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("bad.step: ")) << kind;
    }
  }
}

TEST_F(BadStep, WithEntitiesThatNeedThemselvesEnds) {
  for (const char* kind : {"EDGE_LOOP", "FACE_BOUND", "CLOSED_SHELL"}) {
    const auto [begin, end] = statement(kind);
    const std::string self = number(kind);
    std::string statement = text_.substr(begin, end - begin);
    const std::size_t first = statement.find('#', 1);
    statement.replace(first, statement.find_first_of(",)", first) - first, self);
    try {
      expect_well_formed(read(text_.substr(0, begin) + statement + text_.substr(end)));
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("bad.step: ")) << kind;
    }
  }
}

TEST_F(BadStep, WithAPointThatIsInfiniteNamesTheFaceOrTheFile) {
  std::string text = text_;
  const auto [begin, end] = statement("CARTESIAN_POINT");
  text.replace(begin, end - begin, number("CARTESIAN_POINT") + " = CARTESIAN_POINT('',(1.E400,0.,0.));");
  try {
    const CadModel model = read(text);
    expect_well_formed(model);
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("bad.step: "));
  }
}

TEST(CadImport, AnEmptyAssemblyIsRefusedByItsNameAndAnEmptyPartOfOneIsNoLoss) {
  const TempFolder folder;
  write_step_assembly(folder / "empty.step", {});
  EXPECT_THAT(error_text([&] { read_cad(folder / "empty.step"); }), HasSubstr("empty.step: holds no"));
  write_step_assembly(folder / "half.step", {{cad_compound({}), "nothing"}, {cad_box(), "box", {1, 2, 3}}});
  const CadModel model = read_cad(folder / "half.step");
  ASSERT_EQ(model.parts.size(), 1u);
  ASSERT_EQ(model.instances.size(), 1u);
  EXPECT_EQ(model.instances[0].placement.translation(), Vec3(1, 2, 3));
  EXPECT_TRUE(model.parts[0].is_closed);
}

}  // namespace
}  // namespace recede::test
