// Tests of the contact model "mesh_lod" through the common interface, with servo and carver in lock-step.
#include "haptics/contact/mesh_lod/mesh_lod_model.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/contact/mesh_lod/mesh_lod_body.h"
#include "haptics/contact_method.h"
#include "haptics/import/mesh_tissue.h"
#include "haptics/lockstep.h"
#include "haptics/material_fit.h"
#include "tests/support/campaign.h"
#include "tests/support/haptic_bench.h"
#include "tests/support/hausdorff.h"
#include "tests/support/mesh_shapes.h"

namespace typodont::haptics::mesh_lod {
namespace {

using namespace literals;

constexpr double kBall = 3.0_mm;

MaterialTable materials() {
  MaterialTable table{};
  const auto set = [&](Tissue tissue, double stiffness) {
    table[static_cast<std::size_t>(tissue)] = {stiffness, 20e9, 0.3, 0.2, 2500, dvec3(0.9)};
  };
  set(Tissue::kEnamel, 1000);
  set(Tissue::kDentin, 500);
  set(Tissue::kPulp, 200);
  set(Tissue::kCaries, 300);
  return table;
}

ServoSettings settings(const char* method = R"("mesh_lod")", double diameter = 0.25_mm) {
  ServoSettings s;
  s.tool.diameter = s.tool.length = diameter;
  s.tool.cuts = false;
  s.damping = 0;
  s.friction = false;
  s.passivity = false;
  s.ramp_time = 0;
  s.materials = materials();
  s.method = read_contact_method(Json::parse(method, "model"));
  return s;
}

TissueVolume volume(const char* json) {
  return TissueVolume(read_solids(Json::parse(json, "tissue")));
}
TissueVolume ball() {
  return volume(R"({"voxel_mm": 0.15, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]})");
}

/// Returns the section through a tooth of the paper's Fig. 20, flat at z = 0: pulp, a strip of dentin of 0.2 mm,
/// enamel.
TissueVolume section() {
  TissueVolume tissue = volume(R"({"voxel_mm": 0.2, "solids": [
    {"tissue": "pulp", "solid": {"box": {"center_mm": [0, 0, -1], "size_mm": [6, 4, 2]}}}]})");
  auto mesh = std::make_shared<TissueMesh>();
  const std::vector<double> x = {-3, -2, -1, -0.4, -0.1, 0.1, 0.4, 1, 2, 3}, y = {-2, -1.2, -0.5, 0.1, 0.7, 1.4, 2};
  for (const double a : x)
    for (const double b : y) mesh->vertices.push_back(1e-3 * dvec3(a, b, 0));
  const auto at = [&](std::size_t i, std::size_t j) { return static_cast<unsigned>(i * y.size() + j); };
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    for (std::size_t j = 0; j + 1 < y.size(); ++j) {
      const Tissue tissue_here = x[i] < -0.2 ? Tissue::kPulp : x[i] < 0.05 ? Tissue::kDentin : Tissue::kEnamel;
      mesh->triangles.emplace_back(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      mesh->triangles.emplace_back(at(i, j), at(i + 1, j + 1), at(i, j + 1));
      mesh->tissue.insert(mesh->tissue.end(), 2, tissue_here);
    }
  }
  tissue.set_mesh(mesh);
  return tissue;
}

/// A bench that takes the materials from the settings.
struct MeshBench : test::HapticBench {
  MeshBench(TissueVolume tissue, const ServoSettings& s) : HapticBench(std::move(tissue), s, s.materials) {}
};

