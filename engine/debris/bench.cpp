#include "engine/debris/bench.h"

#include <fmt/format.h>

#include <algorithm>

#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "engine/debris/debris.h"
#include "engine/debris/motion/motion.h"
#include "engine/debris/spray.h"

namespace typodont::debris {
std::vector<BenchRow> bench_debris(const BenchOptions& options) {
  // A ball of 5 mm radius in a box of 4 cm.
  constexpr int n = 81;
  std::vector<float> samples(n * n * n);
  for (int x = 0; x < n; ++x) {
    for (int y = 0; y < n; ++y) {
      for (int z = 0; z < n; ++z) {
        samples[static_cast<std::size_t>((x * n + y) * n + z)] =
            static_cast<float>(glm::length(glm::dvec3(x - 40, y - 40, z - 40) * 5e-4) - 5e-3);
      }
    }
  }
  CoarseField field;
  field.origin = glm::dvec3(-0.02);
  field.size = glm::ivec3(n);
  field.distance = samples.data();

  const double dt = 1.0 / 250;
  const std::string knob = fmt::format("{} particles", options.particles);
  std::vector<BenchRow> rows;
  std::vector<float> arrays[7];
  for (auto& array : arrays) array.assign(options.particles, 1.0f);
  const MeasuredTimes floor = measure(options.repeats, [&] {
    copy_through({arrays[0].data(), arrays[1].data(), arrays[2].data(), arrays[3].data(), arrays[4].data(),
                  arrays[5].data(), arrays[6].data()},
                 options.particles);
  });
  rows.push_back({"memory floor", knob, BenchRow::kNone, "", floor.median, "step"});

  MaterialTable materials{};
  for (auto& material : materials) material.density = 2900;
  auto run = [&](const char* name, int steps_before, const Suction* suction) {
    Debris debris({.capacity = options.particles, .lifetime = 1e6});
    for (std::uint64_t i = 1; debris.alive() < options.particles; ++i) {
      Cut cut;
      cut.index = i;
      cut.removed[static_cast<int>(Tissue::kEnamel)] = 32e-12;
      cut.X_WA.p = cut.X_WB.p = {0, 0, 5.4e-3};
      cut.n_C_W = {0, 0, 1};
      cut.spindle = 300 * kKrpm;
      debris.emit(cut, 0.6e-3, materials);
      if (i % 4 == 0) debris.step(dt, field);
    }
    for (int i = 0; i < steps_before; ++i) debris.step(dt, field, suction);
    const MeasuredTimes step = measure(options.repeats, [&] { debris.step(dt, field, suction); });
    rows.push_back({name, knob, BenchRow::kNone, "", step.median, "step", "memory floor", step.median / floor.median});
  };
  run("step", 250, nullptr);
  run("step while drilling", 0, nullptr);
  const Suction suction{{0.01, 0.01, 0.012}, 5e-3, 4e-3};
  run("step with suction", 250, &suction);

  Debris none;
  const MeasuredTimes idle = measure(options.repeats, [&] { none.step(dt, field); });
  rows.push_back({"none alive", "0 particles", BenchRow::kNone, "", idle.median, "step", "memory floor",
                  idle.median / floor.median});
  // Water on a ball of 5 mm radius, per frame at 30 Hz, on the program's grid.
  constexpr double kFrame = 1.0 / 30;
  constexpr int kFine = 41;
  CoarseField fine;
  fine.spacing = 3e-4;
  fine.origin = glm::dvec3(-fine.spacing * (kFine - 1) / 2);
  fine.size = glm::ivec3(kFine);
  std::vector<float> fine_samples;
  for (int x = 0; x < kFine; ++x)
    for (int y = 0; y < kFine; ++y)
      for (int z = 0; z < kFine; ++z)
        fine_samples.push_back(
            static_cast<float>(glm::length(fine.origin + fine.spacing * glm::dvec3(x, y, z)) - 5e-3));
  fine.distance = fine_samples.data();
  const auto wet = [&](double flow, const char* name) {
    Film film(fine, materials);
    Spray spray({.flow = flow, .count = 4});
    SpraySource source;
    source.X_WT.p = {0, 0, 5.4e-3};
    source.head_radius = source.head_half = 0.6e-3;
    source.spindle = 300 * kKrpm;
    source.water = 1;
    for (int i = 0; i < 60; ++i) spray.step(kFrame, &source, fine, film), film.step(kFrame);
    const int repeats = std::max(options.repeats / 5, 5);
    const MeasuredTimes drops = measure(repeats, [&] { spray.step(kFrame, &source, fine, film); });
    const MeasuredTimes flows = measure(repeats, [&] { film.step(kFrame); });
    const std::string of = fmt::format("{} cells wet", film.loaded());
    rows.push_back({fmt::format("{}: droplets", name), of, BenchRow::kNone, "", drops.median, "step", "memory floor",
                    drops.median / floor.median});
    rows.push_back({fmt::format("{}: film", name), of, BenchRow::kNone, "", flows.median, "step", "memory floor",
                    flows.median / floor.median});
  };
  wet(50e-6 / 60, "spray of 50 ml/min");
  wet(15e-6 / 60, "spray of 15 ml/min");
  return rows;
}

}  // namespace typodont::debris
