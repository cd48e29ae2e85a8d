// Tests that a step of a task is finished when its action was done, and not before.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/app/assets.h"
#include "engine/app/operator/steps.h"
#include "engine/app/scene.h"
#include "engine/base/units.h"
#include "tests/support/folder.h"

namespace typodont {
namespace {

session::Task task_of(const std::string& steps) {
  return session::read_task(Json::parse(R"({"goal": "g", "steps": [)" + steps + "]}", "task.json"));
}

struct WatchedHand {
  StepWatcher watcher;
  StepActions deeds;
  bool after(double seconds) {
    deeds.tick.t += from_seconds(seconds);
    return watcher.follow(deeds);
  }
};

TEST(Steps, AStepIsCompletedByItsActionOnly) {
  WatchedHand h{StepWatcher(task_of(R"({"en": "Move", "done": "move"}, {"en": "Drill", "done": "drill"}, "Look")")),
                {}};
  h.after(0);
  h.deeds.tick.removed[1] = 1 * kCubicMillimetre;
  EXPECT_FALSE(h.after(0.1)) << "drilling is not what the first step asks for";
  for (int i = 0; i < 7; ++i) {
    h.deeds.tick.X_WT.p.x += 1.5e-3;
    EXPECT_EQ(h.after(0.1), i == 6);
  }
  EXPECT_EQ(h.watcher.current(), 1);
  EXPECT_FALSE(h.after(0.1)) << "what was drilled before the step began does not count";
  EXPECT_FALSE(h.after(0.1));
  h.deeds.tick.removed[1] += 0.06 * kCubicMillimetre;
  EXPECT_TRUE(h.after(0.1));
  EXPECT_FALSE(h.watcher.waits()) << "the last step is ticked off by hand";
  EXPECT_FALSE(h.after(100));
  h.watcher.next();
  EXPECT_EQ(h.watcher.current(), h.watcher.count());
  h.watcher.back();
  EXPECT_EQ(h.watcher.current(), 2);
}

TEST(Steps, TouchingCountsOnlyWhileTheHeadIsOnTissue) {
  WatchedHand h{StepWatcher(task_of(R"({"en": "Touch", "done": "touch"})")), {}};
  h.after(0);
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(h.after(0.1));
  h.deeds.tick.contact_area = 1e-8;
  int ticks = 0;
  while (!h.after(0.1) && ticks < 100) ++ticks;
  EXPECT_EQ(ticks, 5);
}

TEST(Steps, AToolThatWasChosenBeforeTheStepDoesNotCompleteIt) {
  WatchedHand h{StepWatcher(task_of(R"({"en": "Take another tool.", "done": "tool"})")), {}};
  h.deeds.chosen_tool = 2;  // the head is still on tissue, so the servo has not taken the tool yet
  h.after(0);
  h.deeds.tick.tool = 2;
  EXPECT_FALSE(h.after(0.1));
  h.deeds.chosen_tool = 1;
  EXPECT_FALSE(h.after(0.1));
  h.deeds.tick.tool = 1;
  EXPECT_TRUE(h.after(0.1));
}

/// Does what an action means, and more than is necessary: three times, with a tick after each.
void act_amply(WatchedHand& h, std::string_view action, std::uint32_t tools) {
  StepActions& deeds = h.deeds;
  for (int i = 0; i < 3; ++i) {
    if (action == "tool") deeds.tick.tool = (deeds.tick.tool + 1) % tools;
    if (action == "move") deeds.tick.X_WT.p.x += 11 * kMillimetre;
    if (action == "drill") deeds.tick.removed[1] += kCubicMillimetre;
    if (action == "speed") deeds.settings.speed_fraction -= 0.05;
    if (action == "touch") deeds.tick.contact_area = 1e-8;
    deeds.chosen_tool = static_cast<std::int32_t>(deeds.tick.tool);
    deeds.undone += action == "undo";
    deeds.redone += action == "redo";
    deeds.views += action == "view";
    deeds.viewpoints += action == "viewpoint";
    deeds.held = action == "hold" && i < 2;
    h.after(0.6);
    deeds.tick.contact_area = 0;
  }
}

TEST(Steps, EachActionOfTheShippedTutorialCompletesItsStepAndNoLaterOne) {
  const Scene scene = read_scene(assets_folder() / "scenes" / "tutorial.json");
  const std::vector<std::string> tools = tool_names(scene);
  const auto& steps = scene.task->steps;
  WatchedHand h{StepWatcher(*scene.task), {}};
  for (int i = 0; i < h.watcher.count(); ++i) {
    const std::string& needed = steps[static_cast<std::size_t>(i)].tool;
    EXPECT_EQ(h.watcher.tool(), needed);
    if (!needed.empty()) {  // the session takes the tool
      h.deeds.tick.tool = static_cast<std::uint32_t>(std::ranges::find(tools, needed) - tools.begin());
      h.deeds.chosen_tool = static_cast<std::int32_t>(h.deeds.tick.tool);
    }
    h.after(0.1);
    ASSERT_EQ(h.watcher.current(), i) << "nothing was done yet";
    const std::string& action = steps[static_cast<std::size_t>(i)].done;
    if (action.empty()) h.watcher.next();
    act_amply(h, action, static_cast<std::uint32_t>(tools.size()));
    ASSERT_EQ(h.watcher.current(), i + 1) << steps[static_cast<std::size_t>(i)].text[0];
  }
  EXPECT_EQ(h.watcher.tool(), "") << "all is done";
}

TEST(Steps, AToolIsRefusedInAStepInWhichTheUserChangesIt) {
  EXPECT_EQ(StepWatcher(task_of(R"({"en": "t", "tool": "explorer"})")).tool(), "explorer");
  for (const std::string action : {"tool", "phase"})
    EXPECT_THAT(test::refusal([&] { task_of(R"({"en": "t", "tool": "explorer", "done": ")" + action + R"("})"); }),
                testing::AllOf(testing::HasSubstr(R"("steps[0].tool": found "explorer")"), testing::HasSubstr(action)));
}

TEST(Steps, AnUnknownActionIsRefusedByName) {
  EXPECT_THAT(test::refusal([&] { task_of(R"({"en": "t", "done": "dance"})"); }),
              testing::AllOf(testing::HasSubstr("dance"), testing::HasSubstr("drill")));
}

}  // namespace
}  // namespace typodont
