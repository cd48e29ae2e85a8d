#include "engine/app/scene.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/app/assets.h"
#include "engine/app/scene/handpiece_file.h"
#include "engine/app/scene/ideal.h"
#include "engine/app/scene/implant_scene.h"
#include "engine/app/surroundings/soft_gum.h"
#include "engine/app/tissue/bone_tissue.h"
#include "engine/app/tissue/paint_file.h"
#include "engine/app/tissue/sampled_tissue.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/error.h"
#include "engine/base/keys.h"
#include "engine/base/log.h"
#include "engine/base/units.h"
#include "engine/session/packing_file.h"
#include "engine/session/place.h"
#include "haptics/contact_method.h"
#include "haptics/described.h"
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

constexpr double kLitrePerMinute = 1e-3 / 60;  // m³/s, one litre per minute
constexpr double kNewtonMillimetre = 1e-3;     // N·m, one newton millimetre
// Ranges of the force and torque limits that a scene may state. The largest values suffice for reaming an acetabulum
// (hip socket), which needs 200 N; a 60 mm reamer then needs 6 N·m at its rim.
constexpr double kMinForceLimit = 0.1, kMaxForceLimit = 300;    // N, smallest and largest force limit
constexpr double kMinTorqueLimit = 1e-3, kMaxTorqueLimit = 20;  // N·m, smallest and largest torque limit
constexpr Form kPrepare{"list of solids or objects",
                        R"({"type": "array", "items": {"anyOf": [{"$ref": "#/$defs/solid"}, "$object"]}})"},
    kFalseOrObject{"false or object", R"({"anyOf": [{"const": false}, "$object"]})"};
constexpr std::array<std::string_view, 6> kParts = {"haptics", "render", "sound", "debris", "record", "score"};

/// Finds the mesh files to which a scene's solids refer: first beside the scene's file, then in the assets.
haptics::SolidFiles files_of(const ScenePlace& place) {
  return {.find = [place](const Json& name) { return find_file(name, place); }, .read_mesh = haptics::read_mesh_solid};
}

void describe_edges(Keys& keys, EdgeLaw& law) {
  keys("energy_ratio", law.energy_ratio, {0.01, 100},
       "cutting energy per volume with chips of `chip_um`, divided by `specific_energy_J_per_mm3`");
  keys("chip_um", law.chip, {0.001, 1000, kMicrometre}, "thickness of these chips");
  keys("exponent", law.exponent, {0, 0.9}, "the cutting energy per volume falls with this power of the chip thickness");
  keys("force_ratio", law.force_ratio, {0, 2}, "ratio of tangential to pressing force; 0: `cutting_coefficient`");
}

void describe_grit(Keys& keys, EdgeLaw& law) {
  describe_edges(keys, law);
  keys("grinding_ratio", law.grinding_ratio, {0, 1e6},
       "removed volume / volume of a diamond's grains at which it cuts half as fast ([Wear](cutting.md#wear)); 0: no "
       "wear");
}

void describe_material(Keys& keys, Material& m) {
  keys("stiffness_N_per_mm", m.stiffness, {0, 1000, kNewtonPerMillimetre}, "stiffness ([Coupling](#coupling))");
  keys("specific_energy_J_per_mm3", m.specific_energy, {1e-6, 1e6, kJoulePerCubicMillimetre}, "energy per cut volume");
  keys("static_friction", m.static_friction, {0, 5}, "coefficient of static friction");
  keys("dynamic_friction", m.dynamic_friction, {0, 5}, "coefficient of sliding friction, at most `static_friction`");
  keys("density_g_per_cm3", m.density, {0, 30, kGramPerCubicCentimetre}, "density");
  keys("color", m.color, read_color, "colour");
  keys("blade", m.blade, describe_edges, "how burs with the key `blades` cut this tissue");
  keys("grit", m.grit, describe_grit, "how diamonds with the key `grit_um` cut this tissue");
  keys.ignore("source");
  keys("looks_like", kName, "the natural view draws this tissue like the tissue of this name ([Picture](#picture))");
  if (keys.json() && m.dynamic_friction > m.static_friction) {
    keys.json()->fail(
        fmt::format("dynamic_friction {} above static_friction {}", m.dynamic_friction, m.static_friction),
        "dynamic_friction at most static_friction");
  }
}

}  // namespace

