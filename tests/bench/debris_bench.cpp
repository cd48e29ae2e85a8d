// A step of all chips, against one pass through their memory, and a step of water.
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "engine/debris/debris.h"
#include "engine/debris/film.h"
#include "engine/debris/spray.h"
#include "tests/bench/bench.h"

namespace typodont::bench {

namespace {

using namespace debris;

/// The distance field of a ball of 5 mm.
struct BallField {
  std::vector<float> samples;
  CoarseField field;
  BallField(int n, double spacing) {
    field.spacing = spacing;
    field.origin = glm::dvec3(-spacing * (n - 1) / 2);
    field.size = glm::ivec3(n);
    for_each_voxel(glm::ivec3(n), [&](int x, int y, int z) {
      samples.push_back(static_cast<float>(glm::length(field.origin + spacing * glm::dvec3(x, y, z)) - 5e-3));
    });
    field.distance = samples.data();
  }
};

MaterialTable materials() {
  MaterialTable table{};
  for (Material& material : table) material.density = 2900;
  return table;
}

std::size_t particles() {
  return smoke() ? 2000 : 100'000;
}

/// Reads and writes the positions and velocities of all chips once, ns.
double memory_pass() {
  std::vector<float> a[7];
  for (auto& array : a) array.assign(particles(), 1.0f);
  return measure(smoke() ? 3 : 500,
                 [&] {
                   for (int k = 0; k < 3; ++k) {
                     float *const x = a[k].data(), *const v = a[3 + k].data(), *const keep = a[6].data();
                     for (std::size_t i = 0; i < particles(); ++i) v[i] += keep[i], x[i] += v[i];
                   }
                 })
      .median;
}

/// `before`: steps after the last chip was made.
void chips(benchmark::State& state, int before, const Suction* suction, double limit) {
  const BallField ball(81, 5e-4);
  Debris debris({.capacity = particles(), .lifetime = 1e6});
  for (std::uint64_t i = 1; debris.alive() < particles(); ++i) {
    Cut cut;
    cut.index = i;
    cut.removed[static_cast<int>(Tissue::kEnamel)] = 32e-12;
    cut.X_WA.p = cut.X_WB.p = {0, 0, 5.4e-3};
    cut.n_C_W = {0, 0, 1};
    cut.spindle = 300 * kKrpm;
    debris.emit(cut, {.head_radius = 0.6e-3}, materials());
    if (i % 4 == 0) debris.step(1.0 / 250, ball.field);
  }
  for (int i = 0; i < before; ++i) debris.step(1.0 / 250, ball.field, suction);
  double ratio = 1e9, ns = 1e9;
  for (int run = 0; run < runs(); ++run) {
    const double step = measure(smoke() ? 3 : 300, [&] { debris.step(1.0 / 250, ball.field, suction); }).median;
    ns = std::min(ns, step), ratio = std::min(ratio, step / memory_pass());
  }
  set_time(state, ns);
  state.counters["memory_passes"] = ratio;
  require_time(ratio < limit, fmt::format("a step takes at most {:g} passes through the memory", limit));
}

/// Droplets and film of a spray on a wet ball, in the steps of World. `flow`: m³/s. Error: of the water on the ball,
/// from a film with so many substeps that none is limited.
void water(benchmark::State& state, double flow) {
  struct WetBall {
    BallField ball{25, 5e-4};
    Film film;
    Spray spray;
    SpraySource source;
    WetBall(double flow, const FilmOptions& options)
        : film(ball.field, materials(), options), spray({.flow = flow, .count = 4}) {
      source.X_WT.p = {0, 0, 5.4e-3};
      source.head_radius = source.head_half = 0.6e-3;
      source.spindle = 300 * kKrpm;
      source.water = 1;
      for (int i = 0; i < (smoke() ? 5 : 120); ++i) step();
    }
    void step() { spray.step(1.0 / 60, &source, ball.field, film), film.step(1.0 / 60); }
    double held() const { return film.ledger().on_surface.water; }
  };
  WetBall wet(flow, {});
  state.counters["error_of_water"] = wet.held() / WetBall(flow, {.max_substeps = smoke() ? 24 : 1000}).held() - 1;
  const double ns = measure(smoke() ? 3 : 100, [&] { wet.step(); }).median;
  set_time(state, ns);
  state.counters["wet_cells"] = static_cast<double>(wet.film.loaded());
  require_time(ns < 2.5e6, "water takes at most a sixth of a step's time");
}

}  // namespace

void add_cases() {
  static const Suction suction{{0.01, 0.01, 0.012}, 5e-3, 4e-3};
  add("100,000 chips/one second old", [](benchmark::State& state) { chips(state, smoke() ? 2 : 250, nullptr, 2.5); });
  add("100,000 chips/while drilling", [](benchmark::State& state) { chips(state, 0, nullptr, 20); });
  add("100,000 chips/with suction", [](benchmark::State& state) { chips(state, smoke() ? 2 : 250, &suction, 3); });
  add("spray and film/50 ml per min", [](benchmark::State& state) { water(state, 50e-6 / 60); });
  add("spray and film/15 ml per min", [](benchmark::State& state) { water(state, 15e-6 / 60); });
}

}  // namespace typodont::bench
