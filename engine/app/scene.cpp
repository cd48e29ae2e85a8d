#include "engine/app/scene.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/app/assets.h"
#include "engine/app/scene/handpiece_file.h"
#include "engine/app/scene/implant_scene.h"
#include "engine/app/surroundings/soft_gum.h"
#include "engine/app/tissue/bone_tissue.h"
#include "engine/app/tissue/paint_file.h"
#include "engine/app/tissue/sampled_tissue.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/units.h"
#include "engine/session/packing_file.h"
#include "engine/session/place.h"
#include "haptics/contact_method.h"
#include "haptics/import/mesh_solid.h"
#include "haptics/import/mesh_tissue.h"
#include "haptics/packing.h"
#include "haptics/solid.h"
#include "haptics/tissue_mesh.h"
#include "haptics/tool.h"

namespace typodont {

namespace fs = std::filesystem;

namespace {

/// Registers the function that loads the sphere packing of a scene's model {"packing": {"file": "P.h5"}}, because the
/// module haptics does not link HDF5.
const haptics::PackingLoaderRegistration kPackings{session::load_packing};
const haptics::ToolMeshReaderRegistration kToolMeshes{haptics::read_mesh_solid};

constexpr std::string_view kTissueForms = "an object with \"volume\", \"mesh\", \"bone\" or \"solids\"";
constexpr double kLitrePerMinute = 1e-3 / 60;       // m³/s, one litre per minute
constexpr double kMillilitrePerMinute = 1e-6 / 60;  // m³/s, one millilitre per minute
constexpr double kNewtonMillimetre = 1e-3;          // N·m, one newton millimetre
// Ranges of the force and torque limits that a scene may state. The largest values suffice for reaming an acetabulum
// (hip socket), which needs 200 N; a 60 mm reamer then needs 6 N·m at its rim.
constexpr double kMinForceLimit = 0.1, kMaxForceLimit = 300;    // N, smallest and largest force limit
constexpr double kMinTorqueLimit = 1e-3, kMaxTorqueLimit = 20;  // N·m, smallest and largest torque limit
constexpr std::array<std::string_view, 6> kParts = {"haptics", "render", "sound", "debris", "record", "score"};

/// Finds the mesh files to which a scene's solids refer: first beside the scene's file, then in the assets.
haptics::SolidFiles files_of(const ScenePlace& place) {
  return {.find = [place](const Json& name) { return find_file(name, place); }, .read_mesh = haptics::read_mesh_solid};
}

void read_edges(const Json& json, std::string_view kind, EdgeLaw& law) {
  const auto edges = json.find(kind);
  if (!edges) return;
  edges->allow_only({"energy_ratio", "chip_um", "exponent", "force_ratio"});
  law.energy_ratio = edges->number_or("energy_ratio", law.energy_ratio, 0.01, 100);
  law.chip = edges->number_or("chip_um", law.chip / kMicrometre, 0.001, 1000) * kMicrometre;
  law.exponent = edges->number_or("exponent", law.exponent, 0, 0.9);
  law.force_ratio = edges->number_or("force_ratio", law.force_ratio, 0, 2);
}

}  // namespace

void read_material(const Json& json, Material& m) {
  json.allow_only({"stiffness_N_per_mm", "specific_energy_J_per_mm3", "static_friction", "dynamic_friction",
                   "density_g_per_cm3", "color", "blade", "grit", "source", "looks_like"});
  m.stiffness =
      json.number_or("stiffness_N_per_mm", m.stiffness / kNewtonPerMillimetre, 0, 1000) * kNewtonPerMillimetre;
  m.specific_energy =
      json.number_or("specific_energy_J_per_mm3", m.specific_energy / kJoulePerCubicMillimetre, 1e-6, 1e6) *
      kJoulePerCubicMillimetre;
  m.static_friction = json.number_or("static_friction", m.static_friction, 0, 5);
  m.dynamic_friction = json.number_or("dynamic_friction", m.dynamic_friction, 0, 5);
  if (m.dynamic_friction > m.static_friction) {
    json.fail(fmt::format("dynamic_friction {} above static_friction {}", m.dynamic_friction, m.static_friction),
              "dynamic_friction at most static_friction");
  }
  m.density = json.number_or("density_g_per_cm3", m.density / kGramPerCubicCentimetre, 0, 30) * kGramPerCubicCentimetre;
  read_edges(json, "blade", m.blade);
  read_edges(json, "grit", m.grit);
  if (const auto color = json.find("color")) {
    m.color = color->vec3();
    for (int i = 0; i < 3; ++i) {
      if (m.color[i] < 0 || m.color[i] > 1) color->fail("three numbers from 0 to 1 (sRGB)");
    }
  }
}

namespace {

void read_materials(const Json& json, MaterialTable& table) {
  for (const std::string& key : json.keys()) {
    const auto tissue = tissue_named(key);
    if (!tissue || *tissue == Tissue::kAir) json[key].fail("\"" + key + "\"", "the name of a tissue");
    read_material(json[key], table[static_cast<std::size_t>(*tissue)]);
  }
}

/// Reads the key "looks_like" of a scene's materials: pictures show a tissue like another one.
DrawnAs read_drawn_as(const Json& json) {
  DrawnAs drawn_as;
  for (const std::string& key : json.keys()) {
    const auto like = json[key].find("looks_like");
    if (!like) continue;
    const auto tissue = tissue_named(like->string());
    if (!tissue || *tissue == Tissue::kAir) like->fail("the name of a tissue");
    drawn_as.set(*tissue_named(key), *tissue);
  }
  return drawn_as;
}

/// Reads a file of assets/suction/. `suction` receives the flow and the radius of the opening.
SuctionTip read_suction_tip(const Json& json, debris::Suction& suction) {
  json.allow_only({"name", "opening_mm", "wall_mm", "slant_deg", "length_mm", "flow_l_per_min", "source"});
  SuctionTip tip;
  tip.opening = json["opening_mm"].number(0.5, 20) * kMillimetre;
  tip.wall = json.number_or("wall_mm", tip.wall / kMillimetre, 0.1, 3) * kMillimetre;
  tip.slant = json.number_or("slant_deg", 0, 0, 60) * kPi / 180;
  tip.length = json.number_or("length_mm", tip.length / kMillimetre, 5, 300) * kMillimetre;
  suction.flow = json["flow_l_per_min"].number(1, 2000) * kLitrePerMinute;
  suction.radius = tip.opening / 2;
  return tip;
}

}  // namespace

MouthMirror read_mouth_mirror(const Json& json) {
  json.allow_only({"translation_mm", "rotation_wxyz", "normal", "diameter_mm", "fog", "focal_mm"});
  MouthMirror mirror;
  mirror.X_WM.p = json["translation_mm"].vec3() * kMillimetre;
  if (json.has("normal") && json.has("rotation_wxyz")) json.fail("both normal and rotation_wxyz", "one of them");
  if (const auto normal = json.find("normal")) {
    const dvec3 n = normal->vec3();
    if (glm::length(n) < 1e-9) normal->fail("a direction, not zero");
    mirror.X_WM.R = rotation_between({0, 0, 1}, glm::normalize(n));
  } else if (const auto rotation = json.find("rotation_wxyz")) {
    const std::vector<double> q = rotation->numbers(4);
    const dquat R(q[0], q[1], q[2], q[3]);
    if (std::abs(glm::length(R) - 1) > 1e-3) rotation->fail("a unit quaternion");
    mirror.X_WM.R = glm::normalize(R);
  }
  mirror.diameter = json.number_or("diameter_mm", kDefaultMirrorDiameter / kMillimetre, 1, 60) * kMillimetre;
  mirror.fog = json.number_or("fog", 0, 0, 1);
  if (const auto focal = json.find("focal_mm")) mirror.focal = focal->number(30, 1000) * kMillimetre;
  return mirror;
}

haptics::Tool load_tool(std::string_view name) {
  haptics::Tool tool = haptics::read_tool(Json::load(named_asset("tools", name)));
  tool.name = name;
  return tool;
}

haptics::Spindle load_spindle(std::string_view name) {
  return haptics::read_spindle(Json::load(named_asset("motors", name)));
}

MaterialTable load_materials() {
  MaterialTable table{};
  read_materials(Json::load(assets_folder() / "materials" / "hard_tissue.json"), table);
  return table;
}

fs::path usual_rig(const Scene& scene, const std::string& usual) {
  if (scene.rig.empty()) return find_rig(usual);
  return find_rig(usual == "closeup" ? scene.rig : scene.rig + "_" + usual);
}

Scene read_scene(const fs::path& scene) {
  const fs::path file = find_scene(scene.string());
  return parse_scene(Json::load(file), file);
}

Scene parse_scene(const Json& json, const fs::path& file) {
  return parse_scene(json, file, file.parent_path());
}

Scene parse_scene(const Json& json, const fs::path& file, const ScenePlace& place) {
  json.allow_only({"name",         "description",      "tissue",         "paint",        "tool",       "tools",
                   "spindle_krpm", "spindle",          "coupling",       "materials",    "parts",      "friction",
                   "cutting",      "passivity",        "boundary_walls", "force_filter", "vibration",  "score",
                   "sound",        "prepare",          "heat",           "paint_file",   "model",      "task",
                   "surroundings", "mouth_mirror",     "suction",        "spray",        "resume",     "force_limit_N",
                   "tooth",        "torque_limit_Nmm", "tool_set",       "implant",      "handpieces", "rig"});
  const haptics::SolidFiles solid_files = files_of(place);
  Scene scene;
  scene.file = file;
  scene.place = place;
  scene.text = json.text();
  scene.name = json.string_or("name", file.stem().string());
  scene.tissue = json["tissue"];
  scene.resume = json.string_or("resume", "");
  if (!scene.tissue->is_object()) scene.tissue->fail(kTissueForms);
  if (scene.tissue->has("volume")) {
    scene.tissue->allow_only({"volume"});
    (*scene.tissue)["volume"].string();
  } else if (const auto mesh = scene.tissue->find("mesh")) {
    scene.tissue->allow_only({"mesh"});
    haptics::read_mesh_tissue_options(*mesh);
  } else if (const auto bone = scene.tissue->find("bone")) {
    scene.tissue->allow_only({"bone"});
    check_bone(*bone);
  } else if (!scene.tissue->has("solids")) {
    scene.tissue->fail(kTissueForms);
  }
  if (const auto paint = json.find("paint")) {
    for (const Json& item : paint->items()) {
      item.allow_only({"tissue", "solid", "hardness"});
      const auto tissue = tissue_named(item["tissue"].string());
      if (!tissue || *tissue == Tissue::kAir) item["tissue"].fail("the name of a tissue");
      haptics::read_solid(item["solid"], solid_files);
      haptics::read_hardness(item);
      scene.paint.push_back(item);
    }
  }

  if (const auto prepare = json.find("prepare")) {
    scene.prepare = prepare->items();
    for (const Json& item : scene.prepare) haptics::read_solid(item, solid_files);
  }

  haptics::ServoSettings& servo = scene.servo;
  const auto set = json.find("tool_set");
  const auto tool_of = [&](const Json& tool) {
    if (const auto handpiece = tool.is_string() ? std::nullopt : tool.find("handpiece");
        handpiece && handpiece->string() != "none")
      (void)asset_name("handpieces", *handpiece);
    if (!tool.is_string()) return haptics::read_tool(tool);
    return set ? load_set_tool(find_file(*set, place), tool) : load_tool(asset_name("tools", tool));
  };
  if (json.has("tool") && json.has("tools")) json.fail("both tool and tools", "one of them");
  if (const auto tools = json.find("tools")) {
    for (const Json& tool : tools->items()) servo.tools.push_back(tool_of(tool));
    if (servo.tools.empty()) tools->fail("at least one tool");
    servo.tool = servo.tools.front();
  } else {
    servo.tool = tool_of(json["tool"]);
  }
  for (const haptics::Tool& tool : haptics::tool_set(servo))
    if (!tool.handpiece.empty() && tool.handpiece != "none") (void)load_handpiece(tool.handpiece);
  if (const auto handpieces = json.find("handpieces")) scene.handpieces = read_handpiece_view(*handpieces);
  if (json.has("spindle") && json.has("spindle_krpm")) json.fail("both spindle and spindle_krpm", "one of them");
  if (const auto motor = json.find("spindle")) {
    scene.motor = asset_name("motors", *motor);
    servo.spindle = load_spindle(scene.motor);
    if (!servo.spindle.handpiece.empty() && servo.spindle.handpiece != "none")
      (void)load_handpiece(servo.spindle.handpiece);
  }
  if (const auto speed = json.find("spindle_krpm")) servo.spindle.free_speed = speed->number(0, 1000) * kKrpm;
  if (const auto coupling = json.find("coupling")) {
    coupling->allow_only({"stiffness_N_per_mm", "damping_Ns_per_mm"});
    servo.stiffness = coupling->number_or("stiffness_N_per_mm", 1, 0, 1000) * kNewtonPerMillimetre;
    servo.damping = coupling->number_or("damping_Ns_per_mm", 0.002, 0, 10) * kNewtonPerMillimetre;
  }
  servo.materials = load_materials();
  if (const auto materials = json.find("materials")) {
    read_materials(*materials, servo.materials);
    scene.drawn_as = read_drawn_as(*materials);
  }
  if (const auto paint = json.find("paint_file")) {
    scene.paint_file = find_file(*paint, place);
    const auto strokes = read_paint(scene.paint_file);
    for (std::size_t i = 0; i < kTissueCount; ++i) {
      servo.materials[i].stiffness *= stiffness_factor(strokes, static_cast<Tissue>(i));
    }
  }
  if (const auto model = json.find("model")) servo.method = haptics::read_contact_method(*model);
  servo.friction = json.boolean_or("friction", true);
  servo.cutting = json.boolean_or("cutting", true);
  servo.passivity = json.boolean_or("passivity", true);
  servo.boundary_walls = json.boolean_or("boundary_walls", true);
  servo.force_limit = json.number_or("force_limit_N", servo.force_limit, kMinForceLimit, kMaxForceLimit);
  servo.torque_limit = json.number_or("torque_limit_Nmm", servo.torque_limit / kNewtonMillimetre,
                                      kMinTorqueLimit / kNewtonMillimetre, kMaxTorqueLimit / kNewtonMillimetre) *
                       kNewtonMillimetre;

  if (const auto vibration = json.find("vibration")) {
    haptics::VibrationLaw& law = servo.vibration;
    if (vibration->is_object()) {
      vibration->allow_only({"band_Hz", "rotor_g", "balance_mm_per_s", "run_out_share", "tooth_share", "teeth"});
      scene.vibration_band_set = vibration->has("band_Hz");
      law.band = vibration->number_or("band_Hz", 0, 0, 2000);
      law.rotor_mass = vibration->number_or("rotor_g", law.rotor_mass * 1e3, 0, 1000) * 1e-3;
      law.balance = vibration->number_or("balance_mm_per_s", law.balance * 1e3, 0, 1000) * 1e-3;
      law.run_out = vibration->number_or("run_out_share", law.run_out, 0, 1);
      law.teeth = vibration->number_or("tooth_share", law.teeth, 0, 1);
      law.tooth_count = static_cast<int>(vibration->number_or("teeth", law.tooth_count, 1, 64));
    } else {
      if (vibration->boolean()) vibration->fail("false, or an object with band_Hz and what else is to differ");
      // A scene with "vibration": false has no vibration, even if the device can vibrate.
      scene.vibration_band_set = true;
    }
  }

  if (const auto filter = json.find("force_filter")) {
    const auto named = haptics::force_filter_named(filter->string());
    if (!named) filter->fail("none, slew or stroke");
    servo.filter = *named;
  }

  if (const auto parts = json.find("parts")) {
    for (const Json& part : parts->items()) {
      const std::string name = part.string();
      if (std::find(kParts.begin(), kParts.end(), name) == kParts.end()) {
        part.fail(fmt::format("one of {}", fmt::join(kParts, ", ")));
      }
      scene.parts.insert(name);
    }
  } else {
    scene.parts = {"haptics"};
  }
  if (const auto score = json.find("score")) scene.score = *score;
  if (const auto task = json.find("task")) {
    if (scene.score) json.fail("both score and task", "the rules in the task");
    scene.task = session::read_task(*task);
    for (const auto& list : {scene.task->protect, scene.task->region}) {
      for (const Json& item : list) haptics::read_solid(item, {.find = {}, .read_mesh = haptics::read_mesh_solid});
    }
  }
  if (const auto implant = json.find("implant")) {
    if (model_name(scene) != "implant") implant->fail("\"model\": \"implant\" beside it");
    scene.implant = read_implant(*implant, *scene.tissue, haptics::tool_set(servo), place);
  }
  (void)session::tooth_sides(json);  // reports errors in the tooth's sides now, although only the report uses them
  if (const auto surroundings = json.find("surroundings")) {
    scene.surroundings = read_surroundings(*surroundings, volume_file(scene), place);
  }
  if (const auto rig = json.find("rig")) {
    scene.rig = rig->string();
    (void)usual_rig(scene, "closeup");  // throws Error if the scene's display rig does not exist
  }
  if (const auto mirror = json.find("mouth_mirror")) scene.mouth_mirror = read_mouth_mirror(*mirror);
  if (const auto suction = json.find("suction")) {
    suction->allow_only({"position_mm", "flow_l_per_min", "radius_mm", "on", "tip", "axis"});
    debris::Suction usual;
    if (const auto tip = suction->find("tip")) {
      if (!suction->has("position_mm")) suction->fail("position_mm beside \"tip\"");
      scene.suction_tip = read_suction_tip(Json::load(named_asset("suction", asset_name("suction", *tip))), usual);
      const dvec3 axis = suction->has("axis") ? (*suction)["axis"].vec3() : dvec3(0, 0, 1);
      if (glm::length(axis) < 1e-9) (*suction)["axis"].fail("a direction, not zero");
      scene.suction_tip.X_WS = {(*suction)["position_mm"].vec3() * kMillimetre,
                                rotation_between({0, 0, 1}, glm::normalize(axis))};
    } else if (suction->has("axis")) {
      suction->fail("\"tip\" beside axis");
    }
    if (const auto p = suction->find("position_mm"))
      scene.suction = {
          .p_W = p->vec3() * kMillimetre,
          .flow = suction->number_or("flow_l_per_min", usual.flow / kLitrePerMinute, 1, 2000) * kLitrePerMinute,
          .radius = suction->number_or("radius_mm", usual.radius / kMillimetre, 0.5, 20) * kMillimetre};
    else
      for (const char* key : {"flow_l_per_min", "radius_mm"})
        if (suction->has(key)) suction->fail("position_mm beside it");
    scene.suction_on = suction->boolean_or("on", true);
    if (scene.suction_on && !scene.needs("debris")) suction->fail("\"debris\" among the parts, or \"on\": false");
  }
  if (const auto spray = json.find("spray")) {
    spray->allow_only({"flow_ml_per_min", "on"});
    if (!servo.spindle.nozzles) spray->fail("a \"spindle\" whose motor has nozzles (\"spray\" in its file)");
    if (!scene.needs("debris")) spray->fail("\"debris\" among the parts");
    scene.spray = servo.spindle.nozzles;
    scene.spray->flow =
        spray->number_or("flow_ml_per_min", scene.spray->flow / kMillilitrePerMinute, 0.1, 500) * kMillilitrePerMinute;
    scene.spray_on = spray->boolean_or("on", true);
  }
  if (const auto heat = json.find("heat")) scene.heat = session::read_heat(*heat);
  if (const auto sound = json.find("sound")) {
    sound->allow_only({"lower_order"});
    scene.sound_lower_order = sound->boolean_or("lower_order", false);
  }
  return scene;
}

/// Loads a shared object that contains a ContactMethodRegistration. Returns the model's name. Main thread.
static std::string load_model(const std::string& file) {
  static std::map<std::string, std::string> loaded;
  std::string& name = loaded[file];
  if (!name.empty()) return name;
  const std::size_t known = haptics::contact_method_names().size();
  if (!dlopen(file.c_str(), RTLD_NOW)) throw Error("--model", "", dlerror(), "a shared object built for this version");
  const std::vector<std::string> names = haptics::contact_method_names();
  if (names.size() == known) throw Error("--model", "", file, "a shared object with a ContactMethodRegistration");
  return name = names.back();
}

void choose_model(Scene& scene, const std::string& wanted) {
  const std::string name = wanted.find('/') == std::string::npos ? wanted : load_model(wanted);
  // The scene already has this contact model: keep its parameters.
  if (name.empty() || (scene.servo.method && scene.servo.method->name() == name)) return;
  scene.servo.method = haptics::contact_method(name, "--model");
  auto json = nlohmann::ordered_json::parse(scene.text);
  json["model"] = name;
  scene.text = json.dump(2);
}

std::string_view model_name(const Scene& scene) {
  return (scene.servo.method ? scene.servo.method : haptics::default_contact_method())->name();
}

bool draws_own_surface(const Scene& scene) {
  return scene.servo.method && scene.servo.method->draws_own_surface();
}

std::vector<std::string> tool_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const haptics::Tool& tool : haptics::tool_set(scene.servo)) names.push_back(tool.name);
  return names;
}

