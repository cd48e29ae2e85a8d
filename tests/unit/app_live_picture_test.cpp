// Tests what controls the picture of a live session: the quality ladder, the surface as the carver passes it on, and
// views for teaching that follow the cut.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "engine/app/assets.h"
#include "engine/app/live/live_picture.h"
#include "engine/app/live/session.h"
#include "engine/app/picture/frame_report.h"
#include "engine/app/picture/label_blocks.h"
#include "engine/app/picture/live_views.h"
#include "engine/app/picture/quality_ladder.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/workbench.h"
#include "engine/base/json.h"
#include "engine/base/units.h"
#include "haptics/solid.h"
#include "tests/support/session_fixture.h"

namespace typodont {
namespace {

using namespace std::chrono_literals;
using namespace typodont::literals;

int frames_until_change(QualityLadder& ladder, double seconds, int most) {
  for (int i = 1; i <= most; ++i)
    if (ladder.frame_took(seconds)) return i;
  return -1;
}

TEST(QualityLadder, ReachesTheLastStepWithinTwoSecondsOf100MillisecondFramesAndStaysThere) {
  QualityLadder ladder;
  double seconds = 0;
  for (; ladder.step().name != render::kQualityLadder.back().name && seconds < 10; seconds += 0.1)
    ladder.frame_took(0.1);
  EXPECT_LT(seconds, 0.9 * static_cast<double>(render::kQualityLadder.size()));
  EXPECT_EQ(frames_until_change(ladder, 0.08, 400), -1);
}

TEST(QualityLadder, KeepsItsStepWhileFramesAreInTimeAndThoseThatCreatePipelinesDoNotCount) {
  QualityLadder ladder;
  EXPECT_FALSE(ladder.frame_took(2.0));
  EXPECT_FALSE(ladder.frame_took(2.0));
  EXPECT_EQ(frames_until_change(ladder, 0.025, 2000), -1);
}

TEST(QualityLadder, OneSlowFrameChangesNothing) {
  QualityLadder ladder;
  EXPECT_EQ(frames_until_change(ladder, 0.02, 50), -1);
  EXPECT_FALSE(ladder.frame_took(3.0));
  EXPECT_EQ(frames_until_change(ladder, 0.02, 50), -1);
}

TEST(QualityLadder, AFixedLevelStaysForSlowAndForQuickFrames) {
  for (const render::Quality& level : render::kQualityLadder) {
    QualityLadder ladder = QualityLadder::fixed_at(level.name);
    EXPECT_EQ(frames_until_change(ladder, 0.5, 500), -1);
    EXPECT_EQ(frames_until_change(ladder, 0.001, 500), -1);
    EXPECT_EQ(ladder.step().name, level.name);
  }
}

TEST(QualityLadder, RetriesAStepThatWasTooSlowAfterLongerAndLongerWaits) {
  QualityLadder ladder;
  ASSERT_GT(frames_until_change(ladder, 0.08, 40), 0);  // down
  int waited = 0;
  for (int round = 0; round < 4; ++round) {
    const int up = frames_until_change(ladder, 0.005, 20'000);
    ASSERT_GT(up, waited) << "round " << round;
    waited = up;
    ASSERT_GT(frames_until_change(ladder, 0.08, 40), 0);  // and down again
  }
}

TEST(QualityLadder, NamesAGraphicsCardIfTheProcessorDrawsALowerLevelThanACardWould) {
  QualityLadder processor = QualityLadder::for_processor();
  EXPECT_EQ(processor.remedy(true, true, 640 * 480), Remedy::kGraphicsCard);
  EXPECT_EQ(processor.remedy(true, false, 4e6), Remedy::kGraphicsCard);
  while (processor.step().name != QualityLadder().step().name)
    ASSERT_GT(frames_until_change(processor, 0.001, 20'000), 0);
  EXPECT_EQ(processor.remedy(true, true, 640 * 480), Remedy::kNone) << "the level of a card";
  EXPECT_EQ(QualityLadder::fixed_at("bare").remedy(true, true, 4e6), Remedy::kNone) << "the user's choice";
}

TEST(QualityLadder, NamesASmallerWindowForALargeOneAndOtherwiseAFasterCardIfACardIsTooSlow) {
  QualityLadder card;
  EXPECT_EQ(card.remedy(false, true, 3840 * 2160), Remedy::kNone);
  ASSERT_GT(frames_until_change(card, 0.08, 40), 0);
  EXPECT_EQ(card.remedy(false, true, 3840 * 2160), Remedy::kSmallerWindow);
  EXPECT_EQ(card.remedy(false, true, 640 * 480), Remedy::kFasterCard);
  EXPECT_EQ(card.remedy(false, false, 3840 * 2160), Remedy::kFasterCard) << "a headset, or a full screen";
}

TEST(FrameReport, AFrameIsLateIfTheDisplayShowedThePreviousOneTwice) {
  FrameReport report;
  const RefreshPeriod refresh{1.0 / 60, "a monitor"};
  for (int i = 0; i < 998; ++i) report.add_interval(1.4 / 60, refresh);
  EXPECT_EQ(report.late_in_1000(), 0);
  for (const double periods : {1.6, 40.0}) report.add_interval(periods / 60, refresh);
  EXPECT_DOUBLE_EQ(report.late_in_1000(), 2);
  EXPECT_EQ(report.lines(), std::vector<std::string>{"late frames: 2.0 of 1,000, more than 1.5 × 16.7 ms after the "
                                                     "previous one (a monitor)"});
}

TEST(FrameReport, StatesMedianAnd99PercentOfEachPassAndCountsEachFrameOnce) {
  FrameReport report;
  report.add(render::GpuTimes());
  EXPECT_TRUE(report.lines().empty()) << "the device has no timestamps";
  render::GpuTimes times;
  for (int i = 1; i <= 100; ++i) {
    times.frames = static_cast<std::uint64_t>(i);
    times.frame = i;
    times.parts[static_cast<std::size_t>(render::FramePart::kTissue)] = 0.5 * i;
    report.add(times);
  }
  for (int i = 0; i < 300; ++i) report.add(times);  // the same frame
  const std::vector<std::string> lines = report.lines();
  ASSERT_EQ(lines.size(), 1 + render::kFrameParts.size());
  EXPECT_EQ(lines[0], "GPU time, whole frame: median 51.00 ms, 99 % 100.00 ms");
  EXPECT_EQ(std::ranges::count(lines, "GPU time, tissue: median 25.50 ms, 99 % 50.00 ms"), 1);
  EXPECT_EQ(std::ranges::count(lines, "GPU time, mirror: median 0.00 ms, 99 % 0.00 ms"), 1);
}

Scene empty_scene() {
  return parse_scene(Json::parse(R"({"tissue": {"voxel_mm": 0.5, "solids": [{"tissue": "enamel",
      "solid": {"sphere": {"radius_mm": 9}}}]}, "tool": "round_012"})",
                                 "scene.json"),
                     "scene.json");
}
haptics::TissueVolume ball(double radius_mm) {
  return haptics::TissueVolume(
      haptics::read_solids(Json::parse(fmt::format(R"({{"voxel_mm": 0.1, "band_mm": 1, "solids": [
        {{"tissue": "dentin", "solid": {{"sphere": {{"center_mm": [0, 0, 0], "radius_mm": {}}}}}}}]}})",
                                                   radius_mm),
                                       "solids")));
}

