// Tests the picture against the geometry: a point is where the rays of the eyes meet, and a mirrored picture is the
// exact mirror image.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/stage.h"
#include "tests/support/tooth_mesh.h"

namespace typodont::test {
namespace {

using glm::dvec2;

/// Returns the centroid of the pixels that are brighter than the black background, in clip coordinates.
dvec2 centroid(const render::Picture& p) {
  dvec2 sum(0);
  double weight = 0;
  for (int y = 0; y < p.size.y; ++y)
    for (int x = 0; x < p.size.x; ++x)
      // The weight is the coverage and not the brightness, because shading must not move the centroid. Pixels at edges
      // count by their fraction of light.
      if (const double w = std::min(1.0, std::pow(p.at(x, y)[1] / 255.0, 2.2) / 0.4); w > 0) {
        sum += w * dvec2(x + 0.5, y + 0.5);
        weight += w;
      }
  return weight > 0 ? 2.0 * sum / weight / dvec2(p.size) - 1.0 : dvec2(1e3);
}

TEST(Stereo, APointIsTriangulatedFromBothPicturesToItsPosition) {
  Stage stage({1280, 1024});
  const display::DisplayRig rig = desk(0.08, 0.064, 0.4);
  render::Frame frame = frame_of(rig);
  frame.background = render::Background::kBlack;
  frame.lights.ambient = 12;  // bright all round
  const auto eyes = display::eye_views(rig);
  std::mt19937_64 g(3);
  const auto u = [&](double r) { return std::uniform_real_distribution<double>(-r, r)(g); };
  for (int i = 0; i < 6; ++i) {
    const dvec3 p(u(0.015), u(0.015), u(0.015));
    const std::vector<render::MeshUpdate> bricks{ball(1, glm::vec3(p), 1.0e-3f, Tissue::kEnamel)};
    stage.renderer->update(0, bricks);
    ASSERT_TRUE(stage.draw(frame).drawn);
    // Rays through the centroids of the two pictures, and the points where the rays are nearest to each other.
    dvec3 origin[2], way[2];
    for (std::size_t e = 0; e < 2; ++e) {
      const dvec2 c = centroid(stage.eye(static_cast<int>(e)));
      const glm::dvec4 far = glm::inverse(eyes[e].projection * eyes[e].view) * glm::dvec4(c, 1, 1);
      origin[e] = eyes[e].position;
      way[e] = glm::normalize(dvec3(far) / far.w - origin[e]);
    }
    const dvec3 between = origin[1] - origin[0];
    const double b = glm::dot(way[0], way[1]), d = glm::dot(way[0], between), e = glm::dot(way[1], between);
    const double s = (d - b * e) / (1 - b * b), t = (b * d - e) / (1 - b * b);
    const dvec3 found = 0.5 * (origin[0] + s * way[0] + origin[1] + t * way[1]);
    EXPECT_LT(glm::length(found - p), 0.05e-3) << "by " << 1e3 * glm::length(found - p) << " mm";
  }
  EXPECT_EQ(stage.device.validation_messages(), 0);
}

TEST(Stereo, EveryLevelKeepsDisparityWithinATenthOfAPixel) {
  for (const render::Quality& quality : render::kQualityLadder) {
    Stage stage({1280, 1024}, quality, Passes::kBest, false);
    const display::DisplayRig rig = desk(0.08, 0.064, 0.4);
    render::Frame frame = frame_of(rig);
    frame.background = render::Background::kBlack;
    frame.lights.ambient = 3;  // bright all round
    const auto eyes = display::eye_views(rig);
    std::mt19937_64 g(7);
    const auto u = [&](double r) { return std::uniform_real_distribution<double>(-r, r)(g); };
    // With one sample per pixel, the centroid of a single ball has an error of a fifth of a pixel. A systematic shift
    // would remain in the mean.
    constexpr int kBalls = 12;
    double error = 0;  // pixels
    for (int i = 0; i < kBalls; ++i) {
      const dvec3 p(u(0.01), u(0.01), u(0.01));
      const std::vector<render::MeshUpdate> bricks{ball(1, glm::vec3(p), 2.0e-3f, Tissue::kEnamel)};
      stage.renderer->update(0, bricks);
      ASSERT_TRUE(stage.draw(frame).drawn);
      for (std::size_t e = 0; e < 2; ++e) {
        const render::Picture picture = stage.eye(static_cast<int>(e));
        const glm::dvec4 c = eyes[e].projection * eyes[e].view * glm::dvec4(p, 1);
        error += (e ? -1 : 1) * (centroid(picture).x - c.x / c.w) * picture.size.x / 2 / kBalls;
      }
    }
    EXPECT_NEAR(error, 0, 0.1) << quality.name;
  }
}

TEST(Mirror, TheTwoFormulationsGiveTheSamePicture) {
  // Compares the real eye and reflected screen with the mirrored eye, the physical screen, and a world of which every
  // corner is mirrored.
  display::DisplayRig rig = desk(0.05, 0.04, 0.4, {0.1, 0.5, 0.8});
  const display::Mirror mirror{glm::normalize(dvec3(0.1, 0.9, 0.3)), -0.03};
  display::DisplayRig behind = rig;  // its panel is at the position of the mirror image of the desk's panel
  behind.screen = display::reflect(mirror, rig.screen);
  // its own picture is upright, because it is seen from the front
  std::swap(behind.screen.lower_left, behind.screen.lower_right);
  behind.screen.upper_left =
      display::reflect(mirror, rig.screen.lower_right + (rig.screen.upper_left - rig.screen.lower_left));
  behind.mirror = mirror;

  const auto tooth = tooth_mesh(0, 0.35e-3);  // without caries, because the pattern of caries is fixed in space
  // Drawn without the shadow map, because its samples lie in the lamp's frame and are not mirrored with the world. Also
  // drawn without the fine structure of enamel, because it is computed per pixel.
  render::Quality quality = render::kQualityLadder[0];
  quality.shadow_map = 0;
  quality.light_per_vertex = true;
  Stage stage({480, 384}, quality);
  render::Frame frame = frame_of(behind);
  frame.lights.key = glm::normalize(dvec3(-0.3, 0.4, 0.9));
  frame.lights.window = glm::normalize(dvec3(0.8, 0.2, 0.4));
  ASSERT_TRUE(frame.eyes[0].flip);
  stage.renderer->update(0, tooth);
  stage.draw(frame);
  const render::Picture seen[2] = {stage.eye(0), stage.eye(1)};

  auto mirrored = tooth;
  const auto turn = [&](const dvec3& v) { return v - 2 * glm::dot(mirror.normal, v) * mirror.normal; };
  for (auto& brick : mirrored) {
    for (auto& v : brick.vertices) {
      v.p = glm::vec3(display::reflect(mirror, dvec3(v.p)));
      v.n = glm::vec3(turn(dvec3(v.n)));
    }
    for (std::size_t i = 0; i + 2 < brick.indices.size(); i += 3) std::swap(brick.indices[i], brick.indices[i + 1]);
  }
  render::Frame direct = frame;
  for (std::size_t e = 0; e < 2; ++e) {
    const dvec3 eye = display::reflect(mirror, frame.eyes[e].position);
    const auto view = display::eye_view(behind.screen, {}, eye, display::clip_range(behind));
    direct.eyes[e] = {view.view, view.projection, view.position, view.flip};
  }
  ASSERT_FALSE(direct.eyes[0].flip);
  direct.lights.key = turn(frame.lights.key);
  direct.lights.up = turn(frame.lights.up);
  direct.lights.window = turn(frame.lights.window);
  stage.renderer->update(0, mirrored);
  stage.draw(direct);
  for (int e = 0; e < 2; ++e) {
    // Single precision rounds differently in the two computations. So an edge may cross a few samples.
    const Difference d = compare(seen[e], stage.eye(e), 4);
    EXPECT_LE(d.pixels, 2) << "worst " << d.worst;
  }
}

}  // namespace
}  // namespace typodont::test
