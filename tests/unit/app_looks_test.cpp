// Tests what pictures contain besides the tooth's own surface: its surroundings, and the content of the views for
// teaching.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "engine/app/assets.h"
#include "engine/app/picture/debris_view.h"
#include "engine/app/picture/detail.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/teaching_views.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/tissue/tooth_field.h"
#include "engine/base/error.h"
#include "engine/base/keys.h"
#include "engine/base/units.h"
#include "haptics/solid.h"

namespace typodont {
namespace {

haptics::TissueVolume solids(const char* list, double voxel_mm = 0.1) {
  return haptics::TissueVolume(haptics::read_solids(
      Json::parse(fmt::format(R"({{"voxel_mm": {}, "band_mm": 1.5, "solids": [{}]}})", voxel_mm, list), "solids")));
}
constexpr const char* kCrownWithPulp = R"(
  {"tissue": "enamel", "solid": {"sphere": {"center_mm": [0.3, 0.2, 0.1], "radius_mm": 4}}},
  {"tissue": "dentin", "solid": {"sphere": {"center_mm": [0.3, 0.2, 0.1], "radius_mm": 2.5}}},
  {"tissue": "pulp", "solid": {"sphere": {"center_mm": [0.3, 0.2, 0.1], "radius_mm": 1}}})";
const dvec3 kMiddle = dvec3(0.3, 0.2, 0.1) * kMillimetre;

struct Corner {
  dvec3 p, n;  // m, W
};
std::vector<Corner> corners(const SurroundingMesh& mesh) {
  std::vector<Corner> out;
  for (const auto& brick : mesh.bricks)
    for (const auto& v : brick.vertices) out.push_back({mesh.origin + dvec3(v.p), dvec3(v.n)});
  return out;
}

/// Returns the scene with mirrored copies of its tooth as neighbours.
Scene scene_with_copies() {
  Scene scene = read_scene(assets_folder() / "scenes/molar-caries.json");
  read_keys(Json::parse(R"({"neighbours": [
                        {"contact_mm": [1.1, 5.36, 16.4], "normal": [0.99863, 0.05234, 0], "scale": [0.72, 0.88, 0.94]},
                        {"contact_mm": [12.66, 5.37, 15.6], "normal": [0.99905, 0.04362, 0], "scale": [0.95, 0.94, 0.95]}],
                      "gum": {"margin_mm": [6.9, 5.5, 14.5], "normal": [0, -0.12, 0.993], "papilla_mm": 1.2,
                              "thickness_mm": 1.1}})",
                        "scene.json"),
            [&](Keys& keys) { describe_surroundings(keys, scene.surroundings.emplace(), volume_file(scene), {}); });
  return scene;
}

struct Around : testing::Test {
  Scene scene = scene_with_copies();
  typodont::Surroundings around = make_surroundings(scene.surroundings);
  std::vector<SurroundingMesh>& meshes = around.meshes;
  ToothField tooth{haptics::TissueVolume::load(volume_file(scene)), 3e-3};
};

TEST_F(Around, NeighboursTouchTheToothAndDoNotPierceIt) {
  for (std::size_t m = 0; m < 2; ++m) {
    double nearest = 1;
    for (const Corner& c : corners(meshes[m])) nearest = std::min(nearest, tooth.distance(c.p));
    EXPECT_LT(nearest, 0.3e-3) << m;
    EXPECT_GT(nearest, -0.3e-3) << m;
  }
}

TEST_F(Around, TheGumTouchesTheToothAndStaysBelowTheCrown) {
  double on_tooth = 0, all = 0;
  for (const Corner& c : corners(meshes[2])) {
    EXPECT_GT(tooth.distance(c.p), -0.55e-3);  // it ends just beneath the tooth's surface
    EXPECT_LT(c.p.z, 17.4e-3);                 // between the teeth it climbs to their contact, no higher
    ++all;
    on_tooth += std::abs(tooth.distance(c.p)) < 0.5e-3;
  }
  EXPECT_GT(on_tooth / all, 0.05);
}

