#include "engine/app/scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "engine/app/picture/surroundings.h"
#include "engine/app/recording/resume.h"
#include "engine/app/sampled_tissue.h"
#include "engine/app/task/paint_file.h"
#include "engine/app/task/tissue_edit.h"
#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/solid.h"
#include "haptics/tool.h"

namespace typodont {

namespace fs = std::filesystem;

namespace {

constexpr double kLitrePerMinute = 1e-3 / 60;  // m³/s
constexpr std::array<std::string_view, 6> kParts = {"haptics", "render", "sound", "debris", "record", "score"};

std::string names_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(folder, code)) {
    if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return fmt::format("one of {}", fmt::join(names, ", "));
}

fs::path named_asset(const char* kind, std::string_view name) {
  const fs::path folder = assets_folder() / kind;
  const fs::path file = folder / (std::string(name) + ".json");
  const bool plain = !name.empty() && name.find('/') == std::string_view::npos && name != "..";
  std::error_code code;
  if (!plain || !fs::is_regular_file(file, code)) {
    throw Error(folder.string(), "", fmt::format("nothing named \"{}\"", name), names_in(folder));
  }
  return file;
}

void read_material(const Json& json, Material& m) {
  json.allow_only({"stiffness_N_per_mm", "specific_energy_J_per_mm3", "static_friction", "dynamic_friction",
                   "density_g_per_cm3", "color", "source"});
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
  if (const auto color = json.find("color")) {
    m.color = color->vec3();
    for (int i = 0; i < 3; ++i) {
      if (m.color[i] < 0 || m.color[i] > 1) color->fail("three numbers from 0 to 1 (sRGB)");
    }
  }
}

void read_materials(const Json& json, MaterialTable& table) {
  for (const std::string& key : json.keys()) {
    const auto tissue = tissue_named(key);
    if (!tissue || *tissue == Tissue::kAir) json[key].fail("\"" + key + "\"", "the name of a tissue");
    read_material(json[key], table[static_cast<std::size_t>(*tissue)]);
  }
}

}  // namespace

MouthMirror read_mouth_mirror(const Json& json) {
  json.allow_only({"translation_mm", "rotation_wxyz", "normal", "diameter_mm", "fog"});
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
  mirror.diameter = json.number_or("diameter_mm", kUsualMirrorDiameter / kMillimetre, 1, 60) * kMillimetre;
  mirror.fog = json.number_or("fog", 0, 0, 1);
  return mirror;
}

fs::path assets_folder() {
  std::error_code code;
  if (const char* set = std::getenv("TYPODONT_ASSETS")) {
    if (!fs::is_directory(fs::path(set) / "tools", code)) {
      throw Error(set, "", "no assets there", "the folder named by TYPODONT_ASSETS to hold tools/, scenes/ …");
    }
    return set;
  }
  // build/release/typodont → assets/ two levels up; an installed bin/typodont → share/typodont/assets.
  const fs::path program = fs::read_symlink("/proc/self/exe", code).parent_path();
  for (fs::path up = program; !up.empty(); up = up.parent_path()) {
    if (fs::is_directory(up / "assets" / "tools", code)) return up / "assets";
    if (fs::is_directory(up / "share/typodont/assets/tools", code)) return up / "share/typodont/assets";
    if (up == up.root_path()) break;
  }
  throw Error(program.string(), "", "no assets beside the program",
              "the assets folder, or its place in TYPODONT_ASSETS");
}

fs::path user_folder() {
  if (const char* set = std::getenv("TYPODONT_HOME"); set && *set) return set;
  const char* home = std::getenv("HOME");
  return fs::path(home && *home ? home : ".") / "Typodont";
}

