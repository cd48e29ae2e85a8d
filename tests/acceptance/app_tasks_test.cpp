// Tests that every shipped task can be solved: its ideal gets the full score, a good hand a high score, a careless hand
// a low score, and an untouched tooth nothing.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <random>

#include "engine/app/assets.h"
#include "engine/app/hands/stroke_planner.h"
#include "engine/app/recording/resume.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/task/heat.h"
#include "engine/app/task/task.h"
#include "engine/app/tissue/paint_file.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "engine/session/task.h"
#include "engine/surface/mesh_export.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

namespace fs = std::filesystem;

/// Returns the same strokes moved aside and deeper, as from a hand that does not look.
std::vector<Stroke> displaced(std::vector<Stroke> strokes, const dvec3& by_W) {
  for (Stroke& s : strokes) {
    s.from.p += by_W;
    s.to.p += by_W;
  }
  return strokes;
}

/// Returns the input for the score of a hand that made mistakes only in the shape that it cut.
session::ScoreInput steady_hand(const haptics::TissueVolume& start) {
  session::ScoreInput input;
  input.before = input.after = start.volumes();
  input.hand.time = 100;
  input.hand.force_mean = 0.6;
  input.hand.force_max = 2;
  input.hand.tremor_rms = 50e-6;
  return input;
}

/// Returns the score in percent of the full score.
double percent(const session::Score& score) {
  return score.full > 0 ? 100 * score.points / score.full : 0;
}

struct TaskBench {
  Scene scene;
  haptics::TissueVolume start;
  TaskEvaluator judge;
  explicit TaskBench(const std::string& name)
      : scene(read_scene(assets_folder() / "scenes" / (name + ".json"))),
        start(load_tissue(scene)),
        judge(scene, start) {}

  session::Score score(const haptics::TissueVolume& after) const {
    session::ScoreInput input = steady_hand(start);
    input.after = after.volumes();
    if (const auto heat = heat_meter(scene, start)) input.heat = heat->result();
    judge.judge(after, input);
    return session::score(input, session::rules_of_scene(Json::parse(scene.text, scene.name), input));
  }
  haptics::TissueVolume carved(const std::vector<Stroke>& strokes, const haptics::Tool& tool) const {
    haptics::TissueVolume after = load_tissue(scene);
    carve_strokes(after, tool, strokes);
    return after;
  }
};

/// Returns the bench of a shipped task. Computing a task's ideal takes seconds, so all tests of this program share it
/// (ONE_PROCESS in app.cmake).
const TaskBench& task_bench(const std::string& name) {
  static std::map<std::string, TaskBench> benches;
  return benches.try_emplace(name, name).first->second;
}

std::string explained(const session::Score& score) {
  std::string text;
  for (const session::ScoreItem& item : score.items) {
    text += fmt::format("{} = {:.3f} {} (target {:.3f} ± {:.3f}): {:.2f} of {:.0f}\n", item.name, item.value, item.unit,
                        item.target, item.tolerance, item.points, item.weight);
  }
  return text;
}

TEST(ShippedScenes, AreAllReadableAndEveryTaskStatesItsGoalInThreeLanguages) {
  int tasks = 0;
  for (const auto& entry : fs::directory_iterator(assets_folder() / "scenes")) {
    if (entry.path().extension() != ".json") continue;
    const Scene scene = read_scene(entry.path());
    if (!scene.task) continue;
    ++tasks;
    for (int k = 0; k < session::kLanguageCount; ++k) {
      EXPECT_NE(scene.task->goal.text[static_cast<std::size_t>(k)], "") << entry.path();
      EXPECT_NE(scene.task->title.text[static_cast<std::size_t>(k)], "") << entry.path();
      for (const auto& step : scene.task->steps) EXPECT_NE(step.text[static_cast<std::size_t>(k)], "") << entry.path();
    }
  }
  EXPECT_GE(tasks, 8);
}