TEST(MeshLodModel, OnABallTheForceIsTheSpringForceAlongTheNormalAndZeroOutside) {
  MeshBench run(ball(), settings());
  const double reach = kBall + 0.125_mm;
  for (int i = 0; i < 1500; ++i) {
    const double height = reach + 0.2_mm - std::min(i, 400) * 1e-6, a = 0.002 * std::max(0, i - 400);
    const dvec3 out(std::sin(a), 0, std::cos(a));
    run.tick({height * out});
    const double depth = reach - height;
    ASSERT_TRUE(depth > -2e-6 || run.last.f_T_W == dvec3(0)) << i;
    if (depth < 0.05_mm) continue;
    ASSERT_NEAR(glm::length(run.last.f_T_W), 1000 * depth, 5e-3) << i;  // flat faces lie inside the ball
    ASSERT_GT(glm::dot(glm::normalize(run.last.f_T_W), out), std::cos(4.0_deg)) << i;
  }
  EXPECT_EQ(run.last.faults, 0U);
}

TEST(MeshLodModel, FromSoftToHardTissueTheBoundaryHasTheHardTissuesStiffness) {
  MeshBench run(section(), settings(R"({"mesh_lod": {"levels": [70]}})", 0.1_mm));
  for (int i = 0; i < 300; ++i) run.tick({{-1e-3, 0.2e-3, 0.1e-3 - 1e-6 * i}});
  int checked = 0;
  for (double x = -1e-3; x < 0.15e-3; x += 5e-6) {
    run.tick({{x, 0.2e-3, -0.2e-3}});
    const double beyond = x + 0.1e-3;
    if (beyond < 0.02e-3) {
      ASSERT_NEAR(-run.last.f_T_W.x, std::max(0.0, 500 * beyond), 1e-3) << x;
      continue;
    }
    ++checked;
    ASSERT_NEAR(-run.last.f_T_W.x / (500 * beyond), 1, 0.01) << x;
  }
  EXPECT_GT(checked, 30);
}

TEST(MeshLodModel, FromHardToSoftTissueTheBoundaryIsNotFelt) {
  MeshBench run(section(), settings(R"({"mesh_lod": {"levels": [70]}})", 0.1_mm));
  for (int i = 0; i < 300; ++i) run.tick({{1e-3, 0.2e-3, 0.1e-3 - 1e-6 * i}});
  for (double x = 1e-3; x > -1e-3; x -= 5e-6) {
    run.tick({{x, 0.2e-3, -0.2e-3}});
    ASSERT_NEAR(run.last.f_T_W.x, 0, 1e-3) << x;
  }
}

TEST(MeshLodModel, StiffnessFallsInStepsFromOutsideToInside) {
  MeshBench run(section(), settings(R"({"mesh_lod": {"levels": [70]}})", 0.1_mm));
  const auto press = [&](double x) {
    for (int i = 0; i < 100; ++i) run.tick({{x, 0.2e-3, 0.1e-3}});
    for (int i = 0; i < 300; ++i) run.tick({{x, 0.2e-3, 0.1e-3 - 1e-6 * i}});
    for (int i = 0; i < 100; ++i) run.tick({{x, 0.2e-3, -0.2e-3}});
    return run.last.f_T_W.z / 0.25e-3;
  };
  EXPECT_NEAR(press(1.5e-3), 1000, 10);
  EXPECT_NEAR(press(0), 500, 5);
  EXPECT_NEAR(press(-1.5e-3), 200, 2);
}

TEST(MeshLodModel, ABumpOfATenthOfAMillimetreIsFeltAtTheFinestLevel) {
  MeshBench run(volume(R"({"voxel_mm": 0.03, "band_mm": 0.3, "solids": [
                {"tissue": "enamel", "solid": {"box": {"center_mm": [0, 0, -0.5], "size_mm": [2, 1.5, 1]}}},
                {"tissue": "enamel", "solid": {"cylinder": {"center_mm": [0, 0, 0], "axis": [0, 1, 0], "radius_mm": 0.1, "height_mm": 1}}}]})"),
                settings(R"({"mesh_lod": {}})"));
  for (int i = 0; i < 400; ++i) run.tick({{-0.6e-3, 0, 0.2e-3 - 1e-6 * std::min(i, 125)}});
  double most = 0, least = 1e9;
  for (double x = -0.6e-3; x < 0.6e-3; x += 4e-6) {
    run.tick({{x, 0, 0.075e-3}});
    const double lift = run.last.X_WG.p.z;
    most = std::max(most, lift), least = std::min(least, lift);
    ASSERT_EQ(run.last.level, 0U);
  }
  EXPECT_NEAR(most - least, 0.1e-3, 0.01e-3);
}

