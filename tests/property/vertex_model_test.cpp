// Tests of the contact model "vertex" in the servo: force, energy, undo, snapshots, and the distance field from
// which scores are computed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "haptics/contact/vertex/vertex_body.h"
#include "haptics/contact_method.h"
#include "tests/support/campaign.h"
#include "tests/support/haptic_bench.h"
#include "tests/support/mesh_shapes.h"

namespace typodont {
namespace {

using namespace literals;
using test::HapticBench;
using test::probe_settings;

constexpr std::string_view kBall =
    R"({"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]})";

haptics::ServoSettings drill(const char* model) {
  haptics::ServoSettings settings = test::drill_settings(model);
  settings.damping = 0.5;
  return settings;
}

/// Returns a ball of 3 mm as a volume, which carries its own mesh with the given edge length.
haptics::TissueVolume ball_of(double edge) {
  haptics::TissueVolume volume(haptics::read_solids(Json::parse(kBall, "tissue")));
  volume.set_mesh(std::make_shared<haptics::TissueMesh>(test::ball(dvec3(3.0_mm), edge)));
  return volume;
}

/// Returns the force (N) on a ball that is pressed 0.15 mm into the top of that mesh. If the model is the printed one,
/// returns the force on a ball that lies at this depth.
double force_on(double edge, const char* model) {
  HapticBench bench(ball_of(edge), probe_settings(model));
  for (int i = 0; i <= 200; ++i) bench.tick({{0, 0, 3.65_mm - 1e-6 * i}});
  for (int i = 0; i < 100; ++i) bench.tick({{0, 0, 3.45_mm}});
  return bench.last.f_model_W.z;
}

TEST(VertexForce, TheMeanForceIsIndependentOfTheMeshAndThePublishedSumIsNot) {
  const double coarse = force_on(0.1_mm, R"({"vertex": {}})"), fine = force_on(0.05_mm, R"({"vertex": {}})");
  EXPECT_NEAR(fine, coarse, 0.05 * coarse) << "four times the vertices";
  EXPECT_NEAR(coarse, 0.15, 0.05 * 0.15) << "1 N/mm, 0.15 mm deep";
  const double sum_coarse = force_on(0.1_mm, R"({"vertex": {"as_printed": true}})"),
               sum_fine = force_on(0.05_mm, R"({"vertex": {"as_printed": true}})");
  EXPECT_GT(sum_fine, 2 * sum_coarse);
}

TEST(VertexForce, OnASmoothBallItPointsAlongTheNormalWithinThreeDegrees) {
  HapticBench bench(ball_of(0.1_mm), probe_settings(R"({"vertex": {}})"));
  double worst = 0;
  for (int i = 0; i < 300; ++i) {
    const dvec3 n = glm::normalize(dvec3(std::cos(0.3 + 0.004 * i), 0.4, std::sin(0.3 + 0.004 * i)));
    bench.tick({(i == 0 ? 5.0_mm : 3.5_mm) * n});
    if (i < 40) continue;
    worst = std::max(worst, std::acos(std::min(1.0, glm::dot(glm::normalize(bench.last.f_model_W), n))) * 180 / kPi);
  }
  EXPECT_LT(worst, 3.0);
}

TEST(VertexForce, TheTipOfAnExplorerStaysAtTheHandHoweverFastItSlides) {
  constexpr double kTip = 0.125_mm, kBallRadius = 3.0_mm, kDeep = 0.15_mm;
  for (const double speed : {0.02, 0.06, 0.15, 0.25}) {  // m/s
    haptics::ServoSettings settings = probe_settings(R"({"vertex": {}})");
    settings.tool.diameter = settings.tool.length = 2 * kTip;
    settings.friction = false, settings.damping = 0;
    HapticBench bench(ball_of(0.1_mm), settings);
    const auto at = [&](double a, double deep) {
      return (kBallRadius + kTip - deep) * dvec3(std::sin(a), 0, std::cos(a));
    };
    for (int i = 0; i <= 100; ++i) bench.tick({at(0, kDeep * i / 100)});
    for (double a = 0; a < 1.5; a += 1e-3 * speed / kBallRadius) {
      bench.tick({at(a, kDeep)});
      ASSERT_NEAR(glm::length(bench.last.f_model_W), 0.15, 0.03) << speed << " m/s, " << a << " rad: 1 N/mm";
    }
  }
}

