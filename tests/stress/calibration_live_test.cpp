// Tests `typodont calibrate guide arm` with an emulated arm on a pseudo-terminal, in real time. The arm has errors in
// its links, joints and scales and is held in sockets. Enter takes each touch. The result must be this arm.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>

#include "calibration/bench_simulator.h"
#include "calibration/rig_file.h"
#include "engine/base/json.h"
#include "engine/base/units.h"
#include "tests/support/emulation/live_board.h"
#include "tests/support/program.h"

namespace typodont::calibration {
namespace {

using testing::HasSubstr;

/// Returns the number of touches for which a test run has time. TYPODONT_ARM_TOUCHES=170 tests the whole step.
std::size_t touches() {
  const char* asked = std::getenv("TYPODONT_ARM_TOUCHES");
  return asked ? std::strtoul(asked, nullptr, 10) : 40;
}

class LiveArm : public testing::Test {
 protected:
  LiveArm() : folder(TYPODONT_PROGRAM) {
    // A Woody arm with encoders on its stylus. Its watchdog waits as long as is allowed, because the machine may be
    // busy.
    std::string preset = test::read_text("assets/devices/woody.json");
    preset.insert(preset.find('{') + 1, "\"silence_ms\": 20,");
    const std::string bare = "[2000, 2000, 2000, 0, 0, 0]";
    preset.replace(preset.find(bare), bare.size(), "[2000, 2000, 2000, 8192, 8192, 8192]");
    board.emplace(folder.path() / "arm", haptics::read_arm(folder.add_device("woody_stylus", preset)));
  }
  ~LiveArm() override {
    if (child > 0) ::kill(child, SIGKILL), ::waitpid(child, nullptr, 0);
    if (keys >= 0) ::close(keys);
  }

