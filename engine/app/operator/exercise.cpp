#include "engine/app/operator/exercise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/app/operator/library.h"
#include "engine/app/planning/scene_text.h"
#include "engine/app/recording/resume.h"
#include "engine/app/task/damage.h"
#include "engine/app/task/heat.h"
#include "engine/app/task/task.h"
#include "engine/base/error.h"
#include "engine/base/folder.h"
#include "engine/base/json.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;
using Text = nlohmann::ordered_json;

Text paint_entry(const PaintStroke& s) {
  const double radius = s.radius / kMillimetre;
  Text solid;
  if (s.a_W == s.b_W) {
    solid["sphere"] = {{"center_mm", millimetres_text(s.a_W)}, {"radius_mm", radius}};
  } else {
    solid["capsule"] = {{"a_mm", millimetres_text(s.a_W)}, {"b_mm", millimetres_text(s.b_W)}, {"radius_mm", radius}};
  }
  Text entry = {{"tissue", std::string(name_of(s.tissue))}, {"solid", solid}};
  const auto rounded = [](double v) { return std::round(v * 1000) / 1000; };
  if (s.hardness != 1) entry["hardness"] = rounded(s.hardness);
  if (const dvec3 c = srgb_of(s.color); s.color != kTissueColor)
    entry["color"] = {rounded(c.x), rounded(c.y), rounded(c.z)};
  return entry;
}

}  // namespace

std::vector<RuleChoice> rule_choices(const Scene& base) {
  std::vector<RuleChoice> choices;
  for (const std::string& name : session::known_score_names()) {
    RuleChoice choice;
    choice.name = name;
    choice.target = static_cast<float>(session::default_target(name).value_or(0));
    choices.push_back(choice);
  }
  const Json json = Json::parse(base.text, base.file.string());
  const auto task = json.find("task");
  const auto block = task ? task : json.find("score");
  const auto rules = block ? block->find("rules") : std::nullopt;
  if (!rules) return choices;
  for (const Json& rule : rules->items()) {
    const auto found = std::find_if(choices.begin(), choices.end(),
                                    [&](const RuleChoice& c) { return c.name == rule["name"].string(); });
    if (found == choices.end()) continue;
    found->counts = true;
    found->from_ideal = !rule.has("target");
    found->target = static_cast<float>(rule.number_or("target", 0));
    found->tolerance = static_cast<float>(rule.number_or("tolerance", 1));
    found->weight = static_cast<float>(rule.number_or("weight", 0));
    if (const auto critical = rule.find("critical")) found->critical = static_cast<float>(critical->number());
  }
  return choices;
}

namespace {

Text rules_of(const std::vector<RuleChoice>& choices) {
  Text rules = Text::array();
  for (const RuleChoice& c : choices) {
    if (!c.counts) continue;
    // Rounds to four significant digits, because the float 0.7 would be written with more digits.
    const auto plain = [](float v) { return std::stod(fmt::format("{:.4g}", v)); };
    Text rule = {{"name", c.name}, {"tolerance", plain(std::max(c.tolerance, 1e-6f))}, {"weight", plain(c.weight)}};
    if (!c.from_ideal) rule["target"] = plain(c.target);
    if (c.critical) rule["critical"] = plain(*c.critical);
    rule["source"] = "the instructor";
    rules.push_back(rule);
  }
  return rules;
}

}  // namespace