namespace {

/// Links followed, also in the part of `path` that is there.
bool lies_in(const fs::path& path, const fs::path& folder) {
  std::error_code code;
  const fs::path file = fs::weakly_canonical(fs::absolute(path), code);
  if (code) return false;
  const fs::path real = fs::weakly_canonical(fs::absolute(folder), code);
  if (code || real.empty()) return false;
  return std::mismatch(real.begin(), real.end(), file.begin(), file.end()).first == real.end();
}

/// By its name: links in the assets are ours.
bool named_in(const fs::path& path, const fs::path& folder) {
  const fs::path file = fs::absolute(path).lexically_normal(), at = fs::absolute(folder).lexically_normal();
  return std::mismatch(at.begin(), at.end(), file.begin(), file.end()).first == at.end();
}

void require_allowed(const fs::path& path, const ScenePlace& place) {
  if (place.within.empty() || named_in(path, assets_folder()) || lies_in(path, assets_folder())) return;
  std::string folders;
  for (const fs::path& folder : place.within) {
    if (lies_in(path, folder)) return;
    folders += (folders.empty() ? "" : ", ") + folder.string();
  }
  throw Error(
      path.string(), "", "a recording that names a file outside its folder",
      fmt::format("it in {} or in assets/; TYPODONT_FILES allows more folders, with ':' between them", folders));
}

}  // namespace

fs::path find_file(const fs::path& path, const ScenePlace& place) {
  std::error_code code;
  if (path.is_absolute()) {
    require_allowed(path, place);
    if (!fs::exists(path, code)) throw Error(path.string(), "", "no such file", "a readable file");
    return path;
  }
  for (const fs::path& folder : {place.beside, assets_folder()}) {
    const fs::path file = folder / path;
    if (!place.within.empty() && !lies_in(file, folder)) require_allowed(file, place);  // "../../x", or a link
    if (!fs::exists(file, code)) continue;
    require_allowed(file, place);
    return file;
  }
  throw Error(
      path.string(), "", "no such file",
      fmt::format("it in {} or {}", place.beside.empty() ? "." : place.beside.string(), assets_folder().string()));
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

Scene read_scene(const fs::path& file) {
  return parse_scene(Json::load(file), file);
}

Scene parse_scene(const Json& json, const fs::path& file) {
  return parse_scene(json, file, file.parent_path());
}

Scene parse_scene(const Json& json, const fs::path& file, const ScenePlace& place) {
  json.allow_only({"name",           "description",  "tissue",       "paint",   "tool",     "tools",   "spindle_krpm",
                   "spindle",        "coupling",     "materials",    "parts",   "friction", "cutting", "passivity",
                   "boundary_walls", "force_filter", "vibration",    "score",   "sound",    "prepare", "paint_file",
                   "task",           "surroundings", "mouth_mirror", "suction", "resume"});
  const auto find = [&](const std::string& name) { return find_file(name, place); };
  Scene scene;
  scene.file = file;
  scene.place = place;
  scene.text = json.text();
  scene.name = json.string_or("name", file.stem().string());
  scene.tissue = json["tissue"];
  scene.resume = json.string_or("resume", "");
  if (!scene.tissue->is_object()) scene.tissue->fail("an object with \"volume\" or \"solids\"");
  if (scene.tissue->has("volume")) {
    scene.tissue->allow_only({"volume"});
    (*scene.tissue)["volume"].string();
  } else if (!scene.tissue->has("solids")) {
    scene.tissue->fail("an object with \"volume\" or \"solids\"");
  }
  if (const auto paint = json.find("paint")) {
    for (const Json& item : paint->items()) {
      item.allow_only({"tissue", "solid"});
      const auto tissue = tissue_named(item["tissue"].string());
      if (!tissue || *tissue == Tissue::kAir) item["tissue"].fail("the name of a tissue");
      haptics::read_solid(item["solid"], find);
      scene.paint.push_back(item);
    }
  }

  if (const auto prepare = json.find("prepare")) {
    scene.prepare = prepare->items();
    for (const Json& item : scene.prepare) haptics::read_solid(item, find);
  }

  haptics::ServoSettings& servo = scene.servo;
  const auto tool_of = [](const Json& tool) {
    return tool.is_string() ? load_tool(tool.string()) : haptics::read_tool(tool);
  };
  if (json.has("tool") && json.has("tools")) json.fail("both tool and tools", "one of them");
  if (const auto tools = json.find("tools")) {
    for (const Json& tool : tools->items()) servo.tools.push_back(tool_of(tool));
    if (servo.tools.empty()) tools->fail("at least one tool");
    servo.tool = servo.tools.front();
  } else {
    servo.tool = tool_of(json["tool"]);
  }
  if (json.has("spindle") && json.has("spindle_krpm")) json.fail("both spindle and spindle_krpm", "one of them");
  if (const auto motor = json.find("spindle")) {
    scene.motor = motor->string();
    servo.spindle = load_spindle(scene.motor);
  }
  if (const auto speed = json.find("spindle_krpm")) servo.spindle.free_speed = speed->number(0, 1000) * kKrpm;
  if (const auto coupling = json.find("coupling")) {
    coupling->allow_only({"stiffness_N_per_mm", "damping_Ns_per_mm"});
    servo.stiffness = coupling->number_or("stiffness_N_per_mm", 1, 0, 1000) * kNewtonPerMillimetre;
    servo.damping = coupling->number_or("damping_Ns_per_mm", 0.002, 0, 10) * kNewtonPerMillimetre;
  }
  servo.materials = load_materials();
  if (const auto materials = json.find("materials")) read_materials(*materials, servo.materials);
  if (const auto paint = json.find("paint_file")) {
    scene.paint_file = find_file(paint->string(), place);
    const auto strokes = read_paint(scene.paint_file);
    for (std::size_t i = 0; i < kTissueCount; ++i) {
      servo.materials[i].stiffness *= stiffness_factor(strokes, static_cast<Tissue>(i));
    }
  }
  servo.friction = json.boolean_or("friction", true);
  servo.cutting = json.boolean_or("cutting", true);
  servo.passivity = json.boolean_or("passivity", true);
  servo.boundary_walls = json.boolean_or("boundary_walls", true);

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
      scene.vibration_band_set = true;  // off, whatever the device could render
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
      for (const Json& item : list) haptics::read_solid(item);
    }
  }
  if (const auto surroundings = json.find("surroundings")) {
    read_surroundings(*surroundings, volume_file(scene), place);
    scene.surroundings = *surroundings;
  }
  if (const auto mirror = json.find("mouth_mirror")) scene.mouth_mirror = read_mouth_mirror(*mirror);
  if (const auto suction = json.find("suction")) {
    suction->allow_only({"position_mm", "flow_l_per_min", "radius_mm", "on"});
    const debris::Suction usual;
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
  if (const auto sound = json.find("sound")) {
    sound->allow_only({"lower_order"});
    scene.sound_lower_order = sound->boolean_or("lower_order", false);
  }
  return scene;
}