std::filesystem::path volume_file(const Scene& scene) {
  const auto volume = scene.tissue->find("volume");
  return volume ? find_file(*volume, scene.place) : fs::path();
}

haptics::ServoSettings servo_settings(const Scene& scene, const haptics::TissueVolume& tissue, double rate,
                                      double vibration_band, double position_step, bool gives_torque) {
  haptics::ServoSettings settings = scene.servo;
  if (!scene.vibration_band_set) settings.vibration.band = vibration_band;
  settings.position_step = position_step;
  settings.gives_torque = gives_torque;
  settings.frame = tissue.frame();
  settings.tick = 1 / rate;
  settings.soft = soft_gum(scene.surroundings);
  return settings;
}

haptics::TissueVolume load_untouched(const Scene& scene) {
  const haptics::SolidFiles solid_files = files_of(scene.place);
  const auto read = [&] {
    if (const fs::path file = volume_file(scene); !file.empty()) return haptics::TissueVolume::load(file);
    haptics::TissueVolume sampled(sampled_tissue(*scene.tissue, solid_files));
    if (const auto json = scene.tissue->find("mesh")) {
      const haptics::MeshTissueOptions options = haptics::read_mesh_tissue_options(*json);
      haptics::ReadTissueMesh from_file = haptics::read_tissue_mesh(find_file((*json)["file"], scene.place), options);
      for (const std::string& repair : from_file.repairs) log::info("{}: {}", options.file, repair);
      sampled.set_mesh(std::make_shared<const haptics::TissueMesh>(std::move(from_file.mesh)));
    }
    return sampled;
  };
  haptics::TissueVolume volume = read();
  for (const Json& item : scene.paint) {
    const auto solid = haptics::read_solid(item["solid"], solid_files);
    volume.paint(*tissue_named(item["tissue"].string()), *solid, haptics::read_hardness(item));
  }
  if (!scene.paint_file.empty()) paint(volume, read_paint(scene.paint_file));
  if (scene.needs("render")) volume.keep_natural_surface();
  for (const Json& item : scene.prepare) {
    const auto natural = volume.natural_surface();
    volume = without_solid(volume, *haptics::read_solid(item, solid_files));
    volume.set_natural_surface(natural);
  }
  if (scene.implant) check_plan(*scene.implant, volume, scene.file);
  return volume;
}

}  // namespace typodont