TEST(ShippedScenes, EveryStepNamesItsToolIfTheUserNeitherChoosesItNorHasOnlyOne) {
  for (const auto& entry : fs::directory_iterator(assets_folder() / "scenes")) {
    if (entry.path().extension() != ".json") continue;
    const Scene scene = read_scene(entry.path());
    if (!scene.task || tool_names(scene).size() == 1) continue;
    for (const session::TaskStep& step : scene.task->steps)
      EXPECT_EQ(step.tool.empty(), step.done == "tool" || step.done == "phase") << entry.path() << step.text[0];
  }
}

/// A task: name of the scene, the tool that can solve it, and the distance of its passes in mm.
struct Solvable {
  const char* name;
  const char* tool;
  double step;
  dvec3 careless_mm;  // displacement of a hand that does not look
};
void PrintTo(const Solvable& task, std::ostream* out) {
  *out << task.name;
}

class SolvableTask : public testing::TestWithParam<Solvable> {};

TEST_P(SolvableTask, TheIdealScoresFullAGoodHandHighACarelessHandLowAndNoWorkZero) {
  const Solvable& task = GetParam();
  const TaskBench& bench = task_bench(task.name);
  ASSERT_TRUE(bench.judge.has_ideal());
  const session::Score ideal = bench.score(*bench.judge.ideal());
  EXPECT_GT(percent(ideal), 99) << explained(ideal);

  const session::Score nothing = bench.score(bench.start);
  EXPECT_LT(percent(nothing), 1) << explained(nothing);

  const haptics::Tool tool = load_tool(task.tool);
  session::Preparation work = bench.judge.preparation(bench.start);
  work.ideal = session::redistanced(work.ideal);
  const auto strokes = plan_strokes(work, tool, {.step = task.step * 1e-3}).strokes;
  const session::Score good = bench.score(bench.carved(strokes, tool));
  EXPECT_GT(percent(good), 90) << explained(good);

  const session::Score careless = bench.score(bench.carved(displaced(strokes, task.careless_mm * 1e-3), tool));
  EXPECT_LT(percent(careless), 60) << explained(careless);
  fmt::print("{}: ideal {:.1f} %, good hand {:.1f} %, careless {:.1f} %\n", task.name, percent(ideal), percent(good),
             percent(careless));
}

INSTANTIATE_TEST_SUITE_P(All, SolvableTask,
                         testing::Values(Solvable{"class-1-cavity", "cylinder_012", 0.3, {0.7, 0.5, -0.8}},
                                         Solvable{"class-2-cavity", "cylinder_012", 0.3, {0.2, 0.8, -0.8}},
                                         Solvable{"crown-preparation", "round_end_cylinder_023", 0.3, {0.6, 0.6, -1.0}},
                                         Solvable{"root-canal-access", "cylinder_012", 0.4, {0, 2.2, -0.5}},
                                         Solvable{"remove-caries", "round_010", 0.25, {1.0, 0.7, -0.6}},
                                         Solvable{"tutorial", "round_008", 0.2, {0.8, 0.8, -0.3}}),
                         [](const auto& param) { return test::test_name(param.param.name); });

/// Removes a ball of tissue that should have stayed, or adds a ball that should have been removed, at a random place.
/// Nothing is improved by it.
void worsen(DenseCopy& after, const DenseCopy& before, const DenseCopy& ideal, bool lose, std::mt19937& dice) {
  const glm::ivec3 n = after.field.size;
  std::uniform_real_distribution<double> fraction(0, 1);
  const double radius = (0.25e-3 + 0.45e-3 * fraction(dice)) / after.frame.voxel;
  std::vector<glm::ivec3> places;  // positions slightly below the perfect surface, or above it where there was tissue
  for_each_voxel(n, [&](int x, int y, int z) {
    const std::size_t i = after.field.at(x, y, z);
    const float wanted = ideal.field.distance[i];
    if (lose ? wanted < -1 && wanted > -4 : wanted > 1 && wanted < 4 && before.field.distance[i] < -1)
      places.push_back({x, y, z});
  });
  ASSERT_FALSE(places.empty());
  const glm::ivec3 c = places[static_cast<std::size_t>(fraction(dice) * static_cast<double>(places.size() - 1))];
  for_each_voxel(n, [&](int x, int y, int z) {
    const std::size_t i = after.field.at(x, y, z);
    const auto ball = static_cast<float>(glm::length(dvec3(x, y, z) - dvec3(c)) - radius);
    float& d = after.field.distance[i];
    d = lose ? std::max(d, -ball) : std::min(d, std::max(ball, before.field.distance[i]));
  });
}

