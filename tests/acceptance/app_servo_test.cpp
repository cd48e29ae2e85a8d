// Tests `typodont servo`, `replay`, `mesh` and `run` with analytic scenes, through the command line.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "engine/base/json.h"
#include "engine/base/units.h"
#include "engine/session/ticks_csv.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using namespace test;
using testing::HasSubstr;

constexpr const char* kHeader = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";

std::string sphere_scene(const std::string& more = "") {
  return R"({"name": "sphere", "tissue": {"voxel_mm": 0.1, "solids": [
    {"tissue": "enamel", "solid": {"sphere": {"radius_mm": 4}}}]},
    "tool": {"shape": "sphere", "diameter_mm": 1.0}, "spindle_krpm": 300, "friction": false)" +
         more + "}";
}

/// Moves straight down onto the top of the sphere, half a millimetre deep, then to the side.
std::string slide() {
  std::string csv = kHeader;
  for (int i = 0; i <= 100; ++i) csv += fmt::format("{},0,0,{},1,0,0,0,0\n", i * 0.01, 6 - i * 0.02);
  for (int i = 1; i <= 100; ++i) {
    const double a = i * 0.01;
    csv += fmt::format("{},{},0,{},1,0,0,0,0\n", 1 + i * 0.01, 4 * std::sin(a), 4 * std::cos(a));
  }
  return csv;
}

std::string drill_scene(const std::string& more = "") {
  return R"({"name": "block", "tissue": {"voxel_mm": 0.1, "solids": [
    {"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 4]}}}]},
    "tool": {"shape": "sphere", "diameter_mm": 1.2}, "spindle_krpm": 300)" +
         more + "}";
}

std::string press(const ProgramFolder& folder, double newton, double seconds = 1) {
  folder.write("path.csv", fmt::format("{}0,0,0,2.65,1,0,0,0,1\n{},0,0,2.65,1,0,0,0,1\n", kHeader, seconds));
  return folder.write("hand.json", fmt::format(R"({{"path": "path.csv", "mass_kg": 0.15, "damping_Ns_per_m": 5,
    "stiffness_N_per_m": [2000, 2000, 0], "push_N": [0, 0, {}]}})",
                                               -newton));
}

TEST(ServoCommand, ASessionThatNeedsOnlyHapticsLoadsFewerThanTwentyLibrariesAndNeedsAtMost60MB) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write("scene.json", sphere_scene());
  folder.write("hand.csv", slide());
  const Ran ran =
      expect_ok(folder.run("servo {}/scene.json --hand {}/hand.csv --out {}/ticks.csv", "env LD_DEBUG=files"));
  int loaded = 0;
  for (std::size_t at = 0; (at = ran.err.find("generating link map", at)) != std::string::npos; ++at) ++loaded;
  EXPECT_GT(loaded, 5) << ran.err;
  EXPECT_LT(loaded, 20) << ran.err;
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  rusage children{};
  getrusage(RUSAGE_CHILDREN, &children);
  EXPECT_LT(children.ru_maxrss, 60'000) << "kilobytes";
#endif
}

TEST(ServoCommand, ForceOnASphereIsStiffnessTimesDepthAlongTheRadius) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write("scene.json", sphere_scene());
  folder.write("hand.csv", slide());
  const Ran ran = expect_ok(folder.run("servo {}/scene.json --hand {}/hand.csv --out {}/ticks.csv --json"));
  EXPECT_EQ(Json::parse(ran.out, "out")["faults"].integer(), 0);
  const auto ticks = session::read_ticks_csv(folder / "ticks.csv");
  ASSERT_EQ(ticks.size(), 2001u);
  for (std::size_t i = 1200; i < ticks.size(); ++i) {
    const dvec3 p = ticks[i].X_WT.p, u = glm::normalize(p), f = ticks[i].f_T_W;
    EXPECT_NEAR(glm::length(f), 1000 * (4.5e-3 - glm::length(p)), 5e-4) << i;
    EXPECT_LT(glm::length(glm::cross(glm::normalize(f), u)), std::sin(0.02 * kDegree)) << i;
  }
}