/// Live views of a session, and in the place of the carver a loop that answers requests as a carver does.
struct Watched {
  static constexpr glm::ivec2 kPicture{160, 120};
  Scene scene = empty_scene();
  haptics::TissueVolume tissue = ball(3);
  Wiring wiring{haptics::Carver(tissue.clone(), scene.servo)};
  Surroundings around;
  PictureStage stage{rig(), scene.servo, {.embedded = true, .hud = false}};
  World world{scene};
  LiveViews views{scene, tissue, around, wiring, /*judged=*/false};

  std::set<std::uint64_t> there;  // bricks shown

  static display::DisplayRig rig() { return rig_of({.elevation = 0.1, .distance = 0.15}, {0, 0, 0}, kPicture); }
  Watched() {
    views.attach(Eyes::kTrainee, &stage);
    show();
  }
  ~Watched() {
    wiring.stop = true;
    views.attach(Eyes::kTrainee, nullptr);
  }
  void show() {
    TissueView view(0.1f);
    MeshBatch batch = view.update(tissue);
    std::set<std::uint64_t> now_there;
    for (const render::MeshUpdate& brick : batch) now_there.insert(brick.brick);
    for (const std::uint64_t brick : std::exchange(there, now_there))
      if (!now_there.contains(brick)) batch.push_back({brick, {}, {}});
    views.take(std::move(batch));
  }
  void cut_to(double radius_mm) {
    tissue = ball(radius_mm);
    ++wiring.tissue_version;
    show();
  }
  /// Gives carver and picture `count` turns, and more until everything that was requested has been made. Returns the
  /// number of pixels of the last frame that show tissue.
  int turns(int count) {
    constexpr int kMost = 6000;  // a slow machine, a sanitizer
    for (int i = 0; i < count || (views.making(Eyes::kTrainee) && i < kMost); ++i) {
      if (wiring.copy_wanted.exchange(false)) {
        auto copy = std::make_unique<haptics::TissueVolume>(tissue.clone());
        if (wiring.copies_to_watch.push(copy.get())) (void)copy.release();
      }
      views.advance();
      stage.draw(world, {.tool = false});
      std::this_thread::sleep_for(5ms);
    }
    const render::Picture picture = stage.eye(0);
    int shown = 0;
    for (std::size_t i = 0; i < picture.rgba.size(); i += 4) shown += picture.rgba[i] > 90;
    return shown;
  }
  void look_as(render::View view) {
    Look look = views.look(Eyes::kTrainee);
    look.view = view;
    if (view == render::View::kSection) look.plane = {0, 1, 0, 0};
    views.look(Eyes::kTrainee, look);
  }
};

