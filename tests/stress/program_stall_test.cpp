// Tests all functions at the same time, while each thread of the program in turn is stopped from outside for a third of
// a second. The session continues and states what it lost; its recording is complete and a replay gives the same bits.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "engine/base/json.h"
#include "engine/session/session_file.h"
#include "tests/support/program.h"

namespace typodont::test {
namespace {

constexpr double kSeconds = 14;

/// A hand drills a dentin ball while it moves to and fro. Picture, sound, debris, recording and scores are on.
class Stalled : public testing::Test {
 protected:
  Stalled() {
    folder_.write("scene.json", R"({"name": "everything", "tissue": {"voxel_mm": 0.2, "solids": [
      {"tissue": "dentin", "solid": {"sphere": {"radius_mm": 4}}}]}, "tool": "round_012", "spindle": "air_turbine",
      "parts": ["haptics", "render", "sound", "debris", "record", "score"]})");
    std::string hand = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";
    for (int i = 0; i <= 10 * kSeconds; ++i) {
      hand += fmt::format("{:.1f},{},0,{},1,0,0,0,1\n", 0.1 * i, i % 20 < 10 ? 1 : -1, 4.6 - 0.4 * (i / 5 % 2));
    }
    folder_.write("hand.csv", hand);
    folder_.write("rig.json", R"({"display": "offscreen", "screen": {"corners_mm": {"lower_left": [-40, -30, 0],
      "lower_right": [40, -30, 0], "upper_left": [-40, 30, 0]}, "pixels": [160, 120], "layout": "side_by_side"},
      "head": {"eye_center_mm": [0, 0, 300], "ipd_mm": 63}})");
  }
  ~Stalled() override {
    if (child_ > 0) ::kill(child_, SIGKILL), ::waitpid(child_, nullptr, 0);
  }

  void start() {
    child_ = folder_.start(fmt::format(
        "run {} --rig {} --hand script:{} --audio wav:{} --record {} --seconds {} --json", folder_ / "scene.json",
        folder_ / "rig.json", folder_ / "hand.csv", folder_ / "sound.wav", folder_ / "session.h5", kSeconds));
    for (int i = 0; i < 600 && !std::filesystem::exists(folder_ / "session.h5"); ++i) pause(0.1);
    ASSERT_TRUE(std::filesystem::exists(folder_ / "session.h5")) << folder_.said();
    pause(1);
  }

  static void pause(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

  std::vector<pid_t> threads() const {
    std::vector<pid_t> ids;
    for (const auto& task : std::filesystem::directory_iterator(fmt::format("/proc/{}/task", child_))) {
      ids.push_back(std::stoi(task.path().filename().string()));
    }
    return ids;
  }

  /// False when the thread is gone by now.
  static bool hold(pid_t thread, double seconds) {
    if (::ptrace(PTRACE_SEIZE, thread, nullptr, nullptr) != 0) return false;
    if (::ptrace(PTRACE_INTERRUPT, thread, nullptr, nullptr) != 0) return false;
    int status = 0;
    if (::waitpid(thread, &status, __WALL) != thread || !WIFSTOPPED(status)) return false;
    pause(seconds);
    return ::ptrace(PTRACE_DETACH, thread, nullptr, nullptr) == 0;
  }

  const ProgramFolder folder_{TYPODONT_PROGRAM};
  pid_t child_ = -1;
};

TEST_F(Stalled, StallingAnyThreadCountsItsLossesAndTheRecordingReplaysExactly) {
  ASSERT_NO_FATAL_FAILURE(start());
  const std::vector<pid_t> ids = threads();
  EXPECT_GE(ids.size(), 4u) << "servo, picture, sound, recorder";
  int held = 0;
  for (const pid_t id : ids) held += hold(id, 0.3);
  EXPECT_GE(held, 4);

  int status = 0;
  ASSERT_EQ(::waitpid(child_, &status, 0), child_);
  child_ = -1;
  ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << folder_.said();

  const Ran replay = expect_ok(folder_.run(fmt::format("replay {} --check --json", folder_ / "session.h5")));
  const Json said = Json::parse(replay.out, "replay");
  EXPECT_TRUE(said["identical"].boolean());
  EXPECT_FALSE(said["truncated"].boolean());
  EXPECT_GE(said["seconds"].number(), kSeconds - 2) << "the hand's time went on";

  const session::SessionReader file(folder_ / "session.h5");
  double most = 0;
  for (const ServoTick& tick : file.ticks()) {
    ASSERT_TRUE(is_finite(tick.f_T_W));
    most = std::max(most, glm::length(tick.f_T_W));
  }
  EXPECT_GT(most, 0.05) << "it was felt";
  EXPECT_LE(most, 10);
}

}  // namespace
}  // namespace typodont::test