TEST(ServoCommand, TheSameInputAndTheHandOfItsRecordingGiveTheSameBytes) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write("scene.json", drill_scene());
  press(folder, 1.0);
  const auto run = [&](const std::string& hand, const char* out) {
    expect_ok(folder.run("servo {}/scene.json --no-timing --hand " + hand + " --out {}/" + out));
  };
  run(folder / "hand.json", "a.csv");
  run(folder / "hand.json", "s.h5");
  run("replay:" + (folder / "s.h5"), "b.csv");
  EXPECT_EQ(read_text(folder / "a.csv"), read_text(folder / "b.csv"));
}

// Each motor of assets/motors/ is started in the air, then pressed on the material for which it is made.
TEST(ServoCommand, RemovalFollowsTheTorqueSpeedLineOfEveryMotorAndEqualsTheWorkOfMotorAndRotor) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  struct Run {
    const char *motor, *tissue, *tool;
    double free_krpm, held_Nmm, stall_Nmm, run_up_s, energy_J_per_mm3, radius_mm, half_mm, cut_s;
  };
  constexpr const char* kBall = R"({"shape": "sphere", "diameter_mm": 1.4})";
  constexpr const char* kBone = R"({"shape": "round_end_cylinder", "diameter_mm": 2.2, "length_mm": 6})";
  constexpr const char* kCylinder = R"({"shape": "cylinder", "diameter_mm": 0.9, "length_mm": 3})";
  for (const Run& run : {Run{"air_turbine", "enamel", kBall, 350, 0, 1.6, 0.25, 30, 0.7, 0.7, 1.0},
                         Run{"electric_1_5", "dentin", kCylinder, 200, 2.8, 6.0, 0.15, 8, 0.45, 1.5, 0.6},
                         Run{"implant", "cortical_bone", kBone, 0.8, 0, 500, 0.1, 3, 1.1, 3, 2.0}}) {
    for (const double newton : {0.7, 1.3, 2.2}) {
      folder.write("scene.json",
                   fmt::format(R"({{"tissue": {{"voxel_mm": 0.1, "solids": [{{"tissue": "{}", "solid": {{"box":
          {{"center_mm": [0, 0, -2.5], "size_mm": [5, 5, 5]}}}}}}]}}, "tool": {}, "spindle": "{}"}})",
                               run.tissue, run.tool, run.motor));
      constexpr double kPressed = 3.5, kSettled = 1;  // s
      const double end = kPressed + kSettled + run.cut_s, top = run.half_mm + 0.02;
      folder.write(
          "path.csv",
          fmt::format("t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal,push_z_N\n0,0,0,{0},1,0,0,0,1,0\n{1},0,0,{0},1,0,0,0,1,0\n"
                      "{2},0,0,{0},1,0,0,0,1,{3}\n{4},0,0,{0},1,0,0,0,1,{3}\n",
                      top, kPressed, kPressed + 0.01, -newton, end));
      folder.write(
          "hand.json",
          R"({"path": "path.csv", "mass_kg": 0.15, "damping_Ns_per_m": 5, "stiffness_N_per_m": [2000, 2000, 0]})");
      expect_ok(folder.run("servo {}/scene.json --hand {}/hand.json --out {}/t.csv"));
      // The rotor needs run_up_s to reach its speed, and gives its energy back while it slows down.
      const double inertia = run.stall_Nmm * 1e-3 * run.run_up_s / (run.free_krpm * kKrpm);  // kg·m²
      double work = 0.5 * inertia * std::pow(run.free_krpm * kKrpm, 2);                      // J
      double at_first = 0, removed = 0, speed = 0;                                           // mm³, rad/s
      for (const ServoTick& tick : session::read_ticks_csv(folder / "t.csv")) {
        const double t = to_seconds(tick.t), krpm = tick.spindle / kKrpm;
        speed = tick.spindle;
        removed = total(tick.removed) / kCubicMillimetre;
        if (t < kPressed + kSettled) at_first = removed;
        if (t >= kPressed) work += run.stall_Nmm * 1e-3 * (1 - krpm / run.free_krpm) * tick.spindle * 1e-3;
      }
      work -= 0.5 * inertia * speed * speed;
      const double torque = 0.3 * newton * run.radius_mm;  // N·mm
      const double over = std::max(0.0, torque - run.held_Nmm);
      const double power = torque * 1e-3 * (1 - over / (run.stall_Nmm - run.held_Nmm)) * run.free_krpm * kKrpm;
      EXPECT_NEAR((removed - at_first) * run.energy_J_per_mm3 / (power * run.cut_s), 1, 0.03)
          << run.motor << " " << newton;
      // A held speed says nothing about the torque.
      if (run.held_Nmm == 0) {
        EXPECT_NEAR(removed * run.energy_J_per_mm3 / work, 1, 0.01) << run.motor << " " << newton;
      }
    }
  }
}

