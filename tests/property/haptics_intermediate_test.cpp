// Tests the intermediate surface of `offset`: the hand feels a surface that learns of cuts and fillings 30 times a
// second, and moves to each new state continuously.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/contact/offset/field_body.h"
#include "haptics/contact/offset/intermediate_surface.h"
#include "tests/support/haptic_bench.h"
#include "tests/support/no_alloc.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::ServoSettings;
using haptics::TissuePatch;
using haptics::Tool;
using haptics::offset::IntermediateModel;
using haptics::offset::IntermediateSurface;
using test::HapticBench;

constexpr const char* kBlock =
    R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [8, 6, 4]}}}]})";
constexpr double kTop = 2e-3;  // m

/// `offset` with an intermediate surface, whose model the test can see.
class SeenMethod final : public haptics::ContactMethod {
 public:
  explicit SeenMethod(const IntermediateSurface& surface) : surface_(surface) {}
  std::string_view name() const override { return "offset"; }
  std::unique_ptr<haptics::ContactModel> make_model(const ServoSettings& settings) const override {
    auto model = std::make_unique<IntermediateModel>(settings, surface_);
    seen = model.get();
    return model;
  }
  std::unique_ptr<haptics::TissueBody> make_body(haptics::TissueVolume tissue,
                                                 std::span<const Tool> tools) const override {
    return std::make_unique<haptics::offset::FieldBody>(std::move(tissue), tools, true);
  }
  mutable const IntermediateModel* seen = nullptr;

 private:
  IntermediateSurface surface_;
};

const IntermediateModel& model_of(const ServoSettings& settings) {
  return *dynamic_cast<const SeenMethod&>(*settings.method).seen;
}

Tool condenser() {
  Tool tool;
  tool.shape = haptics::HeadShape::kRoundEndCylinder;
  tool.diameter = 1.0_mm, tool.length = 3.0_mm;
  tool.cuts = false;
  tool.fill = Tissue::kComposite;
  tool.fill_rate = 2 * kCubicMillimetre;
  tool.fill_reach = 0.6_mm;
  return tool;
}

ServoSettings settings_with(const IntermediateSurface& surface, const std::vector<Tool>& tools = {}) {
  ServoSettings settings = test::drill_settings("offset");
  settings.method = std::make_shared<SeenMethod>(surface);
  if (!tools.empty()) settings.tools = tools, settings.tool = tools.front();
  return settings;
}

/// Distances of the felt field and of the tissue in the servo's patch.
struct Fields {
  glm::ivec3 lo{0};
  std::vector<float> felt, tissue;
};
Fields fields_of(const HapticBench& bench) {
  const TissuePatch &felt = model_of(bench.settings).felt(), &tissue = bench.patch();
  return {felt.lo, {felt.distance.begin(), felt.distance.end()}, {tissue.distance.begin(), tissue.distance.end()}};
}