/// Cuts a groove from the top of the ball.
void groove(HapticBench& bench, int ticks, double y = 0) {
  for (int i = 0; i < ticks; ++i) bench.tick({{2e-6 * i - 1.0_mm, y, 3.7_mm - std::min(i, 300) * 3e-6}}, 1);
}

/// Settings of a cylinder whose cuts in a deep hole take several ticks.
haptics::ServoSettings slow_drill() {
  haptics::ServoSettings settings = drill(R"({"vertex": {"edge_mm": 0.05}})");
  settings.tool.shape = haptics::HeadShape::kCylinder;
  settings.tool.diameter = 1.0_mm, settings.tool.length = 2.0_mm;
  return settings;
}

TEST(VertexModel, AnUnfinishedCutIsFinishedAfterTheBurHasStopped) {
  bool unequal = false;
  for (int stop = 0; stop < 12; ++stop) {
    HapticBench bench(kBall, slow_drill());
    const auto& body = dynamic_cast<const haptics::vertex::VertexBody&>(bench.carver.body());
    const auto mesh_of_servo = [&] {
      return test::mesh_hash(dynamic_cast<const haptics::vertex::VertexSnapshot&>(bench.servo.snapshot()).mesh);
    };
    double z = 4.0_mm;
    for (int i = 0; i < 400 + 3 * stop; ++i) bench.tick({{0, 0, z -= 3e-6}}, 1);
    unequal |= mesh_of_servo() != test::mesh_hash(body.mesh());
    const std::uint64_t cuts = bench.last.cuts;
    for (int i = 0; i < 40; ++i) bench.tick({{0, 0, z += 50e-6}});
    EXPECT_EQ(mesh_of_servo(), test::mesh_hash(body.mesh())) << stop;
    EXPECT_LE(bench.last.cuts, cuts + 1);
  }
  EXPECT_TRUE(unequal) << "no cut took several ticks";
}

TEST(VertexModel, AnUndoDiscardsAnUnfinishedCut) {
  for (int stop = 0; stop < 6; ++stop) {
    HapticBench bench(kBall, slow_drill());
    const auto& body = dynamic_cast<const haptics::vertex::VertexBody&>(bench.carver.body());
    double z = 4.0_mm;
    for (int i = 0; i < 400 + stop; ++i) bench.tick({{0, 0, z -= 3e-6}}, 1);
    bench.carver.rest(bench.t);
    ASSERT_TRUE(bench.carver.undo());
    for (int i = 0; i < 400; ++i) bench.tick({{0, 0, z = std::min(z + 20e-6, 6.0_mm)}});
    for (int i = 0; i < 700; ++i) bench.tick({{0.5_mm, 0, 4.2_mm - 2e-6 * i}}, 1);
    for (int i = 0; i < 40; ++i) bench.tick({{0.5_mm, 0, 2.8_mm + 50e-6 * i}});
    const auto& held = dynamic_cast<const haptics::vertex::VertexSnapshot&>(bench.servo.snapshot());
    EXPECT_EQ(test::mesh_hash(held.mesh), test::mesh_hash(body.mesh())) << stop;
    EXPECT_EQ(test::broken(body.mesh()), "") << stop;
    EXPECT_NEAR(total(bench.last.removed), total(body.removed()) - total(body.taken_back()), 1e-15) << stop;
  }
}

TEST(VertexModel, ALateSnapshotIsTheSameMesh) {
  // The carver takes a snapshot while the servo continues to cut. Then both sides bring the snapshot up to date.
  HapticBench bench(kBall, drill(R"({"vertex": {}})"));
  groove(bench, 500);
  auto late = bench.carver.make_snapshot();
  bench.carver.take_snapshot({}, *late);
  bench.carver.remember_writes(true);
  groove(bench, 300, 0.3_mm);
  const auto& body = dynamic_cast<const haptics::vertex::VertexBody&>(bench.carver.body());
  const auto& mesh = dynamic_cast<const haptics::vertex::VertexSnapshot&>(*late).mesh;
  EXPECT_NE(test::mesh_hash(mesh), test::mesh_hash(body.mesh()));
  EXPECT_TRUE(bench.carver.bring_up_to_date(*late));
  EXPECT_EQ(test::mesh_hash(mesh), test::mesh_hash(body.mesh()));
}

