// Tests of the exercise in implant surgery: bone, plan, procedure, the simulated expert, and scores.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "engine/app/assets.h"
#include "engine/app/hands/implant_expert.h"
#include "engine/app/scene.h"
#include "engine/app/scene/implant_scene.h"
#include "engine/app/tissue/bone_tissue.h"
#include "engine/app/tissue/sampled_tissue.h"
#include "engine/base/units.h"
#include "haptics/dense_tissue.h"
#include "haptics/import/mesh_solid.h"
#include "haptics/lockstep.h"
#include "tests/support/campaign.h"
#include "tests/support/folder.h"

namespace typodont {
namespace {

namespace fs = std::filesystem;

fs::path scene_file(const std::string& name) {
  return assets_folder() / "scenes" / (name + ".json");
}
nlohmann::ordered_json json_of(const std::string& name) {
  std::ifstream in(scene_file(name));
  return nlohmann::ordered_json::parse(in);
}
Scene scene_from(const nlohmann::ordered_json& json) {
  return parse_scene(Json::parse(json.dump(), "scene.json"), "scene.json", scene_file("x").parent_path());
}
std::string error_of(const nlohmann::ordered_json& json, bool load = false) {
  return test::refusal([&] {
    const Scene scene = scene_from(json);
    if (load) load_untouched(scene);
  });
}

haptics::DenseTissue haptics_tissue(const Scene& scene) {
  return sampled_tissue(*scene.tissue, {.find = [&](const Json& name) { return find_file(name, scene.place); },
                                        .read_mesh = haptics::read_mesh_solid});
}

TEST(ImplantScenes, TheShippedPlansLieInBoneAndAwayFromTheCanal) {
  for (const char* name : {"implant-molar", "implant-premolar", "implant-front", "implant-molar-soft"}) {
    const Scene scene = read_scene(scene_file(name));
    ASSERT_TRUE(scene.implant) << name;
    const NerveCanal canal = read_nerve_canal(*scene.tissue);
    if (!canal.path_W.empty()) {
      EXPECT_GT(canal.distance(scene.implant->plan.apex_W()), 2e-3) << name;
    }
    auto coarse = json_of(name);
    coarse["tissue"]["bone"]["voxel_mm"] = 0.3;
    EXPECT_EQ(error_of(coarse, true), "") << name;
  }
}

TEST(ImplantScenes, TeethAndGumStandBesideAFlapAndLeaveTheDrilledBoneAsItWas) {
  constexpr double kAround = 2.5e-3, kAbove = 2e-3;  // m: beside the planned axis, above the entry
  for (const char* name : {"implant-molar", "implant-premolar", "implant-front"}) {
    auto json = json_of(name);
    auto& bone = json["tissue"]["bone"];
    bone["voxel_mm"] = 0.3;
    const Scene scene = scene_from(json);
    const haptics::DenseTissue dressed = haptics_tissue(scene);
    bone.erase("teeth"), bone.erase("gum");
    const haptics::DenseTissue bare = haptics_tissue(scene_from(json));
    ASSERT_EQ(dressed.size, bare.size);
    const session::ImplantPlan& plan = scene.implant->plan;
    std::map<Tissue, int> count;
    int drilled = 0;
    for (int x = 0; x < bare.size.x; ++x)
      for (int y = 0; y < bare.size.y; ++y)
        for (int z = 0; z < bare.size.z; ++z) {
          const std::size_t i = bare.at(x, y, z);
          if (dressed.distance[i] < 0) ++count[dressed.tissue[i]];
          const dvec3 from = bare.frame.to_world(dvec3(x, y, z)) - plan.entry_W;
          const double deep = glm::dot(from, plan.axis_W);
          if (deep < -kAbove || deep > plan.length || glm::length(from - deep * plan.axis_W) > kAround) continue;
          EXPECT_EQ(dressed.distance[i] < 0, bare.distance[i] < 0) << name;
          if (bare.distance[i] >= 0) continue;
          ++drilled;
          ASSERT_EQ(dressed.tissue[i], bare.tissue[i]) << name;
          ASSERT_EQ(dressed.hardness[i], bare.hardness[i]) << name;
        }
    EXPECT_GT(drilled, 3000) << name;
    for (const Tissue tissue : {Tissue::kEnamel, Tissue::kDentin, Tissue::kGingiva})
      EXPECT_GT(count[tissue], 1000) << name;
  }
}

TEST(ImplantScenes, BoneHasAShellANerveInItsCanalAndGreyValuesOfItsClass) {
  auto json = json_of("implant-molar");
  json["tissue"]["bone"]["voxel_mm"] = 0.2;
  const Scene scene = scene_from(json);
  const haptics::TissueVolume bone = load_untouched(scene);
  EXPECT_TRUE(bone.graded());
  const auto look = [&](const dvec3& p_mm) {
    float d;
    Tissue t;
    std::uint8_t hardness;
    bone.copy(glm::ivec3(glm::round(bone.frame().to_voxels(p_mm * kMillimetre))), glm::ivec3(1), &d, &t, &hardness);
    return std::tuple(d, t, haptics::hardness_fraction(hardness));
  };
  const auto [canal_d, canal_t, canal_h] = look({6.8, 3.2, 1.5});
  EXPECT_LT(canal_d, 0);
  EXPECT_EQ(canal_t, kNerve);
  const auto [wall_d, wall_t, wall_h] = look({6.8, 3.2, 1.5 + 1.5 + 0.2});
  EXPECT_EQ(wall_t, Tissue::kCorticalBone) << "the canal has a wall";
  const auto [crest_d, crest_t, crest_h] = look({6.8, 5.8, 18.0});
  EXPECT_LT(crest_d, 0);
  EXPECT_EQ(crest_t, Tissue::kCorticalBone) << "the ridge has a shell of its own";
  EXPECT_NEAR(crest_h, 1.0, 0.01);
  double sum = 0;
  int n = 0;
  for (double x = 2; x < 12; x += 0.5) {
    const auto [d, t, h] = look({x, 5.3, 11});
    if (t != Tissue::kCancellousBone) continue;
    sum += h, ++n;
  }
  ASSERT_GT(n, 10);
  EXPECT_NEAR(sum / n * load_bone_grey().cancellous, 1050, 100) << "class II";
}

TEST(ImplantScenes, WrongInputIsRefusedWithItsPlace) {
  auto json = json_of("implant-molar");
  json["tools"][3] = "pilot_99";
  EXPECT_NE(error_of(json).find("pilot_99"), std::string::npos);
  EXPECT_NE(error_of(json).find("pilot_22"), std::string::npos) << "names those there are";

  json = json_of("implant-molar");
  json["tools"].erase(3);
  EXPECT_NE(error_of(json).find("not among the scene's tools"), std::string::npos) << error_of(json);

  json = json_of("implant-molar");
  json["tissue"]["bone"]["voxel_mm"] = 0.3;
  json["implant"]["plan"]["entry_mm"] = {6.8, 12.5, 18};
  EXPECT_NE(error_of(json, true).find("leaves the jaw"), std::string::npos) << error_of(json, true);

  json = json_of("implant-molar");
  json["tissue"]["bone"]["class"] = "V";
  EXPECT_NE(error_of(json).find("one of: I, II, III, IV"), std::string::npos) << error_of(json);

  json = json_of("implant-molar");
  json["tissue"] = {{"voxel_mm", 0.3},
                    {"solids",
                     {{{"tissue", "cortical_bone"},
                       {"solid", {{"box", {{"center_mm", {6.8, 5.8, 8}}, {"size_mm", {20, 20, 20}}}}}}}}}};
  EXPECT_NE(error_of(json, true).find("without grey values"), std::string::npos) << error_of(json, true);

  json = json_of("implant-molar");
  json["model"] = "offset";
  EXPECT_NE(error_of(json).find("\"model\": \"implant\""), std::string::npos) << error_of(json);
}

/// A copy of the shipped set of tools in which tools with threads turn at `rpm`. It is in a folder of its own, which is
/// removed with this object.
class OtherSet {
 public:
  explicit OtherSet(double rpm) {
    fs::create_directories(folder_);
    for (const auto& entry : fs::directory_iterator(assets_folder() / "implants" / "bone_level")) {
      std::ifstream in(entry.path());
      auto json = nlohmann::ordered_json::parse(in);
      auto& block = json["implant"];
      if (block.contains("thread") && block.contains("speed_rpm")) {
        block["speed_rpm"] = rpm;
        block["top_speed_rpm"] = 1.5 * rpm;
      }
      std::ofstream(folder_ / entry.path().filename()) << json;
    }
  }
  ~OtherSet() { fs::remove_all(folder_); }
  OtherSet(const OtherSet&) = delete;
  OtherSet& operator=(const OtherSet&) = delete;
  std::string folder() const { return folder_.string(); }