TEST(PictureStage, IsBlankUntilAFrameIsDrawnInThePresentSizeAndQuality) {
  Watched watched;
  PictureStage& stage = watched.stage;
  const auto drawn = [&] {
    const bool was_blank = stage.blank();
    stage.draw(watched.world, {.tool = false});
    return was_blank && !stage.blank();
  };
  EXPECT_TRUE(drawn());
  EXPECT_FALSE(drawn());
  EXPECT_TRUE(stage.resize({120, 90}));
  EXPECT_TRUE(drawn());
  stage.set_quality(render::kQualityLadder.back());
  EXPECT_TRUE(drawn());
}

TEST(LivePicture, TheOperatorsWindowNeverGetsABlankPictureWhenTheQualityChanges) {
  const Scene scene = empty_scene();
  LiveSession session(scene, ball(3));
  ServoTick tick;
  LivePicture picture(scene, {.operated = true, .embedded = true}, session, tick);
  // So large a picture is too slow for every processor.
  const display::DisplayRig rig = rig_of({.elevation = 0.1, .distance = 0.15}, {0, 0, 0}, {4096, 3072});
  std::vector<std::string> explanations;
  picture.open(rig, explanations);
  if (!picture.stage()->device().processor) GTEST_SKIP() << "a graphics card draws such pictures in time";
  WorkCounts work;
  for (int i = 0; i < 1000 && picture.ladder().changes() == 0; ++i) {
    tick.X_WG.p.x = 1e-5 * i;
    picture.apply(tick);
    picture.draw("", work);
    std::this_thread::sleep_for(5ms);
    EXPECT_FALSE(picture.stage()->blank());
  }
  EXPECT_GT(picture.ladder().changes(), 0);
}

