// Tests what the hand feels while it drills, through the command line. A simulated hand of 0.15 kg with a damping of 5
// N·s/m oscillates by 2 mm to each side once per second and pushes down. Its force must have no steps.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engine/base/json.h"
#include "engine/session/ticks_csv.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using namespace test;

struct Felt {
  double worst_step = 0;  // N per tick, after the first touch
  double removed = 0;     // mm³
  double max_force = 0;   // N
  double end_z_mm = 0;    // of the hand
  std::uint32_t faults = 0;
};

/// Runs the scene for `seconds`. The head starts at `start_mm`.
Felt drill(const std::string& scene, const dvec3& start_mm, double newton, double seconds, const std::string& more = "",
           double phase = 0) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write("scene.json", scene);
  std::string path = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";
  for (int i = 0; i <= static_cast<int>(seconds * 200); ++i) {
    const double t = i / 200.0;
    path += fmt::format("{},{},{},{},1,0,0,0,1\n", t, start_mm.x + 2 * std::sin(2 * std::numbers::pi * t + phase),
                        start_mm.y, start_mm.z);
  }
  folder.write("path.csv", path);
  folder.write("hand.json", fmt::format(R"({{"path": "path.csv", "mass_kg": 0.15, "damping_Ns_per_m": 5,
    "stiffness_N_per_m": [2000, 2000, 0], "push_N": [0, 0, {}]}})",
                                        -newton));
  expect_ok(folder.run("servo {}/scene.json --hand {}/hand.json --out {}/t.csv --rate 1000 " + more));
  const auto ticks = session::read_ticks_csv(folder / "t.csv");
  Felt felt;
  for (std::size_t i = 300; i < ticks.size(); ++i) {
    felt.worst_step = std::max(felt.worst_step, glm::length(ticks[i].f_T_W - ticks[i - 1].f_T_W));
    felt.max_force = std::max(felt.max_force, glm::length(ticks[i].f_T_W));
    felt.faults |= ticks[i].faults;
  }
  felt.end_z_mm = ticks.back().X_WT.p.z * 1e3;
  for (const double v : ticks.back().removed) felt.removed += v * 1e9;
  return felt;
}

std::string molar(const std::string& tool, const std::string& motor = "air_turbine") {
  std::string text = Json::load("assets/scenes/molar-caries.json").text();
  text.replace(text.find("air_turbine"), 11, motor);
  return text.replace(text.find("round_012"), 9, tool);
}

constexpr dvec3 kFissure{6.7, 5.8, 20.2};

TEST(Feel, DrillingTheMolarHasNoForceStepForAnyBurMotorForceAndPlaceNorAfterAStallOfTheCarver) {
  struct Run {
    const char *tool, *motor = "air_turbine";
    dvec3 start = kFissure;
    double newton = 1.5, phase = 0;
    bool stalls = false;
  };
  for (const Run& run : {Run{"round_012"}, Run{"round_006"}, Run{"cylinder_010"}, Run{"flame_012"}, Run{"pear_010"},
                         Run{.tool = "round_012", .stalls = true}, Run{.tool = "flame_012", .stalls = true},
                         Run{"round_018", "electric_1_5", {7.455, 6.074, 20.2}, 1.21, 6.157},
                         Run{"round_023", "electric_1_5", {6.3, 5.3, 20.2}, 1.9, 0.67, true},
                         Run{"round_006", "electric_1_5", {7.1, 5.9, 20.2}, 1.45, 5.38, true},
                         Run{"round_010", "air_turbine", {7.1, 6.6, 20.2}, 1.03, 0.241},
                         Run{"inverted_cone_012", "air_turbine", {5.7, 6.1, 20.2}, 1.8, 0.724},
                         Run{"cone_016", "electric_1_5", {6.7, 5.0, 20.2}, 1.55, 2.3}}) {
    const Felt felt = drill(molar(run.tool, run.motor), run.start, run.newton, 2.5,
                            run.stalls ? "--stall-carver-ms 200" : "", run.phase);
    EXPECT_LT(felt.worst_step, 0.02) << run.tool;
    EXPECT_GT(felt.max_force, 0.934 * run.newton) << run.tool;
    EXPECT_GT(felt.removed, 0.5) << run.tool;
    if (!run.stalls) {
      EXPECT_EQ(felt.faults, 0u) << run.tool;
    }
  }
}

TEST(Feel, BreakingThroughAHardShellOverASoftCoreGivesNoForceStep) {
  const std::string shell = R"({"tissue": {"voxel_mm": 0.1, "solids": [
    {"tissue": "enamel", "solid": {"box": {"size_mm": [8, 6, 1.2]}}},
    {"tissue": "caries", "solid": {"box": {"size_mm": [8, 6, 0.8]}}}]},
    "tool": {"shape": "sphere", "diameter_mm": 1.2, "end_efficiency": 0.6}, "spindle": "air_turbine"})";
  // The tool has only a head, because a shank that is wider than the slot would end the fall with a blow that is not
  // caused by the cut. The wall of the lower shell holds the bur for four to six seconds, depending on how it lies in
  // its slot.
  const Felt felt = drill(shell, {0, 0, 1.25}, 2.5, 9);
  EXPECT_LT(felt.worst_step, 0.02);
  EXPECT_GT(felt.removed, 1);
  EXPECT_LT(felt.end_z_mm, -5);  // the bur passed through
}

}  // namespace
}  // namespace typodont