TEST_F(Around, BricksMarkedAsCoveredAreInsideTheGum) {
  // A straight line from a corner of a covered brick outwards must leave the gum. Then the corner is inside the gum.
  struct Triangle {
    dvec3 a, ab, ac;
  };
  std::vector<Triangle> gum;
  for (const auto& brick : meshes[2].bricks)
    for (std::size_t i = 0; i < brick.indices.size(); i += 3) {
      const auto at = [&](std::size_t k) { return meshes[2].origin + dvec3(brick.vertices[brick.indices[i + k]].p); };
      gum.push_back({at(0), at(1) - at(0), at(2) - at(0)});
    }
  haptics::TissueVolume volume = load_tissue(scene);
  TissueView view(0.6f);
  int below = 0, open = 0;
  std::string places;
  for (const auto& brick : view.update(volume))
    for (std::size_t i = 0; i < brick.vertices.size(); i += 11) {
      const dvec3 p = volume.frame().origin + dvec3(brick.vertices[i].p), n(brick.vertices[i].n);
      if (glm::dot(around.covered, glm::dvec4(p, 1)) >= 0) continue;
      ++below;
      bool leaves = false;
      for (const Triangle& t : gum) {  // Möller & Trumbore 1997
        const dvec3 h = glm::cross(n, t.ac);
        const double det = glm::dot(t.ab, h);
        if (std::abs(det) < 1e-18) continue;
        const dvec3 s = p - t.a, q = glm::cross(s, t.ab);
        const double u = glm::dot(s, h) / det, v = glm::dot(n, q) / det, way = glm::dot(t.ac, q) / det;
        if (u < 0 || v < 0 || u + v > 1 || way < 0) continue;
        leaves = leaves || glm::dot(glm::cross(t.ab, t.ac), n) > 0;
      }
      open += !leaves;
      if (!leaves) places += fmt::format(" ({:.2f} {:.2f} {:.2f})", p.x * 1e3, p.y * 1e3, p.z * 1e3);
    }
  EXPECT_GT(below, 200);
  EXPECT_EQ(open, 0) << places;
}

TEST(Detail, FollowsThePixelSizeAndIgnoresSmallHeadMotion) {
  const render::Quality& quality = render::kQualityLadder[0];
  Detail detail(surface_tolerance(60e-6, 100e-6, quality), 100e-6);
  const float first = detail.tolerance();
  EXPECT_NEAR(first, 0.24f, 1e-4f);
  for (const double pixel : {66e-6, 54e-6, 60e-6, 0.0}) EXPECT_FALSE(detail.follow(pixel, quality)) << pixel;
  EXPECT_TRUE(detail.follow(33e-6, quality));  // nearer
  EXPECT_NEAR(detail.tolerance(), 0.132f, 1e-4f);
  EXPECT_TRUE(detail.follow(33e-6, render::kQualityLadder.back()));  // a lower step forgives more
  EXPECT_GT(detail.tolerance(), 0.3f);
}

TEST(TissueViewTest, AChangedToleranceIsAppliedGraduallyAndGivesTheSameMeshAsAFreshStart) {
  haptics::TissueVolume volume = solids(kCrownWithPulp), same = solids(kCrownWithPulp);
  struct Picture {
    std::map<std::uint64_t, render::MeshUpdate> bricks;
    std::size_t triangles() const {
      std::size_t indices = 0;
      for (const auto& [number, brick] : bricks) indices += brick.indices.size();
      return indices / 3;
    }
    void add(std::vector<render::MeshUpdate> updates) {
      for (render::MeshUpdate& update : updates) {
        if (update.indices.empty())
          bricks.erase(update.brick);
        else
          bricks[update.brick] = std::move(update);
      }
    }
  };
  TissueView view(0.1f);
  Picture picture;
  picture.add(view.update(volume));
  const std::size_t all = picture.bricks.size(), fine = picture.triangles();
  view.set_tolerance(0.5f);
  std::size_t count = 0;
  for (auto updates = view.update(volume); !updates.empty(); updates = view.update(volume)) {
    ASSERT_LT(++count, 1000u);
    picture.add(std::move(updates));
  }
  EXPECT_GT(count, all / 100);
  EXPECT_LT(picture.triangles(), fine);
  TissueView fresh(0.5f);
  Picture wanted;
  wanted.add(fresh.update(same));
  ASSERT_EQ(picture.bricks.size(), wanted.bricks.size());
  for (const auto& [number, brick] : wanted.bricks) {
    const render::MeshUpdate& found = picture.bricks[number];
    EXPECT_EQ(found.indices, brick.indices);
    ASSERT_EQ(found.vertices.size(), brick.vertices.size());
    for (std::size_t i = 0; i < brick.vertices.size(); ++i) {
      EXPECT_EQ(found.vertices[i].p, brick.vertices[i].p);
      EXPECT_EQ(found.vertices[i].n, brick.vertices[i].n);
    }
  }
}