/// A ball of enamel in the operator's window, and a tool that moves over it at 1 mm/s.
struct BallSession {
  const session::test::TemporaryFolder folder;
  std::optional<Scene> scene;
  std::optional<Workbench> bench;

  BallSession() {
    std::ofstream(folder / "scene.json") << R"({"tissue": {"voxel_mm": 0.2, "solids": [
      {"tissue": "enamel", "solid": {"sphere": {"center_mm": [0, 0, 0], "radius_mm": 5}}}]}, "tool": "round_012",
      "parts": ["haptics", "render"]})";
    std::ofstream(folder / "hand.csv")
        << "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,-5,0,8,1,0,0,0,0\n60,55,0,8,1,0,0,0,0\n";
    scene = read_scene(folder / "scene.json");
    WorkbenchOptions options;
    options.rig = (assets_folder() / "rigs/window.json").string();
    options.embedded = true;
    options.hand = "script:" + (folder / "hand.csv").string();
    options.pedal = "none", options.audio = "none:", options.no_real_time = true;
    bench.emplace(*scene, options);
  }
  /// Runs the session until 20 frames are drawn, or for ten seconds.
  void draw() {
    bench->open();
    while (!bench->begin({640, 480})) std::this_thread::sleep_for(1ms);
    const std::uint64_t first = bench->status().frames;
    const Nanos until = now() + 10 * kNanosPerSecond;
    while (bench->step({}, {640, 480}) && bench->status().frames < first + 20 && now() < until)
      std::this_thread::sleep_for(5ms);
  }
};

TEST(Workbench, ThePictureSaysItsLevelAndThatAGraphicsCardWouldImproveItIfTheProcessorDraws) {
  BallSession session;
  session.draw();
  const std::string hint = session.bench->stage()->hud().hint;
  const bool processor = session.bench->stage()->processor();
  EXPECT_EQ(hint.find("A graphics card would improve it.") != std::string::npos, processor) << hint;
  const WorkbenchStatus status = session.bench->status();
  const auto level = session::text(fmt::format("op.quality.{}", status.quality), session::Language::kEnglish);
  EXPECT_EQ(status.quality_notice.starts_with(fmt::format("picture: {}. ", level)), processor) << hint;
  session.bench->stop();
}

