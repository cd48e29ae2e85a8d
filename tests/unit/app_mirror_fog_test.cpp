// Tests the fog on the mouth mirror: what causes it, and what removes it.
#include <gtest/gtest.h>

#include <cmath>

#include "engine/app/assets.h"
#include "engine/app/picture/mirror_fog.h"
#include "engine/app/scene.h"

namespace typodont {
namespace {

constexpr double kFrame = 1.0 / 60;  // s

MouthMirror glass() {
  MouthMirror mirror;  // faces +z
  mirror.diameter = kDefaultMirrorDiameter;
  return mirror;
}

/// Fog after so many seconds in this air.
double after(MirrorFog& fog, double seconds, const MirrorAir& air, double step = kFrame) {
  const auto steps = static_cast<int>(std::lround(seconds / step));
  for (int i = 0; i < steps; ++i) fog.advance(step, glass(), air);
  return fog.fog();
}

TEST(MirrorFog, BreathFogsAColdGlassAndClearsWhenTheGlassIsWarm) {
  MirrorFog fog;
  const MirrorAir breath{.in_mouth = true};
  EXPECT_GT(after(fog, 10, breath), 0.5);
  EXPECT_LT(after(fog, 150, breath), 0.05);
}

TEST(MirrorFog, AirDriesTheGlass) {
  MirrorFog fog(1);
  EXPECT_NEAR(after(fog, 20, {}), std::exp(-1), 0.02);
  EXPECT_EQ(after(fog, 200, {}), 0);
}

TEST(MirrorFog, TheSprayFogsANearGlassMoreThanAFarOne) {
  const auto sprayed = [](double away) {
    MirrorFog fog;
    return after(fog, 3, {.water = 1, .p_WT = {away, 0, -3e-3}});  // behind the glass, so that nothing rinses it
  };
  EXPECT_GT(sprayed(5e-3), 0.5);
  EXPECT_GT(sprayed(5e-3), 2 * sprayed(40e-3));
  EXPECT_GT(sprayed(40e-3), 0);
}

TEST(MirrorFog, AJetOntoTheGlassRinsesIt) {
  MirrorFog fog(1);
  const MirrorAir jet{.in_mouth = true, .water = 1, .p_WT = {2e-3, 0, 4e-3}};
  EXPECT_LT(after(fog, 1, jet), 0.2);
  MirrorFog beside(1);
  EXPECT_GT(after(beside, 1, {.in_mouth = true, .water = 1, .p_WT = {15e-3, 0, 4e-3}}), 0.8);
}

TEST(MirrorFog, DoesNotDependOnTheFrameRate) {
  const MirrorAir air{.in_mouth = true, .water = 0.5, .p_WT = {12e-3, 3e-3, 5e-3}};
  MirrorFog fast, slow;
  for (int i = 0; i < 20; ++i) EXPECT_NEAR(after(fast, 1, air, 1.0 / 120), after(slow, 1, air, 1.0 / 10), 1.0 / 64);
}

TEST(MirrorFog, AMirrorOutOfTheHandDriesAndGetsColdAgain) {
  MirrorFog fog;
  after(fog, 150, {.in_mouth = true});
  for (int i = 0; i < 6000; ++i) fog.advance(kFrame, {}, {.in_mouth = true, .water = 1});
  EXPECT_EQ(fog.fog(), 0);
  EXPECT_GT(after(fog, 10, {.in_mouth = true}), 0.4);
}

TEST(MirrorFog, OnlyAPatientsMouthAndASprayChangeTheFog) {
  const auto scene = [](const char* name) { return read_scene(assets_folder() / "scenes" / name); };
  EXPECT_FALSE(mirror_fog_of(scene("tooth-section.json")));
  ServoTick tick;
  tick.pedal = 1;
  tick.spindle = 30'000;
  const Scene molar = scene("molar-caries.json");
  const std::optional<MirrorFog> fog = mirror_fog_of(molar);
  ASSERT_TRUE(fog);
  MouthMirror mirror = glass();
  mirror.X_WM.p = molar.surroundings->margin;
  EXPECT_TRUE(fog->air(mirror, tick, true).in_mouth);
  EXPECT_EQ(fog->air(mirror, tick, true).water, 1);
  EXPECT_EQ(fog->air(mirror, tick, false).water, 0);
  mirror.X_WM.p.z += 0.2;
  EXPECT_FALSE(fog->air(mirror, tick, true).in_mouth);
}

}  // namespace
}  // namespace typodont
