// Tests that an exercise made in the window is a scene like any other.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "engine/app/operator/archive.h"
#include "engine/app/operator/exercise.h"
#include "engine/app/operator/file_field.h"
#include "engine/app/operator/library.h"
#include "engine/app/operator/session_works.h"
#include "engine/app/recording/resume.h"
#include "engine/app/review/session_report.h"
#include "engine/app/task/task.h"
#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/session/recorder.h"
#include "engine/session/session_file.h"
#include "tests/support/program.h"
#include "tests/support/session_fixture.h"

namespace typodont {
namespace {

constexpr const char* kBase = R"({"name": "block", "tissue": {"voxel_mm": 0.1, "solids": [
 {"tissue": "enamel", "solid": {"box": {"center_mm": [0, 0, 0], "size_mm": [6, 6, 6]}}}]}, "tool": "round_012"})";

std::filesystem::path saved(const NewExercise& exercise) {
  Progress progress;
  return write_exercise(exercise, progress);
}

struct Exercise : testing::Test {
  test::ProgramFolder folder{""};
  const Scene base = parse_scene(Json::parse(kBase, "base.json"), folder / "base.json");
  Scene imported(const NewTooth& tooth) const {
    Progress progress;
    Scene scene = read_scene(import_tooth(tooth, progress));
    EXPECT_EQ(progress.fraction(), 1);
    return scene;
  }
  void SetUp() override { setenv("TYPODONT_HOME", folder.path().c_str(), 1); }
  void TearDown() override { unsetenv("TYPODONT_HOME"); }
};

/// Returns an OBJ file with these vertices and faces.
std::string obj_of(std::initializer_list<const char*> vertices, std::initializer_list<const char*> faces) {
  std::string obj;
  for (const char* v : vertices) obj += fmt::format("v {}\n", v);
  for (const char* f : faces) obj += fmt::format("f {}\n", f);
  return obj;
}
constexpr std::initializer_list<const char*> kBoxFaces = {"1 4 3 2", "5 6 7 8", "1 2 6 5",
                                                          "2 3 7 6", "3 4 8 7", "4 1 5 8"};
const std::string kCorner = obj_of({"0 0 0", "4 0 0", "0 4 0", "0 0 4"}, {"1 3 2", "1 2 4", "1 4 3", "2 3 4"});

TEST_F(Exercise, EveryShippedOneStandsUnderAHeadingAndTheTutorialIsFirst) {
  std::set<std::string> ended;  // groups do not come back
  std::string group;
  std::vector<std::string> names;
  for (const SceneChoice& choice : find_scenes({})) {
    ASSERT_FALSE(choice.group.empty()) << choice.file;
    if (choice.group != group) {
      EXPECT_TRUE(ended.insert(choice.group).second) << choice.file;
    }
    group = choice.group;
    names.push_back(choice.name);
  }
  ASSERT_FALSE(names.empty());
  EXPECT_EQ(names.front(), "tutorial");
  EXPECT_GT(ended.size(), 5u);
}

TEST_F(Exercise, IsThereToBeChosenAndEveryStrokeKeepsTheHardnessAndTheColourItWasPaintedWith) {
  const std::vector<PaintStroke> strokes = {
      {Tissue::kCaries, {0, 0, 2e-3}, {0, 0, 2e-3}, 1e-3, 1, 0.8},
      {Tissue::kCaries, {0, 0, 2e-3}, {0, 0, 2e-3}, 0.5e-3, 1, 0.2, voxel_color({0.2, 0.1, 0.05})}};
  const auto file = saved({.name = "My caries", .goal = "Take it out.", .base = &base, .strokes = strokes});
  EXPECT_EQ(file, folder.path() / "scenes/my_caries.json");
  EXPECT_TRUE(std::ranges::any_of(find_scenes({}), [&](const SceneChoice& choice) {
    return choice.file == file && choice.own && choice.fault.empty();
  })) << "it is there to be chosen";
  const Scene scene = read_scene(file);
  EXPECT_EQ(scene.name, "My caries");
  const haptics::TissueVolume tissue = load_tissue(scene);
  haptics::TissueVolume expected = load_tissue(base);
  paint(expected, strokes);
  EXPECT_EQ(tissue.hash(), expected.hash());
  EXPECT_TRUE(tissue.graded() && tissue.colored());
  // There are two balls, the smaller one inside the larger one, with different hardness.
  const auto caries = static_cast<std::size_t>(Tissue::kCaries);
  const double mean = tissue.hardness_volumes()[caries] / tissue.volumes()[caries];
  EXPECT_NEAR(mean, (0.8 * 7 + 0.2) / 8, 0.02);
}