// --- Fitted damping

TEST(DampingFit, RecoversTheDamperOfASyntheticPushWithinOnePerCent) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.01);
  std::vector<PushSample> samples;
  double most = 0;
  for (int i = 0; i < 2000; ++i) {
    const double t = 1e-3 * i, w = 2 * kPi * 1.5;
    const double depth = 0.6e-3 * std::sin(w * t) + 0.2e-3 * std::sin(3.1 * w * t);
    const double rate = 0.6e-3 * w * std::cos(w * t) + 0.2e-3 * 3.1 * w * std::cos(3.1 * w * t);
    samples.push_back({t, depth, depth > 0 ? std::max(0.0, 800 * depth + 20 * rate + noise(random)) : 0});
    most = std::max(most, samples.back().force);
  }
  const DampingFit fit = fit_damping(samples);
  EXPECT_NEAR(fit.damping, 20, 0.2);
  EXPECT_NEAR(fit.stiffness, 800, 8);
  EXPECT_GT(most, 0.4);
  EXPECT_LT(fit.rms, 0.02);
}

TEST(DampingFit, ACurveThatDoesNotDetermineTheDampingIsRefusedWithAReason) {
  std::vector<PushSample> samples;
  EXPECT_THROW(fit_damping(samples), Error);
  for (int i = 0; i < 100; ++i) samples.push_back({1e-3 * i, 1e-3, 1});
  EXPECT_THROW(fit_damping(samples), Error);
}

// --- The slew filter (7)

TEST(SlewFilter, AsPublishedItGeneratesEnergy) {
  // The hand moves 2 mm deep into a wall of 1 N/mm and out again, at 100 mm/s. The filter may change the force by at
  // most 0.02 N per tick.
  double force = 0, absorbed = 0, until_surface = 0, until_zero = 0;
  const ForceFilterLaw law;
  dvec3 last(0);
  double depth = 0;
  for (int i = 1; i <= 400; ++i) {
    const double next = i <= 20 ? 0.1e-3 * i : 2e-3 - 0.1e-3 * (i - 20), energy = force * (next - depth);
    if (i <= 20)
      absorbed += energy;
    else if (force > 0)
      until_zero -= energy, until_surface -= next >= 0 ? energy : 0;
    depth = next;
    last = filter_force(ForceFilter::kSlew, law, {0, 0, 1000 * std::max(depth, 0.0)}, last);
    force = last.z;
  }
  EXPECT_NEAR(1e3 * absorbed, 0.380, 0.001);
  EXPECT_NEAR(1e3 * until_surface, 1.10, 0.01);
  EXPECT_NEAR(1e3 * until_zero, 1.80, 0.01);
}

// --- Levels

const TissueMesh& arch() {
  static const TissueMesh mesh = read_tissue_mesh("assets/jaw/lower_arch.ply", 1e-3, Tissue::kEnamel).mesh;
  return mesh;
}
std::shared_ptr<const Levels> arch_levels() {
  static const auto levels = make_levels(arch(), {{}, {13288, 5000, 2500}});
  return levels;
}

/// Presses 0.1 mm deep at random places of the arch.
template <class Use>
void at_random_places(int count, Use&& use) {
  std::mt19937 random(5);
  const TriangleGrid& finest = arch_levels()->grids[0];
  std::uniform_int_distribution<std::size_t> any(0, finest.size() - 1);
  for (int i = 0; i < count; ++i) {
    const Face& face = finest.face(static_cast<std::uint32_t>(any(random)));
    const dvec3 n = glm::normalize(face.normal()), p = (face.a + face.b + face.c) / 3.0;
    if (!finest.inside(p - 0.1e-3 * n)) continue;  // the tissue is thin here, or this is the border
    use(p, n);
  }
}

