// Tests the mouse as a hand: from the events of the window to the position of the tool.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <random>

#include "engine/app/assets.h"
#include "engine/app/hands/mouse_hand.h"
#include "engine/app/recording/resume.h"
#include "engine/app/task/task.h"
#include "engine/base/units.h"
#include "engine/display/keys.h"
#include "haptics/solid.h"
#include "tests/support/folder.h"

namespace typodont::test {
namespace {

using namespace literals;

display::DisplayRig rig_named(const char* name) {
  return display::load_rig(assets_folder() / "rigs" / name);
}
constexpr Nanos kFrame = 16'000'000;  // ns

TEST(MouseHand, AClickShorterThanAFrameReachesTheServo) {
  Pointer pointer(rig_named("window.json"), {0, 0, 0}, 0.15_mm);
  display::UserInput input;
  EXPECT_EQ(pointer.follow(input, kFrame).pedal, 0);
  input.left = true;  // the window also reports a button that was pressed and released between two frames
  EXPECT_EQ(pointer.follow(input, 2 * kFrame).pedal, 1);
  input.left = false;
  // The next call may come so early that a servo at 1 kHz has not read the last result. So the pedal must still be
  // down.
  EXPECT_EQ(pointer.follow(input, 2 * kFrame + 1000).pedal, 1);
  EXPECT_EQ(pointer.follow(input, 4 * kFrame).pedal, 1);
  EXPECT_EQ(pointer.follow(input, 6 * kFrame).pedal, 0);
}

TEST(MouseHand, AButtonReleasedAfterALongPressStopsTheDrillImmediately) {
  Pointer pointer(rig_named("window.json"), {0, 0, 0}, 0.15_mm);
  display::UserInput input;
  input.left = true;
  for (int i = 1; i < 8; ++i) EXPECT_EQ(pointer.follow(input, i * kFrame).pedal, 1);
  input.left = false;
  EXPECT_EQ(pointer.follow(input, 8 * kFrame).pedal, 0);
}

TEST(MouseHand, TheToolStartsAboveTissueThatWouldHideItAndElsewhereItStaysAtItsStart) {
  const auto block = [](double y_mm) {
    return haptics::TissueVolume(
        haptics::read_solids(Json::parse(fmt::format(R"({{"voxel_mm": 0.2, "solids": [{{"tissue": "enamel",
          "solid": {{"box": {{"center_mm": [6.8, {}, 18], "size_mm": [6, 3, 12]}}}}}}]}})",
                                                     y_mm),
                                         "test")));
  };
  const display::DisplayRig rig = rig_named("window.json");
  const dvec3 start(6.8_mm, 14.0_mm, 18.0_mm);
  const dvec3 eye = rig.head.eye_center;
  // The user sits at smaller y. A block between the eye and the tool hides it; a block behind the tool does not.
  for (const double y_mm : {6.0, 26.0}) {
    Pointer pointer(rig, start, 0.15_mm);
    const dvec3 before = pointer.follow({}, 0).X_WT.p;
    pointer.come_into_sight(block(y_mm));
    const haptics::HandSample hand = pointer.follow({}, 0);
    const dvec3 after = hand.X_WT.p, shank = hand.X_WT.R * dvec3(0, 0, 1);
    if (y_mm > 14) {
      EXPECT_EQ(after, before);
      continue;
    }
    const auto inside = [](const dvec3& p) {
      return glm::all(glm::lessThan(glm::abs(p - dvec3(6.8_mm, 6.0_mm, 18.0_mm)), dvec3(3.0_mm, 1.5_mm, 6.0_mm)));
    };
    // Two millimetres along its shank, the tool meets the block (a voxel is 0.2 mm).
    EXPECT_FALSE(inside(after - 1.7_mm * shank));
    EXPECT_TRUE(inside(after - 2.3_mm * shank));
    // On along its shank, it meets the line of sight to the middle of the picture, where the block is seen.
    const dvec3 sight = glm::normalize(eye - before), off = after - eye,
                normal = glm::normalize(glm::cross(sight, shank));
    EXPECT_NEAR(glm::dot(off, normal), 0, 1e-9);
  }
}

