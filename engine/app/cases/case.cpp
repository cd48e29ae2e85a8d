#include "engine/app/cases/case.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/app/assets.h"
#include "engine/app/cases/checks.h"
#include "engine/app/cases/draft.h"
#include "engine/app/cases/scanned_tooth.h"
#include "engine/app/planning/volume_beside.h"
#include "engine/base/error.h"
#include "engine/base/keys.h"
#include "engine/base/partial_file.h"

namespace typodont {

namespace fs = std::filesystem;

namespace {

constexpr double kVoxel = 0.125e-3;  // m, edge of a voxel
// Keys of the shipped exercise that a case does not take: they belong to its tissue.
const std::set<std::string> kOwnKeys = {"name",    "description", "tissue",       "surroundings", "paint",
                                        "prepare", "suction",     "mouth_mirror", "task",         "case"};

/// The family `name` of the table. A family with the key "like" has the keys of that family, changed by its own.
Ordered family_of(const Ordered& table, const std::string& name) {
  const Ordered& own = table.at(name);
  Ordered family = own.contains("like") ? family_of(table, own.at("like").get<std::string>()) : Ordered::object();
  family.merge_patch(own);
  return family;
}

Json families_table() {
  const Ordered own = Ordered::parse(Json::load(assets_folder() / "cases" / "families.json")["families"].text());
  Ordered all = Ordered::object();
  for (const auto& item : own.items()) all[item.key()] = family_of(own, item.key());
  return Json::parse(all.dump(), "families.json", Json::Lines::kUnknown);
}

std::string pretty(double value, std::string_view language) {
  std::string text = fmt::format("{:.2g}", value);
  if (language == "de") std::ranges::replace(text, '.', ',');
  return text;
}

/// The types of tooth that a case family lists; none for a hip.
std::vector<std::string> teeth_of(const Json& family) {
  std::vector<std::string> teeth;
  for (const Json& tooth : family["teeth"].items()) teeth.push_back(tooth.string());
  return teeth;
}

/// The family's rules in the task of the shipped exercise: each replaces that of its name; "without" names those that
/// do not apply.
void set_rules(Ordered& rules, const Json& family) {
  if (const auto without = family.find("without"))
    for (const Json& name : without->items())
      std::erase_if(rules.get_ref<Ordered::array_t&>(),
                    [&](const Ordered& own) { return own["name"] == name.string(); });
  const auto changed = family.find("rules");
  if (!changed) return;
  for (const Json& rule : changed->items()) {
    const auto same =
        std::ranges::find_if(rules, [&](const Ordered& own) { return own["name"] == rule["name"].string(); });
    const Ordered text = Ordered::parse(rule.text());
    if (same != rules.end())
      *same = text;
    else
      rules.push_back(text);
  }
}

Ordered base_of(const Json& family) {
  return Ordered::parse(Json::load(find_scene(family["base"].string())).text());
}

/// The task of the shipped exercise with the family's title, steps and rules.
Ordered task_of(const Json& family, const Ordered& base) {
  Ordered task = base["task"];
  for (const char* key : {"title", "steps"})
    if (const auto own = family.find(key)) task[key] = Ordered::parse(own->text());
  task.erase("protect");
  set_rules(task["rules"], family);
  return task;
}

/// Weight of each item of the score in the cases of a family.
std::map<std::string, double> weights_of(const Json& family, const Ordered& task) {
  session::ScoreInput input;
  const std::string recipe = family["recipe"].string();
  if (task.contains("explore")) {
    input.explore.emplace();
    if (recipe == "pockets") input.explore->sites.resize(1);
  } else {
    input.ideal.emplace();
  }
  std::map<std::string, double> weights;
  if (task.value("defaults", true))
    for (const session::ScoreRule& rule : session::default_rules(input)) weights[rule.name] = rule.weight;
  const auto made_by = [&](std::initializer_list<const char*> recipes) {
    return std::ranges::find(recipes, recipe) != recipes.end();
  };
  std::vector<const char*> absent = {"gingiva_removed_mm3", "protected_removed_mm3"};
  const Json parameters = family["parameters"];
  if (!parameters.has("icdas") && !parameters.has("recurrent_mm")) absent.push_back("residual_caries_percent");
  if (!made_by({"boxes", "onlay", "lingual_box", "fracture"})) absent.push_back("neighbour_removed_mm3");
  if (teeth_of(family).empty()) absent.insert(absent.end(), {"pulp_removed_mm3", "pulp_distance_mm"});
  for (const char* name : absent) weights.erase(name);
  for (const Ordered& rule : task["rules"]) weights[rule["name"]] = rule["weight"];
  std::erase_if(weights, [](const auto& item) { return item.second <= 0; });
  return weights;
}

/// Refuses a scan for a family that needs what a scan does not state.
void check_scan(const CaseRequest& request, const Json& family) {
  if (request.tooth.empty()) throw Error("--scan", "", "no --tooth", "the type of the scanned tooth");
  const std::string recipe = family["recipe"].string();
  if (recipe == "onlay" || recipe == "pockets" || recipe.ends_with("access"))
    throw Error("--scan", "", request.family, "a family that needs neither cusps, pockets nor the pulp's chamber");
}

Ordered scene_of(const Draft& draft, const CaseRequest& request, const std::string& volume) {
  const Json& family = draft.family;
  const CaseTooth& tooth = draft.out.tooth;
  const Ordered& base = draft.base;
  std::string description =
      fmt::format("Case {} of the family {}, difficulty {:g}", request.seed, request.family, request.difficulty);
  if (!tooth.type.empty()) description += fmt::format(": {}", in_words(tooth));
  CaseIdentity made = request;
  if (draft.has("icdas")) made.icdas = static_cast<int>(draft.out.parameters.at("icdas"));
  Ordered scene = {{"name", fmt::format("{}-{}", request.family, request.seed)},
                   {"description", description + "."},
                   {"case", json_of(made)},
                   {"tissue", {{"volume", volume}}}};
  for (const auto& [key, value] : base.items())
    if (!kOwnKeys.contains(key)) scene[key] = value;
  if (const auto changed = family.find("scene")) scene.merge_patch(Ordered::parse(changed->text()));
  if (base["tissue"].contains("bone") && base["tissue"]["bone"].contains("canal")) {
    // The volume does not contain the canal's line.
    scene["implant"]["canal"] = base["tissue"]["bone"]["canal"];
    scene["implant"]["canal"].erase("wall_mm");
  }
  const auto listed = [](const dvec3& d) { return Ordered{d.x, d.y, d.z}; };
  if (scene.contains("tooth"))
    scene["tooth"] = {
        {"mesial", listed(draft.turn[0])}, {"buccal", listed(draft.turn[1])}, {"occlusal", listed(draft.turn[2])}};
  if (!draft.prepare.empty()) scene["prepare"] = draft.prepare;
  if (!draft.surroundings.empty()) scene["surroundings"] = draft.surroundings;
  Ordered task = task_of(family, base);
  for (const std::string& language : family["goal"].keys()) {
    std::string filled = family["goal"][language].string();
    // The age of a scan is unknown: the goal of the shipped exercise stays.
    if (tooth.scan && filled.find("{age}") != std::string::npos) continue;
    const auto fill = [&](const std::string& name, const std::string& value) {
      const std::string mark = "{" + name + "}";
      if (const auto at = filled.find(mark); at != std::string::npos) filled.replace(at, mark.size(), value);
    };
    fill("tooth", tooth.type);
    for (const auto& [name, value] : draft.out.parameters) fill(name, pretty(value, language));
    task["goal"][language] = filled;
  }
  if (!draft.explore.empty())
    task["explore"] = draft.explore;
  else if (!draft.ideal.is_null())
    task["ideal"] = draft.ideal;
  task["axis"] = draft.direction({0, 0, 1});
  scene["task"] = task;
  return scene;
}

}  // namespace

std::string in_words(const CaseTooth& tooth) {
  return fmt::format("{} ({}){}", tooth.name, tooth.type, tooth.scan ? "" : fmt::format(", {:.0f} years", tooth.age));
}

nlohmann::ordered_json json_of(const CaseIdentity& made) {
  nlohmann::ordered_json json = {{"family", made.family}, {"seed", made.seed}, {"difficulty", made.difficulty}};
  if (made.icdas > 0) json["icdas"] = made.icdas;
  return json;
}

std::optional<CaseIdentity> case_in(const Json& scene) {
  const auto made = scene.find("case");
  return made ? std::optional(read_keys(*made, describe_case)) : std::nullopt;
}

std::vector<CaseFamily> case_families() {
  std::vector<CaseFamily> families;
  const Json table = families_table();
  for (const std::string& name : table.keys()) {
    const Json family = table[name];
    const Ordered task = task_of(family, base_of(family));
    families.push_back({name, session::read_task_text(Json::parse(task["title"].dump(), name)), teeth_of(family),
                        family["parameters"].keys(), weights_of(family, task)});
  }
  return families;
}

Case make_case(const CaseRequest& request, const fs::path& out, const std::vector<HandErrors>& hands) {
  const Json table = families_table();
  const auto family = table.find(request.family);
  if (!family)
    throw Error("case", "", request.family, fmt::format("one of the families {}", fmt::join(table.keys(), ", ")));
  const std::vector<std::string> teeth = teeth_of(*family);
  SplitMix64 random{request.seed};
  const std::uint64_t choice = random.next();
  std::string tooth = teeth.empty() ? "" : teeth[choice % teeth.size()];
  if (!request.tooth.empty()) {
    if (std::ranges::find(teeth, request.tooth) == teeth.end())
      throw Error("--tooth", "", request.tooth, fmt::format("one of {}", fmt::join(teeth, ", ")));
    tooth = request.tooth;
  }
  if (!request.scan.empty()) check_scan(request, *family);
  require_volume_beside(out, Over::kNoInput);
  PartialFile volume_file(volume_beside(out), FileKind::kVolume), scene_file(out, FileKind::kJson);
  Case result;
  const Json parameters = (*family)["parameters"];
  for (const std::string& name : parameters.keys()) {
    const std::vector<double> easy = parameters[name]["easy"].numbers(2), hard = parameters[name]["hard"].numbers(2);
    const double low = glm::mix(easy[0], hard[0], request.difficulty);
    const double high = glm::mix(easy[1], hard[1], request.difficulty);
    result.parameters[name] = std::round(glm::mix(low, high, uniform(random)) * 100) / 100;
  }
  Draft draft{result, *family, random, base_of(*family)};
  if (tooth.empty()) {
    apply_recipe(draft);
    const fs::path base = find_scene((*family)["base"].string());
    load_untouched(parse_scene(Json::parse(draft.base.dump(), base.string()), base)).save(volume_file.path());
  } else {
    const double curvature = result.parameters.contains("curvature_deg") ? result.parameters.at("curvature_deg") : 0;
    result.tooth = request.scan.empty()
                       ? make_tooth(tooth, result.parameters.at("age"), random, glm::radians(curvature))
                       : scanned_tooth(tooth, request.scan);
    if (result.tooth.scan) result.parameters.erase("age");
    draft.offset = kTop - dvec3(0, 0, result.tooth.crown);
    apply_recipe(draft);
    draft.tissue = sample_tooth(result.tooth, kVoxel, draft.gum ? &*draft.gum : nullptr);
    apply_lesions(draft);
    check_tissue(draft);
    if (draft.turn != glm::dmat3(1)) draft.tissue = turned(draft.tissue, draft.turn);
    draft.tissue.frame.origin += draft.offset;
    haptics::TissueVolume(draft.tissue).save(volume_file.path());
  }
  Ordered scene = scene_of(draft, request, volume_file.file().filename().string());
  result.scene = scene.dump(2) + "\n";
  // The volume has a temporary name until the case is known to be valid.
  scene["tissue"]["volume"] = fs::absolute(volume_file.path()).string();
  const Json text = Json::parse(scene.dump(), out.string());
  const Scene parsed = parse_scene(text, out);
  grade(result, text, parsed, draft.turn * draft.R, load_untouched(parsed), hands);
  write_file_atomically(scene_file.path(), result.scene, FileKind::kJson);
  volume_file.keep();
  scene_file.keep();
  return result;
}

}  // namespace typodont
