// Functions that add groups of rows to `typodont bench contact`.
#pragma once

#include <string>
#include <vector>

#include "engine/contract/bench_row.h"
#include "haptics/bench.h"
#include "haptics/bench/scene.h"

namespace typodont::haptics::bench {

/// Returns true if the benchmark measures the default contact model.
inline bool by_default(const BenchOptions& options) {
  return !options.method || options.method->name() == default_contact_method()->name();
}

/// Adds rows for a hand that slides on a ball. The rows compare the contact model "voxel penalty", a proxy with field
/// queries (trilinear or cubic), the servo, and methods of other programs (penalty with OpenVDB's field, point proxy on
/// an enlarged mesh). Also adds rows for single queries.
void slide_rows(const BenchOptions& options, std::vector<BenchRow>& rows);

/// Adds rows of a histogram: the fraction of the ticks that take 1 to 2 µs, 2 to 4 µs, and so on. `ticks`: ns.
void histogram_rows(const std::string& name, const std::string& knob, const std::vector<double>& ticks,
                    std::vector<BenchRow>& rows);

/// Adds rows for a hand that drills into a block, with four different heads. They contain the times of ticks, of cuts
/// alone, and of the copying and transfer of patches (the field around the tool).
void drilling_rows(const BenchOptions& options, std::vector<BenchRow>& rows);

/// Adds rows for the time of the cut in one tick. Two lower bounds are measured for comparison. The first is the time
/// to read and write only the samples that the cut changes. The second is the time to read and write all groups of
/// samples that the cut processes. Both sets of samples are determined before the time is measured.
void cut_rows(const Tool& tool, const std::string& knob, const DenseTissue& dense, std::vector<BenchRow>& rows);

/// Returns a lower bound, in ns, of the median time of a drilling tick. It is the sum of three times: the tick's cut
/// alone, repeated in a separate copy of the field; one query; and a scan of the samples that the cut reads and writes.
double drilling_floor(const DenseTissue& dense, const ServoSettings& settings, int ticks);

/// Adds rows for a patch (the field around the tool) that is copied during drilling and passed to the servo. `scene` is
/// a drilling scene with the pedal pressed. The measurement drills the hole in the scene slightly deeper.
void hand_over_rows(Scene& scene, const std::string& knob, std::vector<BenchRow>& rows);

/// Adds rows for sliding and drilling hands with several voxel sizes. Some rows give the servo's time per tick
/// (quantiles, histogram, mean). Other rows give the mean time per tick of the whole process: servo, carver (owner of
/// the tissue), and transfer of patches (copies of the field), both as in LockStep and as in a session. The means also
/// include work that is done only once in many ticks.
void process_rows(const BenchOptions& options, std::vector<BenchRow>& rows);

/// Adds rows for a ball that moves along the surface in steps and removes tissue. They contain the error of the removed
/// volume and the time per step.
void removal_rows(const BenchOptions& options, std::vector<BenchRow>& rows);

/// Adds a row for the time of a tick when no tissue is near the tool.
void free_air_row(const BenchOptions& options, std::vector<BenchRow>& rows);

/// Adds rows for ticks with soft tissue: pressing, cutting, and at rest.
void soft_rows(const BenchOptions& options, std::vector<BenchRow>& rows);

/// Adds rows for the deadlines that the servo misses while it drills at 10 kHz in real time.
void deadline_rows(const BenchOptions& options, std::vector<BenchRow>& rows);

}  // namespace typodont::haptics::bench
