// Tests the expert's hand in a live session. Servo, carver and recorder are those of the program, called in turn on a
// simulated clock. The carver is late, so that snapshots and copies arrive at the same times as in a session with a
// picture.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>

#include "engine/app/hands/expert_hand.h"
#include "engine/app/hands/live_expert.h"
#include "engine/app/live/session.h"
#include "engine/app/recording.h"
#include "engine/app/recording/replay.h"
#include "engine/app/recording/resume.h"
#include "engine/app/stepped.h"
#include "engine/app/task/task.h"
#include "engine/session/score.h"
#include "engine/session/session_file.h"
#include "engine/session/task.h"
#include "haptics/device_safety.h"
#include "tests/support/session_fixture.h"

namespace typodont {
namespace {

using session::test::TemporaryFolder;

constexpr const char* kScene = R"({"name": "block", "tissue": {"voxel_mm": 0.2, "solids": [
  {"tissue": "dentin", "solid": {"box": {"size_mm": [5, 5, 3]}}},
  {"tissue": "enamel", "solid": {"box": {"center_mm": [0, 0, 1.2], "size_mm": [5, 5, 0.6]}}}]},
  "tools": ["cylinder_010", "round_012"], "spindle": "air_turbine", "parts": ["haptics"],
  "task": {"goal": "cut", "ideal": {"remove": [{"box": {"center_mm": [0, 0, 1.4], "size_mm": [2.4, 1.4, 1.6]}}]},
    "rules": [{"name": "over_cut_mm3", "target": 0.2, "tolerance": 1.5, "weight": 50},
              {"name": "under_cut_mm3", "target": 0.2, "tolerance": 1.5, "weight": 50}]}})";

// Two pockets of 3 and 5 mm in a block, beside a wall on which the hand leans.
constexpr const char* kPockets = R"({"name": "pockets", "tissue": {"voxel_mm": 0.1, "solids": [
  {"tissue": "dentin", "solid": {"difference": [{"box": {"size_mm": [8, 5, 12]}},
    {"cylinder": {"center_mm": [2, 0, 6], "axis": [0, 0, 1], "radius_mm": 0.4, "height_mm": 6}},
    {"cylinder": {"center_mm": [-2, 0, 6], "axis": [0, 0, 1], "radius_mm": 0.4, "height_mm": 10}}]}},
    {"tissue": "dentin", "solid": {"box": {"center_mm": [0, 0, 7.5], "size_mm": [3.2, 5, 3]}}}]},
  "tool": "probe_who_621", "parts": ["haptics"],
  "task": {"goal": "probe", "axis": [0, 0, 1], "explore": {"sites": [
    {"name": "shallow", "margin_mm": [2, 0, 6], "floor_mm": [2, 0, 3]},
    {"name": "deep", "margin_mm": [-2, 0, 6], "floor_mm": [-2, 0, 1]}]}}})";

Nanos g_clock = 1'000'000'000;  // ns, simulated
Nanos simulated() noexcept {
  return g_clock += 100'000;  // so that the end of a session, which waits for the clock, is reached
}

/// Points out of 100.
double points(const Scene& scene, const haptics::TissueVolume& start, const haptics::TissueVolume& after,
              const session::HandMeter& meter) {
  session::ScoreInput input;
  input.before = start.volumes();
  input.after = after.volumes();
  input.hand = meter.result();
  TaskEvaluator(scene, start).judge(after, input);
  const session::Score score = session::score(input, session::rules_of_scene(Json::parse(scene.text, "scene"), input));
  return 100 * score.points / score.full;
}

double points_in_lock_step(const Scene& scene, const haptics::TissueVolume& start) {
  SteppedSession session(scene, load_tissue(scene), 1000);
  PlanningExpert hand(scene, session.carver(), 1000);
  session::HandMeter meter(1000);
  while (session.advance(hand)) meter.add({&session.last(), 1});
  return points(scene, start, session.carver().volume(), meter);
}