/// Returns the height (m) of the highest tissue in every column of voxels along z; a value below all tissue if the
/// column has none.
std::vector<double> tops_of(const DenseCopy& copy) {
  std::vector<double> tops;
  for (int x = 0; x < copy.field.size.x; ++x) {
    for (int y = 0; y < copy.field.size.y; ++y) {
      int z = copy.field.size.z - 1;
      while (z >= 0 && copy.field.distance[copy.field.at(x, y, z)] > 0) --z;
      tops.push_back(z < 0 ? -1e9 : copy.frame.to_world(dvec3(x, y, z)).z);
    }
  }
  return tops;
}

TEST(ShippedScenes, TheGoalOfTheClassOneCavityStatesTheMeasuredDepthAndWidth) {
  const TaskBench& bench = task_bench("class-1-cavity");
  session::ScoreInput input = steady_hand(bench.start);
  bench.judge.judge(bench.start, input);
  const std::string& goal = bench.scene.task->goal.text[0];
  EXPECT_NE(goal.find(fmt::format("{:.1f} mm below", *input.cavity_ideal->floor_depth * 1e3)), std::string::npos);
  EXPECT_NE(goal.find(fmt::format("{:.1f} mm wide", *input.cavity_ideal->isthmus * 1e3)), std::string::npos);
}

TEST(ShippedScenes, TheClassOneCavityFollowsTheFissure) {
  const TaskBench& bench = task_bench("class-1-cavity");
  const DenseCopy before = dense_copy(bench.start);
  const DenseCopy ideal =
      dense_copy(*bench.judge.ideal(), glm::ivec3(glm::round(bench.start.frame().to_voxels(before.frame.origin))),
                 before.field.size);
  const std::vector<double> was = tops_of(before), is = tops_of(ideal);
  // In each row across the cavity, the lowest point of the old surface between the cusps is inside the cavity.
  int rows = 0, hit = 0;
  for (int y = 0; y < before.field.size.y; ++y) {
    const double y_mm = before.frame.to_world(dvec3(0, y, 0)).y * 1e3;
    if (y_mm < 3 || y_mm > 7.7) continue;
    double lowest = 1e9;
    bool inside = false;
    for (int x = 0; x < before.field.size.x; ++x) {
      const double x_mm = before.frame.to_world(dvec3(x, 0, 0)).x * 1e3;
      const auto i = static_cast<std::size_t>(x * before.field.size.y + y);
      if (x_mm < 5 || x_mm > 9 || was[i] >= lowest) continue;
      lowest = was[i];
      inside = is[i] < was[i] - 1e-3;
    }
    ++rows;
    hit += inside;
  }
  EXPECT_GT(hit, 0.9 * rows) << rows;
}

