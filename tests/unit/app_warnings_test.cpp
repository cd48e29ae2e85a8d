// Warnings over the picture: when they come, how they fade, and that a replay shows those of the session.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <functional>

#include "engine/app/operator/session_scores.h"
#include "engine/app/picture/world.h"
#include "engine/app/recording.h"
#include "engine/app/recording/resume.h"
#include "engine/app/review/player.h"
#include "engine/app/stepped.h"
#include "engine/base/temporary_folder.h"
#include "engine/base/units.h"
#include "haptics/scripted_hand.h"

namespace typodont {
namespace {

using namespace literals;
using session::WarningLevels;

constexpr std::uint32_t kCylinder = 0, kBall = 1;  // tools of the scene
constexpr double kRadius = 0.6e-3;                 // m, of both tools
constexpr double kPulpTop = -2e-3;                 // m
constexpr const char* kScene = R"({"tissue": {"voxel_mm": 0.1, "solids": [
    {"tissue": "dentin", "solid": {"box": {"size_mm": [8, 8, 6], "center_mm": [0, 0, -3]}}},
    {"tissue": "pulp", "solid": {"box": {"size_mm": [3, 3, 2], "center_mm": [0, 0, -3]}}}]},
  "tools": [{"shape": "cylinder", "diameter_mm": 1.2, "length_mm": 4}, {"shape": "sphere", "diameter_mm": 1.2}],
  "spindle_krpm": 300, "parts": ["haptics", "render", "score"],
  "task": {"goal": "A box.", "ideal": {"remove": [{"box": {"size_mm": [3, 3, 1]}}]}, "rules": [
    {"name": "taper_deg", "tolerance": 8, "weight": 10}, {"name": "pulp_distance_mm", "target": 1, "tolerance": 0.5, "weight": 10},
    {"name": "force_mean_N", "target": 1, "tolerance": 1, "weight": 5},
    {"name": "force_max_N", "target": 2, "tolerance": 1, "weight": 5}]}})";

Scene box() {
  return parse_scene(Json::parse(kScene, "scene.json"), "scene.json");
}
Scene shipped(const char* name) {
  return read_scene(assets_folder() / "scenes" / name);
}
WarningLevels levels_of(const Scene& scene, double level) {
  WarningLevels levels;
  for (const WarningRule& rule : warning_rules(scene)) levels[rule.item] = level;
  return levels;
}

/// A tool that turns in contact, far from everything that a warning protects.
ServoTick safe(std::uint32_t tool) {
  ServoTick tick;
  tick.tool = tool;
  tick.X_WG.p = {0, 0, 80.0_mm};
  tick.spindle = 300 * kKrpm;
  tick.contact_area = 1e-8;
  return tick;
}
ServoTick at(std::uint32_t tool, const dvec3& p_W) {
  ServoTick tick = safe(tool);
  tick.X_WG.p = p_W;
  return tick;
}

/// Shows a world the tick for `seconds` at 1 kHz.
void show(World& world, ServoTick tick, double seconds) {
  const Nanos from = world.tick().t, end = from + from_seconds(seconds);
  for (tick.t = from; tick.t < end; tick.t += 1'000'000) world.apply(tick);
}

/// A case with a measure, whose value in a tick is given; the error begins when it exceeds `limit` in the direction of
/// `sign`.
struct Cause {
  Warning warning;
  std::function<ServoTick(double)> tick;
  double limit, margin, sign, resolution;
};

void expect_thresholds(const Scene& scene, const Cause& cause) {
  for (const double level : {0.0, 0.5, 1.0}) {
    World world(scene);
    world.add_warnings(load_tissue(scene), levels_of(scene, level));
    const double begins = cause.limit - cause.sign * level * cause.margin;
    SCOPED_TRACE(fmt::format("warning {}, level {}", static_cast<int>(cause.warning), level));
    show(world, cause.tick(begins - cause.sign * cause.resolution), 0.5);
    EXPECT_EQ(world.warning(), Warning::kNone);
    show(world, cause.tick(begins + cause.sign * cause.resolution), 0.2);
    EXPECT_EQ(world.warning(), cause.warning);
    show(world, safe(kCylinder), 1.2);
    EXPECT_EQ(world.warning(), Warning::kNone);
  }
}

