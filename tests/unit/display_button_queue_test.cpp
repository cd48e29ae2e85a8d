#include <gtest/gtest.h>

#include "engine/display/button_queue.h"

namespace typodont::display {
namespace {

TEST(ButtonQueue, ShowsEveryPressAndReleaseInTurnAndThenTheLastState) {
  ButtonQueue button;
  EXPECT_FALSE(button.next());
  button.add(true);
  EXPECT_TRUE(button.next());
  EXPECT_TRUE(button.next()) << "still down";
  // The end of a drag and a click arrive at the same time.
  button.add(false), button.add(true), button.add(false);
  EXPECT_FALSE(button.next());
  EXPECT_TRUE(button.next());
  EXPECT_FALSE(button.next());
  EXPECT_FALSE(button.next());
}

}  // namespace
}  // namespace typodont::display