TEST(ShippedScenes, TheIdealCrownIsReducedOnTheWholeTopAndTheIdealAccessRemovesThePulpRoof) {
  const TaskBench& crown = task_bench("crown-preparation");
  const DenseCopy before = dense_copy(crown.start);
  const auto on_lattice = [&](const TaskBench& bench) {
    return dense_copy(*bench.judge.ideal(),
                      glm::ivec3(glm::round(bench.judge.ideal()->frame().to_voxels(before.frame.origin))),
                      before.field.size);
  };
  const std::vector<double> was = tops_of(before), is = tops_of(on_lattice(crown));
  for (int x = 0; x < before.field.size.x; ++x) {
    for (int y = 0; y < before.field.size.y; ++y) {
      const dvec3 p = before.frame.to_world(dvec3(x, y, 0)) * 1e3;
      if (p.x < 4 || p.x > 9.5 || p.y < 2 || p.y > 8) continue;  // mm, between the axial walls, the fossae among it
      const auto i = static_cast<std::size_t>(x * before.field.size.y + y);
      EXPECT_GT(was[i] - is[i], 0.6e-3) << p.x << ", " << p.y;
    }
  }
  const TaskBench& access = task_bench("root-canal-access");
  const DenseCopy opened = on_lattice(access);
  int pulp = 0, roofed = 0;
  for (int x = 0; x < before.field.size.x; ++x) {
    for (int y = 0; y < before.field.size.y; ++y) {
      bool horn = false, roof = false;
      for (int z = 0; z < before.field.size.z; ++z) {
        const std::size_t i = before.field.at(x, y, z);
        if (before.frame.to_world(dvec3(x, y, z)).z < 13.9e-3) continue;  // the horns
        horn = horn || (before.tissue[i] == Tissue::kPulp && before.field.distance[i] < 0);
        roof = roof || (horn && before.tissue[i] != Tissue::kPulp && opened.field.distance[i] < -0.5f);
      }
      pulp += horn;
      roofed += horn && roof;
    }
  }
  EXPECT_GT(pulp, 100);
  EXPECT_LT(roofed, 0.05 * pulp);
}

TEST(ShippedScenes, TheClassTwoCavityHasANeighbourToothAndGum) {
  const Scene scene = read_scene(assets_folder() / "scenes/class-2-cavity.json");
  ASSERT_TRUE(scene.surroundings);
  EXPECT_TRUE(scene.surroundings->row);
  EXPECT_TRUE(scene.surroundings->gum);
  EXPECT_TRUE(scene.surroundings->monitored);
  // The contact point is near the neighbour tooth, and in the ideal the tissue beside it is removed.
  const SurroundingsShape around(*scene.surroundings);
  const TaskBench& bench = task_bench("class-2-cavity");
  const DenseCopy ideal = dense_copy(*bench.judge.ideal());
  const dvec3 contact = dvec3(12.6e-3, 5.2e-3, 16.5e-3);
  EXPECT_LT(around.neighbour(contact), 0.3e-3);
  EXPECT_GT(ideal.field.sample(ideal.frame.to_voxels(contact - dvec3(0.3e-3, 0, 0))), 0);
  EXPECT_TRUE(around.has_neighbours());
}

TEST(ShippedScenes, HiddenCariesHasTheColourOfEnamelAndTheMouthMirrorIsVisible) {
  const test::ProgramFolder folder(TYPODONT_PROGRAM);
  const std::string text = test::read_text("assets/scenes/explore-caries.json");
  const auto paint = text.find("\"paint\":"), tool = text.find("\"mouth_mirror\":");
  ASSERT_NE(paint, std::string::npos);
  ASSERT_NE(tool, std::string::npos);
  const auto picture = [&](const std::string& name, const std::string& scene, const std::string& quality) {
    folder.write(name + ".json", scene);
    expect_ok(folder.run("render " + (folder / (name + ".json")) + " --rig window --size 240x135 --quality " + quality +
                         " --out " + (folder / name)));
    return test::read_text(folder / (name + "/left.png"));
  };
  // The mouth is omitted, because its light takes many seconds to compute.
  const auto alone = [](std::string scene) {
    const std::string mouth = R"("mouth": "patient")";
    const auto at = scene.find(mouth);
    EXPECT_NE(at, std::string::npos);
    return at == std::string::npos ? scene : scene.replace(at, mouth.size(), R"("mouth": "none")");
  };
  const std::string sound = text.substr(0, paint) + text.substr(tool);
  for (const char* quality : {"medium", "high"})  // the light of each pixel is computed only at "high"
    EXPECT_EQ(picture("hidden", alone(text), quality), picture("sound", alone(sound), quality)) << quality;
  const Json frame = Json::load(folder / "hidden/frame.json");
  EXPECT_GT(frame["frame"]["mirror"]["passes"].number(), 0);
}

