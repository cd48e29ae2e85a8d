// Tests that every live session can be replayed bit for bit, however its threads were delayed. The turns of servo,
// carver and recorder are those of the program. The test calls them in random order on a simulated clock, with delays
// in the middle of the carver's turns, undo and redo, changes of tool, faults of the hand, and an end at any moment.
// ./run stress makes it long.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <immintrin.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <thread>

#include "engine/app/live/session.h"
#include "engine/app/recording.h"
#include "engine/app/recording/replay.h"
#include "engine/app/recording/resume.h"
#include "engine/base/realtime.h"
#include "engine/base/units.h"
#include "engine/session/session_file.h"
#include "haptics/device_safety.h"
#include "tests/support/campaign.h"
#include "tests/support/session_fixture.h"

namespace typodont {
namespace {

using namespace literals;
using session::test::TemporaryFolder;

struct Random {
  std::mt19937_64 engine;
  explicit Random(std::uint64_t seed) : engine(seed) {}
  double in(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(engine); }
  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(engine); }
  bool chance(double p) { return in(0, 1) < p; }
  dvec3 vec(double size) { return {in(-size, size), in(-size, size), in(-size, size)}; }
  dquat turn(double most) { return glm::angleAxis(in(0, most), glm::normalize(vec(1) + dvec3(0, 0, 1e-3))); }
};

Nanos g_clock = 0;  // ns, simulated
Nanos simulated() noexcept {
  return g_clock;
}

/// A hand that moves from place to place in and around a block, rotates, drills, changes tools, and sometimes reports a
/// fault.
class RandomHand : public haptics::HapticDevice {
 public:
  RandomHand(std::uint64_t seed, int tools) : random_(seed), tools_(tools) {
    info_.address = "random:";
    info_.rate = random_.chance(0.3) ? 2000 : 1000;
    info_.position_step = random_.chance(0.3) ? 5e-6 : 0;
    info_.torque_limit = random_.chance(0.5) ? 0.2 : 0;
    info_.vibration_band = random_.chance(0.3) ? 150 : 0;
    turns_ = random_.chance(0.7);
    length_ = random_.chance(0.5) ? 1 : 1 + random_.in(-3e-4, 3e-4);  // a driver that does not make it one
    R_ = random_.turn(0.6);
    p_ = start();
    plan();
  }
  static dvec3 start() { return {0, 0, 4.5_mm}; }

  const haptics::DeviceInfo& info() const noexcept override { return info_; }
  bool read(haptics::HandSample& sample) noexcept override {
    const double period = 1 / info_.rate;
    double dt = period;
    if (random_.chance(0.03)) dt *= random_.in(0.2, 6);
    if (random_.chance(2e-4)) dt = 0.15;
    t_ += from_seconds(dt);
    g_clock += from_seconds(dt);
    if ((left_ -= dt) < 0) plan();
    const dvec3 way = to_ - p_;
    const double length = glm::length(way), step = speed_ * dt;
    p_ = length > step ? p_ + way * (step / length) : to_;
    if (turns_) R_ = glm::slerp(R_, to_R_, std::min(1.0, 4 * dt));
    faults_ = random_.chance(1e-3) ? bits(Fault::kLetGo) : random_.chance(3e-4) ? bits(Fault::kBadInput) : 0;
    if (lost_ == 0 && random_.chance(1e-4)) lost_ = 30;
    if (lost_ > 0) --lost_, faults_ |= bits(Fault::kDeviceLost);
    sample = {t_, {p_, length_ * R_}, pedal_, tool_};
    return true;
  }
  void write(const dvec3&, const dvec3&) noexcept override {
    if (random_.chance(1e-3)) faults_ |= bits(Fault::kLetGo);  // noticed after the servo had asked
    if (random_.chance(1e-3)) faults_ |= bits(Fault::kForceLimit);
  }
  std::uint32_t faults() const noexcept override { return faults_; }