TEST_F(Around, TheCoarseMeshesHaveTheSameShapeWithFewerTriangles) {
  const auto triangles = [](const std::vector<render::MeshUpdate>& bricks) {
    std::size_t n = 0;
    for (const auto& b : bricks) n += b.indices.size() / 3;
    return n;
  };
  for (const SurroundingMesh& mesh : meshes) {
    EXPECT_LT(triangles(mesh.coarse), 0.8 * static_cast<double>(triangles(mesh.bricks)));
    glm::vec3 lo(1e9f), hi(-1e9f), coarse_lo(1e9f), coarse_hi(-1e9f);
    for (const auto& b : mesh.bricks)
      for (const auto& v : b.vertices) lo = glm::min(lo, v.p), hi = glm::max(hi, v.p);
    for (const auto& b : mesh.coarse)
      for (const auto& v : b.vertices) coarse_lo = glm::min(coarse_lo, v.p), coarse_hi = glm::max(coarse_hi, v.p);
    EXPECT_LT(glm::length(lo - coarse_lo), 0.2e-3f);
    EXPECT_LT(glm::length(hi - coarse_hi), 0.2e-3f);
  }
}

TEST_F(Around, TheCoarseMeshesAreShadedSmoothly) {
  // Compares the normals of corners at the same position. If each triangle had its own normal, the neighbour tooth
  // would look broken into pieces.
  for (const SurroundingMesh& mesh : {std::cref(meshes[0]), std::cref(meshes[1])}) {
    std::map<std::array<int, 3>, std::vector<glm::vec3>> places;
    for (const auto& b : mesh.coarse)
      for (const auto& v : b.vertices) {
        const glm::ivec3 key(glm::round(v.p / 2e-6f));
        places[{key.x, key.y, key.z}].push_back(v.n);
      }
    std::size_t several = 0, apart = 0;
    for (const auto& [place, normals] : places) {
      several += normals.size() > 1;
      apart += std::any_of(normals.begin(), normals.end(),
                           [&](const glm::vec3& n) { return glm::dot(n, normals[0]) < std::cos(15 * kDegree); });
    }
    EXPECT_GT(several, 20u);
    EXPECT_LE(apart, places.size() / 100) << "of " << places.size() << ", " << several << " with several corners";
  }
}

Scene wet_scene(const std::string& key, const char* parts = R"("haptics", "render", "debris")",
                const char* motor = R"("spindle": "air_turbine")") {
  return parse_scene(Json::parse(fmt::format(R"({{"tissue": {{"voxel_mm": 0.5, "solids": [
          {{"tissue": "enamel", "solid": {{"sphere": {{"radius_mm": 9}}}}}}]}}, "tool": "round_012", {}, "parts": [{}], {}}})",
                                             motor, parts, key),
                                 "scene.json"),
                     "scene.json");
}