TEST(ShippedScenes, TheRubberDamAndItsClampAreDrawn) {
  const test::ProgramFolder folder(TYPODONT_PROGRAM);
  const auto changed = [](std::string text, const std::string& part, const std::string& other) {
    const auto at = text.find(part);
    EXPECT_NE(at, std::string::npos) << part;
    return at == std::string::npos ? text : text.replace(at, part.size(), other);
  };
  const auto picture = [&](const std::string& scene) {
    folder.write("scene.json", scene);
    expect_ok(folder.run("render {}/scene.json --rig closeup --eye left --quality bare --size 160x128 --out {}/p"));
    return test::read_text(folder / "p/left.png");
  };
  // The dam is drawn without cheek and tongue, because their light takes seconds to compute.
  const std::string access =
      changed(test::read_text("assets/scenes/root-canal-access.json"), R"("mouth": "patient")", R"("mouth": "none")");
  const std::string sheet = picture(changed(access, R"("dam": {})", R"("dam": {"clamp": false})"));
  EXPECT_NE(picture(access), sheet) << "the clamp";
  EXPECT_NE(picture(changed(access, ",\n    \"dam\": {}", "")), sheet) << "the rubber";
}

class ShippedTask : public testing::TestWithParam<const char*> {};

TEST_P(ShippedTask, EveryRandomDefectOfTheIdealCostsPoints) {
  const TaskBench& bench = task_bench(GetParam());
  const DenseCopy ideal = dense_copy(*bench.judge.ideal());
  const DenseCopy before = dense_copy(
      bench.start, glm::ivec3(glm::round(bench.start.frame().to_voxels(ideal.frame.origin))), ideal.field.size);
  const session::Score perfect = bench.score(*bench.judge.ideal());
  std::mt19937 dice(29);
  const bool filled = bench.scene.task->ideal->has("unprepared");  // the ideal adds tissue and removes nothing
  for (const bool lose : {true, filled}) {
    DenseCopy after = ideal;
    worsen(after, before, ideal, lose, dice);
    const session::Score worse = bench.score(from_dense(after, bench.start.band()));
    EXPECT_LT(worse.points, perfect.points) << explained(worse);
  }
}

INSTANTIATE_TEST_SUITE_P(All, ShippedTask,
                         testing::Values("tutorial", "class-1-cavity", "class-2-cavity", "crown-preparation",
                                         "root-canal-access", "remove-caries", "molar-caries", "amalgam-filling"),
                         [](const auto& param) { return test::test_name(param.param); });

/// Scores a hand that moves the tip over the region, and presses where `says` returns true.
session::Score explore(const TaskBench& bench, double spacing, const std::function<bool(const dvec3&)>& says) {
  session::ExploreMeter meter = *bench.judge.explore_meter();
  const DenseCopy copy = dense_copy(bench.start);
  std::vector<ServoTick> ticks;
  const auto step = std::max(1, static_cast<int>(spacing / copy.frame.voxel));
  for (int x = 0; x < copy.field.size.x; x += step) {
    for (int y = 0; y < copy.field.size.y; ++y) {
      int z = copy.field.size.z - 1;
      while (z > 0 && copy.field.distance[copy.field.at(x, y, z)] > 0) --z;
      const dvec3 p_W = copy.frame.to_world(dvec3(x, y, z));
      if (z == 0 || p_W.z < 17.8e-3) continue;
      ServoTick tick;
      tick.X_WT.p = tick.X_WG.p = p_W;
      tick.depth = 1e-5;
      tick.pedal = says(p_W) ? 1 : 0;
      ticks.push_back(tick);
    }
  }
  meter.add(ticks);
  session::ScoreInput input = steady_hand(bench.start);
  input.hand.force_max = 1;
  input.explore = meter.result();
  return session::score(input, session::rules_of_scene(Json::parse(bench.scene.text, "scene"), input));
}

