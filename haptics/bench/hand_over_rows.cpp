#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "haptics/bench/rows.h"
#include "haptics/bench/timing.h"

namespace typodont::haptics::bench {

void hand_over_rows(Scene& scene, const std::string& knob, std::vector<BenchRow>& rows) {
  SurfacePatch fresh = scene.patch();
  scene.carver.take_snapshot(scene.last.X_WG.p, fresh);
  const std::string size = fmt::format("{0}, {1}³", knob, fresh.n);
  rows.push_back({"patch cut-out, whole", size, BenchRow::kNone, "",
                  batch_ns(21, 4,
                           [&](int) {
                             fresh.copied_at = 0;
                             scene.carver.take_snapshot(scene.last.X_WG.p, fresh);
                           }),
                  "patch"});
  // Measures a complete patch (copy of the field around the tool) whose centre has moved by travel() since this patch
  // was last filled. In a session, a new patch is due after half of this distance. Two complete patches are used in
  // turn, so each of them moves by the whole distance.
  const dvec3 travel(scene.carver.body().travel(), 0, 0);
  rows.push_back(
      {"patch cut-out, moved by its travel along x", size, BenchRow::kNone, "",
       batch_ns(21, 4,
                [&](int k) { scene.carver.take_snapshot(scene.last.X_WG.p + (k % 2 ? 0.0 : 1.0) * travel, fresh); }),
       "patch"});
  // If the patch is small and moves by one leaf (8³ samples), the carver (owner of the tissue) copies only one layer of
  // leaves, and the servo adds them to its patch.
  const auto step = scene.carver.make_snapshot();
  const double leaf = PatchStep::kSide * scene.settings.frame.voxel;
  std::vector<double> copied, adopted;
  const double reading = clock_ns();
  for (int i = 0; i < 64; ++i) {
    const dvec3 center = scene.last.X_WG.p + dvec3(i % 2 ? leaf : 0.0, 0, 0);
    const Nanos start = thread_cpu_time();
    scene.carver.take_snapshot(center, *step, 0, scene.servo.snapshot().number);
    const Nanos copy = thread_cpu_time();
    scene.servo.adopt(*step);
    const Nanos end = thread_cpu_time();
    if (step->from == 0) continue;
    copied.push_back(static_cast<double>(copy - start) - reading);
    adopted.push_back(static_cast<double>(end - copy) - reading);
  }
  if (!copied.empty()) {
    rows.push_back({"patch step by one leaf along x, copied by the carver", size, BenchRow::kNone, "",
                    quantile(copied, 0.5), "patch"});
    rows.push_back({"patch step by one leaf along x, adopted by the servo", size, BenchRow::kNone, "",
                    quantile(adopted, 0.5), "patch"});
  }
  scene.carver.take_snapshot(scene.last.X_WG.p, fresh);
  rows.push_back({"patch hand-over, no cut missing", knob, BenchRow::kNone, "",
                  batch_ns(21, 64,
                           [&](int) {
                             fresh.cuts = scene.last.cuts;
                             scene.servo.adopt(fresh);
                           }),
                  "patch"});
  // While the carver (owner of the tissue) copies a complete patch (field around the tool), the servo makes further
  // cuts. The new patch lacks them, so the carver adds them to it afterwards, as in a session (PatchExchange).
  std::vector<double> kept_up, handed_over;
  const double clock = clock_ns();
  for (int i = 0; i < 9; ++i) {
    scene.carver.take_snapshot(scene.last.X_WG.p, fresh);
    scene.carver.remember_writes(true);
    const std::uint64_t wanted = scene.last.cuts + 16;
    for (int tick = 0; tick < 200 && scene.last.cuts < wanted; ++tick) {
      const Pose deeper{scene.last.X_WT.p - dvec3(0, 0, 1e-6), scene.last.X_WT.R};
      scene.t += from_seconds(scene.settings.tick);
      if (scene.servo.tick({scene.t, deeper, 1}, scene.last, scene.cut)) scene.carver.apply(scene.cut);
    }
    scene.carving.run([&] {
      const Nanos start = thread_cpu_time();
      scene.carver.bring_up_to_date(fresh);
      kept_up.push_back(static_cast<double>(thread_cpu_time() - start) - clock);
    });
    thread_cpu_time();  // the first reading of the clock after a wait is slow, so it is made before the measurement
    const Nanos start = thread_cpu_time();
    scene.servo.adopt(fresh);
    handed_over.push_back(static_cast<double>(thread_cpu_time() - start) - clock);
    scene.carver.remember_writes(false);
  }
  rows.push_back(
      {"16 cuts added to a patch by the carver", knob, BenchRow::kNone, "", quantile(kept_up, 0.5), "patch"});
  rows.push_back({"patch hand-over, 16 cuts made meanwhile", knob, BenchRow::kNone, "",
                  std::max(quantile(handed_over, 0.5), 0.0), "patch"});
  // If the carver (owner of the tissue) has not added the missing cuts to the new patch (copy of the field around the
  // tool), the servo itself must add them. This is slower.
  scene.carver.take_snapshot(scene.last.X_WG.p, fresh);
  rows.push_back({"patch hand-over, 16 cuts added by the servo", knob, BenchRow::kNone, "",
                  batch_ns(21, 64,
                           [&](int) {
                             fresh.cuts = scene.last.cuts - std::min<std::uint64_t>(scene.last.cuts, 16);
                             scene.servo.adopt(fresh);
                           }),
                  "patch"});
}

}  // namespace typodont::haptics::bench
