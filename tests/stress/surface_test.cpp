#include <gtest/gtest.h>

#include "tests/support/campaign.h"
#include "tests/support/surface_block.h"

namespace typodont::surface {
namespace {

TEST(Incremental, TheMeshAfterThousandsOfRandomCutsEqualsAFullRemesh) {
  EXPECT_EQ(test::cut_and_compare(test::campaign(2000)), "");
}

}  // namespace
}  // namespace typodont::surface