  void start(const std::string& command) {
    int ends[2];
    ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
    const std::string out = folder / "out.txt", err = folder / "err.txt";
    const std::string line = fmt::format("exec {} {}", TYPODONT_PROGRAM, command);
    child = ::fork();
    if (child == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      ::dup2(ends[0], 0);
      ::dup2(::open(out.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600), 1);
      ::dup2(::open(err.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600), 2);
      ::execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
      ::_exit(127);
    }
    ::close(ends[0]);
    keys = ends[1];
  }
  void type(const std::string& text) {
    // If the program has ended, write() must fail. Without this line, the signal would end the test without a message.
    ::signal(SIGPIPE, SIG_IGN);
    ASSERT_EQ(::write(keys, text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  std::string said() const { return test::read_text(folder / "out.txt"); }
  bool wait_for(const std::string& text, double seconds) const {
    for (int i = 0; i < seconds * 100; ++i) {
      if (said().find(text) != std::string::npos) return true;
      ::usleep(10'000);
    }
    return false;
  }

  /// Moves the arm from its present angles to these angles in 0.12 s, as a hand would move it.
  void move_to(const ArmReading& next) {
    const auto from = at;
    board->with([&](test::EmulatedArm& arm) {
      const double began = clock;
      const auto fraction = [this, began] {
        return 0.5 * (1 - std::cos(kPi * std::clamp((clock - began) / 0.12, 0.0, 1.0)));
      };
      arm.hand = [this, from, next, fraction](double t) {
        clock = t;
        dvec3 q;
        for (int i = 0; i < 3; ++i)
          q[i] = std::lerp(from[static_cast<std::size_t>(i)], next.angle[static_cast<std::size_t>(i)], fraction());
        return q;
      };
      arm.stylus = [from, next, fraction](double) {
        dvec3 q;
        for (std::size_t i = 3; i < 6; ++i) q[static_cast<int>(i) - 3] = std::lerp(from[i], next.angle[i], fraction());
        return q;
      };
    });
    at = next.angle;
  }

  test::ProgramFolder folder;
  std::optional<test::LiveBoard> board;
  double clock = 0;                                    // s, of the emulated board; its thread's
  std::array<double, 6> at{0, 0, 0.5 * kPi, 0, 0, 0};  // at home, where the program must find it
  pid_t child = -1;
  int keys = -1;
};

TEST_F(LiveArm, AnArmHeldInSocketsIsCapturedLiveAndSolved) {
  SimulationOptions options;
  options.seed = 5, options.slipped = 0, options.touch_noise = 5e-5;
  BenchSimulator simulator(options);
  const BenchState drawn = simulator.drawings();
  {
    RigFile rig = RigFile::create(folder.path() / "rig.json");
    rig.set(drawn);
    rig.save();
  }
  Captures planned;
  const Pose plates[2] = {{{-0.08, -0.06, 0.02}, glm::normalize(dquat(1, -0.5, 0.05, 0.02))},
                          {{-0.08, -0.06, -0.02}, glm::normalize(dquat(1, -0.2, 0.2, 0.1))}};
  for (std::size_t k = 0; k < touches(); ++k) {
    const dvec3 sockets[4] = {{-0.08, -0.06, 0.0}, {0.08, -0.06, 0.04}, {0, 0.05, -0.05}, {0.02, -0.02, 0.09}};
    const dvec3 known(0.04 * static_cast<double>(k % 5), 0.04 * static_cast<double>((k + 5) / 5 % 5), 0);
    const dvec3 p_W = k < 120 ? sockets[k / 30] : plates[(k - 120) / 25] * known;
    planned.arm.push_back({static_cast<int>(k / 30), std::nullopt, *simulator.touch(p_W, drawn.arm).reading});
  }

  start(fmt::format("calibrate guide arm --rig {} --hand woodenhaptics:{},woody_stylus --pedal none --no-window",
                    folder / "rig.json", folder / "arm"));
  ASSERT_TRUE(wait_for("Hold the tip in socket 1", 60)) << test::read_text(folder / "err.txt");
  ::usleep(500'000);
  for (std::size_t k = 0; k < touches(); ++k) {
    move_to(planned.arm[k].reading);
    bool taken = false;
    for (int attempt = 0; attempt < 40 && !taken; ++attempt) {
      ::usleep(attempt == 0 ? 260'000 : 150'000);
      if (said().find(fmt::format("touch {}:", k + 1)) == std::string::npos) type("\n");
      taken = wait_for(fmt::format("touch {}:", k + 1), 0.5);
    }
    ASSERT_TRUE(taken) << k << "\n" << said() << test::read_text(folder / "err.txt");
  }
  if (touches() < 170) type("done\n");
  int status = 0;
  ::waitpid(child, &status, 0);
  child = -1;
  ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << said() << test::read_text(folder / "err.txt");
  EXPECT_THAT(said(), HasSubstr("mm rms before"));
  EXPECT_THAT(said(), HasSubstr("not observable"));

  // The captured angles must equal the angles at which the arm was held, up to the encoders' resolution. The solved
  // geometry must explain the touches far better than the drawings.
  const auto captures = read_captures(RigFile::load(folder.path() / "rig.json").captures_folder()).arm;
  ASSERT_EQ(captures.size(), touches());
  for (std::size_t k = 0; k < captures.size(); ++k) {
    for (std::size_t i = 0; i < 6; ++i)
      EXPECT_NEAR(captures[k].reading.angle[i], planned.arm[k].reading.angle[i], 1e-3) << k << " " << i;
  }
  const ArmGeometry solved = RigFile::load(folder.path() / "rig.json").bench().arm;
  double before = 0, after = 0;
  for (int socket = 0; socket < 2; ++socket) {
    for (const auto& [arm, sum] : {std::pair{drawn.arm, &before}, std::pair{solved, &after}}) {
      std::vector<dvec3> tips;
      for (const ArmCapture& c : captures) {
        if (c.group == socket) tips.push_back(tip_position(arm, c.reading));
      }
      dvec3 middle(0);
      for (const dvec3& p : tips) middle += p / static_cast<double>(tips.size());
      for (const dvec3& p : tips) *sum += glm::dot(p - middle, p - middle);
    }
  }
  EXPECT_LT(after, 0.1 * before);
  EXPECT_LT(std::sqrt(after / static_cast<double>(touches())), 0.4e-3);
}

}  // namespace
}  // namespace typodont::calibration