TEST(MouseHand, TheToolIsUnderThePointer) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const char* name : {"window.json", "mirror.json", "closeup.json"}) {
    display::DisplayRig rig = rig_named(name);
    rig.screen.layout = display::Layout::kMono;
    const dvec3 work(6.8_mm, 6.0_mm, 18.0_mm);
    for (const double magnify : {1.0, 5.0}) {
      rig.magnify = magnify;
      const display::DisplayRig seen = display::magnified(rig, work);
      Pointer pointer(seen, work, 0.5_mm);
      const display::EyeView eye = display::eye_views(seen)[0];
      for (int i = 0; i < 100; ++i) {
        display::UserInput input;
        input.pointer = {uniform(random), uniform(random)};
        const dvec3 p = pointer.follow(input, i * kFrame).X_WT.p;
        const glm::dvec4 c = eye.projection * eye.view * glm::dvec4(p, 1);
        ASSERT_NEAR(c.x / c.w, input.pointer.x, 1e-9) << name;
        ASSERT_NEAR(-c.y / c.w, input.pointer.y, 1e-9) << name;
      }
    }
  }
}

TEST(MouseHand, ANotchOfTheWheelMovesTheToolAlongItsShankByTheChosenStep) {
  const display::DisplayRig rig = rig_named("window.json");
  for (const char* text : {"", "0.05", "1"}) {
    const double step = wheel_step_of(text);
    Pointer pointer(rig, {6.8_mm, 6.0_mm, 18.0_mm}, step);
    display::UserInput input;
    const haptics::HandSample first = pointer.follow(input, 0);
    const dvec3 before = first.X_WT.p, shank = first.X_WT.R * dvec3(0, 0, 1);
    input.wheel = 2;
    EXPECT_NEAR(glm::length(pointer.follow(input, kFrame).X_WT.p - before - 2 * step * shank), 0, 1e-12) << text;
    input.wheel = -2;
    EXPECT_NEAR(glm::length(pointer.follow(input, 2 * kFrame).X_WT.p - before), 0, 1e-12);
    input.wheel = 0;
    input.pressed = {display::keys::kPageUp};
    pointer.follow(input, 3 * kFrame);
    EXPECT_NEAR(pointer.wheel_step(), 2 * step, 1e-12);
    input.pressed = {display::keys::kPageDown, display::keys::kPageDown};
    pointer.follow(input, 4 * kFrame);
    EXPECT_NEAR(pointer.wheel_step(), step / 2, 1e-12);
  }
  for (const char* wrong : {"x", "0", "-0.1", "5", "0.1mm", "nan"}) {
    EXPECT_THAT(test::refusal([&] { wheel_step_of(wrong); }),
                testing::AllOf(testing::HasSubstr(wrong), testing::HasSubstr("mouse:STEP_MM")));
  }
}

TEST(MouseHand, IsAtMostAMillimetreAheadOfAToolThatTissueHoldsAndOneNotchTakesItBack) {
  Pointer pointer(rig_named("window.json"), {6.8_mm, 6.0_mm, 18.0_mm}, 0.15_mm);
  const haptics::HandSample first = pointer.follow({}, 0);
  const dvec3 held = first.X_WT.p, shank = first.X_WT.R * dvec3(0, 0, 1);
  display::UserInput input;
  const auto lead = [&](int frame) { return pointer.follow(input, frame * kFrame, held).X_WT.p - held; };
  input.wheel = -3;
  EXPECT_NEAR(glm::length(lead(1) + 0.45_mm * shank), 0, 1e-12);
  for (int i = 0; i < 20; ++i) EXPECT_LE(glm::length(lead(2 + i)), Pointer::kMaxLead + 1e-12);
  EXPECT_NEAR(glm::length(lead(22) + Pointer::kMaxLead * shank), 0, 1e-12);
  input.wheel = 1;
  EXPECT_NEAR(glm::length(lead(23) + (Pointer::kMaxLead - 0.15_mm) * shank), 0, 1e-12);
  input.wheel = 0, input.pointer = {0.8, 0};
  EXPECT_NEAR(glm::length(lead(24)), Pointer::kMaxLead, 1e-12);
}