 private:
  void plan() {
    left_ = random_.in(0.1, 1.2);
    const bool away = random_.chance(0.15);
    to_ = away ? start() + random_.vec(2.0_mm)
               : dvec3(random_.in(-2.2_mm, 2.2_mm), random_.in(-2.2_mm, 2.2_mm), random_.in(-0.5_mm, 2.4_mm));
    speed_ = random_.chance(0.1) ? 0.2 : random_.in(2e-3, 1.5e-2);
    if (random_.chance(0.01)) p_ = to_;  // a leap
    to_R_ = random_.turn(1.0);
    pedal_ = away || random_.chance(0.1) ? 0.0 : random_.chance(0.5) ? 1.0 : random_.in(0.1, 1);
    if (random_.chance(0.3)) tool_ = static_cast<std::uint32_t>(random_.below(random_.chance(0.5) ? 2 : tools_));
  }

  Random random_;
  int tools_;
  haptics::DeviceInfo info_;
  bool turns_;
  double length_;
  dquat R_, to_R_{1, 0, 0, 0};
  dvec3 p_, to_{0};
  double speed_ = 0, left_ = 0, pedal_ = 0;
  std::uint32_t tool_ = 0, faults_ = 0;
  int lost_ = 0;
  Nanos t_ = 0;
};

constexpr const char* kScene = R"({"name": "random", "tissue": {"voxel_mm": 0.2, "solids": [
  {"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 5]}}},
  {"tissue": "enamel", "solid": {"box": {"center_mm": [0, 0, 2], "size_mm": [6, 6, 1]}}},
  {"tissue": "caries", "solid": {"sphere": {"center_mm": [0.8, 0, 1.4], "radius_mm": 0.9}}}]},
  "tools": ["round_016", "round_end_cylinder_012", "explorer", "condenser_amalgam", "excavator_spoon", "inverted_cone_012"],
  "spindle": "electric_1_5", "parts": ["haptics"]})";

struct Counts {
  std::uint64_t ticks = 0, cuts = 0, edits = 0, patches = 0, passed_over = 0, tools = 0;
  std::uint64_t asked = 0;  // undos, redos, and changes of tool, settings and emergency stop
};

