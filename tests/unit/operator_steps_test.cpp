// Tests that a step of a task is finished when its action was done, and not before.
#include <gmock/gmock.h>

#include "engine/app/operator/steps.h"
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

TEST(Steps, ToolSpeedUndoViewAndHoldAreSeenAsChanges) {
  WatchedHand h{
      StepWatcher(task_of(R"({"en": "t", "done": "tool"}, {"en": "s", "done": "speed"}, {"en": "u", "done": "undo"},
                               {"en": "v", "done": "view"}, {"en": "h", "done": "hold"})")),
      {}};
  h.after(0);
  h.deeds.tick.tool = 2;
  EXPECT_TRUE(h.after(0.1));
  h.after(0.1);
  h.deeds.settings.speed_fraction = 0.5;
  EXPECT_TRUE(h.after(0.1));
  h.after(0.1);
  EXPECT_FALSE(h.after(0.1));
  h.deeds.undone = 1;
  EXPECT_TRUE(h.after(0.1));
  h.after(0.1);
  h.deeds.views = 1;
  EXPECT_TRUE(h.after(0.1));
  EXPECT_FALSE(h.after(0.1));
  h.deeds.held = true;
  EXPECT_TRUE(h.after(0.1));
}

TEST(Steps, AnUnknownActionIsRefusedByName) {
  EXPECT_THAT(test::refusal([&] { task_of(R"({"en": "t", "done": "dance"})"); }),
              testing::AllOf(testing::HasSubstr("dance"), testing::HasSubstr("drill")));
}

}  // namespace
}  // namespace typodont
