// Tests a live session with strokes that are undone: its replay is exact, its tissue can be saved, and another session
// can continue from it.
#include <gtest/gtest.h>

#include <chrono>

#include "engine/app/recording.h"
#include "engine/app/recording/recorded_tissue.h"
#include "engine/app/recording/replay.h"
#include "engine/app/recording/resume.h"
#include "engine/app/review/player.h"
#include "engine/app/workbench.h"
#include "engine/session/film.h"
#include "engine/session/session_file.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using namespace std::chrono_literals;
using test::ProgramFolder;

constexpr std::string_view kScene = R"({
  "tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "dentin", "solid": {"box": {"center_mm": [0, 0, 0], "size_mm": [10, 10, 4]}}}]},
  "tool": {"shape": "sphere", "diameter_mm": 1.6}, "spindle_krpm": 300, "parts": ["haptics"]})";

/// Returns a hand that makes three strokes through the block's top, with the pedal up between them, and then rests.
std::string hand(double y_mm = 0) {
  std::string csv = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";
  double t = 0;
  const auto row = [&](double x, double z, double pedal, double wait) {
    csv += fmt::format("{:.3f},{},{},{},1,0,0,0,{}\n", t, x, y_mm, z, pedal);
    t += wait;
  };
  for (int stroke = 0; stroke < 3; ++stroke) {
    const double x = -3 + 2.0 * stroke;
    row(x, 4, 0, 0.25), row(x, 3, 1, 0.2), row(x, 2.2, 1, 0.3), row(x + 1, 2.2, 1, 0.2), row(x + 1, 4, 0, 0.35);
  }
  row(2, 4, 0, 0.6), row(2, 4, 0, 0);
  return csv;
}

class UndoSession : public testing::Test {
 protected:
  UndoSession() {
    folder.write("scene.json", std::string(kScene));
    folder.write("hand.csv", hand());
    scene = read_scene(folder.path() / "scene.json");
  }
  /// Runs the script to its end. `asks`: times (s), and the command that is given at each time.
  WorkbenchSummary run(const Scene& of, const std::string& record, std::vector<std::pair<double, TissueCommand>> asks,
                       const std::string& save = "") {
    WorkbenchOptions options;
    options.hand = "script:" + (folder.path() / "hand.csv").string();
    options.audio = "none:";
    options.record = folder.path() / record;
    if (!save.empty()) options.save = folder.path() / save;
    Workbench bench(of, options);
    bench.start();
    const Nanos began = now();
    while (bench.step()) {
      while (!asks.empty() && to_seconds(now() - began) >= asks.front().first) {
        bench.ask(asks.front().second);
        asks.erase(asks.begin());
      }
    }
    strokes = bench.strokes();
    return bench.stop();
  }
  static double volume(const haptics::TissueVolume& tissue) {
    return tissue.volumes()[static_cast<std::size_t>(Tissue::kDentin)];
  }
  static int edits(const std::filesystem::path& file) {
    int count = 0;
    const session::SessionReader session(file);
    for (const session::SessionEvent& event : session.events()) count += edit_of(event).has_value();
    return count;
  }

  ProgramFolder folder{TYPODONT_PROGRAM};
  Scene scene;
  haptics::TissueVolume::Strokes strokes;
};

TEST_F(UndoSession, UndoDuringDrillingIsReplayedBitForBitPlayedBackwardsAndDoesNotCountAsRemovedVolume) {
  // Undoes while the first stroke cuts, in a pause, and after the end. One stroke is redone.
  run(scene, "session.h5",
      {{0.6, TissueCommand::kUndo},
       {1.25, TissueCommand::kUndo},
       {1.3, TissueCommand::kRedo},
       {4.1, TissueCommand::kUndo}});
  EXPECT_GE(edits(folder.path() / "session.h5"), 3);
  const ReplayResult replay = replay_session(session::SessionReader(folder.path() / "session.h5"));
  EXPECT_TRUE(replay.identical) << replay.what_differs;
  EXPECT_GT(replay.ticks, 1000u);
  // The tissue at the end that is computed from cuts and events alone is the same.
  const session::SessionReader session(folder.path() / "session.h5");
  EXPECT_EQ(tissue_at_end(session, scene_of(session), load_tissue(scene)).hash(), session.result()->field_hash);
  // Undone strokes do not count as removed volume.
  const auto dentin = static_cast<std::size_t>(Tissue::kDentin);
  const auto ticks = session.ticks();
  const double gone = session.header().volumes_before[dentin] - session.result()->volumes_after[dentin];
  double made = 0;
  for (const Cut& cut : session.cuts()) made += cut.removed[dentin];
  EXPECT_LT(gone, 0.99 * made) << "strokes were taken back, how much of them depends on when the machine gets to it";
  EXPECT_NEAR(ticks.back().removed[dentin] / gone, 1, 2e-3);
  // Played forward and backward, it shows the same tissue.
  SessionPlayer player(folder.path() / "session.h5");
  const auto then = [&](double t) { return tissue_at(session, scene, load_tissue(scene), from_seconds(t)); };
  int back = 0;
  double last = player.begin();
  for (const double t : {0.4, 0.9, 0.7, 2.0, 1.28, 1.1, player.end(), 3.0, 0.0, player.end(), 2.5}) {
    player.seek(t);
    back += t < last;
    last = t;
    EXPECT_NEAR(volume(player.tissue()) / volume(then(t)), 1, 1e-9) << t;
    const auto later = std::ranges::find_if(ticks, [&](const ServoTick& tick) { return tick.t > from_seconds(t); });
    EXPECT_EQ(player.world().tick().index, later == ticks.begin() ? 0 : (later - 1)->index) << t;
  }
  EXPECT_GE(back, 5);
  player.seek(player.end());
  EXPECT_EQ(player.tissue().hash(), session.result()->field_hash);
}

