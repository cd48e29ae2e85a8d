#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "haptics/bench/rows.h"
#include "haptics/bench/timing.h"
#include "haptics/cutting/carve.h"
#include "haptics/volume/csg_baseline.h"

namespace typodont::haptics::bench {

void removal_rows(const BenchOptions& options, std::vector<BenchRow>& rows) {
  constexpr int kSteps = 20;
  const Tool tool = head(HeadShape::kSphere, 1.2e-3, 1.2e-3);
  const double r = tool.radius(), depth = 0.43e-3, length = 1e-3;
  const dvec3 a(-0.513e-3, 0.027e-3, kBlockTop + r - depth);
  const auto at = [&](int i) { return a + dvec3(length * i / kSteps, 0, 0); };
  // The exact volume of the stroke: a circular segment along the path, and half a spherical cap at each end.
  const double segment = r * r * std::acos((r - depth) / r) - (r - depth) * std::sqrt(2 * r * depth - depth * depth);
  const double exact = segment * length + kPi * depth * depth * (r - depth / 3);
  for (const double voxel_mm : options.voxels_mm) {
    const std::string knob = fmt::format("voxel {:g} mm", voxel_mm);
    const DenseTissue dense = tissue(kBlock, voxel_mm);
    const auto run = [&](auto&& volume, auto&& cut) {
      const double before = volume();
      std::vector<double> times;
      for (int i = 0; i <= kSteps; ++i) {
        const Nanos start = thread_cpu_time();
        cut(i);
        times.push_back(static_cast<double>(thread_cpu_time() - start));
      }
      return std::pair{std::abs((before - volume()) / exact - 1), quantile(times, 0.5)};
    };
    CsgBaseline csg(dense);
    const auto [csg_error, csg_ns] = run([&] { return csg.volume(); }, [&](int i) { csg.cut_ball(at(i), r); });
    rows.push_back({"removal, OpenVDB csgDifference", knob, csg_error, "of the volume", csg_ns, "cut"});

    // Removes whole voxels, as programs based on CHAI3D do: either all voxels within the head at once, or one voxel per
    // tick.
    const double voxel3 = std::pow(dense.frame.voxel, 3);
    const auto clear = [&](const char* name, bool one) {
      std::vector<char> full;
      for (const float d : dense.distance) full.push_back(d < 0);
      const auto [error, ns] =
          run([&] { return voxel3 * static_cast<double>(std::count(full.begin(), full.end(), 1)); },
              [&](int i) {
                const dvec3 c = dense.frame.to_voxels(at(i));
                const double reach = r / dense.frame.voxel;
                const glm::ivec3 lo = glm::max(glm::ivec3(glm::ceil(c - reach)), 0);
                const glm::ivec3 hi = glm::min(glm::ivec3(glm::floor(c + reach)), dense.size - 1);
                double nearest = reach * reach;
                char* first = nullptr;  // the voxel that is nearest to the head's centre
                for (int x = lo.x; x <= hi.x; ++x) {
                  for (int y = lo.y; y <= hi.y; ++y) {
                    for (int z = lo.z; z <= hi.z; ++z) {
                      const dvec3 d = c - dvec3(x, y, z);
                      char& voxel = full[dense.at(x, y, z)];
                      if (!voxel || glm::dot(d, d) > nearest) continue;
                      if (!one) {
                        voxel = 0;
                      } else {
                        first = &voxel, nearest = glm::dot(d, d);
                      }
                    }
                  }
                }
                if (first) *first = 0;
              });
      rows.push_back({name, knob, error, "of the volume", ns, "cut"});
    };
    clear("removal, voxels cleared", false);
    clear("removal, one voxel a tick", true);

    if (!by_default(options)) {
      // Makes the same cuts in the tissue of the measured contact model (its TissueBody).
      const auto body = options.method->make_body(TissueVolume(dense), std::span(&tool, 1));
      const auto held = [&] {
        double all = 0;
        for (const double v : body->rasterize().volumes()) all += v;
        return all;
      };
      body->begin_stroke();
      const auto [error, ns] = run(held, [&](int i) {
        Cut cut;
        cut.X_WA = {at(std::max(i - 1, 0))}, cut.X_WB = {at(i)};
        body->carve(cut, i > 0);
      });
      rows.push_back({fmt::format("removal, {}", options.method->name()), knob, error, "of the volume", ns, "cut",
                      "csgDifference", ns / csg_ns});
      continue;
    }

    // Makes the cuts in the servo's patch (copy of the field around the tool), as a tick does.
    Carver carver(TissueVolume(dense), std::span(&tool, 1));
    SurfacePatch patch;
    patch.resize(2 * static_cast<int>(2e-3 / dense.frame.voxel) + 1);
    carver.take_snapshot(at(kSteps / 2), patch);
    double taken = 0;
    const auto [patch_error, patch_ns] =
        run([&] { return -taken; },
            [&](int i) {
              for (const double v : carve(patch, Sweep(tool, {at(std::max(i - 1, 0))}, {at(i)}, dense.frame, i > 0))) {
                taken += v * voxel3;
              }
            });
    rows.push_back({"removal, sweep in the servo's patch", knob, patch_error, "of the volume", patch_ns, "cut",
                    "csgDifference", patch_ns / csg_ns});

    TissueVolume volume(dense);
    const auto sum = [&] {
      double all = 0;
      for (const double v : volume.volumes()) all += v;
      return all;
    };
    const auto [error, ns] =
        run(sum, [&](int i) { volume.carve(Sweep(tool, {at(std::max(i - 1, 0))}, {at(i)}, dense.frame, i > 0)); });
    rows.push_back({"removal, sweep", knob, error, "of the volume", ns, "cut", "csgDifference", ns / csg_ns});
  }
}

}  // namespace typodont::haptics::bench