TEST(SuctionInAScene, HasTheOpeningAndTheFlowOfItsTipOrItsOwnAndNeedsAPlaceAndDebris) {
  const Scene plain = wet_scene(R"("suction": {"position_mm": [1, 2, 3], "flow_l_per_min": 60, "radius_mm": 5})");
  ASSERT_TRUE(plain.suction && plain.suction_on);
  EXPECT_LT(glm::length(plain.suction->p_W - dvec3(1e-3, 2e-3, 3e-3)), 1e-12);
  EXPECT_NEAR(plain.suction->flow, 1e-3, 1e-12);
  EXPECT_NEAR(plain.suction->radius, 5e-3, 1e-12);
  EXPECT_FALSE(wet_scene(R"("suction": {"on": false})").suction);
  const Scene held = wet_scene(R"("suction": {"position_mm": [1, 2, 3], "tip": "surgical", "axis": [0, 2, 0]})");
  EXPECT_NEAR(held.suction_tip.opening, 4e-3, 1e-12);
  EXPECT_NEAR(held.suction->radius, 2e-3, 1e-12) << "the opening's";
  EXPECT_NEAR(held.suction->flow, 120e-3 / 60, 1e-9);
  EXPECT_LT(glm::length(held.suction_tip.X_WS.R * dvec3(0, 0, 1) - dvec3(0, 1, 0)), 1e-9);
  EXPECT_TRUE(hand_holds_suction(held));
  for (const char* wrong :
       {R"({"flow_l_per_min": 60})", R"({"tip": "surgical"})", R"({"position_mm": [1, 2, 3], "axis": [0, 0, 1]})",
        R"({"position_mm": [1, 2, 3], "tip": "surgical", "axis": [0, 0, 0]})"})
    EXPECT_THROW(wet_scene(std::string(R"("suction": )") + wrong), Error) << wrong;
  EXPECT_THROW(wet_scene(R"("suction": {"position_mm": [0, 0, 0]})", R"("haptics")"), Error);
}

TEST(SprayInAScene, TakesTheMotorsNozzlesAndNeedsThemAndDebris) {
  const Scene plain = wet_scene(R"("spray": {})");
  ASSERT_TRUE(plain.spray && plain.spray_on);
  EXPECT_NEAR(plain.spray->flow, 30e-6 / 60, 1e-15);
  EXPECT_EQ(plain.spray->count, 4);
  const Scene little = wet_scene(R"("spray": {"flow_ml_per_min": 12, "on": false})");
  EXPECT_NEAR(little.spray->flow, 12e-6 / 60, 1e-15);
  EXPECT_FALSE(little.spray_on);
  EXPECT_THROW(wet_scene(R"("spray": {})", R"("haptics", "render")"), Error);
  EXPECT_THROW(wet_scene(R"("spray": {})", R"("debris")", R"("spindle_krpm": 300)"), Error) << "no nozzles";
}

TEST(SprayOfTheView, FillsTheCavityAndCostsNothingWithoutNozzlesOrAtRest) {
  const haptics::TissueVolume volume = solids(kCrownWithPulp);
  const haptics::Tool bur = load_tool("round_012");
  const auto worked = [&](const WaterPlan& water, bool pedal, bool rests = false) {
    DebrisView view(load_materials(), volume, water);
    view.rest(rests);
    ServoTick tick;
    tick.X_WG.p = kMiddle + dvec3(0, 0, 4.8e-3);
    tick.pedal = pedal;
    tick.spindle = pedal ? 3e4 : 0;
    WorkCounts work;
    for (int i = 0; i < 30; ++i) {
      Cut cut;
      cut.X_WA = cut.X_WB = tick.X_WG;
      cut.removed[static_cast<std::size_t>(Tissue::kEnamel)] = 0.01e-9;
      if (pedal) view.add(cut, bur, 1e-6, 1e-3);
      view.hold(tick, bur);
      view.step(1.0 / 30);
    }
    view.count(work);
    return std::pair(work, view.settle());
  };
  WaterPlan water{load_spindle("air_turbine").nozzles, true, glm::dvec4(0)};
  const auto [work, mass] = worked(water, true);
  const auto [rest, unmoved] = worked(water, true, /*rests=*/true);
  EXPECT_EQ(rest.droplets_stepped + rest.film_cells_stepped + rest.film_texels + rest.particles_stepped, 0u);
  EXPECT_EQ(unmoved.spray->sprayed.water, 0);
  EXPECT_GT(work.droplets_stepped, 0u);
  EXPECT_GT(work.film_cells_stepped, 0u);
  EXPECT_GT(work.film_texels, 0u);
  EXPECT_NEAR(mass.spray->sprayed.water, 30e-6 / 60 * 1000, 1e-9);
  EXPECT_GT(mass.film->on_surface.water, 0);
  EXPECT_GT(mass.chips.deposited, 0);
  water.on = false;
  for (const auto& [idle, none] : {worked(water, true), worked({}, true), worked({water.nozzles, true, {}}, false)}) {
    EXPECT_EQ(idle.droplets_stepped, 0u);
    EXPECT_EQ(none.spray ? none.spray->sprayed.water : 0, 0);
  }
  const WorkCounts dry = worked({}, true).first;
  EXPECT_EQ(dry.film_cells_stepped + dry.film_texels, 0u);
}