/// Counts the samples of the felt field that moved in the last tick by more than `most` voxels or away from the tissue.
/// Cuts only raise distances, fillings (`sign` -1) only lower them.
int wrong_motions(const Fields& before, const Fields& now, int n, double most, float sign) {
  int wrong = 0;
  for_each_voxel(glm::ivec3(n), [&](int x, int y, int z) {
    const glm::ivec3 old = glm::ivec3(x, y, z) + now.lo - before.lo;
    if (glm::any(glm::lessThan(old, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(old, glm::ivec3(n)))) return;
    const auto at = [n](const glm::ivec3& p) { return static_cast<std::size_t>((p.x * n + p.y) * n + p.z); };
    const std::size_t i = at({x, y, z});
    const double moved = sign * (now.felt[i] - before.felt[at(old)]), left = sign * (now.tissue[i] - now.felt[i]);
    wrong += moved < 0 || moved > most || left < 0;
  });
  return wrong;
}

TEST(IntermediateSurface, EachSampleGoesFromTheOldSurfaceToTheNewOneAtALimitedSpeedAndNeverBack) {
  const IntermediateSurface surface;
  HapticBench bench(kBlock, settings_with(surface));
  const double most = surface.max_speed * 1e-3 / 0.1e-3 + 1e-5;  // voxels in a tick
  const double height = kTop + 0.6e-3;
  bench.tick({{0, 0, height + 1e-4}}, 1);
  Fields before = fields_of(bench);
  const Fields untouched = before;
  int moves = 0, kept = 0, patches = 0;
  for (int i = 0; i < 700; ++i) {
    // Presses, and then moves over several tissue patches.
    const Pose hand{{5e-6 * std::max(i - 200, 0), 1e-6 * i, height - 3e-6 * std::min(i, 200)}};
    bench.tick(hand, 1);
    Fields now = fields_of(bench);
    ASSERT_EQ(wrong_motions(before, now, bench.patch().n, most, 1), 0) << i;
    patches += now.lo != before.lo;
    moves += now.felt != before.felt;
    if (now.lo == untouched.lo && bench.last.cuts > 0) kept += now.felt == untouched.felt;
    before = std::move(now);
  }
  EXPECT_GT(kept, 5) << "until it first learns of cuts, the surface stays";
  EXPECT_GT(patches, 3);
  EXPECT_GT(moves, 200);
  EXPECT_NE(before.felt, before.tissue);
  for (int i = 0; i < 300; ++i) bench.tick({{2.5e-3, 0.7e-3, height - 0.6e-3 + 1e-5 * i}}, 0);
  const Fields end = fields_of(bench);
  EXPECT_EQ(end.felt, end.tissue);
}

TEST(IntermediateSurface, FillingSwellsUnderTheInstrumentAndIsCarvedBack) {
  constexpr const char* kCavity = R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"difference": [
    {"box": {"size_mm": [7,7,4]}}, {"cylinder": {"center_mm": [0,0,1.5], "axis": [0,0,1], "radius_mm": 1.5, "height_mm": 4}}]}}]})";
  Tool bur;
  bur.diameter = bur.length = 1.2_mm;
  const IntermediateSurface surface;
  HapticBench bench(kCavity, settings_with(surface, {condenser(), bur}));
  const double most = surface.max_speed * 1e-3 / 0.1e-3 + 1e-5;
  const auto end_at = [](double z) { return Pose{{0, 0, z + 1.5_mm}}; };
  for (int i = 0; i < 20; ++i) bench.tick(end_at(-0.45_mm), 0);
  Fields before = fields_of(bench);
  bench.max_step = 0;
  for (int i = 0; i < 500; ++i) {
    // Retreats more slowly than the filling grows, so that it swells against the instrument.
    bench.tick(end_at(-0.45_mm + 0.1e-6 * i), 1);
    Fields now = fields_of(bench);
    ASSERT_EQ(wrong_motions(before, now, bench.patch().n, most, -1), 0) << i;
    before = std::move(now);
  }
  EXPECT_LT(bench.last.removed[static_cast<std::size_t>(Tissue::kComposite)], -0.5 * kCubicMillimetre);
  EXPECT_LT(bench.max_step, 0.014) << "N per tick";
  for (int i = 0; i < 200; ++i) bench.tick(end_at(-0.45_mm + 0.05e-3 * i), 0);
  const Fields filled = fields_of(bench);
  EXPECT_EQ(filled.felt, filled.tissue);
  for (int i = 0; i < 100; ++i) bench.tick({{0, 0, 3.0_mm}}, 0, 1);
  ASSERT_EQ(bench.last.tool, 1u);
  for (int i = 0; i < 1000; ++i) bench.tick({{0, 0, 3.0_mm - 3e-6 * i}}, 1, 1);
  EXPECT_GT(bench.last.removed[static_cast<std::size_t>(Tissue::kComposite)] / kCubicMillimetre, -1);
  for (int i = 0; i < 300; ++i) bench.tick({{0, 0, 2e-5 * i}}, 0, 1);
  const TissuePatch &felt = model_of(bench.settings).felt(), &tissue = bench.patch();
  EXPECT_TRUE(felt.distance == tissue.distance);
  EXPECT_TRUE(felt.tissue == tissue.tissue) << "labels of removed filling";
}