class LiveExpert : public testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(folder / "scene.json") << kScene;
    scene.emplace(read_scene(folder / "scene.json"));
    start.emplace(load_tissue(*scene));
  }

  /// Runs the hand in a live session that is recorded to `file`. The carver has a turn every `late` ticks. From tick
  /// `hold_from` to `hold_to` the session is paused.
  double points_live(int late, std::uint64_t hold_from = 0, std::uint64_t hold_to = 0) {
    session::HandMeter meter(1000);
    const haptics::TissueVolume after = run_live(
        late,
        [&](const ServoTick& tick) {
          meter.add({&tick, 1});
        },
        hold_from, hold_to);
    return points(*scene, *start, after, meter);
  }
  /// Returns the tissue at the end.
  haptics::TissueVolume run_live(int late, const std::function<void(const ServoTick&)>& visit,
                                 std::uint64_t hold_from = 0, std::uint64_t hold_to = 0) {
    LiveSession s(*scene, load_tissue(*scene));
    const auto hand = make_live_expert(*scene, s.carver.volume(), s.wiring, 1000, /*paced=*/false);
    s.record = true;
    s.serve(hand->info());
    SessionRecorder recorder(file(), *scene, session_header(*scene, {}, hand->info(), s.carver.volume(), 1000),
                             s.wiring.event_logs);
    s.wiring.patch.offer(s.carver, dvec3(0, 0, 3e-3));
    {
      ServoTurns servo(s, *hand, simulated);
      CarverTurns carver(s);
      for (std::uint64_t tick = 0; servo.turn(); ++tick) {
        g_clock += 1'000'000;
        haptics::set_emergency_stop(tick >= hold_from && tick < hold_to);
        visit(s.last);
        if (tick % static_cast<std::uint64_t>(late) == 0) carver.turn(), recorder.turn();
      }
      servo.end();
      carver.finish();
    }
    recorder.finish(s.carver.volume());
    return s.carver.volume().clone();
  }
  std::filesystem::path file() const { return folder / "session.h5"; }

  TemporaryFolder folder;
  std::optional<Scene> scene;
  std::optional<haptics::TissueVolume> start;
};

TEST_F(LiveExpert, ScoresWithinOnePointOfTheLockStepScoreForAnyCarverDelay) {
  const double alone = points_in_lock_step(*scene, *start);
  EXPECT_GT(alone, 80);
  for (const int late : {3, 20}) EXPECT_NEAR(points_live(late), alone, 1) << "a turn of the carver in " << late;
}

TEST_F(LiveExpert, ContinuesAfterAPauseAndIsReplayedBitForBit) {
  const double alone = points_in_lock_step(*scene, *start);
  EXPECT_NEAR(points_live(5, 4000, 9000), alone, 1);
  const ReplayResult replayed = replay_session(session::SessionReader(file()));
  EXPECT_TRUE(replayed.identical) << replayed.what_differs;
}

TEST_F(LiveExpert, ReadsTheDepthOfEachPocketAlsoAfterAPause) {
  std::ofstream(folder / "scene.json") << kPockets;
  scene.emplace(read_scene(folder / "scene.json"));
  session::ExploreMeter meter = *TaskEvaluator(*scene, load_tissue(*scene)).explore_meter();
  (void)run_live(
      3,
      [&](const ServoTick& tick) {
        meter.add({&tick, 1});
      },
      1500, 2500);
  const session::ExploreMeasures read = meter.result();
  ASSERT_EQ(read.sites.size(), 2u);
  for (const session::SiteReading& site : read.sites) EXPECT_NEAR(site.reading, site.depth, 0.2e-3);
}

TEST_F(LiveExpert, CanBeCancelledWhileItPlans) {
  LiveSession s(*scene, load_tissue(*scene));
  auto hand = make_live_expert(*scene, s.carver.volume(), s.wiring, 1000, /*paced=*/false);
  s.serve(hand->info());
  s.wiring.patch.offer(s.carver, dvec3(0, 0, 3e-3));
  ServoTurns servo(s, *hand, simulated);
  CarverTurns carver(s);
  while (servo.turn() && !s.wiring.expert_wants_copy) {
    if (s.last.pedal > 0) carver.turn();  // while the pedal is up, no turn of the carver makes the requested copy
  }
  EXPECT_TRUE(s.wiring.expert_wants_copy);
  hand.reset();
}

}  // namespace
}  // namespace typodont