TEST(SuctionOfTheView, RemovesChipsFromTheAir) {
  const haptics::TissueVolume volume = solids(kCrownWithPulp);
  const MaterialTable materials = load_materials();
  const auto left_after = [&](bool sucked) {
    DebrisView view(materials, volume);
    Cut cut;
    cut.X_WA.p = cut.X_WB.p = kMiddle + dvec3(0, 0, 5e-3);
    constexpr int kCuts = 8;  // whose chips are made together
    cut.removed[static_cast<std::size_t>(Tissue::kEnamel)] = 0.05e-9 / kCuts;
    for (int i = 0; i < kCuts; ++i) view.add(cut, load_tool("round_012"), 1e-6, 1e-3);
    if (sucked) view.suck(debris::Suction{.p_W = kMiddle + dvec3(0, 3e-3, 6e-3)});
    for (int i = 0; i < 30; ++i) view.step(0.01);
    double seen = 0;
    for (const render::Particle& p : view.particles()) seen += p.opacity > 0 && p.radius > 0;
    return std::pair(seen, view.settle().chips.sucked);
  };
  EXPECT_EQ(left_after(false).second, 0);
  EXPECT_GT(left_after(true).second, 0);
}

TEST(MouthMirrorInAScene, IsReadAndMistakesAreNamed) {
  const auto read = [](const char* text) { return read_keys(Json::parse(text, "scene"), describe_mouth_mirror); };
  const MouthMirror mirror =
      read(R"({"translation_mm": [1, 2, 3], "normal": [0, -2, 0], "diameter_mm": 20, "fog": 0.3, "focal_mm": 60})");
  EXPECT_LT(glm::length(mirror.X_WM.p - dvec3(1e-3, 2e-3, 3e-3)), 1e-15);
  EXPECT_LT(glm::length(mirror.X_WM.rotate({0, 0, 1}) - dvec3(0, -1, 0)), 1e-12);
  EXPECT_EQ(held(mirror, {}).diameter, 0.02);
  EXPECT_EQ(held(mirror, {}).fog, 0.3);
  EXPECT_EQ(held(mirror, {}).focal, 0.06);
  EXPECT_DOUBLE_EQ(magnification(mirror), 4.0 / 3);
  EXPECT_EQ(magnification(MouthMirror{}), 1);
  EXPECT_EQ(held({}, {}).diameter, 22e-3) << "a hand has a mirror where the scene has none";
  for (const char* wrong : {R"({"normal": [0, 0, 1]})", R"({"translation_mm": [0, 0, 0], "normal": [0, 0, 0]})",
                            R"({"translation_mm": [0, 0, 0], "focal_mm": 29})",
                            R"({"translation_mm": [0, 0, 0], "rotation_wxyz": [1, 1, 0, 0]})"})
    EXPECT_THROW(read(wrong), Error) << wrong;
}

TEST(MouthMirrorInAScene, AsAToolItsHandleIsTheShank) {
  const dvec3 handle = mirror_in_tool().rotate({std::sqrt(0.5), 0, std::sqrt(0.5)});
  EXPECT_LT(glm::length(handle - dvec3(0, 0, 1)), 1e-12);
}