TEST(PlayClock, SeeksLoopsAndRunsBackwards) {
  PlayClock clock;
  clock.begin = 0, clock.end = 10;
  clock.set_range(2, 6);
  EXPECT_EQ(clock.at, 2);
  clock.loop = true;
  clock.advance(5);
  EXPECT_NEAR(clock.at, 3, 1e-12);
  clock.faster(true);
  clock.advance(1);
  EXPECT_NEAR(clock.at, 5, 1e-12);
  clock.speed = -1;
  clock.advance(3.5);
  EXPECT_NEAR(clock.at, 5.5, 1e-12);
  clock.loop = false;
  clock.advance(100);
  EXPECT_TRUE(clock.over);
  EXPECT_EQ(clock.at, 2);
  clock.seek(9);
  EXPECT_EQ(clock.at, 6);
  EXPECT_FALSE(clock.over);
  for (int i = 0; i < 20; ++i) clock.faster(false);
  EXPECT_NEAR(clock.speed, -0.125, 1e-12);
}

TEST_F(UndoSession, ItsHandIsReplayedWithAnotherContactModelAndFilmedBesideTheOriginal) {
  run(scene, "session.h5", {});
  const test::Ran same = expect_ok(folder.run("replay {}/session.h5 --with '{ }' --json"));
  const test::Ran other = expect_ok(folder.run(
      "replay {}/session.h5 --with '{\"coupling\": {\"stiffness_N_per_mm\": 0.5}}' --out {}/soft.h5 --json"));
  const Json a = Json::parse(same.out, "same"), b = Json::parse(other.out, "other");
  EXPECT_LT(a["force_N"]["off_rms"].number(), 0.1 * b["force_N"]["off_rms"].number());
  EXPECT_LT(b["force_N"]["max"].number(), 0.8 * b["force_N"]["max_before"].number());
  EXPECT_TRUE(replay_session(session::SessionReader(folder.path() / "soft.h5")).identical);
  if (!session::find_ffmpeg()) return;
  const test::Ran film = expect_ok(folder.run(
      "replay {}/session.h5 --beside {}/soft.h5 --from 0.5 --to 1.5 --speed 2 --fps 8 --film {}/both.mp4 --json"));
  EXPECT_EQ(Json::parse(film.out, "film")["frames"].number(), 4);
  EXPECT_GT(std::filesystem::file_size(folder.path() / "both.mp4"), 1000u);
}

TEST_F(UndoSession, ANewRunOfItsHandRepeatsItsUndo) {
  run(scene, "session.h5", {{1.3, TissueCommand::kUndo}});
  const session::SessionReader recorded(folder.path() / "session.h5");
  const RerunResult again = rerun_session(recorded, scene_of(recorded), folder.path() / "again.h5");
  EXPECT_GT(again.removed_before, 0);
  EXPECT_NEAR(again.removed / again.removed_before, 1, 0.01);
  EXPECT_TRUE(replay_session(session::SessionReader(folder.path() / "again.h5")).identical);
}

TEST_F(UndoSession, AContinuedPreparationIsScoredAgainstTheUntouchedTissue) {
  run(scene, "first.h5", {}, "half.vdb");
  const double untouched = volume(load_tissue(scene));
  const session::SessionReader first(folder.path() / "first.h5");
  const double half = first.result()->volumes_after[static_cast<std::size_t>(Tissue::kDentin)];
  ASSERT_LT(half, untouched);
  for (const char* from : {"first.h5", "half.vdb"}) {
    const Scene resumed = with_resume(scene, folder.path() / from);
    EXPECT_NEAR(volume(load_tissue(resumed)) / half, 1, 1e-6) << from;
    folder.write("hand.csv", hand(2.5));
    run(resumed, "second.h5", {{1.3, TissueCommand::kUndo}});
    const session::SessionReader second(folder.path() / "second.h5");
    EXPECT_NEAR(second.header().volumes_before[static_cast<std::size_t>(Tissue::kDentin)] / untouched, 1, 1e-12)
        << from;
    EXPECT_LT(second.result()->volumes_after[static_cast<std::size_t>(Tissue::kDentin)], half) << from;
    const ReplayResult replay = replay_session(session::SessionReader(folder.path() / "second.h5"));
    EXPECT_TRUE(replay.identical) << from << ": " << replay.what_differs;
  }
  // A session that continues a recording has the strokes of the recording.
  haptics::TissueVolume tissue = load_tissue(with_resume(scene, folder.path() / "first.h5"));
  ASSERT_GE(tissue.strokes().done, 3u);
  while (tissue.undo()) {
  }
  EXPECT_EQ(tissue.hash(), load_tissue(scene).hash());
}

TEST_F(UndoSession, TheVolumeOfAnotherTissueIsRefusedByName) {
  folder.write(
      "other.json",
      R"({"tissue": {"voxel_mm": 0.25, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]}, "tool": "round_012"})");
  load_tissue(read_scene(folder.path() / "other.json")).save(folder.path() / "other.vdb");
  const auto ran = folder.run("run {}/scene.json --resume {}/other.vdb --hand script:{}/hand.csv --audio none:");
  EXPECT_EQ(ran.status, 2);
  EXPECT_NE(ran.err.find("other.vdb"), std::string::npos) << ran.err;
  EXPECT_NE(ran.err.find("0.2500 mm"), std::string::npos) << ran.err;
}

}  // namespace
}  // namespace typodont
