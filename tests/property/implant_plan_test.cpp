// Tests of planning an implant: in a jaw that is imported from a scan and known exactly (synthetic,
// tests/support/jaw_phantom.h), and in the shipped scenes.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "engine/app/assets.h"
#include "engine/app/planning/implant_planner.h"
#include "engine/app/planning/planned_exercise.h"
#include "engine/app/scene/implant_scene.h"
#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/import/import.h"
#include "tests/support/folder.h"
#include "tests/support/jaw_phantom.h"

namespace typodont {
namespace {

namespace fs = std::filesystem;
using test::JawPhantom;

fs::path fresh_folder(const std::string& name) {
  const fs::path folder = test::scratch(name);
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

/// Returns a scene with a jaw without its second tooth, imported with its grey values.
Scene scanned_jaw() {
  const fs::path folder = fresh_folder("implant_plan_jaw");
  test::JawArtefacts artefacts;
  artefacts.teeth = 1;
  const JawPhantom jaw(artefacts);
  haptics::ImportOptions options;
  options.preset = haptics::ImportPreset::kJaw;
  const auto scan = test::write_nrrd("implant_plan.nrrd", jaw.phantom(), test::bytes_as<float>(jaw.scan()), "float");
  haptics::TissueVolume(haptics::import_tissue(scan, options).tissue).save(folder / "jaw.vdb");
  const nlohmann::ordered_json text = {{"name", "jaw"}, {"tissue", {{"volume", "jaw.vdb"}}}, {"tool", "round_012"}};
  return parse_scene(Json::parse(text.dump(), "jaw.json"), folder / "jaw.json");
}
const ImplantPlanner& scanned() {
  static const ImplantPlanner planner(scanned_jaw());
  return planner;
}

ImplantProcedure small_implant() {
  return read_procedure("implants/procedures/bone_level_41_10.json", {});
}
session::ImplantPlan upright(const ImplantProcedure& procedure, const dvec3& entry_mm) {
  return {entry_mm * kMillimetre, {0, 0, -1}, procedure.length, procedure.diameter, procedure.bed_diameter};
}
std::string error_of(const PlannedExercise& exercise, const fs::path& file) {
  Progress unwatched;
  return test::refusal([&] { write_planned_exercise(exercise, file, Over::kItsInput, unwatched); });
}

TEST(ImplantPlanner, FindsTheCanalOfAScannedJawAsAPath) {
  ASSERT_EQ(scanned().canals().size(), 1u);
  const NerveCanal& canal = scanned().canals().front();
  EXPECT_NEAR(canal.radius / kMillimetre, JawPhantom::kCanal, 0.4);
  ASSERT_GE(canal.path_W.size(), 8u);
  for (const dvec3& p : canal.path_W) {
    const dvec3 mm = p / kMillimetre, truth = JawPhantom::canal_centre(mm.x);
    EXPECT_LT(std::hypot(mm.y - truth.y, mm.z - truth.z), 0.5) << mm.x;
  }
}

TEST(ImplantPlanner, DistancesToCanalAndToothAreThoseOfTheScannedJaw) {
  const session::ImplantPlan plan = upright(small_implant(), {20, 12, 22});
  const PlanFindings found = scanned().findings(plan);
  EXPECT_TRUE(found.fits());
  // The apex is at z = 12, one millimetre beside the canal's centre, so the canal is below the apex.
  const double below = plan.apex_W().z / kMillimetre - JawPhantom::canal_centre(20).z;
  EXPECT_NEAR(found.canal_distance / kMillimetre, below - JawPhantom::kCanal, 0.5);
  const double between = 20 - JawPhantom::kTeeth[0] - JawPhantom::root_radius(22) - plan.diameter / 2 / kMillimetre;
  EXPECT_NEAR(found.tooth_distance / kMillimetre, between, 0.4);
  EXPECT_GT(found.mean_grey, 300);
  EXPECT_LT(found.mean_grey, 1600);
}

TEST(ImplantPlanner, ProposesAnImplantInBoneClearOfTheCanal) {
  const ImplantProcedure procedure = small_implant();
  const session::ImplantPlan plan = scanned().proposal(procedure);
  const PlanFindings found = scanned().findings(plan);
  EXPECT_TRUE(found.fits());
  EXPECT_GE(found.canal_distance, procedure.canal_margin);
  EXPECT_GT(found.tooth_distance, 0);
}

TEST(ImplantPlanner, APlanInAScanBecomesAnExerciseAtTheSite) {
  const ImplantProcedure procedure = small_implant();
  const session::ImplantPlan plan = upright(procedure, {20, 12, 22});
  const fs::path file = fresh_folder("implant_plan_site") / "site.json";
  ASSERT_EQ(error_of({"site", &scanned(), procedure, plan}, file), "");
  // The jaw's own file must not be replaced by the smaller volume around the implant.
  const fs::path jaw = volume_file(scanned().scene());
  EXPECT_NE(error_of({"jaw", &scanned(), procedure, plan}, fs::path(jaw).replace_extension(".json")).find("the jaw"),
            std::string::npos);
  // The exercise may be planned again. But a file with another volume under this name must not be overwritten.
  EXPECT_EQ(error_of({"site", &scanned(), procedure, plan}, file), "");
  const fs::path foreign = file.parent_path() / "foreign.vdb";
  fs::copy_file(jaw, foreign);
  EXPECT_NE(error_of({"foreign", &scanned(), procedure, plan}, fs::path(foreign).replace_extension(".json"))
                .find("does not belong to foreign.json"),
            std::string::npos);
  EXPECT_EQ(fs::file_size(foreign), fs::file_size(jaw));
  EXPECT_FALSE(fs::exists(fs::path(foreign).replace_extension(".json")));
  const Scene scene = read_scene(file);
  ASSERT_TRUE(scene.implant);
  EXPECT_EQ(scene.implant->phases.size(), 14u);
  EXPECT_EQ(scene.task->steps.size(), 14u);
  const haptics::TissueVolume tissue = load_untouched(scene);
  EXPECT_TRUE(tissue.graded());
  // The tissue at the implant's site is the same tissue, only displaced. So the planner must find the same structures
  // there.
  const ImplantPlanner there(scene);
  const PlanFindings before = scanned().findings(plan), after = there.findings(scene.implant->plan);
  EXPECT_NEAR(after.canal_distance, before.canal_distance, 0.05e-3);
  EXPECT_NEAR(after.tooth_distance, before.tooth_distance, 0.4e-3);
  EXPECT_NEAR(after.mean_grey, before.mean_grey, 0.03 * before.mean_grey);
}

TEST(ImplantPlanner, AnImplantThatLeavesTheBoneIsRefusedAndNothingIsWritten) {
  const ImplantProcedure procedure = small_implant();
  const session::ImplantPlan plan = upright(procedure, {20, 6, 22});
  EXPECT_FALSE(scanned().findings(plan).fits());
  const fs::path folder = fresh_folder("implant_plan_refused");
  EXPECT_NE(error_of({"site", &scanned(), procedure, plan}, folder / "site.json").find("leaves the jaw"),
            std::string::npos);
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST(ImplantPlanner, SyntheticBoneOfEachClassTakesThePlanAndBecomesDenserTowardsClassI) {
  auto json = nlohmann::ordered_json::parse(std::ifstream(assets_folder() / "scenes" / "implant-molar.json"));
  json["tissue"]["bone"]["voxel_mm"] = 0.3;
  const Scene scene = parse_scene(Json::parse(json.dump(), "scene.json"), assets_folder() / "scenes" / "scene.json");
  EXPECT_EQ(bone_class_of(scene), "II");
  double last = 1e9;
  for (const char* name : {"I", "II", "III", "IV"}) {
    const ImplantPlanner planner(with_bone_class(scene, name));
    EXPECT_EQ(bone_class_of(planner.scene()), name);
    const PlanFindings found = planner.findings(planner.scene().implant->plan);
    EXPECT_TRUE(found.fits()) << name;
    EXPECT_LT(found.mean_grey, last) << name;
    last = found.mean_grey;
  }
  EXPECT_THROW(with_bone_class(scene, "V"), Error);
  EXPECT_THROW(with_bone_class(scanned().scene(), "II"), Error);
}

TEST(ImplantPlanner, TissueWithoutGreyValuesIsRefused) {
  EXPECT_THAT(
      test::refusal([&] { const ImplantPlanner planner(read_scene(assets_folder() / "scenes" / "tutorial.json")); }),
      testing::HasSubstr("without grey values"));
}

/// exercise.json contains the same blocks of text as the shipped scenes. They must stay equal.
TEST(ImplantPlanner, AShippedScenesOwnPlanGivesTheShippedExercise) {
  const auto json = nlohmann::json::parse(std::ifstream(assets_folder() / "scenes" / "implant-molar.json"));
  auto coarse = json;
  coarse["tissue"]["bone"]["voxel_mm"] = 0.3;
  const Scene scene = parse_scene(Json::parse(coarse.dump(), "scene.json"), assets_folder() / "scenes" / "scene.json");
  const ImplantPlanner planner(scene);
  const ImplantProcedure procedure = read_procedure("implants/procedures/bone_level_48_12.json", {});
  const fs::path file = fresh_folder("implant_plan_shipped") / "molar.json";
  ASSERT_EQ(error_of({"molar", &planner, procedure, planner.proposal(procedure)}, file), "");
  const auto made = nlohmann::json::parse(std::ifstream(file));
  for (const char* key :
       {"tool_set", "tools", "spindle", "model", "coupling", "force_limit_N", "torque_limit_Nmm", "materials", "parts"})
    EXPECT_EQ(made[key], json[key]) << key;
  EXPECT_EQ(made["implant"]["procedure"], json["implant"]["procedure"]);
  for (const char* key : {"goal", "steps", "defaults", "rules"}) EXPECT_EQ(made["task"][key], json["task"][key]) << key;
}

}  // namespace
}  // namespace typodont