TEST(Tasks, ExploringRewardsFoundLesionsAndNotPressingEverywhereOrNowhere) {
  const TaskBench& bench = task_bench("explore-caries");
  EXPECT_EQ(bench.judge.explore_meter()->result().lesions, 3);
  const DenseCopy copy = dense_copy(bench.start);
  const auto caries = [&](const dvec3& p_W) {
    const glm::ivec3 v(glm::round(copy.frame.to_voxels(p_W)));
    return copy.tissue[copy.field.at(v.x, v.y, v.z)] == Tissue::kCaries;
  };
  const session::Score good = explore(bench, 0.8e-3, caries);
  EXPECT_GT(percent(good), 85) << explained(good);
  EXPECT_LT(percent(explore(bench, 0.8e-3, [](const dvec3&) { return false; })), 45);
  EXPECT_LT(percent(explore(bench, 0.8e-3, [](const dvec3& p) { return std::fmod(p.y, 1e-3) < 0.5e-3; })),
            percent(good) - 10);
  EXPECT_LT(percent(explore(bench, 1.0, caries)), 20);
}

/// Returns the scene's text with another ideal.
std::string with_ideal(const std::string& scene, const std::string& ideal) {
  const auto at = scene.find("\"ideal\":"), end = scene.find("},\"", at);
  return scene.substr(0, at) + "\"ideal\":" + ideal.substr(0, ideal.size() - 1) + scene.substr(end);
}

TEST(Tasks, AnIdealCanBeLoadedFromAVolumeOrAMesh) {
  const TaskBench& bench = task_bench("class-1-cavity");
  const test::ProgramFolder folder(TYPODONT_PROGRAM);
  bench.judge.ideal()->save(folder / "ideal.vdb");
  surface::SurfaceMesher mesher({.tolerance = 0.05f});
  FieldBrick brick;
  for (const glm::ivec3& key : bench.judge.ideal()->surface_bricks()) {
    bench.judge.ideal()->read_brick(key, brick);
    mesher.put(brick);
  }
  mesher.remesh();
  surface::write_mesh(folder / "ideal.stl", surface::weld(mesher), bench.judge.ideal()->frame(),
                      bench.scene.servo.materials);
  for (const std::string ideal : {R"({"volume":"ideal.vdb"})", R"({"mesh":{"file":"ideal.stl"}})"}) {
    const Scene other = parse_scene(Json::parse(with_ideal(bench.scene.text, ideal), ideal), folder / "scene.json");
    const TaskEvaluator judge(other, bench.start);
    session::ScoreInput input = steady_hand(bench.start);
    judge.judge(*bench.judge.ideal(), input);
    EXPECT_GT(input.cavity->wanted, 9e-9) << ideal;
    EXPECT_LT(input.cavity->over_volume + input.cavity->under_volume, 0.03 * input.cavity->wanted) << ideal;
  }
}