TEST(MeshLodModel, ALevelSwitchIsNotFeltBecauseOfTheRampAndMappingAloneLeavesAForceStep) {
  const ServoSettings s = settings();
  Parameters eased, mapped, computed_again;
  mapped.ramp = computed_again.ramp = 0;
  computed_again.maps = false;
  double worst[3] = {};  // N, in the order of the loop below
  int done = 0;
  at_random_places(150, [&](const dvec3& p, const dvec3& n) {
    std::size_t which = 0;
    for (const Parameters* parameters : {&eased, &mapped, &computed_again}) {
      double& worst_here = worst[which++];
      MeshLodModel model(s, *parameters);
      MeshSnapshot snapshot;
      snapshot.number = 1;
      snapshot.levels = arch_levels();
      PerTissue removed{};
      model.adopt(snapshot, removed);
      ContactInput in;
      in.X_WT.p = in.X_WG.p = p + 1e-3 * n;
      Contact out;
      model.constrain(in, out);
      if (out.leading_out) return;
      dvec3 held(0);
      // The hand rests at a depth of 0.1 mm. The speed that it reports changes between 0 and 0.2 m/s, across both
      // limits of the switch.
      for (int i = 0; i < 400; ++i) {
        in.X_WG.p = out.p_WG;
        in.X_WT.p = p + (0.025e-3 - std::min(1e-6 * i, 0.1e-3)) * n;
        in.moved = dvec3(i < 150 || i > 300 ? 0 : 0.2e-3, 0, 0);
        out = {};
        model.constrain(in, out);
        if (i > 150 && out.touching) {
          worst_here = std::max(worst_here, 1000 * glm::distance(out.p_WG, held));
        }
        held = out.p_WG;
        EXPECT_TRUE(i != 149 || out.level == 0);
        EXPECT_TRUE(i != 290 || out.level == 2);
      }
      EXPECT_EQ(out.level, 0U);
      ++done;
    }
  });
  EXPECT_GT(done, 100);
  EXPECT_LE(worst[0], 0.005 + 1e-6);
  double apart = 0;  // m
  for (const TriangleGrid& level : arch_levels()->grids) {
    apart = std::max(apart, hausdorff_distance(arch_levels()->grids[0], level));
  }
  for (const double step : {worst[1], worst[2]}) {
    EXPECT_GT(step, 0.02);
    EXPECT_LE(step, 1000 * apart);
  }
  fmt::print("largest step: with a ramp {:.4f} N, mapped {:.4f} N, computed again {:.4f} N\n", worst[0], worst[1],
             worst[2]);
}

// --- Cutting

constexpr const char* kBlock = R"({"voxel_mm": 0.2, "solids": [
  {"tissue": "dentin", "solid": {"box": {"center_mm": [0, 0, -3], "size_mm": [8, 8, 6]}}}]})";
constexpr double kBur = 0.6_mm;

ServoSettings drill() {
  ServoSettings s = settings(R"("mesh_lod")", 2 * kBur);
  s.tool.cuts = true;
  s.spindle.free_speed = 300.0_krpm;
  s.passivity = true;
  s.damping = 2;
  return s;
}

/// Returns the part of the volume of a ball below z = 0. The ball has radius r, and its centre is at height z.
double cap(double r, double z) {
  const double h = std::clamp(r - z, 0.0, 2 * r);
  return kPi * h * h * (r - h / 3);
}

