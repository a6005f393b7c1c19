// A build without OpenCASCADE says that it reads no CAD files.
#include "error_text.h"
#include <recede/geometry/cad_import.h>

#include <gmock/gmock.h>

namespace recede::test {
namespace {

TEST(CadImport, IsRefusedInOneLineWithoutOpenCascade) {
  EXPECT_FALSE(can_read_cad());
  EXPECT_TRUE(is_cad_path("part.STEP"));
  EXPECT_EQ(error_text([] { read_cad("part.step"); }),
            "part.step: this build reads no CAD files: it was made without OpenCASCADE");
}

}  // namespace
}  // namespace recede::test
