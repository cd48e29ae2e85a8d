// Tests the text over a picture: it is as sharp as the screen allows, whatever is below it.
#include <gtest/gtest.h>

#include <algorithm>

#include "engine/display/writing.h"
#include "tests/support/color_vision.h"
#include "tests/support/stage.h"

namespace typodont::test {
namespace {

using display::Hud;
using display::Writing;

const std::string kHint = "left button: drill   wheel: in and out   Z, Y: undo, redo   V: view   space or Esc: stop";

Hud hud() {
  return {.visible = true, .tool = "round 1.2 mm", .speed_krpm = 300, .force = 1.2, .hint = kHint};
}

/// How many pixels of a panel are letters.
int letters(const Writing::Panel& panel) {
  int count = 0;
  for (std::size_t i = 0; i < panel.rgba.size(); i += 4) count += panel.rgba[i] > 120;
  return count;
}

TEST(Writing, IsTheSameAtEveryStepOfTheQualityLadder) {
  // Nothing is drawn below the text, so that only the text can differ.
  render::Frame nothing = frame_of(desk(0.03, 0.024, 0.35));
  nothing.background = render::Background::kBlack;
  std::vector<render::Picture> screens;
  for (const render::Quality& quality : render::kQualityLadder) {
    Stage stage({640, 360}, quality);
    stage.hud = hud();
    stage.draw(nothing, display::Layout::kSideBySide);
    EXPECT_EQ(stage.device.validation_messages(), 0) << quality.name;
    screens.push_back(stage.screen);
  }
  for (std::size_t i = 1; i < screens.size(); ++i)
    EXPECT_EQ(compare(screens[0], screens[i], 0).pixels, 0) << render::kQualityLadder[i].name;
}

TEST(Writing, IsRedrawnOnlyWhenItChanges) {
  Writing writing;
  Hud says = hud();
  EXPECT_TRUE(writing.differs(says, {640, 360}));
  EXPECT_FALSE(writing.write(says, {640, 360}).empty());
  says.force += 0.001;     // "1.20 N" still, and no pixel of the bar
  says.speed_krpm += 0.2;  // "300 krpm" still
  EXPECT_FALSE(writing.differs(says, {640, 360}));
  EXPECT_TRUE(writing.write(says, {640, 360}).empty());
  says.speed_krpm += 0.4;
  EXPECT_TRUE(writing.differs(says, {640, 360}));
  EXPECT_TRUE(writing.differs(hud(), {320, 360})) << "on a picture of another size";
}

TEST(Writing, AForceThatIsNotShownChangesNoPixel) {
  Writing shown, hidden;
  Hud says = hud();
  shown.write(says, {640, 360});
  says.force_shown = false;
  hidden.write(says, {640, 360});
  EXPECT_LT(letters(hidden.panels().front()), letters(shown.panels().front()));
  for (const double force : {0.0, 0.7, 5.0}) {
    says.force = force;
    EXPECT_FALSE(hidden.differs(says, {640, 360})) << force << " N";
  }
}

TEST(Writing, FitsSmallPicturesWithLettersThatCanBeRead) {
  for (const glm::ivec2 place : {glm::ivec2(640, 360), {320, 256}, {192, 216}, {160, 120}}) {
    Writing writing;
    writing.write(hud(), place);
    for (const Writing::Panel& panel : writing.panels()) {
      EXPECT_GE(panel.box.lo.x, 0);
      EXPECT_LE(panel.box.lo.x + panel.box.size.x, place.x);
      EXPECT_GE(panel.box.lo.y, 0);
      EXPECT_LE(panel.box.lo.y + panel.box.size.y, place.y);
    }
    // The text has two lines. The first one may be narrowed to fit the picture. In a picture that is wide enough it is
    // 13 pixels high.
    if (place.x >= 320) {
      EXPECT_GE(writing.panels()[0].box.size.y, 2 * 13) << place.x;
    }
  }
}

TEST(Writing, SmallLettersSubtendTwentyMinutesOfArcOnEveryMirror) {
  const display::DisplayRig shipped = display::load_rig("assets/rigs/mirror.json");
  for (const double distance : {0.7, 1.0, 1.6, 2.5}) {  // of the eyes, over the shipped rig's distance
    display::DisplayRig rig = shipped;
    rig.head.eye_center *= distance;
    // The expected angle is computed from the geometry alone: from the seen screen, and from the number of pixels
    // between the baseline and the top of the letter x.
    const display::Screen seen = display::reflect(*rig.mirror, rig.screen);
    const glm::dvec3 middle = 0.5 * (seen.upper_left + seen.lower_right), sight = middle - rig.head.eye_center;
    const glm::dvec3 pixel = (seen.upper_left - seen.lower_left) / static_cast<double>(rig.screen.pixels.y);
    const double across = glm::length(glm::cross(pixel, sight)) / glm::dot(sight, sight);  // rad per pixel
    Writing writing;
    Hud says = hud();
    says.hint.clear();
    says.tool = "xxxx";
    says.force_shown = false;
    says.aspect = 16.0 / 9;
    says.min_letters = display::readable_letters(rig);
    writing.write(says, rig.screen.pixels);
    // The tool's name is in the left half of the panel. Counts the rows in which a letter of it has ink.
    const Writing::Panel& panel = writing.panels()[0];
    int rows = 0;
    for (int y = 0; y < panel.box.size.y; ++y) {
      bool ink = false;
      for (int x = 0; x < panel.box.size.x / 3; ++x)
        ink = ink || panel.rgba[4 * static_cast<std::size_t>(y * panel.box.size.x + x)] > 120;
      rows += ink;
    }
    EXPECT_GE((rows + 1) * across, display::kMinXHeight) << distance;  // + 1: pixels at the edges are half covered
  }
}

// The bar's colour goes with its length, and its meaning stays visible for colour-blind people.
TEST(Writing, TheForceBarKeepsItsThreeColorsApartForEveryKindOfColorBlindness) {
  const auto bar = [](double fraction) {
    Writing writing;
    Hud says = hud();
    says.force = fraction * says.force_limit;
    writing.write(says, {1280, 720});
    glm::dvec3 most(0);  // the only coloured pixels of the panel are the bar's
    double chroma = 0;
    const Writing::Panel& panel = writing.panels()[0];
    for (std::size_t i = 0; i < panel.rgba.size(); i += 4) {
      const glm::dvec3 c(panel.rgba[i], panel.rgba[i + 1], panel.rgba[i + 2]);
      const double own = std::max({c.r, c.g, c.b}) - std::min({c.r, c.g, c.b});
      if (own > chroma) chroma = own, most = c;
    }
    return most;
  };
  const glm::dvec3 low = bar(0.02), middle = bar(0.6), high = bar(1);
  constexpr glm::dvec3 kTrack(60, 66, 74);
  for (const Vision vision : kVisions) {
    EXPECT_GT(difference(vision, low, middle), 12);
    EXPECT_GT(difference(vision, middle, high), 12);
    EXPECT_GT(difference(vision, low, high), 12);
    for (const glm::dvec3& color : {low, middle, high}) EXPECT_GT(difference(vision, color, kTrack), 25);
  }
}

TEST(Writing, InAMirrorIsItsOwnReflection) {
  constexpr glm::ivec2 kPlace{640, 360};
  const auto drawn = [&](const glm::dmat2& upright) {
    Writing writing;
    Hud says = hud();
    says.upright = upright;
    writing.write(says, kPlace);
    render::Picture picture{kPlace, std::vector<std::uint8_t>(4 * 640 * 360, 90)};
    for (const Writing::Panel& panel : writing.panels())
      Writing::lay_over(panel, picture.rgba.data(), 4 * 640, {0, 0}, false);
    return picture;
  };
  const render::Picture plain = drawn(glm::dmat2(1));
  for (const glm::dvec2 sign : {glm::dvec2(-1, 1), glm::dvec2(1, -1)}) {
    const render::Picture turned = drawn(glm::dmat2(sign.x, 0, 0, sign.y));
    render::Picture back = plain;
    for (int y = 0; y < kPlace.y; ++y)
      for (int x = 0; x < kPlace.x; ++x) {
        const std::uint8_t* from = turned.at(sign.x < 0 ? kPlace.x - 1 - x : x, sign.y < 0 ? kPlace.y - 1 - y : y);
        std::copy(from, from + 4, back.rgba.data() + 4 * (y * kPlace.x + x));
      }
    EXPECT_EQ(compare(plain, back, 2).pixels, 0);
    EXPECT_GT(compare(plain, turned, 8).pixels, 100);
  }
}

}  // namespace
}  // namespace typodont::test