std::string exercise_json(const NewExercise& e, const std::string& ideal_file) {
  Text scene = scene_for_other_folder(*e.base);
  scene["name"] = e.name;
  scene["description"] = e.goal;
  for (const PaintStroke& stroke : e.strokes) scene["paint"].push_back(paint_entry(stroke));
  for (std::size_t i = 1; i < e.stiffness.size(); ++i) {
    if (e.stiffness[i] == 1) continue;
    const std::string tissue(name_of(static_cast<Tissue>(i)));
    // The stiffness in `servo.materials` already includes the factor of the paint file's strokes. Reading the scene
    // applies this factor again, so the stiffness is divided by this factor here.
    const double painted =
        e.base->paint_file.empty() ? 1 : stiffness_factor(read_paint(e.base->paint_file), static_cast<Tissue>(i));
    scene["materials"][tissue]["stiffness_N_per_mm"] =
        e.stiffness[i] * e.base->servo.materials[i].stiffness / painted / kNewtonPerMillimetre;
  }

  const bool ideal = !ideal_file.empty();
  if (!ideal && !e.rules && e.steps.empty() && !scene.contains("task")) return scene.dump(2) + "\n";
  Text task = scene.value("task", Text::object());
  // The rules are written to the key "task". A base scene without a task has its rules in the key "score".
  if (scene.contains("score")) {
    if (scene["score"].contains("rules")) task["rules"] = scene["score"]["rules"];
    scene.erase("score");
  }
  task["title"] = e.name;
  task["goal"] = e.goal.empty() ? e.name : e.goal;
  if (!e.steps.empty()) task["steps"] = e.steps;
  if (ideal) {
    task.erase("explore");
    if (e.ideal)
      task["ideal"] = {{"volume", ideal_file}};
    else
      task["ideal"] = {{"mesh", {{"file", ideal_file}, {"unit_mm", e.mesh_unit_mm}}}};
  }
  if (e.rules) {
    task["rules"] = rules_of(*e.rules);
    task["defaults"] = false;
  }
  scene["task"] = std::move(task);
  return scene.dump(2) + "\n";
}

namespace {

/// Finds errors that would make a session fail: an invalid mesh, a rule without target. Throws Error.
void validate_exercise(const std::string& text, const fs::path& file) {
  const Json json = Json::parse(text, file.filename().string());
  const auto try_rules = [&](const auto& read) {  // applies `read` to one rule at a time, to find the faulty rule
    const auto task = json.find("task");
    const auto rules = task ? task->find("rules") : std::nullopt;
    if (!rules) return;
    for (const Json& rule : rules->items()) {
      Text alone = {{"defaults", false}, {"rules", Text::array({Text::parse(rule.text())})}};
      if (task->has("ideal")) alone["ideal"] = true;
      try {
        read(Json::parse(alone.dump(), file.filename().string()));
      } catch (const Error& e) {
        throw RuleRefused(e, rule["name"].string(), !rule.has("target"));
      }
    }
  };
  try_rules([](const Json& alone) { (void)session::task_rules(alone, {}); });
  const Scene scene = parse_scene(json, file);
  const haptics::TissueVolume start = load_tissue(scene);
  session::ScoreInput input;
  input.before = input.after = start.volumes();
  TaskEvaluator(scene, start).judge(start, input);
  if (const auto meter = damage_meter(scene)) input.damage = meter->result();
  if (const auto meter = heat_meter(scene, start)) input.heat = meter->result();
  try_rules([&](const Json& alone) { (void)session::task_rules(alone, input); });
}

}  // namespace

fs::path write_exercise(const NewExercise& e, Progress& progress) {
  progress.stage("op.saving_exercise");
  std::string stem;
  for (const char c : e.name) {
    const auto u = static_cast<unsigned char>(c);
    stem += std::isalnum(u) || u >= 0x80 || c == '-' ? static_cast<char>(std::tolower(u)) : '_';
  }
  const fs::path folder = user_folder() / "scenes", file = folder / (stem + ".json");
  // All files are first written under temporary names, so that an invalid exercise replaces no file.
  const fs::path aside = folder / ("." + stem + "-new");
  struct Removed {
    fs::path folder;
    ~Removed() {
      std::error_code ignored;
      fs::remove_all(folder, ignored);
    }
  } const removed{aside};
  make_folder(aside);
  std::error_code code;
  std::string ideal;
  if (e.ideal) {
    ideal = stem + "-ideal.vdb";
    e.ideal->save(aside / ideal);
  } else if (!e.ideal_mesh.empty()) {
    ideal = stem + "-ideal" + e.ideal_mesh.extension().string();
    fs::copy_file(e.ideal_mesh, aside / ideal, code);
    if (code)
      throw Error(e.ideal_mesh.string(), "", code.message(),
                  "a mesh that can be read, and a place that can be written");
  }
  progress.at(0.2);
  const std::string text = exercise_json(e, ideal);
  validate_exercise(text, aside / (stem + ".json"));
  progress.at(0.9);
  if (!ideal.empty()) fs::rename(aside / ideal, folder / ideal, code);
  if (code) throw Error((folder / ideal).string(), "", code.message(), "a place that can be written");
  write_file_atomically(file, text, FileKind::kJson, Over::kItsInput);
  progress.at(1);
  return file;
}

}  // namespace typodont