void read_material(const Json& json, Material& m) {
  read_keys(json, [&](Keys& keys) { describe_material(keys, m); });
}

namespace {

void read_materials(const Json& json, MaterialTable& table) {
  for (const std::string& key : json.keys()) {
    const auto tissue = tissue_named(key);
    if (!tissue || *tissue == Tissue::kAir) json[key].fail("\"" + key + "\"", "the name of a tissue");
    read_material(json[key], table[static_cast<std::size_t>(*tissue)]);
  }
}

/// Reads from the key "looks_like" of a scene's materials which tissues the pictures show like another tissue.
DrawnAs read_drawn_as(const Json& json) {
  DrawnAs drawn_as;
  for (const std::string& key : json.keys()) {
    const auto like = json[key].find("looks_like");
    if (!like) continue;
    drawn_as.set(*tissue_named(key), haptics::read_tissue_name(*like));
  }
  return drawn_as;
}

}  // namespace

void describe_case(Keys& keys, CaseIdentity& made) {
  keys(must("family"), made.family, "family of exercises");
  keys(must("seed"), made.seed, {0}, "seed");
  keys(must("difficulty"), made.difficulty, {0, 1}, "difficulty");
  keys("icdas", made.icdas, {1, 6}, "ICDAS code of the lesion");
}

void describe_suction_tip(Keys& keys, SuctionTip& tip, debris::Suction& suction) {
  keys("name", kName, "name of the tip");
  keys(must("opening_mm"), tip.opening, {0.5, 20, kMillimetre}, "inner diameter of the opening");
  keys("wall_mm", tip.wall, {0.1, 3, kMillimetre}, "thickness of the tube's wall");
  keys("slant_deg", tip.slant, {0, 60, kDegree}, "slant of the opening");
  keys("length_mm", tip.length, {5, 300, kMillimetre}, "length of the tube");
  keys(must("flow_l_per_min"), suction.flow, {1, 2000, kLitrePerMinute}, "flow of air");
  keys.ignore("source");
  suction.radius = tip.opening / 2;
}

void describe_mouth_mirror(Keys& keys, MouthMirror& mirror) {
  keys(must("translation_mm"), mirror.X_WM.p, kMillimetre, "centre of the glass");
  const auto rotation = keys("rotation_wxyz", kQuaternion, "rotation of the mirror as a unit quaternion");
  const auto normal = keys("normal", kDirection, "direction out of the glass, instead of a rotation; default: +z of W");
  if (normal && rotation) keys.json()->fail("both normal and rotation_wxyz", "one of them");
  if (normal) mirror.X_WM.R = rotation_between({0, 0, 1}, read_direction(*normal));
  if (rotation) {
    const std::vector<double> q = rotation->numbers(4);
    const dquat R(q[0], q[1], q[2], q[3]);
    if (std::abs(glm::length(R) - 1) > 1e-3) rotation->fail("a unit quaternion");
    mirror.X_WM.R = glm::normalize(R);
  }
  mirror.diameter = kDefaultMirrorDiameter;
  keys("diameter_mm", mirror.diameter, {1, 60, kMillimetre}, "diameter of the glass");
  keys("fog", mirror.fog, {0, 1}, "fog on the glass at the start");
  keys("focal_mm", mirror.focal, {30, 1000, kMillimetre}, "focal length of a concave mirror; default: flat");
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
  try {
    return find_rig(usual == "closeup" ? scene.rig : scene.rig + "_" + usual);
  } catch (const Error& error) {
    throw Error(fmt::format("{}: \"rig\": {}", scene.file.string(), error.what()));
  }
}

Scene read_scene(const fs::path& scene) {
  const fs::path file = find_scene(scene.string());
  return parse_scene(Json::load(file), file);
}

Scene parse_scene(const Json& json, const fs::path& file) {
  return parse_scene(json, file, file.parent_path());
}