std::string tray_scene() {
  return R"({"name": "tray", "tissue": {"voxel_mm": 0.1, "solids": [
    {"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 4]}}}]},
    "tools": ["round_012", "cylinder_010", "explorer"], "spindle_krpm": 300})";
}

/// Cuts with the round bur, lifts, changes to the cylinder, cuts beside it, lifts, probes with the explorer.
std::string tray_path() {
  return R"(t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal,tool
0,0,0,2.8,1,0,0,0,1,round_012
0.2,0,0,2.4,1,0,0,0,1,round_012
0.3,0,0,6,1,0,0,0,0,cylinder_010
0.4,1.5,0,6,1,0,0,0,0,1
0.5,1.5,0,4.1,1,0,0,0,1,1
0.8,1.5,0,3.8,1,0,0,0,1,1
0.9,1.5,0,6,1,0,0,0,0,explorer
1.0,-1.5,0,6,1,0,0,0,0,explorer
1.1,-1.5,0,2.0,1,0,0,0,0,explorer
)";
}

/// Records hand.csv of the folder in scene.json, replays the recording, and returns the ticks of its hand, which
/// includes the tools, in the same scene.
std::vector<ServoTick> ticks_of_replayed_hand(ProgramFolder& folder) {
  Ran ran = expect_ok(folder.run("servo {}/scene.json --hand {}/hand.csv --out {}/s.h5"));
  ran = folder.run("replay {}/s.h5 --check --json");
  EXPECT_EQ(ran.status, 0) << ran.err << ran.out;
  EXPECT_TRUE(Json::parse(ran.out, "out")["identical"].boolean());
  ran = folder.run("servo {}/scene.json --hand replay:{}/s.h5 --out {}/u.csv");
  EXPECT_EQ(ran.status, 0) << ran.err;
  return session::read_ticks_csv(folder / "u.csv");
}

TEST(ServoCommand, AHandChangesToolsByNameAndByNumberAndTheReplayIsExact) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write("scene.json", tray_scene());
  folder.write("hand.csv", tray_path());
  expect_ok(folder.run("servo {}/scene.json --hand {}/hand.csv --out {}/t.csv"));
  const auto ticks = session::read_ticks_csv(folder / "t.csv");
  ASSERT_EQ(ticks.size(), 1101u);
  EXPECT_EQ(ticks[200].tool, 0u);
  EXPECT_EQ(ticks[500].tool, 1u);
  EXPECT_EQ(ticks[1100].tool, 2u);
  EXPECT_GT(glm::length(ticks[1100].f_T_W), 0.01);  // the explorer's tip of 0.125 mm is on the block
  EXPECT_EQ(ticks_of_replayed_hand(folder).at(1100).tool, 2u);
}