/// Records one session to `file`. `seed` determines the order in which its threads have their turns.
void run_session(const Scene& scene, std::uint64_t seed, const std::filesystem::path& file, Counts& counts) {
  Random random(seed);
  g_clock = 1'000'000'000;
  haptics::set_emergency_stop(false);
  RandomHand hand(seed * 7919 + 1, static_cast<int>(haptics::tool_set(scene.servo).size()));
  LiveSession s(scene, load_tissue(scene));
  s.record = true;
  s.operated = random.chance(0.5);
  s.serve(hand.info());
  SessionRecorder recorder(file, scene, session_header(scene, {}, hand.info(), s.carver.volume(), hand.info().rate),
                           s.wiring.event_logs);
  s.wiring.patch.offer(s.carver, RandomHand::start());
  const PerTissue before = s.carver.volume().volumes();

  ServoTurns servo(s, hand, simulated);
  bool alive = true;
  constexpr auto kAmalgam = static_cast<std::size_t>(Tissue::kAmalgam);
  double filled = 0;  // m³, all amalgam that was added
  const auto feel = [&](int turns) {
    for (; turns > 0 && alive; --turns) {
      const std::uint32_t tool = s.last.tool;
      const double amalgam = s.last.removed[kAmalgam];
      alive = servo.turn();
      counts.ticks += alive;
      counts.tools += s.last.tool != tool;
      counts.asked += s.last.tool != tool;
      filled += std::max(0.0, amalgam - s.last.removed[kAmalgam]);
    }
  };
  const double held_up = random.chance(0.5) ? random.in(0, 0.3) : 0;  // of the carver's steps
  CarverTurns carver(s, [&] {
    if (random.chance(held_up)) feel(1 + random.below(random.chance(0.1) ? 120 : 12));
  });
  const int most = random.chance(0.3) ? 60 : 6;  // ticks in a row
  const int length = 2000 + random.below(4000);
  const bool edits = random.chance(0.8);
  const double edit_rate = random.chance(0.3) ? 0.5 : 0.04;
  const auto ask = [&](TissueCommand command) {
    s.wiring.tissue_commands.push(command);
    ++counts.asked;
  };
  for (int i = 0; i < length && alive;) {
    const int turns = random.chance(0.01) ? 300 : 1 + random.below(most);
    feel(turns);
    i += turns;
    if (edits && random.chance(edit_rate)) {
      ask(random.chance(0.6) ? TissueCommand::kUndo : TissueCommand::kRedo);
      if (random.chance(0.3)) ask(TissueCommand::kUndo);
    }
    const bool stopped = haptics::emergency_stopped();
    if (random.chance(stopped ? 0.1 : 0.001)) haptics::set_emergency_stop(!stopped), ++counts.asked;
    if (random.chance(0.005)) {
      SessionSettings settings;
      settings.speed_fraction = random.in(0.4, 1), settings.force_fraction = random.in(0, 1);
      settings.stiffness[2] = random.in(0.2, 2);
      s.wiring.settings.publish(settings);
      ++counts.asked;
    }
    if (random.chance(0.002)) s.wiring.chosen_tool = random.below(5) - 1;
    // The carver sometimes has two turns. Then a snapshot may be replaced by another one before the servo has seen it.
    for (int turn = random.chance(0.2) ? 2 : 1; turn > 0; --turn) {
      if (!random.chance(0.2)) carver.turn();
      if (edits && turn > 1 && random.chance(0.3)) ask(TissueCommand::kRedo);
    }
    if (random.chance(0.2)) recorder.turn();
  }
  carver.turn();  // the last undo; without its patch, the servo would count the undone cuts
  while (alive && s.side.edit_waits()) feel(1), carver.turn();
  if (random.chance(0.2)) s.wiring.emergency = true;
  if (random.chance(0.5)) carver.turn();
  // The servo may still have a turn while the carver ends. Then whoever ends the session must repeat the cuts of this
  // turn.
  carver.finish();
  feel(random.below(2));
  s.wiring.stop = true;
  EXPECT_FALSE(servo.turn());
  servo.end();
  carver.finish();
  if (scene.servo.method->name() == "offset") {  // other models count what their own elements lose
    const PerTissue after = s.carver.volume().volumes();
    double removed = 0, all_gone = 0;
    for (std::size_t t = 1; t < after.size(); ++t) {
      const double gone = before[t] - after[t];
      removed += s.last.removed[t], all_gone += gone;
      // A voxel with amalgam and tissue has one label: amalgam in it is counted as amalgam but looks like tissue.
      EXPECT_NEAR(s.last.removed[t], gone, 1e-11 + 0.01 * std::abs(gone) + 0.1 * filled)
          << "session " << seed << ", tissue " << t;
    }
    EXPECT_NEAR(removed, all_gone, 1e-11 + 0.01 * std::abs(all_gone)) << "session " << seed;
  }
  counts.cuts += s.carver.cuts();
  counts.patches += s.carver.snapshots();
  recorder.finish(s.carver.volume());
}

class LiveReplayOfModel : public testing::TestWithParam<const char*> {};