TEST(MeshLodModel, ABurSinksWhereItIsPressedAndRemovesItsSweptVolume) {
  MeshBench run(volume(kBlock), drill());
  const double whole = total(run.carver.volume().volumes());
  for (int i = 0; i < 1800; ++i) {
    run.tick({{0.03e-3, 0.02e-3, kBur + 0.05e-3 - std::min(i, 600) * 1e-6}}, 1);
    if (i <= 20) run.max_step = 0;
  }
  EXPECT_LE(run.max_step, 0.02);
  for (int i = 0; i < 100; ++i) run.tick({{0.03e-3, 0.02e-3, kBur - 0.55e-3}}, 1);
  ASSERT_GT(run.last.cuts, 100U);
  const double z = run.last.X_WG.p.z;
  EXPECT_LT(z, kBur - 0.2e-3);
  EXPECT_NEAR(total(run.last.removed) / cap(kBur, z), 1, 0.05);
  EXPECT_NEAR((whole - total(run.carver.volume().volumes())) / cap(kBur, z), 1, 0.1);
  EXPECT_GE(run.min_energy, -1e-9);
}

TEST(MeshLodModel, ABurIsHeldWhileTheCarverSendsNoMeshAndGoesOnCuttingAfterwards) {
  for (const auto& [shape, length] :
       {std::pair{HeadShape::kSphere, 2 * kBur}, {HeadShape::kCone, 6.0_mm}, {HeadShape::kCylinder, 4.0_mm}}) {
    SCOPED_TRACE(haptics::name_of(shape));
    ServoSettings s = drill();
    s.tool.shape = shape, s.tool.length = length;
    MeshBench run(volume(kBlock), s);
    const double tip = s.tool.half();
    const auto tick = [&](double z) { run.tick({{0.03e-3, 0.02e-3, z}}, 1); };
    double z = tip + 0.05_mm;
    for (int i = 0; i < 600; ++i) tick(z -= 1e-6);
    const double landed = run.last.X_WG.p.z;
    // The hand presses 3 mm into the block, and the carver does nothing for two seconds.
    run.steps.stall(true);
    for (int i = 0; i < 2000; ++i) tick(z = std::max(z - 2e-6, tip - 3.0_mm));
    EXPECT_GT(run.last.X_WG.p.z, landed - 2.1 * kBur);
    EXPECT_GT(run.last.f_T_W.z, 0.05) << "the hand feels that it is held";
    const std::uint64_t cuts = run.last.cuts;
    run.steps.stall(false);
    for (int i = 0; i < 500; ++i) tick(z);
    EXPECT_GT(run.last.cuts, cuts);
    EXPECT_LT(run.last.X_WG.p.z, landed - 0.1_mm);
    EXPECT_LE(run.max_step, 0.025);
    EXPECT_GE(run.min_energy, -1e-9);
  }
}

TEST(MeshLodModel, ACutMeshStaysClosedAndUndoBringsItBackToTheBit) {
  MeshBench run(volume(kBlock), drill());
  const auto& mesh = dynamic_cast<const MeshLodBody&>(run.carver.body()).mesh();
  const std::uint64_t untouched = test::mesh_hash(mesh);
  EXPECT_EQ(mesh.border_edges(), 0U);
  for (int i = 0; i < 1500; ++i) {
    const double down = kBur + 0.02e-3 - std::min(i, 300) * 1e-6;
    run.tick({{i * 0.5e-6, 0.2e-3 * std::sin(0.005 * i), down}}, 1);
  }
  EXPECT_EQ(mesh.border_edges(), 0U);
  const std::uint64_t cut = test::mesh_hash(mesh);
  EXPECT_NE(cut, untouched);
  double min_angle = 180;
  for (mesh::Index f = 0; f < mesh.face_range(); ++f) {
    if (!mesh.uses(f)) continue;
    for (int k = 0; k < 3; ++k) {
      const dvec3 a = mesh.point(f, (k + 1) % 3) - mesh.point(f, k), b = mesh.point(f, (k + 2) % 3) - mesh.point(f, k);
      if (glm::length(mesh.point(f, k)) > 3e-3) continue;  // beside the cut, where the mesh equals the volume's surface
      min_angle = std::min(min_angle, std::acos(glm::dot(a, b) / (glm::length(a) * glm::length(b))) * 180 / kPi);
    }
  }
  EXPECT_GE(min_angle, 10);
  ASSERT_TRUE(run.carver.undo());
  EXPECT_EQ(test::mesh_hash(mesh), untouched);
  ASSERT_TRUE(run.carver.redo());
  EXPECT_EQ(test::mesh_hash(mesh), cut);
}

