// The groups of rows of `typodont bench contact`.
#pragma once

#include <string>
#include <vector>

#include "engine/contract/bench_row.h"
#include "haptics/bench.h"
#include "haptics/bench/scene.h"

namespace typodont::haptics::bench {

/// True if the default contact model is measured.
inline bool by_default(const BenchOptions& options) {
  return !options.method || options.method->name() == default_contact_method()->name();
}

/// Adds rows for a hand that slides on a ball. They compare the voxel penalty, queries of both interpolation orders,
/// the servo, and methods of other programs (penalty by OpenVDB's field, point proxy on an offset mesh). Also adds rows
/// for single queries.
void slide_rows(const BenchOptions& options, std::vector<BenchRow>& rows);

/// A hand drills into a block, with four heads. Measures ticks, cuts alone, and patches.
void drilling_rows(const BenchOptions& options, std::vector<BenchRow>& rows);

/// The cut of one tick, compared with two lower bounds: reading and writing only the samples that the cut changes, and
/// reading and writing the same groups of samples as the cut. Both sets are known in advance.
void cut_rows(const Tool& tool, const std::string& knob, const DenseTissue& dense, std::vector<BenchRow>& rows);

/// Lower bound of a drilling tick, ns, median. The sum of: the tick's cut alone, repeated in a separate patch; one
/// query; and a scan of the samples that the cut reads and writes.
double drilling_floor(const DenseTissue& dense, const ServoSettings& settings, int ticks);

/// A patch is copied during drilling and passed to the servo. `scene`: a drilling scene with the pedal pressed;
/// afterwards the hole is slightly deeper.
void hand_over_rows(Scene& scene, const std::string& knob, std::vector<BenchRow>& rows);

/// Adds rows for sliding and drilling hands, by voxel size. They contain the mean time per tick of the whole process
/// (servo, carver, transfer of patches) and of the servo alone, and quantiles and a histogram of the servo's time. The
/// means include work that is done once in many ticks.
void process_rows(const BenchOptions& options, std::vector<BenchRow>& rows);

/// A stroke of a ball along the surface, in steps. Measures the error of the volume, and the time per step.
void removal_rows(const BenchOptions& options, std::vector<BenchRow>& rows);

/// Time of a tick without tissue nearby.
void free_air_row(const BenchOptions& options, std::vector<BenchRow>& rows);

/// Times of a tick with soft tissue: pressing, cutting, and at rest.
void soft_rows(const BenchOptions& options, std::vector<BenchRow>& rows);

/// Adds rows for the deadlines that the servo misses while drilling at 10 kHz in real time.
void deadline_rows(const BenchOptions& options, std::vector<BenchRow>& rows);

}  // namespace typodont::haptics::bench