TEST_P(LiveReplayOfModel, EverySessionIsReplayedBitForBitForAnyThreadDelays) {
  const TemporaryFolder folder;
  const std::filesystem::path scene_file = folder / "scene.json", file = folder / "session.h5";
  std::string json = kScene;
  const std::string fills = R"("condenser_amalgam", )";
  if (GetParam() != std::string("offset")) json.erase(json.find(fills), fills.size());  // only offset fills
  if (GetParam() == std::string("implant")) {  // drills a bed in bone of two classes
    const auto replace = [&](std::string_view from, std::string_view by) {
      json.replace(json.find(from), from.size(), by);
    };
    replace("dentin", "cancellous_bone"), replace("enamel", "cortical_bone");
    replace("excavator_spoon", "implant_drill_028"), replace("round_016", "implant_drill_022");
  }
  std::ofstream(scene_file) << json << std::flush;
  Scene scene = read_scene(scene_file);
  choose_model(scene, GetParam());
  Counts counts;
  const std::uint64_t first = test::campaign_seed(1);
  for (std::uint64_t seed = first; seed < first + static_cast<std::uint64_t>(test::campaign(4)); ++seed) {
    run_session(scene, seed, file, counts);
    const session::SessionReader session(file);
    counts.edits += edits_of(session).size();
    for (std::size_t i = 1; i < session.patches().size(); ++i)
      counts.passed_over += session.patches()[i].patch - session.patches()[i - 1].patch - 1;
    const ReplayResult replayed = replay_session(session);
    EXPECT_TRUE(replayed.identical) << "session " << seed << ": " << replayed.what_differs << " of "
                                    << session.tick_count();
  }
  fmt::print("{}: {} ticks, {} cuts, {} undos, redos and changes of tool, settings and stop\n", GetParam(),
             counts.ticks, counts.cuts, counts.asked);
  // What may go wrong did happen.
  EXPECT_GT(counts.cuts, 5u);
  EXPECT_GT(counts.edits, 20u);
  EXPECT_GT(counts.patches, 50u);
  EXPECT_GT(counts.passed_over, 2u);  // snapshots that no servo took up
  EXPECT_GT(counts.tools, 0u);
}

INSTANTIATE_TEST_SUITE_P(Models, LiveReplayOfModel,
                         testing::Values("offset", "voxel_penalty", "packing", "mesh_lod", "vertex", "implant"),
                         [](const auto& model) { return std::string(model.param); });

/// A random hand in real time, which leaves after some ticks.
class PacedHand : public RandomHand {
 public:
  using RandomHand::RandomHand;
  bool read(haptics::HandSample& sample) noexcept override {
    if (++ticks_ > 4000) return false;
    std::this_thread::sleep_for(std::chrono::microseconds(100));
    return RandomHand::read(sample);
  }

 private:
  int ticks_ = 0;
};

TEST(LiveReplay, ASessionOnItsOwnThreadsIsReplayedBitForBit) {
  const TemporaryFolder folder;
  const std::filesystem::path scene_file = folder / "scene.json", file = folder / "session.h5";
  std::ofstream(scene_file) << kScene;
  const Scene scene = read_scene(scene_file);
  PacedHand hand(3, static_cast<int>(haptics::tool_set(scene.servo).size()));
  LiveSession s(scene, load_tissue(scene));
  s.record = true;
  s.serve(hand.info());
  SessionRecorder recorder(file, scene, session_header(scene, {}, hand.info(), s.carver.volume(), hand.info().rate),
                           s.wiring.event_logs);
  StateStream stream({"ws:0"}, {scene.name, tool_names(scene), hand.info().rate});
  StreamTurns streaming(s, stream, 1000);
  s.wiring.patch.offer(s.carver, RandomHand::start());
  std::jthread servo(servo_thread, std::ref(s), std::ref(hand)), carver(carver_thread, std::ref(s)),
      recording(recorder_thread, std::ref(s), std::ref(recorder)),
      other(stream_thread, std::ref(s), std::ref(streaming));
  EventLog<ServoEvent>::Reader score(s.wiring.event_logs.servo);
  std::uint64_t ticks = 0, undone = 0;
  for (ServoEvent event; !s.wiring.servo_ended; std::this_thread::sleep_for(std::chrono::milliseconds(3))) {
    while (score.next(event)) ticks += std::holds_alternative<ServoTick>(event);
    if (ticks > 1000 * (undone + 1)) s.wiring.tissue_commands.push(TissueCommand::kUndo), ++undone;
  }
  servo.join();
  s.wiring.stop = true;
  carver.join();
  EXPECT_EQ(s.carver_failure, "");
  s.side.follow([](const Cut&) {}, /*to_end=*/true);
  s.wiring.nothing_more = true;
  recording.join();
  other.join();
  recorder.finish(s.carver.volume());
  EXPECT_GT(s.carver.cuts(), 100u);
  const ReplayResult replayed = replay_session(session::SessionReader(file));
  EXPECT_TRUE(replayed.identical) << replayed.what_differs;
  EXPECT_EQ(replayed.ticks, s.last.index + 1);
}

