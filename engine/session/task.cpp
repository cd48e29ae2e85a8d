#include "engine/session/task.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "engine/base/units.h"

namespace typodont::session {

const std::string& TaskText::in(Language language) const {
  const std::string& own = text[static_cast<std::size_t>(language)];
  return own.empty() ? text[0] : own;
}

namespace {

TaskText translations(const Json& json) {
  return {{json["en"].string(), json.string_or("de", ""), json.string_or("zh", "")}};
}

/// Reads a step: a text, or {"en": …, "done": "drill", "tool": …} with the action that completes it and its tool.
TaskStep read_step(const Json& json) {
  if (!json.is_object()) return {read_task_text(json), "", ""};
  json.allow_only({"en", "de", "zh", "done", "tool"});
  TaskStep step{translations(json), json.string_or("done", ""), json.string_or("tool", "")};
  if (json.has("done") && std::find(kStepActions.begin(), kStepActions.end(), step.done) == kStepActions.end())
    json["done"].fail(fmt::format("one of {}", fmt::join(kStepActions, ", ")));
  if (json.has("tool") && (step.done == "tool" || step.done == "phase"))
    json["tool"].fail(fmt::format("no tool, because the user changes it in a step with \"done\": \"{}\"", step.done));
  return step;
}

}  // namespace

TaskText read_task_text(const Json& json) {
  if (json.is_string()) return {{json.string()}};
  if (!json.is_object()) json.fail("a text, or {\"en\": …, \"de\": …, \"zh\": …}");
  json.allow_only({"en", "de", "zh"});
  return translations(json);
}

Task read_task(const Json& json) {
  json.allow_only({"title", "goal", "steps", "axis", "ideal", "explore", "protect", "rules", "defaults", "pass"});
  Task task;
  if (const auto title = json.find("title")) task.title = read_task_text(*title);
  task.goal = read_task_text(json["goal"]);
  if (const auto steps = json.find("steps")) {
    for (const Json& step : steps->items()) task.steps.push_back(read_step(step));
  }
  if (const auto axis = json.find("axis")) {
    task.axis_W = axis->vec3();
    if (!(glm::length(task.axis_W) > 1e-9)) axis->fail("a direction that is not zero");
    task.axis_W = glm::normalize(task.axis_W);
  }
  task.ideal = json.find("ideal");
  if (const auto explore = json.find("explore")) {
    explore->allow_only({"region", "sites"});
    task.explore = true;
    if (const auto sites = explore->find("sites")) {
      if (explore->has("region")) explore->fail("both region and sites", "one of them");
      for (const Json& site : sites->items()) {
        site.allow_only({"name", "margin_mm", "floor_mm"});
        task.site_names.push_back(read_task_text(site["name"]));
        task.sites.push_back({site["margin_mm"].vec3() * kMillimetre, site["floor_mm"].vec3() * kMillimetre});
        if (!(glm::dot(task.sites.back().margin_W - task.sites.back().floor_W, task.axis_W) > 0))
          site["floor_mm"].fail("a point below the margin, along the axis");
      }
      if (task.sites.empty()) sites->fail("at least one site");
    }
    if (const auto region = explore->find("region")) task.region = region->items();
    if (task.ideal) json.fail("both ideal and explore", "one of them");
  }
  if (const auto protect = json.find("protect")) task.protect = protect->items();
  task.rules = stated_rules(json);
  task.defaults = json.boolean_or("defaults", true);
  return task;
}

std::vector<ScoreRule> rules_of_scene(const Json& scene, const ScoreInput& input) {
  if (const auto task = scene.find("task")) return task_rules(*task, input);
  if (const auto block = scene.find("score")) return rules_from(*block, input);
  return default_rules(input);
}

Score score_of_scene(const Json& scene, const ScoreInput& input) {
  const auto task = scene.find("task"), block = task ? task : scene.find("score");
  return score(input, rules_of_scene(scene, input), block ? pass_mark(*block) : PassMark{});
}

}  // namespace typodont::session