/// Returns all samples of a distance field in voxels. (The field's hash also depends on which leaves were ever
/// written.)
std::vector<float> samples(const haptics::TissueVolume& volume) {
  const glm::ivec3 size(100);
  std::vector<float> field(100 * 100 * 100);
  volume.copy(glm::ivec3(glm::round(volume.frame().to_voxels(dvec3(-5.0_mm)))), size, field.data(), nullptr);
  return field;
}

TEST(VertexModel, UndoAndRedoRestoreMeshAndFieldBitForBit) {
  HapticBench bench(kBall, drill(R"({"vertex": {}})"));
  const auto& body = dynamic_cast<const haptics::vertex::VertexBody&>(bench.carver.body());
  const auto mesh_before = test::mesh_hash(body.mesh());
  const auto field_before = samples(bench.carver.volume());
  groove(bench, 800);
  for (int i = 0; i < 400; ++i) bench.tick({{0, 0, 5.0_mm}});  // after this, the stroke has ended
  bench.carver.rest(bench.t);
  const auto mesh_after = test::mesh_hash(body.mesh());
  const auto field_after = samples(bench.carver.volume());
  EXPECT_FALSE(field_after == field_before);
  const double removed = total(bench.last.removed);
  ASSERT_TRUE(bench.carver.undo());
  EXPECT_EQ(test::mesh_hash(body.mesh()), mesh_before);
  EXPECT_TRUE(samples(bench.carver.volume()) == field_before);
  bench.tick({{0, 0, 5.0_mm}});
  EXPECT_NEAR(total(bench.last.removed), 0, 1e-9 * removed);
  ASSERT_TRUE(bench.carver.redo());
  EXPECT_EQ(test::mesh_hash(body.mesh()), mesh_after);
  EXPECT_TRUE(samples(bench.carver.volume()) == field_after);
  bench.tick({{0, 0, 5.0_mm}});
  EXPECT_NEAR(total(bench.last.removed), removed, 1e-9 * removed);
  const auto& held = dynamic_cast<const haptics::vertex::VertexSnapshot&>(bench.servo.snapshot());
  EXPECT_EQ(test::mesh_hash(held.mesh), mesh_after);
  groove(bench, 300, 0.4_mm);
  EXPECT_EQ(test::mesh_hash(held.mesh), test::mesh_hash(body.mesh()));
}

TEST(VertexModel, TheFieldLosesTheVolumeOfTheMesh) {
  HapticBench bench(kBall, drill(R"({"vertex": {}})"));
  const double before = total(bench.carver.volume().volumes());
  groove(bench, 1000);
  const double lost = before - total(bench.carver.volume().volumes()), removed = total(bench.last.removed);
  EXPECT_GT(removed, 0.05e-9);
  EXPECT_NEAR(lost, removed, 0.05 * removed);
}

constexpr std::string_view kBlock = R"({"voxel_mm": 0.2, "solids": [
  {"tissue": "dentin", "solid": {"box": {"center_mm": [0, 0, -2], "size_mm": [8, 8, 4]}}}]})";

class VertexHeads : public testing::TestWithParam<haptics::HeadShape> {
 protected:
  static haptics::ServoSettings settings() {
    haptics::ServoSettings s = drill(R"({"vertex": {}})");
    s.tool.shape = GetParam();
    s.tool.diameter = 1.0_mm;
    s.tool.length = GetParam() == haptics::HeadShape::kSphere ? 1.0_mm : 2.0_mm;
    return s;
  }
};

TEST_P(VertexHeads, AHeadIsFeltWithTheTissuesStiffnessAndLeavesItsCutWithoutAForceStep) {
  HapticBench bench(kBlock, settings());
  const double tip = bench.settings.tool.half();
  const auto tick = [&](const dvec3& p) { bench.tick({p}, 1); };
  for (int i = 0; i < 600; ++i) tick({0, 0, tip + 0.1_mm - i * 1e-6});
  const double lag = bench.last.X_WG.p.z - (tip + 0.1_mm - 599e-6);
  EXPECT_GT(lag, 0.05_mm);
  EXPECT_NEAR(bench.last.f_model_W.z, 500 * lag, 0.05 * 500 * lag) << "dentin, 0.5 N/mm";
  for (int i = 0; i < 600; ++i) tick({i * 1e-6, 0, tip - 0.5_mm});
  // Moves up and to the side. There the head is below the rest of the surface.
  for (int i = 0; i < 400; ++i) tick({0.6_mm + i * 1e-6, i * 2e-6, tip - 0.5_mm + i * 6e-6});
  EXPECT_GT(total(bench.last.removed), 0.02e-9);
  EXPECT_EQ(bench.last.X_WG.p, dvec3(0.6_mm + 399e-6, 399 * 2e-6, tip - 0.5_mm + 399 * 6e-6)) << "it came out";
  EXPECT_EQ(bench.last.f_T_W, dvec3(0));
  EXPECT_LE(bench.max_step, 0.025);
  EXPECT_GE(bench.min_energy, -1e-9);
}

