#include "engine/session/task.h"

#include <fmt/format.h>

#include "engine/base/units.h"

namespace typodont::session {

const std::string& TaskText::in(Language language) const {
  const std::string& own = text[static_cast<std::size_t>(language)];
  return own.empty() ? text[0] : own;
}

namespace {

void describe_translations(Keys& keys, TaskText& text) {
  keys(must("en"), text.text[0], "");
  keys("de", text.text[1], "");
  keys("zh", text.text[2], "");
}

/// Declares the keys of a step with the action that completes it and its tool.
void describe_step(Keys& keys, TaskStep& step) {
  describe_translations(keys, step);
  keys("done", step.done, kStepActions, "action that completes the step; default: a click");
  keys("tool", step.tool, "tool to which the session changes when the step begins");
  if (keys.json() && !step.tool.empty() && (step.done == "tool" || step.done == "phase")) {
    (*keys.json())["tool"].fail(
        fmt::format("no tool, because the user changes it in a step with \"done\": \"{}\"", step.done));
  }
}

void describe_explore(Keys& keys, Task& task) {
  keys.alternative();
  if (const auto region = keys("region", kSolids, "the surface to explore; default: all"))
    task.region = region->items();
  keys.alternative();
  const auto site = [&](Keys& of, ProbeSite& read) {
    TaskText name;
    describe_text(of, must("name"), name, "name of the pocket");
    of(must("margin_mm"), read.margin_W, kMillimetre, "middle of the pocket at the gum's margin");
    of(must("floor_mm"), read.floor_W, kMillimetre, "middle of its floor");
    if (!of.json()) return;
    task.site_names.push_back(std::move(name));
    if (!(glm::dot(read.margin_W - read.floor_W, task.axis_W) > 0))
      (*of.json())["floor_mm"].fail("a point below the margin, along the axis");
  };
  keys(must("sites"), task.sites, site,
       "pockets to measure. The pedal reads the depth of the tip of the first tool below the margin, along `axis`, at "
       "the nearest site (at most 2 mm away); the last reading counts");
  if (keys.json() && task.sites.empty()) (*keys.json())["sites"].fail("at least one site");
}

}  // namespace

TaskText read_task_text(const Json& json) {
  if (json.is_string()) return {{json.string()}};
  if (!json.is_object()) json.fail("a text, or {\"en\": …, \"de\": …, \"zh\": …}");
  return read_keys(json, describe_translations);
}

void describe_text(Keys& keys, Key key, TaskText& text, std::string_view meaning) {
  const auto any = [](Keys& of) {
    TaskText none;
    describe_translations(of, none);
  };
  if (const auto json = keys(key, Form{"text, or `{\"en\", \"de\", \"zh\"}`", kNameOrObject.schema}, any, meaning))
    text = read_task_text(*json);
}

void describe_task(Keys& keys, Task& task, void (*ideal)(Keys&)) {
  const Json* json = keys.json();
  describe_text(keys, must("goal"), task.goal, "what the trainee should do");
  describe_text(keys, "title", task.title, "title");
  const auto any_step = [](Keys& of) {
    TaskStep none;
    describe_step(of, none);
  };
  if (const auto steps = keys("steps", Form{"list of texts or objects", kNamesOrObjects.schema}, any_step,
                              "[steps](scene_format.md#steps)")) {
    for (const Json& step : steps->items()) {
      task.steps.push_back(step.is_object() ? read_keys(step, describe_step) : TaskStep{read_task_text(step), "", ""});
    }
  }
  keys("axis", task.axis_W, read_direction,
       "direction out of the cavity's opening, from which the bur approaches or a crown is placed; default [0, 0, 1]");
  task.ideal = keys("ideal", kObject, ideal, "the desired final tissue ([The ideal](#the-ideal)); else no comparison");
  const auto explore = [&](Keys& of) { describe_explore(of, task); };
  if (const auto block = keys("explore", kObject, explore,
                              "instead of `ideal`: what the trainee should explore. The pedal marks a finding")) {
    read_keys(*block, explore);
    task.explore = true;
    if (task.ideal) json->fail("both ideal and explore", "one of them");
  }
  if (const auto protect =
          keys("protect", kSolids, "tissue that must not be cut (a neighbouring tooth, the neck of the tooth)"))
    task.protect = protect->items();
  describe_score(keys, task.score, json && json->has("ideal"));
}

Task read_task(const Json& json) {
  Task task;
  read_keys(json, [&](Keys& keys) { describe_task(keys, task, [](Keys&) {}); });
  return task;
}

std::vector<ScoreRule> rules_of_scene(const Json& scene, const ScoreInput& input) {
  if (const auto task = scene.find("task")) return task_rules(*task, input);
  if (const auto block = scene.find("score")) return rules_from(*block, input);
  return default_rules(input);
}

Score score_of_scene(const Json& scene, const ScoreInput& input) {
  const auto task = scene.find("task"), block = task ? task : scene.find("score");
  StatedScore stated;
  if (block) {
    Keys keys(*block);
    describe_score(keys, stated, true);
  }
  return score(input, rules_of_scene(scene, input), stated.pass);
}

}  // namespace typodont::session