namespace {

void describe_tissue(Keys& keys) {
  std::string volume;
  haptics::MeshTissueOptions mesh;
  keys.alternative();
  keys(must("volume"), volume, "a volume file, which `import` or the option `--save` of `run` and `servo` writes");
  keys.alternative();
  keys(must("mesh"), mesh, haptics::describe_mesh_tissue, "a [scanned surface](#mesh)");
  keys.alternative();
  keys(must("bone"), describe_bone, "a [jaw](#bone)");
  keys.alternative();
  haptics::describe_solid_tissue(keys);
}

void describe_vibration(Keys& keys, haptics::VibrationLaw& law) {
  law.band = keys.json() ? 0 : kNoDefault;
  keys("band_Hz", law.band, {0, 2000}, "largest frequency that every hand feels; default: the device's limit");
  keys("rotor_g", law.rotor_mass, {0, 1000, 1e-3}, "mass of the rotor");
  keys("balance_mm_per_s", law.balance, {0, 1000, 1e-3}, "balance quality grade G of ISO 21940-11");
  keys("run_out_share", law.run_out, {0, 1}, "fraction of the tangential force that changes once per revolution");
  keys("tooth_share", law.teeth, {0, 1}, "fraction of the tangential force that changes once per cutting edge");
  double teeth = law.tooth_count;
  keys("teeth", teeth, {1, 64}, "number of cutting edges");
  law.tooth_count = static_cast<int>(teeth);
}

void describe_suction(Keys& keys, Scene& scene) {
  debris::Suction suction;
  const Json* json = keys.json();
  if (const auto tip = json ? json->find("tip") : std::nullopt) {
    if (!json->has("position_mm")) json->fail("position_mm beside \"tip\"");
    read_keys(Json::load(named_asset("suction", asset_name("suction", *tip))),
              [&](Keys& file) { describe_suction_tip(file, scene.suction_tip, suction); });
  }
  const auto position = keys("position_mm", kPoint,
                             "position of the nozzle; with `tip`, of the opening. Default: 9 mm behind the tooth. "
                             "Required beside `tip`, `flow_l_per_min` and `radius_mm`");
  if (position) suction.p_W = position->vec3() * kMillimetre;
  keys("flow_l_per_min", suction.flow, {1, 2000, kLitrePerMinute}, "flow of air; default beside `tip`: the tip's");
  keys("radius_mm", suction.radius, {0.5, 20, kMillimetre},
       "distance from the nozzle within which chips disappear; default beside `tip`: half the tip's opening");
  scene.suction_on = true;
  keys("on", scene.suction_on, "false: the suction is off at the start; true needs the part `debris`");
  keys("tip", kName, "draws a suction tip of `assets/suction/` (`high_volume` or `surgical`)");
  const auto axis =
      keys("axis", kDirection, "direction in which the tube of the tip points; default +z; only with `tip`");
  if (!json) return;
  if (json->has("tip")) {
    scene.suction_tip.X_WS = {suction.p_W, rotation_between({0, 0, 1}, axis ? read_direction(*axis) : dvec3(0, 0, 1))};
  } else if (axis) {
    json->fail("\"tip\" beside axis");
  }
  if (position) {
    scene.suction = suction;
  } else {
    for (const char* key : {"flow_l_per_min", "radius_mm"})
      if (json->has(key)) json->fail("position_mm beside it");
  }
  if (scene.suction_on && !scene.needs("debris")) json->fail("\"debris\" among the parts, or \"on\": false");
}

void describe_spray(Keys& keys, Scene& scene) {
  if (const Json* json = keys.json()) {
    if (!scene.servo.spindle.nozzles) json->fail("a \"spindle\" whose motor has nozzles (\"spray\" in its file)");
    if (!scene.needs("debris")) json->fail("\"debris\" among the parts");
    scene.spray = scene.servo.spindle.nozzles;
  }
  Nozzles motors;
  keys("flow_ml_per_min", (scene.spray ? *scene.spray : motors).flow, {0.1, 500, kMillilitrePerMinute},
       "default: the motor's flow");
  scene.spray_on = true;
  keys("on", scene.spray_on, "false: the session begins with the water switched off");
}

void list_tool(Keys& keys) {
  haptics::Tool tool;
  haptics::describe_tool(keys, tool);
}

void check_score(Keys& keys) {
  session::StatedScore stated;
  session::describe_score(keys, stated, /*with_ideal=*/false);
}

void check_ideal(Keys& keys) {
  Ideal ideal;
  describe_ideal(keys, ideal, haptics::unread_meshes());
}

/// JSON Schema of an object with a key for each tissue.
std::string schema_by_tissue() {
  std::vector<std::string_view> names;
  for (std::size_t i = 1; i < kTissueCount; ++i) names.push_back(name_of(static_cast<Tissue>(i)));
  return fmt::format(R"({{"type": "object", "propertyNames": {{"enum": ["{}"]}}, "additionalProperties": "$object"}})",
                     fmt::join(names, R"(", ")"));
}

void require_handpiece(const std::string& name) {
  if (!name.empty() && name != "none") (void)load_handpiece(name);
}

}  // namespace

