// The same result, to the last byte, from one thread and from two: ten models of different kinds.
#include "different_models.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

namespace recede {
namespace {

using test::DifferentModel;

class SameBytes : public testing::TestWithParam<DifferentModel> {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(RECEDE_DATA "/meshes")) GTEST_SKIP() << "no models; ./dev data fetches them";
    soup_ = GetParam().load(RECEDE_DATA);
  }

  std::string simplified(std::size_t threads, CostPolicy cost) const {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    SimplifyOptions options;
    options.target.ratio = 0.1;
    options.cost = cost;
    return test::bytes_of(simplify(soup_, options));
  }

  // Not by EXPECT_EQ, which would print the bytes.
  void expect_same_bytes(CostPolicy cost) const { EXPECT_TRUE(simplified(1, cost) == simplified(2, cost)); }

 private:
  PolygonSoup soup_;
};

TEST_P(SameBytes, FromOneAndFromTwoThreads) {
  expect_same_bytes(CostPolicy::volume);
  if (GetParam().small) expect_same_bytes(CostPolicy::normal_deviation);
}

std::string model_name(const testing::TestParamInfo<DifferentModel>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(TenModels, SameBytes, testing::ValuesIn(test::different_models()), model_name);

}  // namespace
}  // namespace recede
