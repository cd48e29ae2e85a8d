// Tests of the voxel size that the import chooses for meshes.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/import/import_scan.h"

namespace typodont::haptics::importing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kBand = 1e-3;  // m

struct Chosen {
  double voxel;  // m
  std::vector<std::string> notes;
};
Chosen chosen(const dvec3& extent, const std::optional<double>& asked = std::nullopt) {
  ImportOptions options;
  options.band = kBand;
  options.voxel = asked;
  Chosen result{};
  result.voxel = voxel_of_meshes({dvec3(1, 2, 3), dvec3(1, 2, 3) + extent}, options, result.notes);
  return result;
}

TEST(MeshVoxel, OfALargeBodyIsTheSmallestThatIsAllowedAndANoteStatesIt) {
  const dvec3 mouth = dvec3(78, 76, 108) * kMillimetre;
  const Chosen c = chosen(mouth);
  EXPECT_GT(c.voxel, 0.11e-3);
  EXPECT_THAT(c.notes, ElementsAre(HasSubstr(fmt::format("{:.2f} mm", c.voxel / kMillimetre))));
  EXPECT_DOUBLE_EQ(chosen(mouth, c.voxel).voxel, c.voxel);
  EXPECT_THROW(chosen(mouth, c.voxel - 0.01e-3), Error);
}

TEST(MeshVoxel, MeshesInDifferentFramesAreRefused) {
  EXPECT_THROW(chosen(dvec3(1.1, 0.1, 0.1)), Error);
  EXPECT_THROW(chosen(dvec3(1e300, 1, 1)), Error);
  EXPECT_THROW(chosen(dvec3(1, 1, 0.0 / 0.0)), Error);
}

}  // namespace
}  // namespace typodont::haptics::importing