TEST_F(Exercise, TheSceneHasTheInstructorsStiffnessStepsAndRules) {
  NewExercise made{.name = "Soft", .goal = "Take it out.", .steps = {"Feel it.", "Drill it."}, .base = &base};
  made.stiffness[static_cast<std::size_t>(Tissue::kCaries)] = 0.5;
  made.rules = rule_choices(base);
  ASSERT_EQ(made.rules->size(), session::known_score_names().size());
  for (RuleChoice& rule : *made.rules) {
    EXPECT_FALSE(rule.counts) << rule.name;
    if (rule.name != "residual_caries_mm3") continue;
    rule.counts = true;
    rule.from_ideal = false;
    rule.target = 0.25f;
    rule.tolerance = 2;
    rule.weight = 70;
  }
  const Scene scene = read_scene(saved(made));
  const Material& was = base.servo.materials[static_cast<std::size_t>(Tissue::kCaries)];
  const Material& is = scene.servo.materials[static_cast<std::size_t>(Tissue::kCaries)];
  EXPECT_NEAR(is.stiffness, 0.5 * was.stiffness, 1e-9 * was.stiffness);
  EXPECT_EQ(scene.servo.materials[static_cast<std::size_t>(Tissue::kEnamel)].stiffness,
            base.servo.materials[static_cast<std::size_t>(Tissue::kEnamel)].stiffness);
  ASSERT_TRUE(scene.task);
  ASSERT_EQ(scene.task->steps.size(), 2u);
  EXPECT_EQ(scene.task->steps[1].text[0], "Drill it.");
  const auto rules = session::rules_of_scene(Json::parse(scene.text, "scene"), {});
  ASSERT_EQ(rules.size(), 1u) << "nothing else counts";
  EXPECT_EQ(rules[0].name, "residual_caries_mm3");
  EXPECT_EQ(rules[0].target, 0.25);
  EXPECT_EQ(rules[0].tolerance, 2);
  EXPECT_EQ(rules[0].weight, 70);

  // An exercise that is made again from this scene must start with the same rules.
  const auto again = rule_choices(scene);
  for (const RuleChoice& rule : again) EXPECT_EQ(rule.counts, rule.name == "residual_caries_mm3");
}

TEST_F(Exercise, ThePictureOfTheResultShowsWhereItWasCutTooDeep) {
  std::string text = kBase;
  text.insert(text.rfind('}'), R"(, "task": {"goal": "g", "ideal": {"remove": [
    {"box": {"center_mm": [0, 0, 3], "size_mm": [2, 2, 2]}}]}})");
  const Scene aimed = parse_scene(Json::parse(text, "aimed.json"), folder / "aimed.json");
  const auto deeper = [&] {  // a millimetre more than the ideal
    std::string deep = text;
    deep.replace(deep.find("[2, 2, 2]"), 9, "[2, 2, 4]");
    const Scene scene = parse_scene(Json::parse(deep, "deep.json"), folder / "deep.json");
    return std::move(*ideal_tissue(scene, load_tissue(scene)));
  };
  const auto pixels = [](const render::Picture& p, const auto& wanted) {
    int count = 0;
    for (int y = 0; y < p.size.y; ++y)
      for (int x = 0; x < p.size.x; ++x) count += wanted(p.at(x, y));
    return count;
  };
  const auto red = [](const std::uint8_t* c) { return c[0] > 2 * c[1] && c[0] > 2 * c[2] && c[0] > 60; };
  const auto ground = [](const std::uint8_t* c) { return c[0] == 32 && c[1] == 32 && c[2] == 33; };
  const haptics::TissueVolume left = deeper();
  const session::ReportOptions compared = result_of(aimed, left), alone = result_of(base, left);
  EXPECT_TRUE(compared.ideal);
  EXPECT_FALSE(alone.ideal);
  EXPECT_GT(pixels(picture_of_result(compared), red), 300);
  EXPECT_EQ(pixels(picture_of_result(alone), red), 0);
  for (const session::ReportOptions* one : {&compared, &alone}) {
    const int bare = pixels(picture_of_result(*one), ground);
    EXPECT_GT(bare, 10'000);
    EXPECT_LT(bare, 560 * 420 / 2 + 80'000);
  }
  EXPECT_TRUE(picture_of_result({}).rgba.empty());
}

TEST_F(Exercise, AnInvalidRuleIsNamedWithItsDisplayedNameAndReplacesNothing) {
  const std::string first = test::read_text(saved({.name = "Refused", .goal = "First.", .base = &base}));
  const auto refused = [&](const char* rule, const auto& set, const haptics::TissueVolume* ideal) {
    NewExercise made{.name = "Refused", .goal = "g", .base = &base, .ideal = ideal};
    made.rules = rule_choices(base);
    for (RuleChoice& choice : *made.rules)
      if (choice.name == rule || choice.name == "time_s") {
        choice.counts = true;
        choice.from_ideal = false;
        if (choice.name == rule) set(choice);
      }
    try {
      saved(made);
    } catch (const RuleRefused& e) {
      EXPECT_EQ(test::read_text(folder / "scenes/refused.json"), first);
      EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path() / "scenes"), {}), 1);
      return e.rule + (e.no_target ? " without a target" : " out of range");
    }
    return std::string("not refused");
  };
  const haptics::TissueVolume untouched = load_tissue(base);
  EXPECT_EQ(refused(
                "floor_depth_mm", [](RuleChoice& c) { c.from_ideal = true; }, &untouched),
            "floor_depth_mm without a target")
      << "the ideal has no floor";
  EXPECT_EQ(refused(
                "taper_deg", [](RuleChoice& c) { c.from_ideal = true; }, nullptr),
            "taper_deg without a target");
  EXPECT_EQ(refused(
                "taper_deg", [](RuleChoice& c) { c.weight = -1; }, nullptr),
            "taper_deg out of range");
  EXPECT_EQ(refused(
                "taper_deg", [](RuleChoice& c) { c.target = 6; }, nullptr),
            "not refused");
}

