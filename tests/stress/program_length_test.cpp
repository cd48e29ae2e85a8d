// Sessions of any length: what is kept in memory does not grow with them. Nine minutes in every test run, eight hours and more in
// ./run stress 80.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <string>

#include "tests/support/campaign.h"
#include "tests/support/program.h"

namespace typodont::test {
namespace {

/// A hand that comes down every ten seconds, drills along a furrow and leaves again.
std::string hand_of(int minutes) {
  std::string hand = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";
  for (int i = 0; i < 6 * minutes; ++i) {
    hand += fmt::format("{0},-1,0,6,1,0,0,0,0\n{1},-1,0,4.4,1,0,0,0,1\n{2},1,0,4.3,1,0,0,0,1\n", 10 * i, 10 * i + 3, 10 * i + 6);
  }
  return hand + fmt::format("{},-1,0,6,1,0,0,0,0\n", 60 * minutes);
}

TEST(LongSession, TwiceAsLongTakesNoMoreMemoryWithEveryTickRecorded) {
  const ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write("scene.json", R"({"tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "dentin", "solid": {"sphere": {"radius_mm": 4}}}]},
    "tool": "round_012", "spindle_krpm": 300})");
  const auto peak_kib = [&](int minutes) {
    folder.write("hand.csv", hand_of(minutes));
    const pid_t child = folder.start(fmt::format("servo {} --hand {} --out {}", folder / "scene.json", folder / "hand.csv", folder / "out.h5"));
    int status = -1;
    rusage used{};
    EXPECT_EQ(::wait4(child, &status, 0, &used), child);
    EXPECT_EQ(status, 0) << folder.said();
    return static_cast<double>(used.ru_maxrss);
  };
  // In the first minutes HDF5's own caches fill up.
  const double once = peak_kib(campaign(3)), twice = peak_kib(campaign(6));
  EXPECT_LT(twice, 1.05 * once) << "KiB";
}

}  // namespace
}  // namespace typodont::test