TEST(Tasks, ARecordedPreparationCanBeTheIdealAndWithoutItATaskHasNoPoints) {
  const test::ProgramFolder folder(TYPODONT_PROGRAM);
  const std::string scene =
      R"({"tissue": {"voxel_mm": 0.15, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 4]}}}]},
      "tool": "round_012", "spindle_krpm": 300, "task": {"goal": "as I do it", IDEAL
      "rules": [{"name": "over_cut_mm3", "target": 0, "tolerance": 1, "weight": 50}, {"name": "under_cut_mm3", "target": 0, "tolerance": 1, "weight": 50}],
      "defaults": false}})";
  const auto with = [&](const std::string& ideal) {
    std::string text = scene;
    return text.replace(text.find("IDEAL"), 5, ideal);
  };
  folder.write("practice.json", with(""));
  folder.write("hand.csv",
               "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,4,1,0,0,0,1\n0.5,0,0,2.6,1,0,0,0,1\n2,0,0,1.2,1,0,0,0,1\n4,"
               "1.5,0,1.2,1,0,0,0,1\n");
  folder.write("other.csv",
               "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,4,1,0,0,0,1\n0.5,0,0,2.6,1,0,0,0,1\n2,0,0,1.6,1,0,0,0,1\n4,"
               "-1.5,0,1.6,1,0,0,0,1\n");
  expect_ok(folder.run("servo {}/practice.json --hand {}/hand.csv --out {}/ideal.h5"));
  folder.write("task.json", with("\"ideal\": {\"session\": \"ideal.h5\"},"));
  const auto percent_of = [&](const std::string& hand) {
    expect_ok(folder.run("servo {}/task.json --hand " + (folder / hand) + " --out {}/s.h5"));
    const test::Ran report = expect_ok(folder.run("report {}/s.h5 --json --out {}/r.html"));
    EXPECT_EQ(report.err.find("not measured"), std::string::npos) << report.err;
    const Json json = Json::parse(report.out, "report");
    return 100 * json["points"].number() / json["full"].number();
  };
  EXPECT_GT(percent_of("hand.csv"), 98);
  EXPECT_LT(percent_of("other.csv"), 60);

  // The same recording seen from above: at its start, at its end, and compared with the ideal.
  folder.write(
      "above.json",
      R"({"display": "offscreen", "screen": {"corners_mm": {"lower_left": [-4, -3, 2], "lower_right": [4, -3, 2],
      "upper_left": [-4, 3, 2]}, "pixels": [160, 120], "layout": "mono"}, "head": {"eye_center_mm": [0, 0, 300]}})");
  const auto picture = [&](const std::string& name, const std::string& arguments) {
    expect_ok(folder.run("render {}/s.h5 --rig {}/above.json --eye left --quality fast --out " + (folder / name) + " " +
                         arguments));
    return test::read_text(folder / (name + "/left.png"));
  };
  const std::string begin = picture("begin", "--at 0"), end = picture("end", "--at 4");
  EXPECT_NE(begin, end);
  EXPECT_NE(end, picture("difference", "--at 4 --view difference"));
  EXPECT_EQ(end, picture("after", "--at 100"));  // beyond the last tick nothing moves

  // If a file of the task is missing, the rules that do not need the file give no points.
  std::filesystem::remove(folder / "ideal.h5");
  const Json lost = Json::parse(expect_ok(folder.run("report {}/s.h5 --json --out {}/r.html")).out, "report");
  EXPECT_EQ(lost["full"].number(), 0);
  EXPECT_NE(lost["not_measured"].string().find("ideal.h5"), std::string::npos);
  EXPECT_NE(test::read_text(folder / "r.html").find("a task has no points"), std::string::npos);
}

TEST(PaintFile, PaintsTissueAndSoftensIt) {
  const fs::path file = fs::temp_directory_path() / fmt::format("typodont_paint_{}.json", getpid());
  write_file_atomically(file, R"({"strokes": [
      {"tissue": "caries", "a_mm": [0, 0, 2.4], "b_mm": [1, 0, 2.4], "radius_mm": 0.5, "stiffness_factor": 0.5},
      {"tissue": "pulp", "a_mm": [0, 0, 0], "radius_mm": 1}]})");
  const Json json = Json::parse(fmt::format(R"({{"tissue": {{"voxel_mm": 0.2, "solids": [{{"tissue": "dentin", "solid":
      {{"box": {{"size_mm": [8, 8, 5]}}}}}}]}}, "tool": "round_012", "paint_file": "{}"}})",
                                            file.string()),
                                "scene");
  const Scene scene = parse_scene(json, "scene.json");
  const PerTissue volumes = load_tissue(scene).volumes();
  EXPECT_NEAR(volumes[static_cast<std::size_t>(Tissue::kPulp)] * 1e9, 4.0 / 3 * kPi, 0.3);
  EXPECT_GT(volumes[static_cast<std::size_t>(Tissue::kCaries)] * 1e9, 0.4);
  const auto caries = static_cast<std::size_t>(Tissue::kCaries);
  EXPECT_DOUBLE_EQ(scene.servo.materials[caries].stiffness, 0.5 * load_materials()[caries].stiffness);
  const std::vector<PaintStroke> again = read_paint(file);
  ASSERT_EQ(again.size(), 2u);
  EXPECT_NEAR(again[0].b_W.x, 1e-3, 1e-9);
  EXPECT_EQ(again[0].stiffness_factor, 0.5);
  fs::remove(file);
}

}  // namespace
}  // namespace typodont