TEST(SectionFace, OfABallIsADiscWithTheTissuesAsRings) {
  const haptics::TissueVolume volume = solids(kCrownWithPulp);
  const dvec3 n = glm::normalize(dvec3(0.3, 0.9, 0.2)), origin = volume.frame().origin;
  const double away = 0.6e-3, offset = glm::dot(n, kMiddle) + away;
  double area = 0;
  for (const auto& tile : section_face(volume, n, offset)) {
    for (const auto& v : tile.vertices) {
      const dvec3 p = origin + dvec3(v.p);
      EXPECT_NEAR(glm::dot(n, p), offset, 5e-6);
      EXPECT_LT(glm::length(dvec3(v.n) + n), 1e-6);
      const double r = glm::length(p - kMiddle);
      const Tissue drawn = v.tissue[v.second > 0.5f];
      if (std::abs(r - 2.5e-3) > 0.15e-3 && std::abs(r - 1e-3) > 0.15e-3) {
        EXPECT_EQ(drawn, r < 1e-3 ? Tissue::kPulp : r < 2.5e-3 ? Tissue::kDentin : Tissue::kEnamel) << r;
      }
    }
    for (std::size_t i = 0; i < tile.indices.size(); i += 3) {
      const auto at = [&](std::size_t k) { return dvec3(tile.vertices[tile.indices[i + k]].p); };
      const double twice = glm::dot(glm::cross(at(1) - at(0), at(2) - at(0)), -n);
      EXPECT_GT(twice, -1e-15);  // faces the one who looks at it
      area += 0.5 * twice;
    }
  }
  EXPECT_NEAR(area / (kPi * (16e-6 - away * away)), 1, 0.005);
}

TEST(TissueInside, IsTheTissuesOwnSurface) {
  const haptics::TissueVolume volume = solids(kCrownWithPulp);
  std::size_t count = 0;
  for (const auto& brick : tissue_inside(volume, Tissue::kPulp))
    for (const auto& v : brick.vertices) {
      EXPECT_NEAR(glm::length(volume.frame().origin + dvec3(v.p) - kMiddle), 1e-3, 0.09e-3);
      EXPECT_EQ(v.tissue[0], Tissue::kPulp);
      ++count;
    }
  EXPECT_GT(count, 100u);
  EXPECT_TRUE(tissue_inside(volume, Tissue::kAmalgam).empty());
}

TEST(Difference, IsTheSignedDistanceOfTheSurfaceFromTheIdeal) {
  haptics::TissueVolume now = solids(kCrownWithPulp, 0.2);
  const haptics::TissueVolume smaller =
      solids(R"({"tissue": "enamel", "solid": {"sphere": {"center_mm": [0.3, 0.2, 0.1], "radius_mm": 3.2}}})", 0.2);
  const haptics::TissueVolume larger =
      solids(R"({"tissue": "enamel", "solid": {"sphere": {"center_mm": [0.3, 0.2, 0.1], "radius_mm": 4.3}}})", 0.2);
  TissueView view;
  std::vector<render::MeshUpdate> surface = view.update(now);
  const auto all_near = [&](double expected) {
    for (const auto& brick : surface)
      for (const auto& v : brick.vertices) ASSERT_NEAR(v.difference, expected, 0.03e-3);
  };
  mark_difference(ToothField(smaller, kDifferenceReach), now.frame().origin, surface);
  all_near(0.8e-3);
  mark_difference(ToothField(larger, kDifferenceReach), now.frame().origin, surface);
  all_near(-0.3e-3);
  mark_difference(ToothField(now, kDifferenceReach), now.frame().origin, surface);
  all_near(0);
}

TEST(WhatShowsThrough, ThinEnamelShowsItsDentinAndThickEnamelNone) {
  haptics::TissueVolume thin = solids(R"(
    {"tissue": "enamel", "solid": {"sphere": {"center_mm": [0, 0, 0], "radius_mm": 4}}},
    {"tissue": "dentin", "solid": {"sphere": {"center_mm": [0.6, 0, 0], "radius_mm": 3}}})");
  TissueView view;
  double near = 0, far = 0, nears = 0, fars = 0;  // enamel is 0.4 mm thick at +x, 1.6 mm at −x
  for (const auto& brick : view.update(thin))
    for (const auto& v : brick.vertices) {
      const dvec3 p = thin.frame().origin + dvec3(v.p);
      if (p.x > 3.8e-3) near += v.shows, ++nears;
      if (p.x < -3.8e-3) far += v.shows, ++fars;
      EXPECT_TRUE(v.shows == 0 || v.under == Tissue::kDentin);
    }
  ASSERT_GT(nears, 0);
  ASSERT_GT(fars, 0);
  EXPECT_GT(near / nears, 0.4);
  EXPECT_LT(far / fars, 0.05);
}