/// Two equal diamonds; dentin wears them.
std::string grinding_scene(const std::string& ratio) {
  return R"({"name": "block", "tissue": {"voxel_mm": 0.1, "solids": [
    {"tissue": "dentin", "solid": {"box": {"size_mm": [8, 6, 4]}}}]},
    "tools": ["round_end_cylinder_012", "round_end_cylinder_012"], "spindle": "air_turbine",
    "materials": {"dentin": {"grit": {"grinding_ratio": )" +
         ratio + "}}}}";
}

TEST(ServoCommand, AWornBurCutsSlowerANewOneDoesNotAndTheReplayHasTheSameBits) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  // Each bur lies on its side and is pressed into the block for a second.
  std::string csv = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal,tool\n";
  for (const auto& [t, x, tool] : {std::tuple{0.0, -2.0, 0}, {4.0, 2.0, 1}})
    for (const auto& [after, z, pedal] :
         {std::tuple{0.0, 6.0, 0}, {1.0, 6.0, 0}, {1.01, 6.0, 1}, {2.0, 2.6, 1}, {3.0, 1.6, 1}, {3.1, 6.0, 0}})
      csv += fmt::format("{},{},0,{},0.7071067811865476,0.7071067811865476,0,0,{},{}\n", t + after, x, z, pedal, tool);
  folder.write("hand.csv", csv);
  folder.write("scene.json", grinding_scene("0.2"));
  folder.write("hard.json", grinding_scene("0"));
  for (const char* name : {"scene", "hard"}) {
    expect_ok(folder.run(fmt::format("servo {{}}/{0}.json --hand {{}}/hand.csv --out {{}}/{0}.csv", name)));
  }
  const auto worn = session::read_ticks_csv(folder / "scene.csv"), sharp = session::read_ticks_csv(folder / "hard.csv");
  ASSERT_EQ(worn[5000].tool, 1u);
  EXPECT_GT(worn[3000].wear, 0.2);
  EXPECT_EQ(worn[5500].wear, 0);
  EXPECT_GT(worn[7000].wear, 0.2) << "the second bur";
  EXPECT_LT(total(worn[3000].removed), 0.95 * total(sharp[3000].removed));
  EXPECT_EQ(sharp[7000].wear, 0);

  EXPECT_EQ(ticks_of_replayed_hand(folder).at(7000).wear, worn[7000].wear);
  folder.write("bad.json", grinding_scene("-1"));
  const Ran ran = folder.run("servo {}/bad.json --hand {}/hand.csv --out {}/v.csv");
  EXPECT_EQ(ran.status, 2);
  EXPECT_THAT(ran.err, testing::AllOf(HasSubstr("grinding_ratio"), HasSubstr("0 to 1")));
}

TEST(ServoCommand, AToolThatTheSceneLacksIsRefusedWithTheListOfItsTools) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write("scene.json", tray_scene());
  for (const char* tool : {"flame_012", "3", "-1", "1.5", ""}) {
    folder.write("hand.csv", fmt::format("t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal,tool\n0,0,0,9,1,0,0,0,0,{}\n", tool));
    const Ran ran = expect_exit(folder.run("servo {}/scene.json --hand {}/hand.csv --out {}/t.csv"), 2,
                                "round_012, cylinder_010, explorer");
    EXPECT_THAT(ran.err, HasSubstr("line 2, column tool")) << tool;
  }
}

TEST(LiveSession, WithAnIntermediateSurfaceReplaysBitForBit) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write("scene.json", drill_scene(R"(, "model": {"offset": {"intermediate_surface": {}}})"));
  std::int64_t cuts = 0;
  for (int seconds = 1; seconds <= 64 && cuts <= 50; seconds *= 4) {
    // On a busy machine, the carver thread gets little processor time and makes few cuts in a second. The test then
    // repeats the session with four times its duration.
    press(folder, 1.0, seconds);
    const Ran live = expect_ok(folder.run("run {}/scene.json --hand script:{}/hand.json --record {}/s.h5 --json",
                                          "env -u DISPLAY -u WAYLAND_DISPLAY timeout 240"));
    cuts = Json::parse(live.out, "out")["cuts"].integer();
    expect_ok(folder.run("replay {}/s.h5 --check --json"));
  }
  EXPECT_GT(cuts, 50);
}
TEST(RunCommand, TerminatingTheProgramSavesTheRecording) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write("scene.json", drill_scene());
  folder.write("hand.csv", std::string(kHeader) + "0,0,0,4,1,0,0,0,0\n600,0,0,4,1,0,0,0,0\n");
  GrowingFile recording(folder / "s.h5");
  const Ran live = folder.interrupted("run {}/scene.json --hand script:{}/hand.csv --record {}/s.h5", SIGTERM,
                                      [&] { return recording.has_grown(); });
  EXPECT_EQ(live.status, 0) << live.err;
  const Ran ran = expect_ok(folder.run("replay {}/s.h5 --check --json"));
  const Json json = Json::parse(ran.out, "out");
  EXPECT_GT(json["ticks"].integer(), 0);
  EXPECT_FALSE(json["truncated"].boolean());
}

