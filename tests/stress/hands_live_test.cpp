// Tests the whole program, `typodont run`, with an emulated arm on a pseudo-terminal that fails during contact. The
// currents of the arm's motors are observed in the arm. The arm's firmware never switches the motors off itself, so
// only the program or its watchdog process can end the force. This test does not check times in milliseconds, because
// the machine also does other work. The strict limits (2 ms) and the thousand random moments are tested in
// device_faults_test.cpp, in simulated time, and processes that end in device_ends_test.cpp. This test waits for
// states, on the board's own clock.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <optional>
#include <random>
#include <thread>
#include <utility>

#include "engine/app/workbench.h"
#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/units.h"
#include "engine/contract/safety_event.h"
#include "engine/session/session_file.h"
#include "haptics/devices/fd_link.h"
#include "tests/support/emulation/leaping_clock.h"
#include "tests/support/emulation/live_board.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using test::LiveBoard;
using test::ProgramFolder;

constexpr double kPeriod = 2;  // s, of the board's clock, between two presses

/// The tissue is a block under the arm's tip, and the tool is a ball probe that does not cut.
const char* const kScene = R"({"name": "block", "tissue": {"voxel_mm": 0.25, "solids": [
  {"tissue": "enamel", "solid": {"box": {"center_mm": [25, 0, 196], "size_mm": [10, 10, 8]}}}]},
  "tool": {"shape": "sphere", "diameter_mm": 2, "cuts": false}, "parts": ["haptics"]})";

class LiveHands : public testing::Test {
 protected:
  LiveHands() : folder(TYPODONT_PROGRAM), board(folder.path() / "arm", haptics::read_arm("assets/devices/woody.json")) {
    folder.write("scene.json", kScene);
    // A shell that starts the tests in the background makes them ignore these signals, and the program inherits this.
    for (const int signal : {SIGHUP, SIGINT, SIGQUIT}) ::signal(signal, SIG_DFL);
    // Uses the shipped assets, and a Woody arm whose watchdog waits as long as is allowed. The result must not depend
    // on whether the machine stalls for a millisecond. The usual limit of 1.8 ms is tested in simulated time.
    std::string preset = test::read_text("assets/devices/woody.json");
    preset.insert(preset.find('{') + 1, "\"silence_ms\": 20,");
    folder.add_device("woody_patient", preset);
  }
  ~LiveHands() override {
    if (child > 0) ::kill(child, SIGKILL), ::waitpid(child, nullptr, 0);
  }

  /// Holds the arm in its home position, where the program must find it when it opens the arm.
  static void rest(LiveBoard& arm) {
    arm.hold([home = arm.home()](double) { return home; });
  }
  /// Moves the tip 0.6 mm into the block and out of it again and again, at the speed of a hand. After a jump into
  /// contact, the hand has put in no energy, and the passivity controller would allow no force.
  void press() {
    board.hold([home = board.home()](double s) {
      const auto ease = [](double x) { return 0.5 * (1 - std::cos(kPi * std::clamp(x, 0.0, 1.0))); };
      const double in = std::fmod(s, kPeriod);                          // every two seconds …
      const double fraction = ease(in / 0.4) - ease((in - 1.4) / 0.2);  // … in for one of them, free for half of one
      return home - dvec3(0, 0, 3e-3 * ease(s / 0.5) + 1.6e-3 * fraction);
    });
  }