/// Largest change (N) of the model's force in a tick while the hand rests and the bur sinks, and the sinking in mm.
std::pair<double, double> step_at_rest(const IntermediateSurface& surface) {
  MaterialTable materials = test::plain_materials();
  Material& dentin = materials[static_cast<std::size_t>(Tissue::kDentin)];
  dentin.stiffness = 1000, dentin.specific_energy = 4e9;
  HapticBench bench(kBlock, settings_with(surface), materials);
  const auto hand = [](int i) { return Pose{{1e-4, 0, kTop + 0.6e-3 - 1e-5 * std::min(i, 100)}}; };
  for (int i = 0; i < 130; ++i) bench.tick(hand(i), 1);
  const double before = bench.last.X_WG.p.z;
  double step = 0;
  for (int i = 130; i < 300; ++i) {
    const dvec3 last = bench.last.f_model_W;
    bench.tick(hand(i), 1);
    step = std::max(step, glm::length(bench.last.f_model_W - last));
  }
  return {step, (before - bench.last.X_WG.p.z) / kMillimetre};
}

TEST(IntermediateSurface, TheForceOnAHandAtRestIsSmoothWhere30UpdatesASecondAloneMakeSteps) {
  const auto [blended, sunk] = step_at_rest({});
  IntermediateSurface at_once;
  at_once.removal = 1e-3, at_once.max_speed = 10;
  const auto [unblended, sunk_at_once] = step_at_rest(at_once);
  EXPECT_LT(blended, 0.008) << "N per tick";
  EXPECT_GT(unblended, 0.03);
  EXPECT_GT(sunk, 0.1) << "mm";
  EXPECT_NEAR(sunk, sunk_at_once, 0.05);
}

TEST(IntermediateSurface, ItMovesFasterWithMoreForceAndSlowerInMoreStiffTissueAndWithMoreArea) {
  const auto lag = [](double depth_mm, double stiffness, double diameter_mm) {
    IntermediateSurface slow;
    slow.removal = 2e-11;
    ServoSettings settings = settings_with(slow);
    settings.tool.diameter = settings.tool.length = diameter_mm * kMillimetre;
    MaterialTable materials = test::plain_materials();
    Material& dentin = materials[static_cast<std::size_t>(Tissue::kDentin)];
    dentin.stiffness = stiffness;
    dentin.specific_energy = 1e8;  // the tissue is removed at once
    HapticBench bench(kBlock, settings, materials);
    const double touch = kTop + settings.tool.radius();
    for (int i = 0; i < 200; ++i) bench.tick({{0, 0, touch - depth_mm * kMillimetre * std::min(i / 100.0, 1.0)}}, 1);
    const double before = bench.last.X_WG.p.z;
    for (int i = 0; i < 100; ++i) bench.tick({{0, 0, touch - depth_mm * kMillimetre}}, 1);
    return before - bench.last.X_WG.p.z;  // m in 0.1 s
  };
  const double usual = lag(0.3, 1000, 1.2);
  EXPECT_GT(usual, 1e-6);
  EXPECT_GT(lag(0.45, 1000, 1.2), 1.1 * usual);
  // Softer tissue also pushes less at the same depth: force / stiffness is the same.
  EXPECT_NEAR(lag(0.3, 500, 1.2), usual, 0.1 * usual);
  EXPECT_LT(lag(0.3, 1000, 2.4), 0.7 * usual);
}