void describe_scene(Keys& keys, Scene& scene) {
  const Json* json = keys.json();
  const haptics::SolidFiles solid_files = files_of(scene.place);
  haptics::ServoSettings& servo = scene.servo;
  keys.define("solid", haptics::list_solid);
  keys("name", scene.name, "name of the scene; default: the file name without `.json`");
  keys("description", kText, "free text");
  keys("exam", scene.exam, "seed of a school's [sealed exam](school.md#exams)");
  CaseIdentity made;
  keys("case", made, describe_case, "a [generated exercise](cases.md)");
  scene.tissue = keys(must("tissue"), kObject, describe_tissue, "the [tissue](#tissue)");
  if (scene.tissue) read_keys(*scene.tissue, describe_tissue);
  const auto painted = [&](Keys& of) {
    haptics::LabelledSolid solid;
    haptics::describe_labelled_solid(of, solid, solid_files);
  };
  if (const auto paint =
          keys("paint", kObjects, painted, "tissue that gets another label, for example a lesion ([Paint](#paint))")) {
    scene.paint = paint->items();
    for (const Json& item : scene.paint) read_keys(item, painted);
  }
  const auto tool_of = [&](const Json& tool) {
    if (const auto handpiece = tool.is_string() ? std::nullopt : tool.find("handpiece");
        handpiece && handpiece->string() != "none")
      (void)asset_name("handpieces", *handpiece);
    if (!tool.is_string()) return haptics::read_tool(tool);
    const auto set = json->find("tool_set");
    return set ? load_set_tool(find_file(*set, scene.place), tool) : load_tool(asset_name("tools", tool));
  };
  const auto tool = keys("tool", kNameOrObject, list_tool, "the only tool ([Tools](#tools))");
  const auto tools = keys("tools", kNamesOrObjects, list_tool, "several tools, instead of `tool`");
  if (tool && tools) json->fail("both tool and tools", "one of them");
  if (tools) {
    for (const Json& each : tools->items()) servo.tools.push_back(tool_of(each));
    if (servo.tools.empty()) tools->fail("at least one tool");
    servo.tool = servo.tools.front();
  } else if (json) {
    servo.tool = tool_of((*json)["tool"]);
  }
  for (const haptics::Tool& each : haptics::tool_set(servo)) require_handpiece(each.handpiece);
  keys("spindle_krpm", servo.spindle.free_speed, {0, 1000, kKrpm}, "speed of an ideal motor ([Motors](#motors))");
  if (const auto motor = keys("spindle", kName, "a motor of `assets/motors/`, instead of `spindle_krpm`")) {
    if (json->has("spindle_krpm")) json->fail("both spindle and spindle_krpm", "one of them");
    scene.motor = asset_name("motors", *motor);
    servo.spindle = load_spindle(scene.motor);
    require_handpiece(servo.spindle.handpiece);
  }
  const auto coupling = [&](Keys& spring) {
    spring("stiffness_N_per_mm", servo.stiffness, {0, 1000, kNewtonPerMillimetre}, "stiffness of the coupling");
    spring("damping_Ns_per_mm", servo.damping, {0, 10, kNewtonPerMillimetre}, "damping, only along the contact normal");
  };
  keys("coupling", coupling, "spring and damper between hand and tool ([Coupling](#coupling))");
  if (json) servo.materials = load_materials();
  const auto any_material = [](Keys& of) {
    Material material;
    describe_material(of, material);
  };
  if (const auto materials = keys("materials", Form{"object", schema_by_tissue()}, any_material,
                                  "properties of tissues ([Materials](#materials))")) {
    read_materials(*materials, servo.materials);
    scene.drawn_as = read_drawn_as(*materials);
  }
  scene.parts = {"haptics"};
  if (const auto parts =
          keys("parts", kNames, "what a session has besides force and cutting; default `[\"haptics\"]`")) {
    scene.parts.clear();
    for (const Json& part : parts->items()) {
      if (std::ranges::find(kParts, part.string()) == kParts.end())
        part.fail(fmt::format("one of {}", fmt::join(kParts, ", ")));
      scene.parts.insert(part.string());
    }
  }
  keys("friction", servo.friction, "friction between tool and tissue ([Switches](#switches-for-experiments))");
  keys("cutting", servo.cutting, "cutting by all tools ([Switches](#switches-for-experiments))");
  keys("passivity", servo.passivity, "the passivity controller ([Switches](#switches-for-experiments))");
  keys("boundary_walls", servo.boundary_walls, "walls of harder tissue ([Switches](#switches-for-experiments))");
  keys("force_filter", servo.filter, {"none", "slew", "stroke"}, "[Force filter](#force-filter)");
  const auto vibration = [&](Keys& of) { describe_vibration(of, servo.vibration); };
  if (const auto of =
          keys("vibration", kFalseOrObject, vibration, "vibration of the spindle ([Vibration](#vibration))")) {
    if (of->is_object()) {
      read_keys(*of, vibration);
      scene.vibration_band_set = of->has("band_Hz");
    } else {
      if (of->boolean()) of->fail("false, or an object with band_Hz and what else is to differ");
      // A scene with "vibration": false has no vibration, even if the device can vibrate.
      scene.vibration_band_set = true;
    }
  }
  scene.score = keys("score", kObject, check_score, "rules of the score, for a scene without `task`");
  if (scene.score) read_keys(*scene.score, check_score);
  keys(
      "sound",
      [&](Keys& sound) { sound("lower_order", scene.sound_lower_order, "reduces the order of the sound models"); },
      "options of the sound ([Sound](#sound))");
  const auto added = [&](Keys& of) {
    if (const auto name = of(must("tissue"), kName, "added tissue, for example calculus"))
      (void)haptics::read_tissue_name(*name);
    if (const auto solid = of(must("solid"), kSolid, "its bounded region")) {
      dvec3 low, high;
      haptics::read_solid(*solid, solid_files)->bounds(low, high);
      if (!std::isfinite(glm::length(high - low))) solid->fail("a solid without end", "a bounded solid");
    }
  };
  if (const auto prepare = keys("prepare", kPrepare, added, "[solids](#solids) removed or added before the session")) {
    scene.prepare = prepare->items();
    for (const Json& item : scene.prepare) {
      if (item.has("tissue"))
        read_keys(item, added);
      else
        haptics::read_solid(item, solid_files);
    }
  }
  keys("heat", scene.heat, session::describe_heat, "temperatures of pulp and bone ([Heat](#heat))");
  if (const auto paint = keys("paint_file", kFile, "strokes of tissue with another label ([Paint](#paint))")) {
    scene.paint_file = find_file(*paint, scene.place);
    const auto strokes = read_paint(scene.paint_file);
    for (std::size_t i = 0; i < kTissueCount; ++i) {
      servo.materials[i].stiffness *= stiffness_factor(strokes, static_cast<Tissue>(i));
    }
  }
  if (const auto model = keys("model", kNameOrObject, haptics::list_contact_methods,
                              "default `\"offset\"` ([Contact model](#contact-model))"))
    servo.method = haptics::read_contact_method(*model);
  const auto stated = [](Keys& of, session::Task& task) { session::describe_task(of, task, check_ideal); };
  keys("task", scene.task, stated, "goal, steps and rules of the score ([Task](tasks.md#the-block))");
  if (scene.task) {
    if (scene.score) json->fail("both score and task", "the rules in the task");
    if (scene.task->ideal) read_keys(*scene.task->ideal, check_ideal);
    if (const auto steps = (*json)["task"].find("steps")) {
      for (const Json& step : steps->items())
        if (step.is_object() && step.has("tool")) (void)tool_named(step["tool"], haptics::tool_set(servo));
    }
    for (const auto& list : {scene.task->protect, scene.task->region}) {
      for (const Json& item : list) haptics::read_solid(item, {.find = {}, .read_mesh = haptics::read_mesh_solid});
    }
  }
  keys("warnings", scene.warnings, "false: no [warnings](tasks.md#warnings) over the picture, as in an exam");
  const auto surroundings = [&](Keys& of, SurroundingsPlan& plan) {
    describe_surroundings(of, plan, json ? volume_file(scene) : fs::path(), scene.place);
  };
  keys("surroundings", scene.surroundings, surroundings, "teeth, gum, mouth, dam ([Surroundings](#surroundings))");
  keys("mouth_mirror", scene.mouth_mirror, describe_mouth_mirror, "[Mouth mirror](#mouth-mirror)");
  keys("suction", scene, describe_suction, "suction ([Water and suction](#water-and-suction))");
  keys("spray", scene, describe_spray, "water of the handpiece ([Water and suction](#water-and-suction))");
  keys("resume", scene.resume, "saved volume (`.vdb`) or session (`.h5`) that is continued ([Volume](#volume))");
  keys("force_limit_N", servo.force_limit, {kMinForceLimit, kMaxForceLimit}, "largest force ([Limits](#limits))");
  session::ToothSides sides;  // only checked here; the report uses them
  keys("tooth", sides, session::describe_tooth, "perpendicular directions, by which the report names places");
  keys("torque_limit_Nmm", servo.torque_limit,
       {kMinTorqueLimit / kNewtonMillimetre, kMaxTorqueLimit / kNewtonMillimetre, kNewtonMillimetre}, "largest torque");
  keys("tool_set", Form{"folder", kText.schema}, "folder with one file for each tool ([Tool sets](#tool-sets))");
  if (json && json->has("implant") && model_name(scene) != "implant")
    (*json)["implant"].fail("\"model\": \"implant\" beside it");
  const auto implant = [&](Keys& of, session::ImplantTask& task) {
    describe_implant(of, task, json ? read_nerve_canal(*scene.tissue) : NerveCanal{}, haptics::tool_set(servo),
                     scene.place);
  };
  keys("implant", scene.implant, implant, "an implant exercise ([Implant exercise](#implant-exercise))");
  keys("handpieces", scene.handpieces, describe_handpiece_view, "the drawn handpiece ([Picture](#picture))");
  keys("rig", scene.rig, "positions of eyes and screen for this scene ([Picture](#picture))");
  if (json && !scene.rig.empty()) (void)usual_rig(scene, "closeup");  // throws Error if the rig does not exist
}

Scene parse_scene(const Json& json, const fs::path& file, const ScenePlace& place) {
  Scene scene;
  scene.file = file;
  scene.place = place;
  scene.text = json.text();
  scene.name = file.stem().string();
  read_keys(json, [&](Keys& keys) { describe_scene(keys, scene); });
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
  // If the scene already has the contact model `name`, the parameters of this model in the scene are kept.
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
    haptics::LabelledSolid part;
    read_keys(item, [&](Keys& keys) { haptics::describe_labelled_solid(keys, part, solid_files); });
    volume.paint(part.tissue, *part.solid, part.hardness, part.color);
  }
  if (!scene.paint_file.empty()) paint(volume, read_paint(scene.paint_file));
  if (scene.needs("render")) volume.keep_natural_surface();
  for (const Json& item : scene.prepare) {
    const auto natural = volume.natural_surface();
    volume = item.has("tissue") ? with_solid(volume, *haptics::read_solid(item["solid"], solid_files),
                                             haptics::read_tissue_name(item["tissue"]))
                                : without_solid(volume, *haptics::read_solid(item, solid_files));
    volume.set_natural_surface(natural);
  }
  if (scene.implant) check_plan(*scene.implant, volume, scene.file);
  return volume;
}

}  // namespace typodont