TEST(MouseHand, RightButtonAndShiftTiltTheToolAboutItsHeadWithoutAJump) {
  for (const char* name : {"window.json", "mirror.json"}) {
    for (const bool by_key : {false, true}) {
      const display::DisplayRig rig = rig_named(name);
      Pointer pointer(rig, {6.8_mm, 6.0_mm, 18.0_mm}, 0.15_mm);
      const auto shank = [](const haptics::HandSample& s) { return s.X_WT.R * dvec3(0, 0, 1); };
      display::UserInput input;
      const haptics::HandSample before = pointer.follow(input, 0);
      // Directions as the user sees them: to the user's right, and towards the user.
      const dvec3 right = rig.head.right, toward = glm::normalize(rig.head.eye_center - before.X_WT.p);
      (by_key ? input.shift : input.right) = true;
      input.pointer = rig.mirror ? glm::dvec2(-0.2, 0) : glm::dvec2(0.2, 0);  // a mirror turns the picture
      haptics::HandSample after = pointer.follow(input, kFrame);
      EXPECT_NEAR(glm::length(after.X_WT.p - before.X_WT.p), 0, 1e-12);
      EXPECT_GT(glm::dot(shank(after) - shank(before), right), 0.05);
      const dvec3 upright = shank(after);
      input.pointer.y = -0.3;
      after = pointer.follow(input, 2 * kFrame);
      EXPECT_GT(glm::dot(shank(after) - upright, dvec3(toward.x, toward.y, 0)), 0.05) << name;

      // After the button is released, the tool stays. When the pointer moves on, the tool returns to the pointer in
      // small steps.
      input.right = input.shift = false;
      dvec3 last = pointer.follow(input, 3 * kFrame).X_WT.p;
      EXPECT_NEAR(glm::length(last - before.X_WT.p), 0, 1e-12);
      const double half = 0.5 * glm::length(rig.screen.lower_right - rig.screen.lower_left);
      for (int i = 0; i < 60; ++i) {
        input.pointer.x += i < 30 ? 0.02 : -0.02;
        const dvec3 p = pointer.follow(input, (4 + i) * kFrame).X_WT.p;
        EXPECT_LT(glm::length(p - last), 0.02 * half * 2);
        last = p;
      }
      Pointer other(rig, {6.8_mm, 6.0_mm, 18.0_mm}, 0.15_mm);
      EXPECT_NEAR(glm::length(last - other.follow(input, 0).X_WT.p), 0, 1e-9);

      input.middle = true;
      EXPECT_NEAR(glm::length(shank(pointer.follow(input, 100 * kFrame)) - dvec3(0, 0, 1)), 0, 1e-12);
    }
  }
}

TEST(MouseHand, InATaskTheShankStartsAlongTheTasksAxisAndTheMiddleButtonSetsItBack) {
  const display::DisplayRig rig = rig_named("window.json");
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 100; ++i) {
    const dvec3 axis = i == 0   ? dvec3(1, 0, 0)
                       : i == 1 ? dvec3(0, 0, -1)
                                : glm::normalize(dvec3(normal(random), normal(random), normal(random)));
    Pointer pointer(rig, {6.8_mm, 6.0_mm, 18.0_mm}, 0.15_mm, axis);
    const auto off = [&](const display::UserInput& input, int frame) {
      return glm::length(pointer.follow(input, frame * kFrame).X_WT.R * dvec3(0, 0, 1) - axis);
    };
    EXPECT_NEAR(off({}, 0), 0, 1e-9);
    EXPECT_GT(off({.pointer = {0.2, 0.1}, .right = true}, 1), 0.05);
    EXPECT_NEAR(off({.pointer = {0.2, 0.1}, .middle = true}, 2), 0, 1e-9);
  }
}

}  // namespace
}  // namespace typodont::test