/// Drills to and fro in the top of the block.
class DrillingHand : public haptics::HapticDevice {
 public:
  DrillingHand() { info_.address = "drilling:"; }
  const haptics::DeviceInfo& info() const noexcept override { return info_; }
  bool read(haptics::HandSample& sample) noexcept override {
    g_clock += 1'000'000;
    sample = {};
    sample.t = g_clock;
    const double s = to_seconds(++ticks_ * Nanos{1'000'000});
    sample.X_WT.p = {1.5e-3 * std::sin(3 * s), 0, std::max(4.5e-3 - 5e-3 * s, 2.6e-3)};
    sample.pedal = ticks_ > 20;  // once released
    return true;
  }
  void write(const dvec3&, const dvec3&) noexcept override {}

 private:
  haptics::DeviceInfo info_;
  int ticks_ = 0;
};

TEST(LiveReplay, UndoRestoresTheTissueAlsoIfItIsPaintedWhileTheBurCuts) {
  const TemporaryFolder folder;
  const std::filesystem::path scene_file = folder / "scene.json";
  std::ofstream(scene_file) << R"({"name": "block", "tissue": {"voxel_mm": 0.2, "solids": [
    {"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 5]}}}]}, "tool": "round_016", "spindle_krpm": 300,
    "parts": ["haptics"]})";
  for (const char* model : {"offset", "packing"}) {
    Scene scene = read_scene(scene_file);
    choose_model(scene, model);
    g_clock = 1'000'000'000;
    haptics::set_emergency_stop(false);
    DrillingHand hand;
    LiveSession s(scene, load_tissue(scene));
    s.operated = true;
    s.serve(hand.info());
    const std::uint64_t untouched = s.carver.volume().hash();
    s.wiring.patch.offer(s.carver, dvec3(0, 0, 4.5e-3));
    ServoTurns servo(s, hand, simulated);
    CarverTurns carver(s);
    std::uint64_t cuts = 0;
    for (int i = 0; i < 1500; ++i) {
      ASSERT_TRUE(servo.turn());
      if (i > 700 && i % 20 == 0) {
        BrushMove move;
        move.begins = i % 200 == 0;
        move.stroke.a_W = {-2e-3, -1e-3 + i * 1e-6, 2.2e-3};
        move.stroke.b_W = {2e-3, -1e-3 + i * 1e-6, 2.2e-3};
        s.wiring.paint_to_carver.push(move);
      }
      if (i % 3 == 0) carver.turn();
      cuts = s.carver.cuts();
    }
    carver.turn();
    EXPECT_GT(cuts, 200u) << model;
    const std::size_t strokes = s.carver.strokes().done;
    EXPECT_GT(strokes, 5u) << model;
    for (std::size_t i = 0; i < strokes; ++i) {
      s.wiring.tissue_commands.push(TissueCommand::kUndo);
      carver.turn();
    }
    EXPECT_EQ(s.carver.strokes().done, 0u) << model;
    EXPECT_EQ(s.carver.volume().hash(), untouched) << model;
    carver.finish();
  }
}

TEST(LiveReplay, StandardArithmeticRestoresDenormalNumbersInAThread) {
  _mm_setcsr(_mm_getcsr() | 0x8040);  // flush-to-zero and denormals-are-zero flags
  volatile double least = std::numeric_limits<double>::min();
  EXPECT_EQ(least / 2, 0);
  use_ieee_arithmetic();
  EXPECT_GT(least / 2, 0);
}

}  // namespace
}  // namespace typodont