TEST(Warnings, OfPulpForceAndAxisComeByTheirMarginBeforeTheErrorAndAtTheErrorForAMasteredSkill) {
  const Scene scene = box();
  expect_thresholds(scene, {Warning::kPulp,
                            [](double d) {
                              return at(kBall, {0, 0, kPulpTop + kRadius + d});
                            },
                            1.0_mm, 0.5_mm, -1, 0.06_mm});
  expect_thresholds(scene, {Warning::kPulp,
                            [](double d) {
                              return at(kCylinder, {1.5_mm + kRadius + d, 0, -3.0_mm});
                            },
                            1.0_mm, 0.5_mm, -1, 0.06_mm});
  expect_thresholds(scene, {Warning::kForce,
                            [](double newtons) {
                              ServoTick tick = safe(kBall);
                              tick.f_T_W = {0.6 * newtons, 0, 0.8 * newtons};
                              return tick;
                            },
                            2, 0.5, 1, 1e-6});
  expect_thresholds(scene, {Warning::kAxis,
                            [](double angle) {
                              ServoTick tick = safe(kCylinder);
                              tick.X_WG.R = glm::angleAxis(angle, glm::normalize(dvec3(1, 2, 0)));
                              return tick;
                            },
                            8 * kDegree, 4 * kDegree, 1, 1e-6});
}

TEST(Warnings, OfTheNeighbouringToothComeByTheirMarginBeforeTheTouch) {
  const Scene scene = shipped("class-2-cavity.json");
  const auto tools = haptics::tool_set(scene.servo);
  ASSERT_EQ(tools[kBall].shape, haptics::HeadShape::kSphere);
  const SurroundingsShape around(*scene.surroundings);
  const auto samples = haptics::sample_head(tools[kBall], 3000);
  // Moves the ball from the middle of the occlusal surface to this distance from the neighbour.
  const auto beside = [&](double distance) {
    dvec3 p{7.2_mm, 6.0_mm, 18.5_mm};
    for (;;) {
      double away = 1;
      for (const haptics::HeadSample& s : samples) away = std::min(away, around.neighbour(p + s.p_TQ));
      if (away - distance < 5e-6) return at(kBall, p);
      p.x -= std::min(0.2e-3, 0.5 * (away - distance));
    }
  };
  expect_thresholds(scene, {Warning::kNeighbour, beside, 0, 0.3_mm, -1, 0.05_mm});
}

TEST(Warnings, NeedATurningBurAndTheAxisOneThatIsNoBall) {
  const Scene scene = box();
  World world(scene);
  world.add_warnings(load_tissue(scene), levels_of(scene, 1));
  ServoTick still = at(kBall, {0, 0, kPulpTop + kRadius});
  still.spindle = 0;
  show(world, still, 0.5);
  EXPECT_EQ(world.warning(), Warning::kNone);
  ServoTick tilted = safe(kBall);
  tilted.X_WG.R = glm::angleAxis(1.0, dvec3(1, 0, 0));
  show(world, tilted, 0.5);
  EXPECT_EQ(world.warning(), Warning::kNone);
  tilted.tool = kCylinder;
  tilted.contact_area = 0;
  show(world, tilted, 0.5);
  EXPECT_EQ(world.warning(), Warning::kNone) << "in the air";
}

TEST(Warnings, OneOfATickIsShownForASecondUnlessAMoreUrgentOneComes) {
  const Scene scene = box();
  World world(scene);
  world.add_warnings(load_tissue(scene), levels_of(scene, 1));
  show(world, safe(kBall), 0.05);
  ServoTick hard = safe(kBall);
  hard.f_T_W = {0, 0, 5};
  show(world, hard, 0.001);
  show(world, safe(kBall), 0.9);
  EXPECT_EQ(world.warning(), Warning::kForce);
  show(world, at(kBall, {0, 0, kPulpTop + kRadius}), 0.11);
  EXPECT_EQ(world.warning(), Warning::kPulp);
  show(world, hard, 0.9);
  EXPECT_EQ(world.warning(), Warning::kPulp);
  show(world, hard, 0.3);
  EXPECT_EQ(world.warning(), Warning::kForce);
  show(world, safe(kBall), 1.2);
  EXPECT_EQ(world.warning(), Warning::kNone);
}

