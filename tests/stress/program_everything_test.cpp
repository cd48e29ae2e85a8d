// Tests all functions at the same time on two cores: a window on the screen, sound, debris, recording and scores. The
// hand drills, jumps and leaves at random; the desktop resizes, hides and shows the window; the system stops each
// thread once for a fifth of a second, and sometimes the whole program. Normal test runs do one round, ./run stress
// does twenty, each with another seed.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <random>

#include "engine/base/json.h"
#include "engine/session/session_file.h"
#include "tests/support/campaign.h"
#include "tests/support/desktop.h"
#include "tests/support/program.h"

namespace typodont::test {
namespace {

constexpr double kSeconds = 12;

/// Returns a hand that moves down into a ball of 4 mm, along it and away. Sometimes it jumps to another place between
/// two samples.
std::string hand_of(std::mt19937& random) {
  const auto uniform = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  std::string hand = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";
  double x = 0, y = 0;
  for (double t = 0; t < kSeconds; t += uniform(0.02, 0.4)) {
    if (uniform(0, 1) < 0.3) x = uniform(-4, 4), y = uniform(-4, 4);
    hand += fmt::format("{:.3f},{:.3f},{:.3f},{:.3f},1,0,0,0,{}\n", t, x, y, uniform(3.8, 5.5),
                        uniform(0, 1) < 0.7 ? 1 : 0);
  }
  return hand + fmt::format("{},0,0,8,1,0,0,0,0\n", kSeconds + 1);
}

std::deque<pid_t> threads_of(pid_t process) {
  std::deque<pid_t> ids;
  for (const auto& task : std::filesystem::directory_iterator(fmt::format("/proc/{}/task", process))) {
    ids.push_back(std::stoi(task.path().filename().string()));
  }
  return ids;
}

/// Stops a thread of the program. Returns false if the thread has ended.
bool hold(pid_t thread, useconds_t microseconds) {
  if (::ptrace(PTRACE_SEIZE, thread, nullptr, nullptr) != 0) return false;
  if (::ptrace(PTRACE_INTERRUPT, thread, nullptr, nullptr) != 0) return false;
  int status = 0;
  if (::waitpid(thread, &status, __WALL) != thread || !WIFSTOPPED(status)) return false;
  ::usleep(microseconds);
  return ::ptrace(PTRACE_DETACH, thread, nullptr, nullptr) == 0;
}

TEST(EverythingAtOnce, OnTwoCoresLossesAreCountedForcesLimitedAndTheRecordingReplaysExactly) {
  cpu_set_t two;
  CPU_ZERO(&two);
  CPU_SET(0, &two);
  CPU_SET(1, &two);
  ASSERT_EQ(::sched_setaffinity(0, sizeof two, &two), 0) << "the program inherits it";
  const Desktop desktop;
  ASSERT_GT(desktop.server.process, 0) << "Xvfb is needed (apt install xvfb)";
  const ProgramFolder folder(TYPODONT_PROGRAM);
  constexpr std::array kTools{"round_012", "cone_012", "cylinder_010"};
  for (int round = 0; round < std::min(20, campaign(1)); ++round) {
    SCOPED_TRACE(round);
    std::mt19937 random(static_cast<unsigned>(round));
    folder.write("hand.csv", hand_of(random));
    folder.write("scene.json", fmt::format(R"({{"name": "everything", "tissue": {{"voxel_mm": 0.15, "solids": [
      {{"tissue": "dentin", "solid": {{"sphere": {{"radius_mm": 4}}}}}}]}}, "tool": "{}", "spindle": "air_turbine",
      "parts": ["haptics", "render", "sound", "debris", "record", "score"]}})",
                                           kTools[random() % kTools.size()]));
    folder.write("rig.json", R"({"display": "window", "screen": {"corners_mm": {"lower_left": [-20, -15, 0],
      "lower_right": [20, -15, 0], "upper_left": [-20, 15, 0]}, "pixels": [320, 240], "layout": "side_by_side"},
      "head": {"eye_center_mm": [0, 0, 300], "ipd_mm": 63}})");
    std::filesystem::remove(folder / "s.h5");
    GrowingFile recording(folder / "s.h5");
    const pid_t child = folder.start(
        fmt::format("run {} --rig {} --hand script:{} --pedal none --audio wav:{} --record {} --seconds {} --json",
                    folder / "scene.json", folder / "rig.json", folder / "hand.csv", folder / "sound.wav",
                    folder / "s.h5", kSeconds),
        fmt::format("DISPLAY={}", std::getenv("DISPLAY")));
    std::string window;
    std::deque<pid_t> threads;
    int status = 0, held = 0;
    const auto ended = [&] { return ::waitpid(child, &status, WNOHANG) == child; };
    bool gone = false;
    for (int i = 0; i < 3000 && !(gone = ended()); ++i) {
      ::usleep(static_cast<useconds_t>(20'000 + random() % 300'000));
      if (window.empty()) {
        window = Desktop::xdotool("search --name Typodont");
        window = window.substr(0, window.find('\n'));
        continue;
      }
      if (threads.empty() && held == 0 && recording.has_grown()) threads = threads_of(child);
      if (!threads.empty()) {
        held += hold(threads.front(), 200'000);
        threads.pop_front();
      }
      switch (random() % 4) {
        case 0:
          Desktop::xdotool(fmt::format("windowsize {} {} {}", window, 50 + random() % 600, 50 + random() % 400));
          break;
        case 1:
          Desktop::xdotool("windowunmap " + window);
          break;
        case 2:
          Desktop::xdotool("windowmap " + window);
          break;
        default:
          ::kill(child, SIGSTOP);
          ::usleep(static_cast<useconds_t>(random() % 200'000));
          ::kill(child, SIGCONT);
      }
    }
    ASSERT_TRUE(gone && WIFEXITED(status) && WEXITSTATUS(status) == 0) << folder.said();
    EXPECT_FALSE(window.empty());
    EXPECT_GE(held, 4) << "servo, picture, sound, recorder";

    const Json work = Json::parse(read_text(folder / ".started_out"), "run")["work"];
    EXPECT_GT(work["frames"].integer(), 0);
    EXPECT_GT(work["voxels_cut"].integer(), 0);
    EXPECT_GT(work["samples"].integer(), 0);
    const Ran replay = expect_ok(folder.run("replay {}/s.h5 --check --json"));
    const Json replayed = Json::parse(replay.out, "replay");
    EXPECT_TRUE(replayed["identical"].boolean());
    EXPECT_GE(replayed["seconds"].number(), kSeconds - 2) << "the hand's time went on";
    const session::SessionReader file(folder / "s.h5");
    EXPECT_FALSE(file.truncated());
    ASSERT_TRUE(file.loop());
    EXPECT_EQ(file.loop()->timing.ticks, file.tick_count() + file.lost().ticks_ring);
    double most = 0;
    for (const ServoTick& tick : file.ticks()) {
      ASSERT_TRUE(is_finite(tick.f_T_W) && is_finite(tick.X_WT.p));
      most = std::max(most, glm::length(tick.f_T_W));
    }
    EXPECT_GT(most, 0.05) << "it was felt";
    EXPECT_LE(most, 10);
  }
}

}  // namespace
}  // namespace typodont::test