  /// Starts the program, also on machines that do not allow real-time priority.
  void start(const std::string& more = "", const std::string& environment = "") {
    child = folder.start(
        fmt::format("run {} --hand woodenhaptics:{},woody_patient --pedal none --audio none: --json --no-real-time {}",
                    folder / "scene.json", folder / "arm", more),
        environment);
    ASSERT_GT(child, 0);
    ASSERT_TRUE(gives_force()) << folder.said();
    press();
  }
  /// Returns true when the arm is open, free and armed. Then its motors hold up the arm's own weight.
  bool gives_force() const {
    return board.wait_for([this] { return board.current() > 0; });
  }
  /// Returns how often the program has reported the given words.
  int reports(std::string_view words) const {
    const std::string all = folder.said();
    int found = 0;
    for (std::size_t at = all.find(words); at != std::string::npos; at = all.find(words, at + 1)) ++found;
    return found;
  }
  /// Returns true if the program has lost the arm and has not found it again.
  virtual bool lost() { return reports("is disconnected") > reports("is back"); }
  /// Waits for a moment of contact: the motors push. On a busy machine, the board may be delayed for so long that the
  /// program rightly treats the arm as lost. Then the arm must lie in its home position until the program finds it.
  void wait_for_contact() {
    for (int i = 0; i < 20; ++i) {
      const bool contact = board.wait_for([this] { return pushing(); }, 10);
      if (!contact && lost()) {
        rest(board);
        ASSERT_TRUE(board.wait_for([this] { return !lost(); })) << folder.said();
        press();
        continue;
      }
      ASSERT_TRUE(contact) << "no contact\n" << folder.said();
      board.pass(1e-6 * static_cast<double>(random() % 200'000));  // at a random moment of it
      if (pushing()) return;
    }
    FAIL() << "contacts were all too short\n" << folder.said();
  }
  /// Watches the board for `seconds` of its own clock. Returns the longest time, by the machine's clock, in which the
  /// board got no command.
  Nanos longest_silence(double seconds) const {
    std::uint64_t told = board.lines();
    Nanos since = now(), longest = 0;
    board.wait_for(
        [&] {
          longest = std::max(longest, now() - since);
          if (board.lines() != told) told = board.lines(), since = now();
          return false;
        },
        seconds);
    return longest;
  }
  void expect_let_go() const { EXPECT_TRUE(board.lets_go()) << folder.said(); }
  /// Waits until the program has reported n times that the arm is back.
  void wait_until_back(int n) {
    ASSERT_TRUE(board.wait_for([&] { return reports("is back") >= n; })) << folder.said();
  }
  /// Unplugs the arm and puts it into its home position, from which it counts its angles.
  void unplug_and_rest() {
    board.unplug();
    rest(board);
    board.plug_in();
  }
  bool pushing() const { return board.current() > 0.5; }  // A; holding up its own arm takes less
  /// Asks it to end; what it printed.
  Json end() {
    const test::Ran ran = folder.finish(child);
    child = -1;
    EXPECT_EQ(ran.status, 0) << ran.err;
    return Json::parse(ran.out, "what run printed");
  }

  ProgramFolder folder;
  LiveBoard board;
  pid_t child = -1;
  std::mt19937 random{1};
};

TEST_F(LiveHands, WithMotorsNeedRealTimePriorityOrTheUsersConsent) {
  // Root would be granted it all the same.
  const std::string refused = std::string("prlimit --rtprio=0:0 ") +
                              (::geteuid() == 0 ? "setpriv --bounding-set=-sys_nice --inh-caps=-sys_nice" : "");
  child =
      folder.start("run {}/scene.json --hand woodenhaptics:{}/arm,woody_patient --pedal none --audio none:", refused);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  child = -1;
  EXPECT_EQ(WEXITSTATUS(status), 2);
  const std::string said = folder.said();
  for (const char* words : {"real time: found SCHED_FIFO refused", "typodont doctor", "--no-real-time"})
    EXPECT_NE(said.find(words), std::string::npos) << said;
  EXPECT_EQ(board.take_worst(), 0) << "not a moment of force";

  folder.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,0,1,0,0,0,0\n0.1,0,0,0,1,0,0,0,0\n");
  // A hand without motors needs no real-time priority.
  expect_ok(folder.run("run {}/scene.json --hand script:{}/hand.csv --audio none:", refused));

  start("", refused);
  wait_for_contact();
  const std::string note = end()["real_time"]["note"].string();
  EXPECT_NE(note.find("SCHED_FIFO refused"), std::string::npos) << note;
  expect_let_go();
}

TEST_F(LiveHands, GetForcesFromTheWholeProgramAndNoneAfterItsEnd) {
  start("--record " + (folder / "s.h5"));
  wait_for_contact();
  const Json ran = end();
  expect_let_go();
  EXPECT_LE(board.take_worst(), 3.0);
  EXPECT_GT(ran["jitter_us"]["p99_9"].number(), 0);
  EXPECT_GT(ran["motor_heat"].number(), 0);
  const session::SessionReader session(folder / "s.h5");
  ASSERT_TRUE(session.loop());
  EXPECT_EQ(session.loop()->timing.ticks, session.tick_count() + session.lost().ticks_ring);
  EXPECT_EQ(session.loop()->timing.jitter.total() + 1, session.loop()->timing.ticks);
  EXPECT_GT(session.loop()->timing.worst_tick, 0);
  EXPECT_EQ(session.header().vibration_band, 150);
  EXPECT_LT(session.ticks(0, 1).front().t, from_seconds(1));  // its time is the session's, not the computer's
}

TEST_F(LiveHands, TheWatchdogProcessOutlivesAKilledProcessAndSendsZero) {
  for (int i = 0; i < 3; ++i) {
    start();
    wait_for_contact();
    ::kill(child, SIGKILL);
    expect_let_go();
    ::waitpid(child, nullptr, 0);
    child = -1;
    unplug_and_rest();
  }
}

TEST_F(LiveHands, LeaveNoForceAfterATerminatingSignal) {
  for (const int signal : {SIGTERM, SIGHUP, SIGQUIT, SIGSEGV, SIGABRT}) {
    start();
    wait_for_contact();
    ::kill(child, signal);
    int status = 0;
    ::waitpid(child, &status, 0);
    child = -1;
    expect_let_go();
    board.pass(0.1);
    EXPECT_EQ(board.current(), 0) << signal;
    EXPECT_TRUE((signal != SIGSEGV && signal != SIGABRT) || (WIFSIGNALED(status) && WTERMSIG(status) == signal))
        << signal;
    unplug_and_rest();
  }
}

TEST_F(LiveHands, AReconnectedArmRampsInItsForceOnceItIsFreeAndTheRecordingReplaysExactly) {
  start("--record " + (folder / "s.h5"));
  for (int i = 1; i <= 2; ++i) {
    wait_for_contact();
    board.unplug();
    EXPECT_EQ(board.current(), 0);
    ::usleep(300'000);
    rest(board);  // where it is put, and where it counts from
    board.plug_in();
    wait_until_back(i);  // it lies still until then, or it would not be taken up
    board.take_worst();
    press();
    wait_for_contact();  // the motors push again
    EXPECT_LE(board.take_worst(), 3.0);
  }
  const Json ran = end();
  EXPECT_EQ(ran["faults"].integer() & bits(Fault::kDeviceLost), bits(Fault::kDeviceLost));
  EXPECT_NE(ran["safety"].string().find("device lost"), std::string::npos);
  const test::Ran replayed = expect_ok(folder.run("replay {}/s.h5 --check --json"));
  EXPECT_TRUE(Json::parse(replayed.out, "replay")["identical"].boolean());
}

TEST_F(LiveHands, FurtherProgramsAreToldThatTheArmIsInUseAndTheFirstContinues) {
  start();
  wait_for_contact();
  const std::string second_run =
      fmt::format("run {} --hand woodenhaptics:{},woody_patient --pedal none", folder / "scene.json", folder / "arm");
  // A machine that delays the board's reports for a tenth of a second makes the program lose the arm. Then nobody holds
  // the arm until the program has found it again, and the attempt does not count.
  test::Ran second;
  for (int attempt = 0; attempt < 5; ++attempt) {
    wait_for_contact();
    const int losses = reports("is disconnected");
    second = folder.run(second_run, "timeout 30");
    if (reports("is disconnected") == losses) break;
  }
  EXPECT_EQ(second.status, 2);
  EXPECT_NE(second.err.find("another program holds this device"), std::string::npos) << second.err;
  for (int refused = 0; refused < 1000;) {
    const int losses = reports("is disconnected");
    bool opened = true;
    try {
      haptics::open_serial(folder / "arm");
    } catch (const Error&) {
      opened = false;
      ++refused;
    }
    board.pass(1e-6 * static_cast<double>(random() % 6000));
    if (opened) board.wait_for([&] { return reports("is disconnected") > losses; }, 5);
    if (lost() || reports("is disconnected") > losses) {
      ASSERT_NO_FATAL_FAILURE(wait_for_contact());
    } else {
      ASSERT_FALSE(opened) << "opened a second time\n" << folder.said();
    }
  }
  wait_for_contact();
  EXPECT_LE(board.take_worst(), 3.0);
  end();
}

TEST_F(LiveHands, SettingTheWallClockIsNotFeltAndAMonotonicJumpSetsTheForceToZero) {
  test::LeapingClock clock(folder / "clock");
  start("--record " + (folder / "s.h5"), clock.environment(TYPODONT_STANDIN_CLOCK));
  for (const double hours : {1.0, -2.0, 48.0, -1.0}) {
    // If the machine stalls the program at this moment, the force also becomes zero. Then the board gets no command for
    // a long time, and the test tries again.
    Nanos silence = 0;
    for (int attempt = 0; attempt < 3; ++attempt) {
      wait_for_contact();
      clock.set_wall(3600 * (hours + 0.25 * attempt));
      silence = longest_silence(0.05);
      if (board.current() > 0 || silence < 10'000'000) break;
    }
    EXPECT_GT(board.current(), 0) << "silent for " << silence << " ns\n" << folder.said();
  }
  for (const double leap : {0.15, 2.0, -0.05, -1.0, 30.0, -20.0}) {
    wait_for_contact();
    clock.leap(leap);
    expect_let_go();
  }
  wait_for_contact();
  EXPECT_LE(board.take_worst(), 3.0);
  const std::string safety = end()["safety"].string();
  EXPECT_TRUE(safety.find("clock") != std::string::npos || safety.find("watchdog") != std::string::npos) << safety;
  EXPECT_EQ(folder.run("replay {}/s.h5 --check").status, 0);
}

/// Runs the program within this process, so that the test can reach its threads.
class LiveBench : public LiveHands {
 protected:
  LiveBench() {
    // The messages of the session go into the file from which folder.said() reads them.
    stderr = std::fopen((folder / ".started_err").c_str(), "w");
    std::setvbuf(stderr, nullptr, _IONBF, 0);
    WorkbenchOptions options;
    options.rig = folder.write("rig.json", R"({"display": "offscreen"})");
    options.hand = "woodenhaptics:" + (folder / "arm") + ",woody_patient";
    options.pedal = "none";
    options.audio = "none:";
    options.no_real_time = true;
    bench.emplace(read_scene(folder / "scene.json"), options);
    bench->start();
  }
  ~LiveBench() override {
    bench.reset();
    std::fclose(std::exchange(stderr, standard_error));
  }
  /// The session reports that the arm is lost only in its steps, which these tests leave out while they wait.
  bool lost() override {
    EXPECT_TRUE(bench->step());
    return LiveHands::lost();
  }
  std::FILE* const standard_error = stderr;
  std::optional<Workbench> bench;
};

TEST_F(LiveBench, TheEmergencyKeyAndAnInterfaceThatHangsLeaveTheHandSafe) {
  ASSERT_TRUE(gives_force());
  press();
  wait_for_contact();
  // Now the interface hangs: nothing calls the session's steps. The servo must not notice it.
  board.pass(kPeriod);
  wait_for_contact();
  bench->hold(true);
  expect_let_go();
  board.pass(1.5 * kPeriod);  // through a whole stretch of freedom and contact
  EXPECT_EQ(board.current(), 0);
  bench->hold(false);
  wait_for_contact();
  const WorkbenchSummary summary = bench->stop();
  expect_let_go();
  EXPECT_NE(summary.loop.safety & bits(SafetyEvent::kEmergency), 0u);
}

// A signal handler can stop a thread at any of its instructions.
const LiveBoard* watched = nullptr;
std::atomic<bool> frozen_for_ever{false};
std::atomic<Nanos> held_up{0};

TEST_F(LiveBench, TheServoContinuesWhenTheInterfaceHangsAtARandomInstruction) {
  ASSERT_TRUE(gives_force());
  press();
  wait_for_contact();
  watched = &board;
  struct sigaction action {};
  // The handler waits until the servo has sent three more commands. It gives up if the servo never does.
  action.sa_handler = [](int) {
    const std::uint64_t seen = watched->lines();
    const double begin = watched->time();
    while (watched->lines() < seen + 3) {
      if (watched->time() - begin > 20) {
        frozen_for_ever = true;
        return;
      }
      const timespec pause{0, 200'000};
      ::nanosleep(&pause, nullptr);
    }
  };
  action.sa_flags = SA_RESTART;
  ::sigaction(SIGUSR1, &action, nullptr);
  std::atomic<int> hangs{0};
  const pthread_t interface = ::pthread_self();
  std::thread troublemaker([&] {
    for (; hangs < 1000 && !frozen_for_ever; ++hangs) {
      ::pthread_kill(interface, SIGUSR1);
      ::usleep(static_cast<useconds_t>(random() % 10'000));
    }
  });
  while (hangs < 1000 && !frozen_for_ever) ASSERT_TRUE(bench->step());
  troublemaker.join();
  EXPECT_FALSE(frozen_for_ever);
  wait_for_contact();
  EXPECT_LE(board.take_worst(), 3.0);
  bench->stop();
  expect_let_go();
}

TEST_F(LiveBench, ADelayedServoLosesItsForceUntilTheHandIsFree) {
  ASSERT_TRUE(gives_force());
  press();
  pid_t servo = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    if (test::read_text(task.path() / "comm") == "typodont-servo\n") servo = std::stoi(task.path().filename().string());
  }
  ASSERT_GT(servo, 0);
  struct sigaction action {};
  action.sa_handler = [](int) {
    const timespec pause{0, held_up.load()};
    ::nanosleep(&pause, nullptr);
    held_up = 0;
  };
  action.sa_flags = SA_RESTART;
  ::sigaction(SIGUSR2, &action, nullptr);
  for (int i = 0; i < 6; ++i) {
    wait_for_contact();
    held_up = 1'000'000 * (40 + static_cast<Nanos>(random() % 460));
    ASSERT_EQ(::syscall(SYS_tgkill, ::getpid(), servo, SIGUSR2), 0);
    expect_let_go();
    EXPECT_TRUE(board.wait_for([] { return held_up == 0; }));
    // The arm is back, and still in contact. It is armed only when it is free, so its motors may not push yet;
    // afterwards they hold up the arm's own weight.
    EXPECT_FALSE(board.wait_for([this] { return pushing(); }, 0.03));
  }
  wait_for_contact();
  EXPECT_LE(board.take_worst(), 3.0);
  const WorkbenchSummary summary = bench->stop();
  expect_let_go();
  EXPECT_NE(summary.loop.safety & bits(SafetyEvent::kWatchdog), 0u);
}

/// A second arm holds the mouth mirror and moves to and fro while the first arm presses on the block.
TEST_F(LiveHands, WithAMirrorInASecondArmAreRecordedOnTheSameClock) {
  LiveBoard other(folder.path() / "other", haptics::read_arm("assets/devices/woody.json"));
  start(fmt::format("--left-hand woodenhaptics:{},woody_patient --record {}", folder / "other", folder / "s.h5"));
  other.hold([home = other.home()](double t) { return home + dvec3(0, 5e-3 * std::sin(3 * t), 0); });
  wait_for_contact();
  other.pass(2.5);                  // to and fro
  EXPECT_LT(other.current(), 0.5);  // A: its motors only hold up the arm's own weight
  end();
  const session::SessionReader session(folder / "s.h5");
  ASSERT_EQ(session.header().streams.size(), 1u);
  EXPECT_EQ(session.header().streams[0].name, "left_hand");
  const session::StreamData& left = session.streams()[0];
  ASSERT_GT(left.t.size(), 500u);
  const auto ticks = session.ticks();
  EXPECT_LT(std::abs(left.t.back() - ticks.back().t), from_seconds(1));
  double least = 1, most = -1;
  for (const double y : left.columns[1]) least = std::min(least, y), most = std::max(most, y);
  EXPECT_GT(most - least, 4e-3);
}

}  // namespace
}  // namespace typodont