ServoSettings drill(HeadShape shape, double diameter, double length) {
  ServoSettings s = drill();
  s.tool.shape = shape;
  s.tool.diameter = diameter, s.tool.length = length;
  return s;
}

/// Every head except the ball, on its tip and on its flank.
struct HeadCase {
  const char* name;
  HeadShape shape;
  double diameter, length;  // m
  bool lies;
};
void PrintTo(const HeadCase& head, std::ostream* out) {
  *out << head.name;
}
class MeshLodHeads : public testing::TestWithParam<HeadCase> {};

TEST_P(MeshLodHeads, EveryHeadCutsWhereItIsPressedCountsItsVolumeAndHasNoForceStep) {
  const HeadCase& head = GetParam();
  MeshBench run(volume(kBlock), drill(head.shape, head.diameter, head.length));
  const dquat R = head.lies ? glm::angleAxis(kPi / 2, dvec3(0, 1, 0)) : dquat(1, 0, 0, 0);
  const double top = head.lies ? head.diameter / 2 : head.length / 2;
  const auto& mesh = dynamic_cast<const MeshLodBody&>(run.carver.body()).mesh();
  const double whole = test::volume(mesh);
  for (int i = 0; i < 1900; ++i) {
    // From tick 1500 the hand moves up and to the side. There the head is below the rest of the surface.
    const int up = std::max(i - 1500, 0);
    run.tick({{0.03e-3 + 0.2e-3 * std::sin(0.004 * (i - up)), 0.02e-3 + 2e-6 * up,
               top + 0.05e-3 - std::min(i, 350) * 1e-6 + 6e-6 * up},
              R},
             1);
    if (i <= 20) run.max_step = 0;
  }
  EXPECT_LE(run.max_step, 0.02);
  EXPECT_GE(run.min_energy, -1e-9);
  for (int i = 0; i < 100; ++i) run.tick({{0.03e-3, 0.02e-3, 10e-3}, R}, 1);
  ASSERT_GT(run.last.cuts, 50U);
  EXPECT_EQ(mesh.border_edges(), 0U);
  const double lost = whole - test::volume(mesh);
  EXPECT_GT(lost, 0.5e-12) << "m³";
  EXPECT_NEAR(total(run.last.removed) / lost, 1, 1e-6);
}

