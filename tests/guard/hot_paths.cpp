// Short runs of the loops that must stay fast. callgrind counts their instructions (guard_test.cpp). Preparation is not
// counted. Each path writes its own dump, which has the name of its trigger.
#include <valgrind/callgrind.h>

#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "audio/drill_synth.h"
#include "calibration/registration_solver.h"
#include "engine/app/assets.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/scene.h"
#include "engine/base/units.h"
#include "engine/debris/debris.h"
#include "tests/support/haptic_bench.h"

namespace typodont::test {
namespace {

using haptics::HeadShape;

/// Counts the instructions between its construction and its destruction. The dump has the name `path`; its counts are
/// for `units` of work.
class Counted {
 public:
  Counted(const char* path, int units) : label_(std::string(path) + "/" + std::to_string(units)) {
    CALLGRIND_ZERO_STATS;
    CALLGRIND_START_INSTRUMENTATION;
    CALLGRIND_TOGGLE_COLLECT;
  }
  ~Counted() {
    CALLGRIND_TOGGLE_COLLECT;
    CALLGRIND_STOP_INSTRUMENTATION;
    CALLGRIND_DUMP_STATS_AT(label_.c_str());
  }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;

 private:
  std::string label_;
};

constexpr std::string_view kBlock =
    R"({"voxel_mm": 0.05, "band_mm": 0.5, "domain_mm": [[-1.5, -1.5, -1], [1.5, 1.5, 1]],
  "solids": [{"tissue": "dentin", "solid": {"halfspace": {"normal": [0, 0, 1], "offset_mm": 0}}}]})";
constexpr std::string_view kBall =
    R"({"voxel_mm": 0.05, "band_mm": 0.5, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 1}}}]})";
constexpr std::string_view kBore = R"({"voxel_mm": 0.05, "band_mm": 0.5, "solids": [{"tissue": "enamel", "solid":
  {"difference": [{"sphere": {"radius_mm": 1}}, {"cylinder": {"center_mm": [0, 0, 1], "radius_mm": 0.6, "height_mm": 2}}]}}]})";

haptics::ServoSettings settings_of(HeadShape shape, double diameter, double length) {
  haptics::ServoSettings settings;
  settings.tool.shape = shape;
  settings.tool.diameter = diameter;
  settings.tool.length = length;
  settings.spindle.free_speed = 300 * kKrpm;
  return settings;
}

void free_air() {
  HapticBench bench(kBlock, settings_of(HeadShape::kSphere, 0.6e-3, 0.6e-3));
  const auto hand = [](int i) { return Pose{{1e-6 * i, 0, 0.9e-3}}; };
  bench.tick(hand(0));
  ServoTick out;
  Cut cut;
  Counted counted("free air", 200);  // the servo alone
  for (int i = 1; i <= 200; ++i) bench.servo.tick({bench.t + i * 1'000'000, hand(i)}, out, cut);
}

template <class Hand>
void sliding(const char* path, std::string_view tissue, Hand hand) {
  haptics::ServoSettings settings = settings_of(HeadShape::kSphere, 0.6e-3, 0.6e-3);
  settings.cutting = false;
  HapticBench bench(tissue, settings);
  for (int i = 0; i < 50; ++i) bench.tick(hand(i));
  ServoTick out;
  Cut cut;
  Counted counted(path, 200);  // the servo alone
  for (int i = 50; i < 250; ++i) bench.servo.tick({bench.t + (i - 50) * 1'000'000, hand(i)}, out, cut);
}

void sliding_on_ball() {
  sliding("sliding contact", kBall, [](int i) {
    const double a = 0.4 + 1.5e-3 * i;
    return Pose{1.25e-3 * dvec3(std::sin(a), 0.2, std::cos(a))};
  });
}

void sliding_on_rim() {
  sliding("sliding contact on a rim", kBore, [](int i) {
    const double a = 0.4 + 3e-3 * i;
    return Pose{dvec3(0.55e-3 * std::cos(a), 0.55e-3 * std::sin(a), 1.02e-3)};
  });
}

void drilling(const char* path, HeadShape shape, double diameter, double length) {
  HapticBench bench(kBlock, settings_of(shape, diameter, length));
  const auto hand = [&](int i) {
    return Pose{{2e-4 * std::sin(0.01 * i), 0, length / 2 + 2e-5 - 1.2e-6 * std::min(i, 200)}};
  };
  for (int i = 0; i < 100; ++i) bench.tick(hand(i), 1);
  Counted counted(path, 100);
  for (int i = 100; i < 200; ++i) bench.tick(hand(i), 1);
}