std::vector<std::string> tool_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const haptics::Tool& tool : haptics::tray(scene.servo)) names.push_back(tool.name);
  return names;
}

std::filesystem::path volume_file(const Scene& scene) {
  const auto volume = scene.tissue->find("volume");
  return volume ? find_file(volume->string(), scene.place) : fs::path();
}

haptics::ServoSettings servo_settings(const Scene& scene, const haptics::TissueVolume& tissue, double rate,
                                      double vibration_band, double position_step, bool gives_torque) {
  haptics::ServoSettings settings = scene.servo;
  if (!scene.vibration_band_set) settings.vibration.band = vibration_band;
  settings.position_step = position_step;
  settings.gives_torque = gives_torque;
  settings.frame = tissue.frame();
  settings.tick = 1 / rate;
  return settings;
}

haptics::TissueVolume load_tissue(const Scene& scene) {
  haptics::TissueVolume untouched = load_untouched(scene);
  return scene.resume.empty() ? std::move(untouched) : resumed_tissue(scene, untouched);
}

haptics::TissueVolume load_untouched(const Scene& scene) {
  const auto find = [&](const std::string& name) { return find_file(name, scene.place); };
  const auto read = [&] {
    if (const fs::path file = volume_file(scene); !file.empty()) return haptics::TissueVolume::load(file);
    return haptics::TissueVolume(sampled_tissue(*scene.tissue, find));
  };
  haptics::TissueVolume volume = read();
  for (const Json& item : scene.paint) {
    const auto solid = haptics::read_solid(item["solid"], find);
    volume.paint(*tissue_named(item["tissue"].string()), *solid);
  }
  if (!scene.paint_file.empty()) paint(volume, read_paint(scene.paint_file));
  for (const Json& item : scene.prepare) volume = without_solid(volume, *haptics::read_solid(item, find));
  return volume;
}

}  // namespace typodont
