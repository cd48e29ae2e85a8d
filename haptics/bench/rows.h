// The rows of `typodont bench contact`, part by part.
#pragma once

#include <string>
#include <vector>

#include "engine/contract/bench_row.h"
#include "haptics/bench.h"
#include "haptics/bench/scene.h"

namespace typodont::haptics::bench {

/// True where the default contact model is measured.
inline bool by_default(const BenchOptions& options) {
  return !options.method || options.method->name() == default_contact_method()->name();
}

/// A hand that slides on a ball: by voxel penalty, by looks of either order, by the servo, and by the methods of other
/// programs (penalty by OpenVDB's field, point proxy on an offset mesh). Then queries alone.
void slide_rows(const BenchOptions& options, std::vector<BenchRow>& rows);

/// A hand that drills into a block, with four heads: ticks, cuts alone, patches.
void drilling_rows(const BenchOptions& options, std::vector<BenchRow>& rows);

/// The cut of one tick by itself, beside two floors: reading and writing just the samples that it changes, and reading
/// and writing the same groups of samples as it does. Both known beforehand.
void cut_rows(const Tool& tool, const std::string& knob, const DenseTissue& dense, std::vector<BenchRow>& rows);

/// What the ticks of a drilling hand cannot do without: the cut that each makes, made once more in a patch of its own;
/// one query; and a scan of the samples that such a cut reads and writes. ns, of the median tick.
double drilling_floor(const DenseTissue& dense, const ServoSettings& settings, int ticks);

/// A patch cut out beside a drilling servo, and handed over to it. `scene`: while it drills, pedal down; it is left a
/// little deeper.
void hand_over_rows(Scene& scene, const std::string& knob, std::vector<BenchRow>& rows);

/// Sliding and drilling hands, by voxel size: time of the whole process per tick (servo, carver, hand-over of patches)
/// beside the servo's own, both as means, so that what is done once in many ticks counts too; then the servo's
/// quantiles and a histogram.
void process_rows(const BenchOptions& options, std::vector<BenchRow>& rows);

/// A stroke of a ball along the surface, in steps: error of the volume, time per step.
void removal_rows(const BenchOptions& options, std::vector<BenchRow>& rows);

/// A tick with no tissue near.
void free_air_row(const BenchOptions& options, std::vector<BenchRow>& rows);

/// Drilling at 10 kHz on the clock.
void deadline_rows(const BenchOptions& options, std::vector<BenchRow>& rows);

}  // namespace typodont::haptics::bench