TEST_F(Exercise, AMeshCanBeTheIdealAndAnInvalidOneIsRefusedBeforeAnyFileIsWritten) {
  // Writes the block with its top cut down to z = 2 mm.
  folder.write("lower.obj",
               obj_of({"-3 -3 -3", "3 -3 -3", "3 3 -3", "-3 3 -3", "-3 -3 2", "3 -3 2", "3 3 2", "-3 3 2"}, kBoxFaces));
  const Scene scene = read_scene(saved({.name = "Lower", .base = &base, .ideal_mesh = folder / "lower.obj"}));
  const haptics::TissueVolume start = load_tissue(scene);
  const auto ideal = ideal_tissue(scene, start);
  ASSERT_TRUE(ideal);
  const auto enamel = static_cast<std::size_t>(Tissue::kEnamel);
  EXPECT_NEAR((start.volumes()[enamel] - ideal->volumes()[enamel]) / kCubicMillimetre, 36, 2);

  folder.write("none.obj", "v 0 0 0\n");
  EXPECT_THROW(saved({.name = "None", .base = &base, .ideal_mesh = folder / "none.obj"}), Error);
  EXPECT_FALSE(std::filesystem::exists(folder / "scenes/none.json"));
}

TEST_F(Exercise, AnImportedToothIsUprightAtTheCentreOfTheRigsView) {
  // Writes a box of 2 × 3 × 8 mm whose crown points along −y.
  folder.write("box.obj",
               obj_of({"50 0 0", "52 0 0", "52 8 0", "50 8 0", "50 0 3", "52 0 3", "52 8 3", "50 8 3"}, kBoxFaces));
  NewTooth tooth{.input = folder / "box.obj", .name = "My box", .crown = Crown::kFront};
  tooth.options.voxel = 0.2e-3;
  const Scene scene = imported(tooth);
  const haptics::TissueVolume volume = load_tissue(scene);
  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  const dvec3 size = dvec3(hi - lo) * volume.frame().voxel / kMillimetre;
  EXPECT_GT(size.z, size.x + 3) << "it stands";
  EXPECT_GT(size.z, size.y + 3);
  const dvec3 top = volume.frame().to_world(dvec3((lo.x + hi.x) / 2.0, (lo.y + hi.y) / 2.0, hi.z)) / kMillimetre;
  EXPECT_NEAR(top.x, 6.8, 0.3);
  EXPECT_NEAR(top.y, 6.0, 0.3);
  EXPECT_NEAR(top.z, 20.2, 2) << "the band lies above it";
}

TEST_F(Exercise, AToothWhoseSceneCannotBeWrittenLeavesNoFile) {
  folder.write("corner.obj", kCorner);
  std::filesystem::create_directories(folder / "scenes/Corner.json/in the way");
  NewTooth tooth{.input = folder / "corner.obj", .name = "Corner"};
  tooth.options.voxel = 0.5e-3;
  Progress progress;
  EXPECT_THROW(import_tooth(tooth, progress), Error);
  EXPECT_FALSE(std::filesystem::exists(folder / "scenes/Corner.vdb"));
}

