#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/base/dispatch.h"
#include "haptics/bench/rows.h"
#include "haptics/bench/timing.h"
#include "haptics/cut_front.h"
#include "haptics/cutting/carve.h"

namespace typodont::haptics::bench {

namespace {

/// Consecutive samples along z whose values a cut changed. To find them, the patches (copies of the field around the
/// tool) before and after the cut are compared.
struct Stretch {
  std::size_t from, count;
};
std::vector<Stretch> changed_stretches(const SurfacePatch& before, const SurfacePatch& after) {
  std::vector<Stretch> list;
  for (std::size_t i = 0; i < after.distance.size(); ++i) {
    if (after.distance[i] == before.distance[i]) continue;
    if (!list.empty() && list.back().from + list.back().count == i) {
      ++list.back().count;
    } else {
      list.push_back({i, 1});
    }
  }
  return list;
}

/// Reads and writes groups of consecutive samples. Uses the longest vectors that the processor has.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void scan_groups(float* samples, const CutFront::Place* places, std::size_t groups, float least) {
  for (std::size_t g = 0; g < groups; ++g) {
    float* const group = samples + places[g].at;
    for (int half = 0; half < places[g].lanes; half += 8) {
      for (int i = half; i < half + 8; ++i) group[i] = std::max(group[i], least);
    }
  }
}

}  // namespace

double drilling_floor(const DenseTissue& dense, const ServoSettings& settings, int ticks) {
  const Tool& tool = settings.tool;
  std::vector<double> queries, scans;
  const std::vector<double> cuts = least_of([&] {
    Scene scene(dense, settings);
    DrillingHand hand(tool);
    SurfacePatch patch;
    CutFront front(std::span(&tool, 1), dense.frame.voxel);
    Pose end;
    std::vector<double> run;
    for (int i = 0; i < ticks; ++i) {
      const Pose X_WT = hand.next(scene.last.f_T_W, settings.tick);
      if (scene.renew_patch(X_WT)) patch = scene.patch();
      const std::uint64_t before = scene.last.cuts;
      scene.tick(X_WT, 1);
      const bool made = scene.last.cuts > before;
      const Nanos start = thread_cpu_time();
      if (made) {
        const Cut& cut = scene.cut;
        carve(patch, Sweep(tool, cut.X_WA, cut.X_WB, dense.frame, before > 0 && same(cut.X_WA, end)), nullptr, &front);
      }
      run.push_back(static_cast<double>(thread_cpu_time() - start));
      if (made) end = scene.cut.X_WB;
    }
    const dvec3 c = dense.frame.to_voxels(end.p);
    queries.push_back(batch_ns(51, 256, [&](int k) { sample_cubic(patch, c + dvec3(1e-3 * k)); }));
    const std::vector<CutFront::Place> groups = front.listed_in(patch.lo, patch.n);
    scans.push_back(batch_ns(51, 16, [&](int k) {
      scan_groups(patch.distance.data(), groups.data(), groups.size(), 1e-9f * static_cast<float>(k) - 9);
    }));
    return run;
  });
  return quantile(cuts, 0.5) + quantile(queries, 0.5) + quantile(scans, 0.5);
}

void cut_rows(const Tool& tool, const std::string& knob, const DenseTissue& dense, std::vector<BenchRow>& rows) {
  Carver carver(TissueVolume(dense), std::span(&tool, 1));
  SurfacePatch patch;
  patch.resize(patch_edge_for(std::span(&tool, 1), dense.frame.voxel));
  // Each cut moves the head by 0.03 voxel, as in drilling. The lists of samples near the head (the active front) are
  // renewed from time to time. During this number of cuts, each list is renewed once.
  constexpr int kCycle = 34;
  const double way = 0.03 * dense.frame.voxel;
  const auto at = [&](int i) {
    return Pose{dvec3(0, 0, kBlockTop + tool.length / 2 - 0.4e-3) + way * i * glm::normalize(dvec3(0.5, 0.2, -0.6))};
  };
  carver.take_snapshot(at(0).p, patch);
  CutFront front(std::span(&tool, 1), dense.frame.voxel);
  carve(patch, Sweep(tool, at(0), at(0), dense.frame), nullptr, &front);
  int step = 0;
  const auto cut_on = [&](int) {
    carve(patch, Sweep(tool, at(step), at(step + 1), dense.frame, true), nullptr, &front);
    ++step;
  };
  for (int i = 0; i < 2 * kCycle; ++i) cut_on(i);
  const SurfacePatch before = patch;
  cut_on(0);
  const std::vector<Stretch> stretches = changed_stretches(before, patch);
  const std::vector<CutFront::Place> groups = front.listed_in(patch.lo, patch.n);
  double samples = 0;
  for (const Stretch& s : stretches) samples += static_cast<double>(s.count);
  const double scan = batch_ns(51, 16, [&](int k) {
    const float rise = 1e-9f * static_cast<float>(k);
    for (const Stretch& s : stretches) {
      for (std::size_t i = s.from; i < s.from + s.count; ++i) patch.distance[i] = std::max(patch.distance[i], rise - 9);
    }
  });
  const double same = batch_ns(51, 16, [&](int k) {
    scan_groups(patch.distance.data(), groups.data(), groups.size(), 1e-9f * static_cast<float>(k) - 9);
  });
  const double cut = batch_ns(5, kCycle, cut_on);
  double lanes = 0;
  for (const CutFront::Place& place : groups) lanes += place.lanes;
  rows.push_back({"floor: scan of the samples a cut changes", knob, BenchRow::kNone, "", scan, "cut", "",
                  BenchRow::kNone, samples, "samples"});
  rows.push_back({"floor: scan of the samples a cut reads and writes", knob, BenchRow::kNone, "", same, "cut", "",
                  BenchRow::kNone, lanes, "samples"});
  rows.push_back(
      {"cut alone, 0.03 voxel", knob, BenchRow::kNone, "", cut, "cut", "the scan", cut / scan, samples, "samples"});
  rows.push_back({"cut alone, 0.03 voxel, by what it reads and writes", knob, BenchRow::kNone, "", cut, "cut",
                  "that scan", cut / same, lanes, "samples"});
}

}  // namespace typodont::haptics::bench
