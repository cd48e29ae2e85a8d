// Measures the contact model "vertex" (vertex deformation, paper S4 in docs/papers.md): the times of ticks of a tool
// that slides over a dental arch, and of a tool that cuts it, for several numbers of vertices.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "haptics/bench.h"
#include "haptics/bench/cavity_rows.h"
#include "haptics/bench/timing.h"
#include "haptics/contact/mesh_lod/mesh_levels.h"
#include "haptics/contact_method.h"
#include "haptics/lockstep.h"
#include "haptics/solid.h"

namespace typodont::haptics {

namespace {

constexpr double kBur = 0.6e-3;    // m, radius of a round bur
constexpr int kApproach = 500;     // number of ticks in which the hand moves from the air into the surface
constexpr double kDepth = 0.1e-3;  // m, depth of a sliding probe below the surface; a bur sinks three times as deep

TissueVolume with_mesh(TissueMesh mesh) {
  TissueVolume volume(read_solids(Json::parse(
      R"({"voxel_mm": 1, "band_mm": 4, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [4, 4, 4]}}}]})",
      "bench")));
  volume.set_mesh(std::make_shared<const TissueMesh>(std::move(mesh)));
  return volume;
}

/// Returns the times of the servo's ticks after the approach, ns. A round bur oscillates on the highest cusp. The time
/// of a tick is its shortest time over several equal runs.
std::vector<double> tick_times(const TissueMesh& mesh, bool cuts, int ticks) {
  const dvec3 top = *std::ranges::max_element(mesh.vertices, {}, &dvec3::z);
  ServoSettings settings;
  settings.tool.diameter = settings.tool.length = 2 * kBur;
  settings.cutting = cuts;
  settings.spindle.free_speed = 300'000 * 2 * kPi / 60;  // rad/s, speed of the spindle without load
  settings.materials.fill({1000, 20e9, 0.2, 0.15, 2900, dvec3(0.9)});
  settings.method = read_contact_method(Json::parse(R"({"vertex": {"edge_mm": 0.1}})", "bench"));
  return bench::least_of([&] {
    LockStep steps(with_mesh(mesh), settings);
    std::vector<double> times;
    ServoTick tick;
    Cut cut;
    HandSample hand;
    hand.pedal = cuts ? 1 : 0;
    for (int i = 0; i < kApproach + ticks; ++i) {
      hand.t += 1'000'000;
      const double down = kDepth * std::min(i, kApproach) / kApproach;
      hand.X_WT.p =
          top + dvec3(0.4e-3 * std::sin(0.004 * i), 0, kBur + 0.05e-3 - down - (cuts ? 2 * kDepth : 0) * down / kDepth);
      steps.tick(hand, tick, cut);
      if (i >= kApproach) times.push_back(static_cast<double>(tick.cpu_time));
    }
    return times;
  });
}

}  // namespace

std::vector<BenchRow> bench_vertex(const TissueMesh& arch, bool quick) {
  std::vector<BenchRow> rows;
  const std::vector<std::size_t> sizes =
      quick ? std::vector<std::size_t>{53'000} : std::vector<std::size_t>{13'288, 53'000, 212'000, 1'000'000};
  for (const bool cuts : {false, true}) {
    double first = 0;
    for (const std::size_t size : sizes) {
      const TissueMesh mesh = mesh_lod::without_double_faces(mesh_lod::base_mesh(arch, {size, {}}));
      const std::vector<double> times = tick_times(mesh, cuts, quick ? 2000 : 10'000);
      const double median = quantile(times, 0.5);
      if (size == 53'000) first = median;
      const auto row = [&](const char* what, double ns) {
        BenchRow r;
        r.name = fmt::format("{} the arch, {}", cuts ? "carve" : "slide on", what);
        r.knob = fmt::format("round 1.2 mm, edge 0.1 mm, {} vertices", mesh.vertices.size());
        r.time_ns = ns, r.per = "tick";
        r.size = static_cast<double>(mesh.vertices.size()), r.size_unit = "vertices";
        return r;
      };
      rows.push_back(row("median", median));
      if (first > 0) rows.back().baseline = "53,000 vertices", rows.back().ratio = median / first;
      rows.push_back(row("99.9 %", quantile(times, 0.999)));
    }
  }
  bench::cavity_rows("vertex", true, quick, rows);
  if (!quick) bench::large_cavity_rows("vertex", rows);
  return rows;
}

}  // namespace typodont::haptics
