// What a live session's picture goes by: the ladder of quality, and views for teaching that follow the cut.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "engine/app/picture/followed_views.h"
#include "engine/app/picture/quality_ladder.h"
#include "engine/app/picture/teaching_views.h"
#include "engine/base/json.h"
#include "engine/base/units.h"
#include "haptics/solid.h"

namespace typodont {
namespace {

using namespace std::chrono_literals;

int frames_until_change(QualityLadder& ladder, double seconds, int most) {
  for (int i = 1; i <= most; ++i)
    if (ladder.frame_took(seconds)) return i;
  return -1;
}

TEST(QualityLadder, StepsDownWhileFramesAreSlowAndStopsAtTheLastStep) {
  QualityLadder ladder;
  const auto last = static_cast<int>(render::kQualityLadder.size()) - 1;
  while (ladder.place() < last) EXPECT_GT(frames_until_change(ladder, 0.08, 40), 0);
  EXPECT_EQ(frames_until_change(ladder, 0.08, 400), -1);
  EXPECT_EQ(ladder.step().name, render::kQualityLadder.back().name);
}

TEST(QualityLadder, StaysWhereFramesAreInTime) {
  QualityLadder ladder;
  EXPECT_EQ(frames_until_change(ladder, 0.025, 2000), -1);
}

TEST(QualityLadder, OneSlowFrameChangesNothing) {
  QualityLadder ladder;
  EXPECT_EQ(frames_until_change(ladder, 0.02, 50), -1);
  EXPECT_FALSE(ladder.frame_took(3.0));
  EXPECT_EQ(frames_until_change(ladder, 0.02, 50), -1);
}

TEST(QualityLadder, ComesBackLaterEachTimeTheStepAboveProvesTooSlow) {
  QualityLadder ladder;
  ASSERT_GT(frames_until_change(ladder, 0.08, 40), 0);  // down
  int waited = 0;
  for (int round = 0; round < 4; ++round) {
    const int up = frames_until_change(ladder, 0.005, 20'000);
    ASSERT_GT(up, waited) << "round " << round;
    waited = up;
    ASSERT_GT(frames_until_change(ladder, 0.08, 40), 0);  // and down again
  }
}

haptics::TissueVolume ball(double radius_mm) {
  return haptics::TissueVolume(haptics::read_solids(Json::parse(
      fmt::format(R"({{"voxel_mm": 0.1, "band_mm": 1, "solids": [
        {{"tissue": "dentin", "solid": {{"sphere": {{"center_mm": [0, 0, 0], "radius_mm": {}}}}}}}]}})",
                  radius_mm),
      "solids")));
}

/// mm²
double area(const std::vector<render::MeshUpdate>& bricks) {
  double sum = 0;
  for (const auto& b : bricks)
    for (std::size_t i = 0; i + 2 < b.indices.size(); i += 3) {
      const glm::dvec3 p = b.vertices[b.indices[i]].p, q = b.vertices[b.indices[i + 1]].p, r = b.vertices[b.indices[i + 2]].p;
      sum += 0.5e6 * glm::length(glm::cross(q - p, r - p));
    }
  return sum;
}

/// As the carver's and the drawing thread do, until there is a result or two seconds have passed.
bool follow(FollowedViews& views, const haptics::TissueVolume& tissue, std::uint64_t state, FollowedViews::Bodies& bodies) {
  for (int i = 0; i < 400; ++i) {
    views.offer(tissue, state);
    if (views.take(bodies)) return true;
    std::this_thread::sleep_for(5ms);
  }
  return false;
}

TEST(FollowedViews, ASectionsFaceFollowsTheCut) {
  FollowedViews views;
  FollowedViews::Bodies bodies;
  const haptics::TissueVolume before = ball(3), after = ball(2);
  views.want(render::View::kSection, {0, 1, 0, 0});
  ASSERT_TRUE(follow(views, before, 1, bodies));
  ASSERT_EQ(bodies.size(), 1u);
  EXPECT_EQ(bodies[0].first, render::kSectionFace);
  EXPECT_NEAR(area(bodies[0].second), kPi * 9, 0.3);
  ASSERT_TRUE(follow(views, after, 2, bodies));
  EXPECT_NEAR(area(bodies[0].second), kPi * 4, 0.3);
  views.want(render::View::kXray, {0, 0, 0, 1});
  ASSERT_TRUE(follow(views, after, 2, bodies));
  EXPECT_EQ(bodies.size(), 3u);
}

TEST(FollowedViews, NothingWantedNothingDoneAndTheSameTissueIsNotLookedAtTwice) {
  FollowedViews views;
  FollowedViews::Bodies bodies;
  const haptics::TissueVolume tissue = ball(2);
  const auto never = [&](std::uint64_t state) {
    for (int i = 0; i < 60; ++i) {
      views.offer(tissue, state);
      if (views.take(bodies)) return false;
      std::this_thread::sleep_for(5ms);
    }
    return true;
  };
  EXPECT_TRUE(never(1));
  views.want(render::View::kDifference, {0, 0, 0, 1});
  EXPECT_TRUE(never(2));
  views.want(render::View::kSection, {0, 1, 0, 0});
  ASSERT_TRUE(follow(views, tissue, 3, bodies));
  EXPECT_TRUE(never(3));
}

}  // namespace
}  // namespace typodont