 private:
  fs::path folder_ = fs::temp_directory_path() / fmt::format("typodont_other_set_{}", getpid());
};

TEST(ImplantScenes, AnotherManufacturersSetIsAFolderOfFiles) {
  const OtherSet set(60);
  auto json = json_of("implant-molar");
  json["tool_set"] = set.folder();
  const Scene scene = scene_from(json);
  const auto tap = std::find_if(scene.servo.tools.begin(), scene.servo.tools.end(),
                                [](const haptics::Tool& tool) { return tool.name == "tap_48"; });
  ASSERT_NE(tap, scene.servo.tools.end());
  EXPECT_NEAR(tap->implant->speed, 2 * kPi, 1e-9);
}

struct Done {
  session::ImplantMeasures measures;
  std::string gave_up;
  double seconds = 0;
  // N, change of force along or across the tool's axis at a switch of state, beyond the hand's own and beyond the
  // changes in the ticks before and after, in which the tool advances as fast
  double max_switch_step = 0;
};
/// Runs the expert in a scene without the coupling's damper. The force of the damper changes with the hand's speed and
/// not with a switch of state.
Done expert_in(nlohmann::ordered_json json, double rate) {
  json["coupling"]["damping_Ns_per_mm"] = 0;
  const Scene scene = scene_from(json);
  haptics::TissueVolume tissue = load_untouched(scene);
  const haptics::ServoSettings settings = servo_settings(scene, tissue, rate);
  haptics::LockStep steps(std::move(tissue), settings);
  ImplantExpert hand(scene, rate);
  session::ImplantMeter meter(*scene.implant);
  haptics::HandSample sample;
  ServoTick tick, last;
  Cut cut;
  Done done;
  struct Change {
    double along = 0, across = 0, own = 0;  // N; `own`: by the hand's motion
    bool switches = false;
  } before, switched;
  while (hand.read(sample)) {
    steps.tick(sample, tick, cut);
    hand.see(tick);
    meter.add({&tick, 1});
    Change change;
    if (tick.index > 0) {
      const dvec3 by = tick.f_T_W - last.f_T_W, axis = tick.X_WT.R * dvec3(0, 0, 1);
      const double along = glm::dot(by, axis);
      change = {std::abs(along), glm::length(by - along * axis),
                settings.stiffness * glm::length(tick.X_WT.p - last.X_WT.p), (tick.level == 0) != (last.level == 0)};
    }
    if (switched.switches) {
      done.max_switch_step =
          std::max({done.max_switch_step, switched.along - std::max({before.along, change.along, switched.own}),
                    switched.across - std::max({before.across, change.across, switched.own})});
    }
    before = std::exchange(switched, change);
    last = tick;
  }
  done.measures = meter.result();
  measure_bed(*scene.implant, steps.carver().volume(), done.measures);
  done.gave_up = hand.gave_up();
  done.seconds = to_seconds(last.t);
  return done;
}
void expect_to_plan(const Done& done, std::size_t phases, double depth, double diameter) {
  EXPECT_EQ(done.gave_up, "");
  EXPECT_LT(done.seconds, 120);
  ASSERT_EQ(done.measures.phases.size(), phases);
  for (const auto& phase : done.measures.phases) {
    EXPECT_TRUE(phase.done) << phase.name[0];
    EXPECT_GE(phase.force.along.size(), 2u) << phase.name[0];
  }
  const session::ImplantBedMeasures& bed = done.measures.bed;
  EXPECT_TRUE(done.measures.placed);
  EXPECT_NEAR(bed.depth, depth, 0.1e-3);
  EXPECT_LT(bed.axis_error, 0.2 * kDegree);
  EXPECT_LT(bed.entry_error, 0.1e-3);
  EXPECT_LT(bed.apex_error, 0.15e-3);
  EXPECT_NEAR(bed.diameter, diameter, 0.1e-3);
  EXPECT_LT(bed.ovality, 0.1e-3);
  EXPECT_GT(bed.canal_distance, 2e-3);
  EXPECT_GT(done.measures.insertion_torque, 0.01);
  EXPECT_LT(done.measures.insertion_torque, 0.5);
  EXPECT_GT(done.measures.bone_contact, 0.9);
  EXPECT_LT(done.measures.hottest, 43);
  EXPECT_LT(done.max_switch_step, 0.02);
}

/// Uses coarse bone, fast threads and few ticks, so that the test takes seconds. ./run stress uses the shipped values,
/// at all sites.
TEST(ImplantExpert, CompletesAllPhasesAsPlanned) {
  if (test::campaign(1) > 1) {
    expect_to_plan(expert_in(json_of("implant-premolar"), 1000), 16, 12e-3, 4.2e-3);
    expect_to_plan(expert_in(json_of("implant-molar"), 1000), 16, 12e-3, 4.2e-3);
    expect_to_plan(expert_in(json_of("implant-molar-soft"), 1000), 16, 12e-3, 4.2e-3);
    expect_to_plan(expert_in(json_of("implant-front"), 1000), 14, 10e-3, 3.5e-3);
    return;
  }
  const OtherSet quick(60);
  for (const char* name : {"implant-premolar", "implant-molar-soft"}) {
    SCOPED_TRACE(name);
    auto json = json_of(name);
    json["tissue"]["bone"]["voxel_mm"] = 0.2;
    json["tool_set"] = quick.folder();
    expect_to_plan(expert_in(json, 500), 16, 12e-3, 4.2e-3);
  }
}

}  // namespace
}  // namespace typodont