/// A flat end touches a flat surface. Almost every sample under the end can change in the first cut, and the servo has
/// no list of samples yet, so these ticks take much longer than the later ones.
void first_contact() {
  constexpr double kLength = 4e-3;
  HapticBench bench(kBlock, settings_of(HeadShape::kCylinder, 1e-3, kLength));
  const auto hand = [&](double height) { return Pose{{0, 0, kLength / 2 + height}}; };
  for (int i = 0; i < 10; ++i) bench.tick(hand(2e-5 - 2e-6 * i), 1);
  Counted counted("first contact, cylinder 1 x 4 mm", 4);
  for (int i = 0; i < 4; ++i) bench.tick(hand(-2e-5 - 1e-5 * i), 1);
}

/// A condenser moves around in the amalgam that it puts down, until the amalgam has reached its largest extent.
void filling() {
  constexpr std::string_view kCavity = R"({"voxel_mm": 0.05, "solids": [{"tissue": "dentin", "solid": {"difference": [
    {"box": {"size_mm": [5, 5, 3]}}, {"cylinder": {"center_mm": [0, 0, 1], "axis": [0, 0, 1], "radius_mm": 1.6, "height_mm": 3}}]}}]})";
  haptics::ServoSettings settings = settings_of(HeadShape::kCylinder, 0.8e-3, 3e-3);
  settings.tool.cuts = false;
  settings.tool.fill = Tissue::kAmalgam;
  settings.tool.fill_rate = 8 * kCubicMillimetre;
  settings.tool.fill_reach = 1.2e-3;
  HapticBench bench(kCavity, settings);
  const auto hand = [](int i) { return Pose{{4e-5 * std::sin(0.05 * i), 4e-5 * std::cos(0.05 * i), 1.3e-3}}; };
  for (int i = 0; i < 400; ++i) bench.tick(hand(i), i > 20 ? 1 : 0);
  ServoTick out;
  Cut cut;
  Counted counted("filling, condenser 0.8 mm", 20);  // without the carver
  for (int i = 400; i < 420; ++i) bench.servo.tick({bench.t + (i - 400) * 1'000'000, hand(i), 1}, out, cut);
}

void meshing() {
  HapticBench bench(kBlock, settings_of(HeadShape::kSphere, 0.8e-3, 0.8e-3));
  TissueView view;
  haptics::TissueVolume volume(haptics::read_solids(Json::parse(kBlock, "tissue")));
  (void)view.update(volume);
  const VoxelFrame frame = volume.frame();
  Counted counted("mesh of a cut", 10);
  for (int i = 0; i < 10; ++i) {
    const Pose at{{1e-5 * i, 0, 0.3e-3}};
    volume.carve(haptics::Sweep(bench.settings.tool, at, at, frame));
    (void)view.update(volume);
  }
}

void sound() {
  const auto models = audio::load_sound_models(assets_folder() / "sounds/micromotor.json");
  audio::DrillSynth synth(models, 48000, 1);
  std::vector<float> block(480);
  audio::SoundState state;
  state.spindle = 3000;
  state.pedal = 1;
  state.contact_area = 1e-6;
  state.force = 1;
  state.removal_rate = 1e-10;
  state.tissue = Tissue::kEnamel;
  synth.push(state);
  synth.render(block);
  Counted counted("sound of 10 ms", 20);
  for (int i = 0; i < 20; ++i) synth.render(block);
}

void debris_step() {
  debris::Debris debris({.capacity = 5000});
  MaterialTable materials = plain_materials();
  for (std::uint64_t i = 1; debris.alive() < 5000; ++i) {
    Cut cut;
    cut.index = i;
    cut.removed[static_cast<int>(Tissue::kEnamel)] = 32e-12;
    cut.n_C_W = {0, 0, 1};
    cut.spindle = 300 * kKrpm;
    debris.emit(cut, {.head_radius = 0.6e-3}, materials);
  }
  debris.step(0.01, {});
  Counted counted("debris, 5000 particles", 10);
  for (int i = 0; i < 10; ++i) debris.step(0.004, {});
}

void registration() {
  std::vector<dvec3> h, d;
  for (int i = 0; i < 16; ++i) {
    h.push_back(0.04 * dvec3(std::sin(1.0 * i), std::sin(2.3 * i), std::sin(4.1 * i)));
    d.push_back(dquat(0.9, 0.1, 0.3, 0.3) * h.back() + dvec3(0.1, 0.2, 0.3) + 1e-4 * dvec3(std::cos(7.0 * i)));
  }
  Pose X;
  Counted counted("registration of 16 points", 100);
  for (int i = 0; i < 100; ++i) X = calibration::fit_rigid(h, d);
}

}  // namespace
}  // namespace typodont::test

int main() {
  using namespace typodont::test;
  free_air();
  sliding_on_ball();
  sliding_on_rim();
  drilling("drilling, round 0.6 mm", HeadShape::kSphere, 0.6e-3, 0.6e-3);
  drilling("drilling, round 1.2 mm", HeadShape::kSphere, 1.2e-3, 1.2e-3);
  drilling("drilling, flame 0.8 x 1.5 mm", HeadShape::kFlame, 0.8e-3, 1.5e-3);
  first_contact();
  filling();
  meshing();
  sound();
  debris_step();
  registration();
  return 0;
}
