// Tests that long work reports its progress and can be stopped.
#include "engine/base/progress.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <thread>

namespace typodont {
namespace {

TEST(Progress, StagesFillTheWholeRangeInOrder) {
  Progress p;
  p.stage("reading", 0, 0.25);
  p.at(0.5);
  EXPECT_DOUBLE_EQ(p.fraction(), 0.125);
  p.stage("writing", 0.25, 1);
  EXPECT_DOUBLE_EQ(p.fraction(), 0.25);
  EXPECT_STREQ(p.what(), "writing");
  p.at(7);
  EXPECT_DOUBLE_EQ(p.fraction(), 1) << "never more than all";
}

TEST(Progress, AWatcherStopsTheWorkAtTheNextReport) {
  Progress p;
  bool stopped = false;
  std::jthread worker([&] {
    try {
      for (;;) p.at(0.5);
    } catch (const Cancelled&) {
      stopped = true;
    }
  });
  p.cancel();
  worker.join();
  EXPECT_TRUE(stopped);
}

TEST(Progress, OnTheTerminalAnInterruptCancelsTheWorkAndLaterInterruptsAreNormal) {
  const auto before = signal(SIGINT, SIG_IGN);
  {
    Progress p("work");
    p.at(0.1);
    raise(SIGINT);
    EXPECT_TRUE(p.cancelled());
    EXPECT_THROW(p.at(0.2), Cancelled);
  }
  EXPECT_EQ(signal(SIGINT, before), SIG_IGN) << "whoever handled it before does so again";
}

}  // namespace
}  // namespace typodont