TEST(Workbench, ASessionBeginsWhenItsPictureShowsTheTissueAndCreatesNoPipelineOnItsThread) {
  BallSession session;
  Workbench& bench = *session.bench;
  bench.open();
  while (!bench.begin({640, 480})) {
    EXPECT_EQ(bench.status().tick.index, 0u);
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_GT(bench.status().frames, 0u);
  EXPECT_EQ(bench.stage()->device().unprepared_pipelines, 0);
  const render::Picture first = bench.stage()->eye(0);
  EXPECT_GT(std::ranges::count_if(first.rgba, [](std::uint8_t byte) { return byte > 150; }), 1000);
  bench.stop();
}

TEST(LiveViews, ASectionFollowsTheCutAndAnotherViewReplacesIt) {
  Watched watched;
  watched.turns(2);
  EXPECT_FALSE(watched.views.started());
  watched.look_as(render::View::kSection);
  EXPECT_TRUE(watched.views.started());
  EXPECT_TRUE(watched.views.making(Eyes::kTrainee));
  const int before = watched.turns(160);
  EXPECT_FALSE(watched.views.making(Eyes::kTrainee));
  watched.cut_to(2);
  const int after = watched.turns(160);
  // The cut face is a disc with the radius of the ball, so 4/9 of its area remains. Only bright pixels count, so the
  // limits are wide.
  EXPECT_GT(static_cast<double>(after) / before, 0.25);
  EXPECT_LT(static_cast<double>(after) / before, 0.6);
  watched.look_as(render::View::kXray);
  watched.turns(160);
  EXPECT_FALSE(watched.views.making(Eyes::kTrainee));
  EXPECT_EQ(watched.stage.view(), render::View::kXray);
}

TEST(LiveViews, WithoutAViewThereIsNoWorkAndUnchangedTissueIsNotReadTwice) {
  Watched watched;
  watched.cut_to(2.5);
  watched.turns(30);
  EXPECT_FALSE(watched.wiring.copy_wanted);
  EXPECT_FALSE(watched.views.started());
  watched.look_as(render::View::kSection);
  watched.turns(160);
  ASSERT_FALSE(watched.views.making(Eyes::kTrainee));
  for (int i = 0; i < 60; ++i) {
    EXPECT_FALSE(watched.wiring.copy_wanted);
    watched.views.advance();
    std::this_thread::sleep_for(5ms);
  }
}

/// The carver's thread of a session, without the other threads. The test gives it strokes of a brush.
struct Carved {
  Scene scene = empty_scene();
  LiveSession session{scene, ball(2)};
  std::vector<PaintStroke> strokes;
  std::jthread carver;

  ~Carved() {
    session.wiring.stop = true;
    if (carver.joinable()) carver.join();
    MeshBatch* batch = nullptr;
    while (session.wiring.bricks.pop(batch)) delete batch;
  }
  void start() { carver = std::jthread(carver_thread, std::ref(session)); }
  /// Paints a stroke. Returns true if the carver answers within ten seconds.
  bool paint(const PaintStroke& stroke) {
    strokes.push_back(stroke);
    const std::uint64_t before = session.wiring.tissue_version;
    session.wiring.paint_to_carver.push({stroke, true});
    return within_ten_seconds([&] { return session.wiring.tissue_version != before; });
  }
  static bool within_ten_seconds(const auto& reached) {
    for (int i = 0; i < 10'000 && !reached(); ++i) std::this_thread::sleep_for(1ms);
    return reached();
  }
};

TEST(CarverThread, APausedPictureGetsTheWholeSurfaceWhenItContinues) {
  Carved carved;
  LiveSession& s = carved.session;
  s.draw = true;
  s.mesh_interval = 0;
  s.wiring.tissue_in_sight[0] = true;
  carved.start();
  for (int i = 0; i < 400; ++i) {
    const double a = 0.1 * i, z = 0.01 * i - 2;  // mm: a spiral about the ball
    const double r = std::sqrt(4 - z * z);
    const dvec3 at = dvec3(r * std::cos(a), r * std::sin(a), z) * kMillimetre;
    ASSERT_TRUE(carved.paint({Tissue::kCaries, at, at, 0.2_mm}));
    std::this_thread::sleep_for(500us);  // a batch each
  }

  haptics::TissueVolume same = ball(2);
  paint(same, carved.strokes);
  TissueView view(0.1f);
  std::map<std::uint64_t, std::size_t> expected, shown;  // corners of decay by brick
  const auto decay = [](const render::MeshUpdate& brick) {
    return static_cast<std::size_t>(std::count_if(
        brick.vertices.begin(), brick.vertices.end(),
        [](const render::Vertex& v) { return v.tissue[0] == Tissue::kCaries || v.tissue[1] == Tissue::kCaries; }));
  };
  for (const render::MeshUpdate& brick : view.update(same)) expected[brick.brick] = decay(brick);
  const bool all = Carved::within_ten_seconds([&] {
    MeshBatch* batch = nullptr;
    while (s.wiring.bricks.pop(batch)) {
      const std::unique_ptr<MeshBatch> owned(batch);
      for (const render::MeshUpdate& brick : *owned) shown[brick.brick] = decay(brick);
    }
    return shown == expected;
  });
  EXPECT_TRUE(all);
}

TEST(CarverThread, PaintingInTheAirIsNoStrokeAndNotPartOfAnExercise) {
  Carved carved;
  LiveSession& s = carved.session;
  carved.start();
  const dvec3 air(0, 0, 5.0_mm), surface(0, 0, 2.0_mm);
  s.wiring.paint_to_carver.push({{Tissue::kCaries, air, air, 0.5_mm}, true});
  ASSERT_TRUE(carved.paint({Tissue::kCaries, surface, surface, 0.5_mm}));
  s.wiring.paint_to_carver.push({{Tissue::kCaries, air, air, 0.5_mm}, true});
  ASSERT_TRUE(carved.paint({Tissue::kCaries, -surface, -surface, 0.5_mm}));
  s.wiring.stop = true;
  carved.carver.join();
  TissueState tissue;
  EventLog<CarverEvent>::Reader reader(s.wiring.event_logs.carver);
  for (CarverEvent event; reader.next(event);)
    if (const auto* const state = std::get_if<TissueState>(&event)) tissue = *state;
  EXPECT_EQ(tissue.painted, 2u);
  EXPECT_EQ(tissue.strokes.done, 2u);
  EXPECT_EQ(s.book.paint(s.carver.strokes()).size(), 2u);
}

TEST(CarverThread, DoesNotWaitForTissueThatIsBeingSaved) {
  const session::test::TemporaryFolder folder;
  Carved carved;
  carved.session.save = folder / "tissue.vdb";
  // The tissue is saved into a pipe. The test opens the pipe but does not read it yet, so the saving takes as long as
  // the test wants.
  const std::string pipe = carved.session.save.string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  ASSERT_GT(::fcntl(reader, F_SETPIPE_SZ, 4096), 0);
  carved.start();
  carved.session.wiring.tissue_commands.push(TissueCommand::kSave);
  std::this_thread::sleep_for(50ms);
  carved.session.wiring.tissue_commands.push(TissueCommand::kSave);
  EXPECT_TRUE(carved.paint({Tissue::kCaries, dvec3(0), dvec3(0), 0.5_mm}));
  EXPECT_EQ(carved.session.wiring.saved, 0u) << "the pipe is full";
  EXPECT_TRUE(Carved::within_ten_seconds([&] {
    std::array<char, 4096> piece;
    while (::read(reader, piece.data(), piece.size()) > 0) {
    }
    return carved.session.wiring.saved == 2;
  }));
  ::close(reader);
  EXPECT_EQ(carved.session.wiring.not_saved, 0u);
  carved.session.wiring.stop = true;
  carved.carver.join();
}

TEST(RecorderThread, CountsTheEventsThatEachTapeLost) {
  Carved made;
  LiveSession& s = made.session;
  session::SessionHeader header;
  header.streams = {left_hand_stream(), head_stream(), water_stream()};
  const session::test::TemporaryFolder folder;
  EventLogs& event_logs = s.wiring.event_logs;
  SessionRecorder recorder(folder / "tapes.h5", made.scene, header, event_logs);
  const auto lap = [](auto& event_log, std::uint64_t kept, auto event) {
    for (std::uint64_t i = 0; i < kept + 3; ++i) event_log.write(event);
  };
  constexpr std::uint64_t kKept = (1 << 16) - 1;
  for (std::uint64_t i = 0; i < (kKept + 3) / 2; ++i) {
    Cut cut;
    cut.index = i + 1;
    ServoTick tick;
    tick.index = i;
    event_logs.servo.write(cut);
    event_logs.servo.write(tick);
  }
  lap(event_logs.carver, (1 << 12) - 1, LoosePiece());
  lap(event_logs.view, (1 << 12) - 1, WaterSwitch());
  lap(event_logs.left, (1 << 13) - 1, haptics::HandSample());
  s.wiring.nothing_more = true;
  recorder_thread(s, recorder);
  EXPECT_EQ(recorder.writer().status().lost, (session::Lost{.ticks_ring = 1, .cuts_ring = 2, .other_ring = 9}));
}

}  // namespace
}  // namespace typodont