// ./run stress repeats this test more often.
TEST_P(VertexHeads, RandomHandsLeaveTheMeshClosedAndFreeOfCrossings) {
  for (int run = 0; run < test::campaign(2); ++run) {
    // The first two seeds make a cone fold the surface.
    const int seed = run == 0 ? 7 : run == 1 ? 112 : run;
    std::mt19937 random(static_cast<unsigned>(seed));
    std::uniform_real_distribution<double> unit(-1, 1);
    HapticBench bench(kBlock, settings());
    dvec3 p(0, 0, 2.0_mm), way(0);
    dquat R(1, 0, 0, 0), turn(1, 0, 0, 0);
    for (int i = 0; i < 2000; ++i) {
      if (i % 100 == 0) {  // a new velocity of up to 20 mm/s and a new rotation
        way = 20e-6 * dvec3(unit(random), unit(random), unit(random) - (p.z > 0 ? 0.8 : -0.2));
        turn = glm::angleAxis(2e-3 * unit(random), glm::normalize(dvec3(unit(random), unit(random), 0.1)));
      }
      p = glm::clamp(p + way, dvec3(-2.0_mm, -2.0_mm, -1.0_mm), dvec3(2.0_mm, 2.0_mm, 2.5_mm));
      R = glm::normalize(turn * R);
      bench.tick({p, R}, i % 700 < 600);
    }
    const auto& mesh = dynamic_cast<const haptics::vertex::VertexBody&>(bench.carver.body()).mesh();
    EXPECT_GT(bench.last.cuts, 20u) << seed;
    EXPECT_EQ(test::broken(mesh), "") << seed;
    EXPECT_EQ(test::crossings(mesh), 0) << seed;
    EXPECT_EQ(mesh.border_edges(), 0u) << seed;
    EXPECT_GE(bench.last.energy, -1e-9) << seed;
  }
}

/// Volume (m³) that a rotating head removed, and volume that it swept below the surface of kBlock.
struct Removal {
  double removed, swept;
};
/// Presses the head `deep` into the block and draws it 1.5 mm to the side, at 2 mm/s. The swept volume is counted on a
/// grid of 0.05 mm along the proxy's path. Wherever the tissue holds the head back, the hand must feel a force.
Removal draw_through_block(const haptics::ServoSettings& settings, double deep) {
  constexpr double kGrid = 0.05_mm;
  HapticBench bench(kBlock, settings);
  const double tip = settings.tool.half(), wide = settings.tool.radius();
  const haptics::vertex::VertexHead head(settings.tool);
  std::vector<dvec3> path;
  const auto tick = [&](const dvec3& p) {
    bench.tick({p}, 1);
    if (glm::distance(bench.last.X_WG.p, p) > 0.1_mm) {
      EXPECT_GT(glm::length(bench.last.f_T_W), 0);
    }
    if (path.empty() || glm::distance(path.back(), bench.last.X_WG.p) > 0.02_mm) path.push_back(bench.last.X_WG.p);
  };
  dvec3 p(-1.0_mm, 0, tip);
  for (; p.z > tip - deep; p.z -= 2e-6) tick(p);
  for (; p.x < 0.5_mm; p.x += 2e-6) tick(p);
  std::size_t inside = 0;
  for (double x = -1.0_mm - wide + kGrid / 2; x < 0.5_mm + wide; x += kGrid)
    for (double y = -wide + kGrid / 2; y < wide; y += kGrid)
      for (double z = -kGrid / 2; z > -deep; z -= kGrid)
        inside += std::ranges::any_of(path, [&](const dvec3& c) { return head.distance(dvec3(x, y, z) - c) < 0; });
  return {total(bench.last.removed), static_cast<double>(inside) * kGrid * kGrid * kGrid};
}