/// Returns an open sheet of 12 × 8 units at z = 0 as an OBJ file. Its face points up. Each coordinate is multiplied by
/// `scale`.
std::string open_sheet(double scale) {
  std::string obj;
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 3; ++y) obj += fmt::format("v {} {} 0\n", 4 * x * scale, 4 * y * scale);
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 2; ++y) {
      const int a = 1 + 3 * x + y;
      obj += fmt::format("f {} {} {}\nf {} {} {}\n", a, a + 3, a + 4, a, a + 4, a + 1);
    }
  return obj;
}

TEST_F(Exercise, AFailedOrCancelledImportChangesNoFile) {
  for (const bool scanned : {false, true}) {
    folder.write("tooth.obj", scanned ? open_sheet(1) : kCorner);
    NewTooth tooth{.input = folder / "tooth.obj", .name = "Tooth", .as_scanned = scanned};
    if (!scanned) tooth.options.voxel = 0.5e-3;
    Progress progress, cancelled;
    import_tooth(tooth, progress);
    const std::string extension = scanned ? ".stl" : ".vdb";
    const auto files = [&] {
      return std::pair(test::read_text(folder / "scenes/Tooth.json"),
                       test::read_text(folder / ("scenes/Tooth" + extension)));
    };
    folder.write("scenes/Tooth.json", "a note of the user, which is no scene");
    const auto before = files();
    if (scanned) {
      EXPECT_EQ(before.second.size(), 84u + 12 * 50);
    }
    EXPECT_GT(before.second.size(), scanned ? 0u : 1000u);
    if (scanned)
      folder.write("tooth.obj", open_sheet(1.5));
    else
      tooth.options.voxel = 0.6e-3;
    EXPECT_THROW(import_tooth(tooth, progress), Error);
    EXPECT_EQ(files(), before);
    cancelled.cancel();
    tooth.name = "Another";
    EXPECT_THROW(import_tooth(tooth, cancelled), Cancelled);
    for (const std::string& end : {std::string(".json"), extension})
      EXPECT_FALSE(std::filesystem::exists(folder / ("scenes/Another" + end))) << end;
    std::filesystem::remove(folder / "scenes/Tooth.json");
  }
}

TEST_F(Exercise, AScannedSurfaceStaysOpenAndIsCarvedAsTheMeshItIs) {
  folder.write("sheet.obj", open_sheet(1));
  NewTooth tooth{.input = folder / "sheet.obj", .name = "My scan", .as_scanned = true, .crown = Crown::kDown};
  const Scene scene = imported(tooth);
  EXPECT_EQ(model_name(scene), "vertex");
  const haptics::TissueVolume volume = load_tissue(scene);
  EXPECT_FALSE(volume.exact_outside()) << "it is open";
  ASSERT_TRUE(volume.mesh());
  const haptics::TissueMesh& mesh = *volume.mesh();
  ASSERT_EQ(mesh.vertices.size(), 12u);
  ASSERT_EQ(mesh.triangles.size(), 12u);
  dvec3 lo(mesh.vertices.front()), hi(lo);
  for (const dvec3& p : mesh.vertices) lo = glm::min(lo, p), hi = glm::max(hi, p);
  const dvec3 size = (hi - lo) / kMillimetre, top = dvec3((lo.x + hi.x) / 2, (lo.y + hi.y) / 2, hi.z) / kMillimetre;
  EXPECT_LT(glm::length(size - dvec3(12, 8, 0)), 1e-4);
  EXPECT_LT(glm::length(top - dvec3(6.8, 6, 20.2)), 1e-4) << "where the rigs look";
  const glm::uvec3& t = mesh.triangles.front();
  const dvec3 a = mesh.vertices[t.x];
  EXPECT_LT(glm::cross(mesh.vertices[t.y] - a, mesh.vertices[t.z] - a).z, 0) << "upside down, not a mirror image";
}

TEST_F(Exercise, TheHighestPointOfAScannedArchIsAtTheCentreOfTheRigsView) {
  // Two triangles are 40 mm apart, with nothing between them.
  folder.write("arch.obj", "v 0 0 0\nv 5 0 0\nv 0 5 1\nv 40 0 0\nv 45 0 3\nv 40 5 0\nf 1 2 3\nf 4 5 6\n");
  const haptics::TissueVolume volume =
      load_tissue(imported({.input = folder / "arch.obj", .name = "Arch", .as_scanned = true}));
  dvec3 top(-1);
  for (const dvec3& p : volume.mesh()->vertices)
    if (p.z > top.z) top = p;
  EXPECT_LT(glm::length(top / kMillimetre - dvec3(6.8, 6, 20.2)), 1e-4);
}