/// A bur that drills over several tissue patches, with two undos. The carver is up to 50 cuts late, and sends
/// steps or complete tissue patches.
std::vector<ServoTick> drilled(bool steps) {
  haptics::TissueVolume volume(haptics::read_solids(Json::parse(kBlock, "tissue")));
  ServoSettings settings = HapticBench::with_materials(settings_with({}), test::plain_materials());
  settings.frame = volume.frame();
  haptics::Servo servo(settings);
  haptics::Carver carver(std::move(volume), settings);
  const auto snapshot = carver.make_snapshot();
  std::deque<Cut> waiting;
  std::vector<ServoTick> ticks;
  ServoTick last;
  last.X_WT.p = last.X_WG.p = {0, 0, kTop + 1e-3};
  for (int i = 0; i < 1500; ++i) {
    const bool edits = i == 700 || i == 1100;
    while (waiting.size() > (edits ? 0 : 50)) carver.apply(waiting.front()), waiting.pop_front();
    if (edits && !carver.undo()) throw std::logic_error("nothing to undo");
    if (carver.snapshot_due(last)) {
      carver.take_snapshot(carver.snapshot_center(last), *snapshot, 0, steps ? servo.snapshot().number : 0);
      servo.adopt(*snapshot);
    }
    const double x = 1.5e-3 * std::sin(4e-3 * i), z = kTop + 0.6e-3 - 3e-6 * std::min(i, 200);
    Cut cut;
    if (servo.tick({i * 1'000'000ll, {{x, 1e-4 * std::sin(0.03 * i), z}}, 1}, last, cut)) waiting.push_back(cut);
    last.cpu_time = 0;
    ticks.push_back(last);
  }
  return ticks;
}

TEST(IntermediateSurface, StepsAndCompleteTissuePatchesGiveTheSameBits) {
  const std::vector<ServoTick> a = drilled(true), b = drilled(false);
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].f_T_W, b[i].f_T_W) << i;
    ASSERT_EQ(a[i].X_WG.p, b[i].X_WG.p) << i;
    ASSERT_EQ(a[i].removed, b[i].removed) << i;
  }
  EXPECT_GT(a.back().cuts, 500u);
}

TEST(IntermediateSurface, TheLedgerHoldsAndNoTickAllocates) {
  for (const double hz : {500.0, 1000.0, 4000.0}) {
    ServoSettings settings = settings_with({});
    settings.tick = 1 / hz;
    settings.friction = true;
    settings.damping = 2;
    HapticBench bench(kBlock, settings);
    ServoTick out;
    Cut cut;
    bench.tick({{0, 0, kTop + 1e-3}}, 1);
    for (int i = 0; i < static_cast<int>(1.5 * hz); ++i) {
      const double t = i / hz;
      const Pose hand{{2e-3 * std::sin(3 * t), 1e-3 * std::sin(7 * t), kTop + 0.5e-3 - 0.9e-3 * std::sin(5 * t)}};
      bench.tick(hand, t < 1.2 ? 1 : 0);
    }
    EXPECT_GT(bench.min_energy, -1e-9) << hz;
    EXPECT_GT(bench.last.cuts, 0u);
    const test::NoAlloc guard;
    for (int i = 0; i < 50; ++i) bench.servo.tick({bench.t + i * 1'000'000, {{0, 0, kTop + 0.4e-3}}, 1}, out, cut);
    EXPECT_EQ(guard.count(), 0u) << hz;
  }
}

TEST(IntermediateSurface, WithoutCutsItFeelsLikeTheTissue) {
  const auto slide = [](const ServoSettings& settings) {
    HapticBench bench(kBlock, settings);
    std::vector<dvec3> forces;
    for (int i = 0; i < 500; ++i) {
      bench.tick({{1e-5 * i - 1e-3, 2e-6 * i, kTop + 0.6e-3 - 1e-6 * std::min(i, 300)}}, 0);
      forces.push_back(bench.last.f_T_W);
    }
    return forces;
  };
  EXPECT_EQ(slide(settings_with({})), slide(test::drill_settings("offset")));
}

}  // namespace
}  // namespace typodont