TEST_P(VertexHeads, ATurningHeadRemovesWhatItSweeps) {
  const Removal done = draw_through_block(settings(), 0.8_mm);
  EXPECT_GT(done.removed, 0.05e-9);
  EXPECT_NEAR(done.removed, done.swept, 0.1 * done.swept);
}

INSTANTIATE_TEST_SUITE_P(Shapes, VertexHeads,
                         testing::Values(haptics::HeadShape::kSphere, haptics::HeadShape::kCylinder,
                                         haptics::HeadShape::kRoundEndCylinder, haptics::HeadShape::kCone,
                                         haptics::HeadShape::kPear, haptics::HeadShape::kFlame),
                         [](const auto& each) { return std::string(haptics::name_of(each.param)); });

TEST(VertexModel, APointedConeGoesOnCuttingInItsOwnHole) {
  // At this depth the hole is only slightly wider than the length of the mesh's edges, so about half of the swept
  // volume remains.
  haptics::ServoSettings settings = drill(R"({"vertex": {}})");
  settings.tool.shape = haptics::HeadShape::kCone;
  settings.tool.diameter = 1.2_mm, settings.tool.length = 6.0_mm;
  const Removal done = draw_through_block(settings, 1.2_mm);
  EXPECT_GT(done.removed, 0.05e-9);
  EXPECT_NEAR(done.removed, done.swept, 0.57 * done.swept);
}

/// Volume (m³) that a sharp edge removes when it moves forwards and backwards over kBlock, and in one slow stroke. The
/// energy density is 1e9 J/m³.
struct Scraping {
  double removed, paid;
};
Scraping scrape(const char* model, haptics::HeadShape shape, double scrapes, double deep, bool one_stroke) {
  MaterialTable materials = test::plain_materials();
  constexpr double kSpecificEnergy = 1e9;
  materials[static_cast<std::size_t>(Tissue::kDentin)].specific_energy = kSpecificEnergy;
  haptics::ServoSettings settings = probe_settings(model);
  settings.cutting = true;
  settings.tool.shape = shape;
  settings.tool.diameter = 1.5_mm, settings.tool.length = shape == haptics::HeadShape::kSphere ? 1.5_mm : 1.8_mm;
  settings.tool.scrapes = scrapes;
  HapticBench bench(kBlock, settings, materials);
  const double tip = settings.tool.half();
  double work = 0;
  dvec3 before(-1.5_mm, 0, tip + 0.1_mm);
  const auto tick = [&](const dvec3& p) {
    bench.tick({p});
    work += scrapes * bench.last.f_T_W.z * std::abs(p.x - before.x);
    before = p;
  };
  for (double z = before.z; z > tip - deep; z -= 2e-6) tick({-1.5_mm, 0, z});
  for (int i = 0; i < (one_stroke ? 1500 : 2400); ++i) {
    tick({one_stroke ? -1.5_mm + i * 2e-6 : -1.5_mm * std::cos(kPi * i / 600), 0, tip - deep});
  }
  return {total(bench.last.removed), work / kSpecificEnergy};
}

TEST(DrawnEdges, WithEitherMeshModelASpoonRemovesWhatItDoesFromTheField) {
  const double from_field = scrape("offset", haptics::HeadShape::kPear, 1.5, 0.5_mm, false).removed;
  ASSERT_GT(from_field, 1e-12);
  for (const char* model : {"vertex", "mesh_lod"}) {
    EXPECT_NEAR(scrape(model, haptics::HeadShape::kPear, 1.5, 0.5_mm, false).removed, from_field, 0.2 * from_field)
        << model;
  }
}

TEST(DrawnEdges, WithVertexACuttingEdgeRemovesTheVolumeOfTheHandsWork) {
  for (const auto& [shape, scrapes] : {std::pair{haptics::HeadShape::kPear, 1.5}, {haptics::HeadShape::kSphere, 0.5}}) {
    for (const double deep : {0.2_mm, 0.5_mm}) {
      for (const bool one_stroke : {true, false}) {
        const Scraping done = scrape("vertex", shape, scrapes, deep, one_stroke);
        EXPECT_GT(done.removed, 1e-13);
        EXPECT_NEAR(done.removed, done.paid, 0.15 * done.paid)
            << haptics::name_of(shape) << ' ' << deep << ' ' << one_stroke;
      }
    }
  }
}

}  // namespace
}  // namespace typodont
