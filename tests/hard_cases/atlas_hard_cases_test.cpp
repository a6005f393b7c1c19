// Charts and atlases of everything that breaks mesh code.
#include "chart_checks.h"
#include "hard_cases.h"
#include "input_errors.h"

namespace recede {
namespace {

class AtlasHardCases : public testing::TestWithParam<test::HardCase> {};

TEST_P(AtlasHardCases, GiveDisksWithoutFlipsOrAClearError) {
  const PolygonSoup& soup = GetParam().soup;
  if (!GetParam().refusal.empty()) {
    EXPECT_NE(test::error_text([&] { make_atlas(soup); }).find(GetParam().refusal), std::string::npos);
    return;
  }
  // As it comes, and with vertices merged.
  PolygonSoup merged = soup;
  merge_identical_vertices(merged);
  for (const PolygonSoup& input : {soup, merged}) {
    AtlasOptions options;
    options.packing = {.resolution = 256, .gutter = 2};
    const AtlasResult atlas = make_atlas(input, options);
    test::expect_sound(input, atlas, options);
    test::expect_gutter(atlas, 2);
  }
}

std::string case_name(const testing::TestParamInfo<test::HardCase>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(All, AtlasHardCases, testing::ValuesIn(test::hard_cases()), case_name);

}  // namespace
}  // namespace recede