/// Returns a scene with a ball of dentin of 4 mm radius. With `prepare`, the scene removes a shaft of 2 mm radius from
/// the ball.
Scene ball_scene(const char* prepare) {
  const std::string text = fmt::format(
      R"({{"tissue": {{"voxel_mm": 0.1, "band_mm": 1.5, "solids": [
         {{"tissue": "dentin", "solid": {{"sphere": {{"center_mm": [0, 0, 0], "radius_mm": 4}}}}}}]}},
         "prepare": [{}], "tool": "round_012", "parts": ["render"]}})",
      prepare);
  return parse_scene(Json::parse(text, "scene.json"), "scene.json");
}

TEST(CutSurface, ACavityIsCutAndTheTissueAroundItIsNatural) {
  haptics::TissueVolume volume = load_tissue(
      ball_scene(R"({"cylinder": {"center_mm": [0, 0, 3], "axis": [0, 0, 1], "radius_mm": 2, "height_mm": 4}})"));
  TissueView view;
  int inside = 0, outside = 0;
  for (const auto& brick : view.update(volume))
    for (const auto& v : brick.vertices) {
      const dvec3 p = volume.frame().origin + dvec3(v.p);
      // The rim of the shaft is at a distance of 4 mm from the middle, too.
      if (std::abs(std::hypot(p.x, p.y) - 2e-3) < 0.3e-3 && p.z > 3e-3) continue;
      const bool natural = glm::length(p) > 3.9e-3;
      EXPECT_EQ(v.cut, natural ? 0 : 1) << p.x << " " << p.y << " " << p.z;
      ++(natural ? outside : inside);
    }
  EXPECT_GT(inside, 100);
  EXPECT_GT(outside, 100);
}

TEST(CutSurface, AnUncutToothHasNone) {
  haptics::TissueVolume molar = load_tissue(read_scene(assets_folder() / "scenes/molar-caries.json"));
  TissueView view(0.5f);
  int cut = 0, all = 0;
  const auto crown = [&](const dvec3& p) { return p.z > 14e-3; };
  for (const auto& brick : view.update(molar))
    for (const auto& v : brick.vertices) {
      ++all;
      cut += v.cut > 0.5f;
      if (crown(molar.frame().origin + dvec3(v.p))) {
        EXPECT_LT(v.cut, 0.5f);
      }
    }
  EXPECT_GT(all, 1000);
  EXPECT_LT(cut, all / 100);  // the scan has a crack in the furcation that is as narrow as a voxel
}

TEST(ThinTissue, ItsThinnessFollowsItsThickness) {
  for (const double thickness_mm : {0.4, 0.8, 1.2, 2.4}) {
    haptics::TissueVolume plate = solids(
        fmt::format(R"({{"tissue": "enamel", "solid": {{"box": {{"center_mm": [0, 0, 0], "size_mm": [6, 6, {}]}}}}}})",
                    thickness_mm)
            .c_str());
    TissueView view;
    int middles = 0;
    for (const auto& brick : view.update(plate))
      for (const auto& v : brick.vertices) {
        const dvec3 p = plate.frame().origin + dvec3(v.p);
        if (std::max(std::abs(p.x), std::abs(p.y)) > 2.5e-3) continue;
        const double expected = std::max(0.0, 1 - thickness_mm * kMillimetre / render::kTranslucentThickness);
        EXPECT_NEAR(v.thin, expected, 0.08) << thickness_mm;
        ++middles;
      }
    EXPECT_GT(middles, 4);
  }
}

TEST(ThinTissue, TheEdgesOfAThickBlockAreNotThin) {
  haptics::TissueVolume block =
      solids(R"({"tissue": "enamel", "solid": {"box": {"center_mm": [0, 0, 0], "size_mm": [5, 5.3, 4.7]}}})");
  TissueView view;
  int all = 0;
  for (const auto& brick : view.update(block))
    for (const auto& v : brick.vertices) {
      const dvec3 p = block.frame().origin + dvec3(v.p);
      EXPECT_EQ(v.thin, 0) << p.x << " " << p.y << " " << p.z;
      ++all;
    }
  EXPECT_GT(all, 20);
}

}  // namespace
}  // namespace typodont