// ./run stress repeats this test more often.
TEST_P(MeshLodHeads, RandomHandsKeepTheMeshClosedAndTheProxyContinuous) {
  const HeadCase& head = GetParam();
  for (int seed = 1; seed <= test::campaign(1); ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed));
    std::uniform_real_distribution<double> unit(-1, 1);
    MeshBench run(volume(kBlock), drill(head.shape, head.diameter, head.length));
    dvec3 p(0, 0, 2.5_mm), way(0), before(0);
    dquat R = head.lies ? glm::angleAxis(kPi / 2, dvec3(0, 1, 0)) : dquat(1, 0, 0, 0), turn(1, 0, 0, 0);
    double max_step = 0;  // m
    for (int i = 0; i < 1200; ++i) {
      if (i % 100 == 0) {  // a new velocity of up to 20 mm/s and a new rotation
        way = 20e-6 * dvec3(unit(random), unit(random), unit(random) - (p.z > 0 ? 0.8 : -0.2));
        turn = glm::angleAxis(2e-3 * unit(random), glm::normalize(dvec3(unit(random), unit(random), 0.1)));
      }
      const Pose last{p, R};
      p = glm::clamp(p + way, dvec3(-2.0_mm, -2.0_mm, -1.0_mm), dvec3(2.0_mm, 2.0_mm, 2.5_mm));
      R = glm::normalize(turn * R);
      run.tick({p, R}, 1);
      const dvec3 lag = run.last.X_WG.p - p;
      max_step = std::max(max_step, glm::distance(lag, before) - displacement_bound(last, {p, R}, head.length / 2));
      before = lag;
    }
    const auto& mesh = dynamic_cast<const MeshLodBody&>(run.carver.body()).mesh();
    EXPECT_GT(run.last.cuts, 20U) << seed;
    EXPECT_EQ(test::broken(mesh), "") << seed;
    EXPECT_EQ(test::crossings(mesh), 0) << seed;
    EXPECT_EQ(mesh.border_edges(), 0U) << seed;
    EXPECT_LE(max_step, 0.04_mm) << seed << ": what a bur eases by in a tick, and what it cuts";
    EXPECT_GE(run.min_energy, -1e-9) << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, MeshLodHeads,
                         testing::Values(HeadCase{"cylinder", HeadShape::kCylinder, 1.0_mm, 3.0_mm, false},
                                         HeadCase{"lying_cylinder", HeadShape::kCylinder, 1.0_mm, 3.0_mm, true},
                                         HeadCase{"round_end", HeadShape::kRoundEndCylinder, 1.0_mm, 3.0_mm, false},
                                         HeadCase{"cone", HeadShape::kCone, 1.2_mm, 3.0_mm, false},
                                         HeadCase{"lying_cone", HeadShape::kCone, 1.2_mm, 3.0_mm, true},
                                         HeadCase{"flame", HeadShape::kFlame, 1.0_mm, 3.0_mm, false},
                                         HeadCase{"lying_flame", HeadShape::kFlame, 1.0_mm, 3.0_mm, true}),
                         [](const auto& each) { return std::string(each.param.name); });

TEST(MeshLodModel, AStoppedHeadTouchesTheWallsOfItsOwnCutAlongItsWholeLength) {
  MeshBench run(volume(kBlock), drill(HeadShape::kCylinder, 1.0_mm, 3.0_mm));
  const dquat lying = glm::angleAxis(kPi / 2, dvec3(0, 1, 0));
  for (int i = 0; i < 3000; ++i) run.tick({{0, 0, 0.55_mm - std::min(i, 400) * 1e-6}, lying}, 1);
  const double cut_to = run.last.X_WG.p.z;
  EXPECT_LT(cut_to, 0.48_mm);
  for (int i = 0; i < 400; ++i) run.tick({{0, 0, 2.0_mm}, lying});
  // The spindle is at rest. The cut groove supports the bur; beside the groove, the untouched surface supports it.
  for (int i = 0; i < 1900; ++i) run.tick({{0, 0, 2.0_mm - i * 1e-6}, lying});
  EXPECT_NEAR(run.last.X_WG.p.z, cut_to, 0.02_mm);
  for (int i = 0; i < 400; ++i) run.tick({{0, 0, 2.0_mm}, lying});
  for (int i = 0; i < 400; ++i) run.tick({{0, 2.5e-3 * i / 400, 2.0_mm}, lying});
  for (int i = 0; i < 1900; ++i) run.tick({{0, 2.5_mm, 2.0_mm - i * 1e-6}, lying});
  EXPECT_NEAR(run.last.X_WG.p.z, 0.5_mm, 0.01_mm);
}

