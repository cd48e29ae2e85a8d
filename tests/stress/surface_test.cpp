#include <gtest/gtest.h>

#include "tests/support/surface_block.h"

namespace typodont::surface {
namespace {

TEST(Incremental, TheMeshAfterTenThousandRandomCutsEqualsAFullRemesh) {
  EXPECT_EQ(test::cut_and_compare(10000), "");
}

}  // namespace
}  // namespace typodont::surface
