// What the surface costs and how true it is: work-precision rows for `typodont bench`.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "engine/contract/bench_row.h"
#include "engine/contract/field_brick.h"

namespace typodont::surface {

struct BenchOptions {
  int repeats = 9;
  std::vector<double> tolerances = {-1, 0, 0.05, 0.1, 0.2};  // voxels; negative: full resolution
  double floor_32 = 6.5e-6;                                  // s, the floor of a 32³ dirty block (a mean of 5–8 µs)
};

/// Bricks of a distance given by a formula, in voxels: those with surface within [low, high].
std::vector<FieldBrick> bench_bricks(const glm::dvec3& low, const glm::dvec3& high,
                                     const std::function<double(const glm::dvec3&)>& distance);

/// A sphere of 50 voxels: N·ε/R in `error`, time per brick against the floor.
std::vector<BenchRow> bench_sphere(const BenchOptions& options);

/// Any tissue: whole extraction, and the update after one frame of drilling with a head of `radius` voxels, whose
/// bricks (all that share samples with the cut) are `drilled`. `baseline` in s (0: none) is another mesher's time for
/// the whole.
std::vector<BenchRow> bench_tissue(std::span<const FieldBrick> whole, std::span<const FieldBrick> drilled,
                                   double baseline, const BenchOptions& options);

}  // namespace typodont::surface