#ifdef TYPODONT_WINDOW
TEST(RunCommand, OnADesktopItOpensAWindowWithTheMouseAsHandAndDrawsOnlyOnMotion) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write(
      "scene.json",
      R"({"tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "dentin", "solid": {"sphere": {"center_mm": [7,6,15], "radius_mm": 5}}}]},
    "tool": "round_012", "spindle_krpm": 300, "parts": ["haptics", "render"]})");
  const Ran live =
      expect_ok(folder.run("run {}/scene.json --seconds 4 --record {}/s.h5 --json", "xvfb-run -a timeout 120"));
  const Json json = Json::parse(live.out, "out");
  EXPECT_GT(json["ticks"].integer(), 2000);
  EXPECT_GE(json["frames"].integer(), 1);
  EXPECT_LT(json["frames"].integer(),
            // the mouse rests, so there is one frame when the tooth appears and a few frames while the hand settles
            60);
  EXPECT_EQ(folder.run("replay {}/s.h5 --check").status, 0);
}

TEST(RunCommand, AScenesOwnWindowIsUsedUnlessTheUserNamesARig) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write(
      "scene.json",
      R"({"tissue": {"voxel_mm": 0.5, "solids": [{"tissue": "cortical_bone", "solid": {"sphere": {"center_mm": [0,0,-12], "radius_mm": 12}}}]},
    "tool": "round_012", "rig": "hip", "parts": ["haptics", "render"]})");
  const auto said = [&](const std::string& options) {
    const Ran live =
        expect_ok(folder.run("run {}/scene.json --seconds 1 --explain" + options, "xvfb-run -a timeout 120"));
    return live.out + live.err;
  };
  EXPECT_THAT(said(""), testing::HasSubstr("rigs/hip_window.json"));
  EXPECT_THAT(said(" --rig window"), testing::HasSubstr("rigs/window.json"));
}

TEST(RunCommand, FollowsTheTrackedHeadAndCountsInvalidPackets) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write(
      "scene.json",
      R"({"tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "dentin", "solid": {"sphere": {"center_mm": [0,0,0], "radius_mm": 5}}}]},
    "tool": "round_012", "parts": ["haptics", "render"]})");
  const int port = 24300 + getpid() % 1000;
  folder.write("rig.json", fmt::format(R"({{"display": "window", "screen": {{"corners_mm": {{"lower_left": [-20,-15,0],
    "lower_right": [20,-15,0], "upper_left": [-20,15,0]}}, "pixels": [320,240], "layout": "mono"}},
    "head": {{"eye_center_mm": [0,0,400], "tracker": "opentrack:{}"}}}})",
                                       port));
  std::jthread tracker([&](const std::stop_token& stop) {
    const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    for (int i = 0; !stop.stop_requested(); ++i) {
      const double head[6] = {5 * std::sin(0.05 * i), 0, 0, 0, 0, 0};  // cm; this machine is little-endian, too
      // Every tenth packet is one byte too short.
      ::sendto(socket, head, i % 10 ? sizeof head : sizeof head - 1, 0, reinterpret_cast<const sockaddr*>(&to),
               sizeof to);
      std::this_thread::sleep_for(std::chrono::milliseconds(8));
    }
    ::close(socket);
  });
  std::int64_t samples = 0, dropped = 0, frames = 0;
  for (int seconds = 4; seconds <= 64 && (samples <= 100 || dropped <= 5 || frames <= 20); seconds *= 4) {
    // On a busy machine, a frame can take a second. The test then repeats the session with four times its duration.
    const Ran live =
        expect_ok(folder.run(fmt::format("run {{}}/scene.json --rig {{}}/rig.json --seconds {} --json", seconds),
                             "xvfb-run -a timeout 240"));
    const Json json = Json::parse(live.out, "out");
    samples = json["head_tracker"]["samples"].integer();
    dropped = json["head_tracker"]["dropped"].integer();
    frames = json["frames"].integer();
  }
  EXPECT_GT(samples, 100);
  EXPECT_GT(dropped, 5);
  EXPECT_GT(frames, 20) << "the head moves: so does the picture";
}
#endif

TEST(RunCommand, WithoutADesktopOrAHandItSaysWhatIsMissing) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write("scene.json", drill_scene());
  expect_exit(folder.run("run {}/scene.json", "env -u DISPLAY -u WAYLAND_DISPLAY timeout 20"), 2, "--hand");
}

}  // namespace
}  // namespace typodont
