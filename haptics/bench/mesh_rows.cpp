// Measures the contact with triangle meshes that have levels of detail (paper S3 in docs/papers.md): the time of a tick
// of a sliding tool, for several numbers of vertices.
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
#include "haptics/contact/mesh_lod/surface_point.h"
#include "haptics/contact_method.h"
#include "haptics/lockstep.h"
#include "haptics/solid.h"

namespace typodont::haptics {

namespace {

using namespace mesh_lod;

constexpr double kSpeed = 30e-3;   // m/s, speed of the hand
constexpr double kDepth = 0.3e-3;  // m, depth of the hand below the surface
// m, radii of the sliding tips: almost 0, like the point in paper S3, and the radius of an explorer (pointed dental
// probe)
constexpr double kTips[] = {1e-9, 0.125e-3};
constexpr int kTurn = 60;        // number of ticks after which the hand changes its direction
constexpr int kSlidePasses = 6;  // number of passes over each mesh
constexpr int kApproach = 100;   // number of ticks in which the hand moves from the air to the surface

/// Returns the path of a hand over the mesh. The path is computed on one level of detail of the mesh. All levels of
/// detail are then measured with this path.
std::vector<dvec3> path_over(const TriangleGrid& grid, double tip, int ticks) {
  dvec3 top(0, 0, -1e300);
  for (std::uint32_t i = 0; i < grid.size(); ++i)
    if (grid.face(i).a.z > top.z) top = grid.face(i).a;
  SurfaceOptions options;
  options.radius = tip;
  Stiffness even;
  even.fill(1000);
  SurfacePoint point(options, even);
  point.put(grid, top + dvec3(0, 0, 1e-3));
  std::vector<dvec3> path;
  dvec3 hand = top + dvec3(0, 0, 1e-3), n(0, 0, 1);
  for (int i = 0; i < ticks; ++i) {
    if (i < kApproach) {
      hand = top + dvec3(0, 0, tip + 0.2e-3 - (kDepth + 0.2e-3) * i / (kApproach - 1));
    } else {
      // rad; the angle is a multiple of the golden angle, so that the direction never repeats
      const double turn = 2.4 * (i / kTurn);
      const dvec3 ahead(std::cos(turn), std::sin(turn), 0);
      const dvec3 along = ahead - glm::dot(ahead, n) * n;
      hand = point.place() - kDepth * n + kSpeed * 1e-3 * along;
    }
    path.push_back(hand);
    point.follow(grid, hand);
    if (point.touching()) n = glm::normalize(point.place() - hand);
  }
  return path;
}

TissueVolume with_mesh(TissueMesh mesh) {
  TissueVolume volume(read_solids(Json::parse(
      R"({"voxel_mm": 0.5, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [4, 4, 4]}}}]})", "bench")));
  volume.set_mesh(std::make_shared<const TissueMesh>(std::move(mesh)));
  return volume;
}

struct Bur {
  const char* name;
  HeadShape shape;
  double diameter, length;  // m, diameter and length of the bur's head
};
constexpr Bur kBurs[] = {{"round 1.2 mm", HeadShape::kSphere, 1.2e-3, 1.2e-3},
                         {"cylinder 1.0 x 4 mm", HeadShape::kCylinder, 1.0e-3, 4e-3},
                         {"cone 1.2 x 4 mm", HeadShape::kCone, 1.2e-3, 4e-3},
                         {"flame 1.0 x 4 mm", HeadShape::kFlame, 1.0e-3, 4e-3}};

/// Measures servo and carver (owner of the tissue) while a bur sinks into the highest cusp and oscillates there.
void cutting_rows(const TissueMesh& mesh, const Bur& bur, bool quick, std::vector<BenchRow>& rows) {
  const dvec3 top = *std::ranges::max_element(mesh.vertices, {}, &dvec3::z);
  ServoSettings settings;
  settings.tool.shape = bur.shape;
  settings.tool.diameter = bur.diameter, settings.tool.length = bur.length;
  settings.spindle.free_speed = 300'000 * 2 * kPi / 60;  // rad/s, speed of the spindle without load
  settings.materials.fill({1000, 20e9, 0.2, 0.15, 2900, dvec3(0.9)});
  settings.method = read_contact_method(Json::parse(R"("mesh_lod")", "bench"));
  std::vector<double> servo, carver;
  // All passes do the same work. Interrupts make single ticks longer. So the shortest time of a tick over all passes is
  // its time without interrupts.
  for (int pass = 0; pass < (quick ? 1 : bench::kRuns); ++pass) {
    LockStep steps(with_mesh(mesh), settings);
    ServoTick tick;
    Cut cut;
    HandSample hand;
    hand.pedal = 1;
    const int ticks = quick ? 1000 : 4000;
    if (pass == 0) servo.assign(static_cast<std::size_t>(ticks), 1e18), carver = servo;
    for (int i = 0; i < ticks; ++i) {
      hand.t += 1'000'000;
      hand.X_WT.p = top + dvec3(0.4e-3 * std::sin(0.004 * i), 0, bur.length / 2 + 0.05e-3 - std::min(i, 500) * 1e-6);
      const Nanos start = thread_cpu_time();
      steps.tick(hand, tick, cut);
      const auto all = static_cast<double>(thread_cpu_time() - start), own = static_cast<double>(tick.cpu_time);
      const auto k = static_cast<std::size_t>(i);
      servo[k] = std::min(servo[k], own), carver[k] = std::min(carver[k], all - own);
    }
  }
  const auto row = [&](const char* name, double ns) {
    BenchRow r;
    r.name = name, r.knob = fmt::format("{}, 33140 vertices", bur.name), r.time_ns = ns, r.per = "tick";
    rows.push_back(r);
  };
  row("cutting, servo, median", quantile(servo, 0.5));
  row("cutting, servo, 99.9 %", quantile(servo, 0.999));
  row("cutting, geometry (mesh, and at 30 Hz a snapshot), median", quantile(carver, 0.5));
  row("cutting, geometry, longest: the loop's rate is at least its inverse", *std::ranges::max_element(carver));
}

/// Measures each tick (ns) while a tip slides along the path. `least` contains the shortest time of each tick in all
/// passes so far; the function updates it.
void slide(const TissueMesh& mesh, double tip, const std::vector<dvec3>& path, std::vector<double>& least) {
  ServoSettings settings;
  settings.tool.diameter = settings.tool.length = 2 * tip;
  settings.tool.cuts = false;
  settings.materials.fill({1000, 30e9, 0.2, 0.15, 2900, dvec3(0.9)});
  settings.method = read_contact_method(
      Json::parse(fmt::format(R"({{"mesh_lod": {{"levels": [{}]}}}})", vertex_count(mesh)), "bench"));
  LockStep steps(with_mesh(mesh), settings);
  const double clock = bench::clock_ns();
  std::vector<double> run;
  ServoTick tick;
  Cut cut;
  HandSample hand;
  for (const dvec3& p : path) {
    hand.t += 1'000'000;
    hand.X_WT.p = p;
    const Nanos start = thread_cpu_time();
    steps.tick(hand, tick, cut);
    run.push_back(std::max(static_cast<double>(thread_cpu_time() - start) - clock, 0.0));
  }
  run.erase(run.begin(), run.begin() + kApproach);
  if (least.empty()) least = run;
  for (std::size_t i = 0; i < run.size(); ++i) least[i] = std::min(least[i], run[i]);
}

}  // namespace

std::vector<BenchRow> bench_mesh_lod(const TissueMesh& arch, bool quick) {
  std::vector<BenchRow> rows;
  const std::vector<std::size_t> sizes =
      quick ? std::vector<std::size_t>{7443, 33140} : std::vector<std::size_t>{7443, 13306, 33140, 143865, 212000};
  const int ticks = quick ? 2000 : 10'000;
  const auto reference = make_levels(arch, {33140, {33140}});
  for (const double tip : kTips) {
    const std::vector<dvec3> path = path_over(reference->grids.front(), tip, ticks);
    std::vector<TissueMesh> meshes;
    for (const std::size_t size : sizes) meshes.push_back(base_mesh(arch, {size, {}}));
    // The meshes are measured in turn, one pass each, again and again. So other work on the machine affects all meshes
    // equally, and does not change the ratios of their times.
    std::vector<std::vector<double>> least(sizes.size());
    for (int pass = 0; pass < (quick ? 1 : kSlidePasses); ++pass) {
      for (std::size_t k = 0; k < sizes.size(); ++k) slide(meshes[k], tip, path, least[k]);
    }
    double first = 0;
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      const TissueMesh& mesh = meshes[k];
      const std::vector<double>& times = least[k];
      const std::string knob = fmt::format("{}, {} vertices", tip < 1e-6 ? "a point" : "explorer", vertex_count(mesh));
      const double median = quantile(times, 0.5), slow = quantile(times, 0.999);
      if (first == 0) first = median;
      const auto row = [&](const char* name, double ns) {
        BenchRow r;
        r.name = name, r.knob = knob, r.time_ns = ns, r.per = "tick";
        r.size = static_cast<double>(vertex_count(mesh)), r.size_unit = "vertices";
        return r;
      };
      rows.push_back(row("slide on the arch, median", median));
      rows.back().baseline = "the coarsest", rows.back().ratio = median / first;
      rows.push_back(row("slide on the arch, 99.9 %", slow));
      if (tip != kTips[0]) continue;
      const TriangleGrid grid(mesh);
      BenchRow memory;
      memory.name = "memory, grid included", memory.knob = knob;
      memory.error = static_cast<double>(grid.bytes()) / static_cast<double>(grid.size());
      memory.error_unit = "bytes a triangle";
      rows.push_back(memory);
    }
  }
  const TissueMesh mesh = base_mesh(arch, {33140, {}});
  for (const Bur& bur : kBurs) cutting_rows(mesh, bur, quick, rows);
  bench::cavity_rows("mesh_lod", !quick, quick, rows);
  return rows;
}

}  // namespace typodont::haptics