TEST(Warnings, ComeFromTheRulesOfTheTaskThatGivePoints) {
  const auto kinds = [](const Scene& scene) {
    std::vector<Warning> all;
    for (const WarningRule& rule : warning_rules(scene)) all.push_back(rule.warning);
    return all;
  };
  using enum Warning;
  EXPECT_EQ(kinds(shipped("class-2-cavity.json")), (std::vector{kPulp, kNeighbour, kForce, kAxis}));
  EXPECT_EQ(kinds(shipped("molar-caries.json")), (std::vector{kPulp, kNeighbour, kForce}));
  EXPECT_EQ(kinds(shipped("root-canal-access.json")), (std::vector{kForce})) << "the pulp is opened, under a dam";
  EXPECT_EQ(kinds(shipped("explore-caries.json")), (std::vector{kForce}));
  EXPECT_TRUE(kinds(shipped("free-practice.json")).empty());
  EXPECT_TRUE(kinds(shipped("implant-molar.json")).empty()) << "it has its own notes";
  Scene exam = box();
  exam.warnings = false;
  EXPECT_TRUE(kinds(exam).empty());
}

TEST(Warnings, AReplayShowsThoseOfTheSessionAlsoBackwards) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "session.h5";
  const Scene scene = box();
  const WarningLevels levels = {{"pulp_distance_mm", 0.7}, {"force_max_N", 1}};
  std::vector<haptics::HandPath::Row> rows;
  for (const auto& [t, z] : {std::pair{0.0, 1.0}, {0.5, -2.5}, {2.5, -2.5}, {2.7, 1.0}, {4.5, 1.0}})
    rows.push_back({t, {{2.5e-3, 0, z * 1e-3}, {1, 0, 0, 0}}, 1, dvec3(0)});
  const auto hand = haptics::make_scripted_hand({rows}, 1000, /*paced=*/false);
  SteppedSession session(scene, load_tissue(scene), hand->info());
  World world(scene);
  world.add_warnings(session.carver().volume(), levels);
  WorldReader reader(world, session.event_logs());
  session::SessionHeader header = session_header(scene, {}, hand->info(), session.carver().volume(), 1000);
  header.warnings = levels;
  SessionRecorder recorder(file, scene, header, session.event_logs());
  std::vector<Warning> seen;
  while (session.advance(*hand)) {
    reader.read();
    recorder.turn();
    if (session.last().index % 97 == 96) seen.push_back(world.warning());
  }
  recorder.finish(session.carver().volume());
  for (const Warning warning : {Warning::kNone, Warning::kPulp, Warning::kForce})
    ASSERT_GT(std::ranges::count(seen, warning), 2) << static_cast<int>(warning);
  SessionPlayer player(file);
  EXPECT_EQ(player.session().header().warnings, levels);
  for (int round = 0; round < 2; ++round)
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const std::size_t k = round == 0 ? i : seen.size() - 1 - i;
      player.seek(0.097 * static_cast<double>(k + 1) - 1e-3);
      EXPECT_EQ(player.world().warning(), seen[k]) << k;
    }
}

TEST(Warnings, FadeWithThePointsOfTheTraineesSessionsAndNeverForAGuest) {
  const TemporaryFolder folder;
  setenv("TYPODONT_HOME", folder.path().c_str(), 1);
  setenv("TYPODONT_CACHE", (folder.path() / "cache").c_str(), 1);
  const Scene scene = box();
  const WarningLevels full = levels_of(scene, 1);
  EXPECT_EQ(warning_levels(scene, "Anna"), full);
  const std::filesystem::path own = folder.path() / "sessions" / "Anna";
  std::filesystem::create_directories(own);
  double last = 1;
  for (int i = 0; i < 12; ++i) {
    const std::filesystem::path file = own / fmt::format("2026-01-{:02}_box.h5", i + 10);
    std::ofstream(file) << i;
    cache_score(file, {.points = 50,
                       .counts = true,
                       .date = fmt::format("2026-01-{:02}T10:00:00Z", i + 10),
                       .items = {{"force_max_N", 9.5, 10}, {"pulp_distance_mm", 2, 10}}});
    const WarningLevels levels = warning_levels(scene, "Anna");
    EXPECT_EQ(levels.at("pulp_distance_mm"), 1) << "few points";
    EXPECT_EQ(levels.at("taper_deg"), 1) << "never scored";
    EXPECT_LE(levels.at("force_max_N"), last);
    last = levels.at("force_max_N");
  }
  EXPECT_EQ(last, 0);
  EXPECT_EQ(warning_levels(scene, ""), full);
  unsetenv("TYPODONT_HOME"), unsetenv("TYPODONT_CACHE");
}

}  // namespace
}  // namespace typodont
