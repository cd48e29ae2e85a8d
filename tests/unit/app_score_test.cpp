// Tests the score of a finished session: it is the same with and without a recording.
#include <gtest/gtest.h>

#include <fstream>

#include "engine/app/task/task.h"
#include "engine/app/workbench.h"
#include "engine/session/session_file.h"
#include "tests/support/session_fixture.h"

namespace typodont {
namespace {

constexpr const char* kScene = R"({"name": "lesion", "tissue": {"voxel_mm": 0.2, "solids": [
  {"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 5]}}}]},
  "paint": [{"tissue": "caries", "solid": {"sphere": {"center_mm": [0, 0, 2.2], "radius_mm": 0.9}}}],
  "tools": ["round_016"], "spindle": "electric_1_5", "parts": ["haptics", "score"],
  "task": {"title": "Lesion", "goal": "Take it out.", "ideal": {"remove_tissue": ["caries"]}, "rules": [
    {"name": "over_cut_mm3", "target": 0, "tolerance": 4, "weight": 25, "source": "a test"}]}})";

// The hand moves into the lesion and out of it within a second. This is so fast that no score is computed between its
// last cut and the end.
constexpr const char* kHand =
    "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,4.5,1,0,0,0,1\n"
    "0.3,0,0,3.6,1,0,0,0,1\n0.9,0.2,0,1.8,1,0,0,0,1\n1.0,0,0,4.5,1,0,0,0,0\n";

TEST(FinalScore, IsTheSameWithAndWithoutARecordingAndIncludesTheLastCuts) {
  const session::test::TemporaryFolder folder;
  std::ofstream(folder / "scene.json") << kScene;
  std::ofstream(folder / "hand.csv") << kHand;
  const Scene scene = read_scene(folder / "scene.json");
  WorkbenchOptions options;
  options.hand = "script:" + (folder / "hand.csv").string();
  options.audio = "none:";
  options.operated = true;
  options.record = folder / "session.h5";
  Workbench bench(scene, options);
  bench.start();
  while (bench.step()) {
  }
  const WorkbenchSummary summary = bench.stop();
  ASSERT_GT(summary.cuts, 50u);
  const session::Score live = final_score(scene, bench.take_tissue(), bench.take_hand());
  const session::Score recorded = evaluate_session(session::SessionReader(options.record)).score;
  EXPECT_GT(live.completion, 0.02);
  EXPECT_GT(live.points, 0);
  EXPECT_EQ(live.completion, recorded.completion);
  EXPECT_EQ(live.full, recorded.full);
  ASSERT_EQ(live.items.size(), recorded.items.size());
  for (std::size_t i = 0; i < live.items.size(); ++i) {
    EXPECT_EQ(live.items[i].name, recorded.items[i].name);
    EXPECT_NEAR(live.items[i].value, recorded.items[i].value, 1e-9 * std::abs(recorded.items[i].value))
        << live.items[i].name;
    EXPECT_NEAR(live.items[i].points, recorded.items[i].points, 1e-9) << live.items[i].name;
  }
}

}  // namespace
}  // namespace typodont