TEST(MeshLodModel, AfterACutTheLevelFollowsTheSpeedAndNoSwitchCausesAForceStep) {
  ServoSettings s = drill();
  haptics::Tool probe = s.tool;
  probe.cuts = false;
  s.tools = {s.tool, probe};
  MeshBench run(volume(R"({"voxel_mm": 0.2, "solids": [
    {"tissue": "dentin", "solid": {"box": {"center_mm": [0, 0, -1], "size_mm": [36, 4, 2]}}}]})"),
                s);
  for (int i = 0; i < 600; ++i) {
    run.tick({{0.3e-3 * std::sin(0.01 * i), 0, kBur + 0.05e-3 - std::min(i, 300) * 1e-6}}, 1);
    EXPECT_EQ(run.last.level, 0U) << "a cut wants the finest level";
  }
  ASSERT_GT(run.last.cuts, 50U);
  for (int i = 0; i < 1500; ++i) run.tick({{0, 0, 2.0_mm}}, 0, 1);
  ASSERT_EQ(run.last.tool, 1U);
  std::array<int, 3> ticks{};
  double x = 0, max_step = 0;
  dvec3 before(0);
  std::uint32_t level = 0;
  for (int i = 0; i < 4000; ++i) {
    // The bur moves down beside the groove, then forwards and backwards across it at up to 160 mm/s, twice per second.
    const double speed = i < 1500 ? 0 : 160e-3 * std::sin(2 * kPi * 0.002 * (i - 1500));
    x += 1e-3 * speed;
    run.tick({{x, 0, 2.0_mm - std::min(i, 1450) * 1e-6}}, 0, 1);
    ++ticks.at(run.last.level);
    if (run.last.level != level) max_step = std::max(max_step, glm::distance(run.last.f_T_W, before));
    before = run.last.f_T_W, level = run.last.level;
  }
  for (const int at_level : ticks) EXPECT_GT(at_level, 200);
  EXPECT_LE(max_step, 0.02);
}

// The following tests concern the common interface of contact models.

TEST(MeshLodModel, AfterASnapshotTheServoUsesThePointsThatTheCarverListed) {
  LockStep steps(volume(kBlock), drill(HeadShape::kCylinder, 1.0_mm, 3.0_mm));
  ServoTick tick;
  Cut cut;
  HandSample hand;
  hand.pedal = 1;
  int snapshots = 0;
  for (int i = 0; i < 1500; ++i) {
    hand.t += 1'000'000;
    hand.X_WT = {{0.2e-3 * std::sin(0.004 * i), 0, 1.55_mm - std::min(i, 500) * 1e-6},
                 glm::angleAxis(0.0002 * i, dvec3(0, 1, 0))};
    const bool due = tick.cuts > 0 && steps.carver().snapshot_due(tick);
    if (due) steps.take_snapshot(steps.carver().snapshot_center(tick)), steps.adopt_snapshot();
    const std::uint64_t before = looks_of_this_thread().triangles;
    if (!due && i % 100 == 0 && i < 200) {
      steps.take_snapshot(hand.X_WT.p), steps.adopt_snapshot();
    }
    steps.tick_servo(hand, tick, cut);
    const std::uint64_t searches = looks_of_this_thread().triangles - before;
    steps.apply_cuts(std::numeric_limits<std::uint64_t>::max());
    if (!due) continue;
    ++snapshots;
    EXPECT_EQ(searches, 0u) << "tick " << i;
  }
  EXPECT_GT(snapshots, 20);
}

TEST(SurfacePoint, ATissueBoundaryStopsAProbeButNotACuttingBur) {
  const TissueVolume tissue = section();
  const TriangleGrid grid(*tissue.mesh());
  Stiffness stiffness{};
  for (std::size_t i = 0; i < stiffness.size(); ++i) stiffness[i] = materials()[i].stiffness;
  for (const bool cuts : {false, true}) {
    SurfacePoint point({.radius = 0.1_mm, .wall_limit = 10}, stiffness);
    point.put(grid, {-1.0_mm, 0.3_mm, 0.3_mm});
    bool held = false;
    for (int i = 0; i < 1000; ++i) {  // first on the pulp, then across the border to dentin
      point.follow(grid, {-1.0_mm + i * 1e-6, 0.3_mm, 0.05_mm}, cuts);
      for (int k = 0; k < point.count(); ++k) held |= point.hold(k).wall;
    }
    EXPECT_EQ(held, !cuts);
  }
}

}  // namespace
}  // namespace typodont::haptics::mesh_lod