TEST_F(Exercise, AScannedSurfaceInMetresIsTakenAsSuchUnlessAUnitIsGiven) {
  folder.write("metres.obj", open_sheet(1e-3));
  const auto extent = [&](double unit) {
    NewTooth tooth{.input = folder / "metres.obj", .name = "Metres", .as_scanned = true};
    tooth.options.mesh_unit = unit;
    const haptics::TissueVolume volume = load_tissue(imported(tooth));
    double lo = 1, hi = -1;
    for (const dvec3& p : volume.mesh()->vertices) lo = std::min(lo, p.x), hi = std::max(hi, p.x);
    return (hi - lo) / kMillimetre;
  };
  EXPECT_NEAR(extent(kMillimetre), 12, 1e-4);
  EXPECT_NEAR(extent(2), 24, 1e-4);
  EXPECT_THROW(extent(1e-4), Error) << "too small in the unit that was given";
}

TEST_F(Exercise, FilesOfTheRequestedKindAreListedAndAnUnreadableFolderIsEmpty) {
  std::filesystem::create_directories(folder / "scans/old");
  for (const char* name : {"scans/b.STL", "scans/a.ply", "scans/c.txt", "scans/.hidden.stl", "scans/d.nii.gz"})
    folder.write(name, "");
  FileChooser chooser;
  list_folder(chooser, folder / "scans", tooth_extensions());
  EXPECT_EQ(chooser.folders, std::vector<std::filesystem::path>{"old"});
  EXPECT_EQ(chooser.files, (std::vector<std::filesystem::path>{"a.ply", "b.STL", "d.nii.gz"}));
  list_folder(chooser, folder / "nowhere", tooth_extensions());
  EXPECT_TRUE(chooser.files.empty());
}

/// Writes a recording of one second into this folder, as for the trainee to whom the folder belongs.
std::filesystem::path session_of(const std::filesystem::path& folder, const std::string& file,
                                 const std::string& scene) {
  std::filesystem::create_directories(folder);
  session::SessionHeader header = session::test::some_header();
  header.scene_json = fmt::format("{{\"name\": \"{}\"}}", scene);
  header.streams.clear();
  session::SessionWriter writer(folder / file, header);
  writer.append(session::test::random_ticks(1000, 1));
  writer.finish({});
  return folder / file;
}

TEST_F(Exercise, ReportsCompareWithTheNewestExpertSessionOfTheExercise) {
  const auto ours = session_of(folder / "sessions/bo", "2026-02-02_10-00-00_pit.h5", "pit");
  const session::SessionReader reader(ours);
  const auto experts = expert_folder(ours.parent_path());
  EXPECT_FALSE(expert_session(experts, reader));
  make_expert(session_of(folder / "sessions/ada", "2026-01-01_10-00-00_pit.h5", "pit"));
  make_expert(session_of(folder / "sessions/ada", "2026-03-01_10-00-00_other.h5", "other"));
  ASSERT_TRUE(expert_session(experts, reader));
  EXPECT_EQ(expert_session(experts, reader)->file, "2026-01-01_10-00-00_pit.h5");
  EXPECT_THROW(make_expert(folder / "sessions/ada/none.h5"), Error);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(experts), {}), 2) << "nothing half written";
}

TEST_F(Exercise, ChoicesAreStoredAndADamagedStoreIsIgnored) {
  EXPECT_FALSE(remembered().any);
  remember({.language = "de", .trainee = "Zoë \"Z\"", .record = false});
  const Remembered r = remembered();
  EXPECT_TRUE(r.any);
  EXPECT_EQ(r.language, "de");
  EXPECT_EQ(r.trainee, "Zoë \"Z\"");
  EXPECT_FALSE(r.record);
  folder.write("settings.json", "{\"language\": 3");
  EXPECT_FALSE(remembered().any);
}

TEST_F(Exercise, ATraineesNameCannotLeadOutOfTheFolder) {
  const auto file = new_session_file("../../etc/x", "a/b");
  EXPECT_EQ(file.parent_path().parent_path(), folder.path() / "sessions") << file;
  EXPECT_EQ(new_session_file("", "a").parent_path().filename(), "guest");
}

}  // namespace
}  // namespace typodont
