// The size of a tissue patch, and the distance that a tool may move in it.
#include <algorithm>
#include <cmath>

#include "haptics/contact/proxy/non_cutting_contacts.h"
#include "haptics/contact/tissue_patch.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

namespace {

/// Voxels that a tool may move from the centre of the tissue patch. Half of this distance must exceed four voxels,
/// because patches start at multiples of 8 voxels. Filling instruments need 1 mm to search places for filling.
double travel_for(const Tool& tool, double voxel) {
  const double least = tool.fill != Tissue::kAir ? 1e-3 : 0.4e-3;
  return std::max({9.0, least / voxel, 0.25 * tool.reach() / voxel});
}

}  // namespace

int patch_edge_for(std::span<const Tool> tools, double voxel) {
  double half = 0;
  for (const Tool& tool : tools) {
    // The tissue patch must extend beyond the head. Filling is added only if it lies completely inside.
    const double reach = std::max(near_reach(tool), tool.fill == Tissue::kAir ? 0.0 : tool.half() + tool.fill_reach);
    half = std::max(half, reach / voxel + Sweep::kMargin + 3 + travel_for(tool, voxel));
  }
  // The edge is rounded up to a multiple of n samples. 1e-6 is subtracted so that rounding errors do not add n samples.
  constexpr int n = Sweep::kLeaf;
  return n * static_cast<int>(std::ceil((2 * half + 1 - 1e-6) / n));
}

double patch_travel_for(std::span<const Tool> tools, double voxel) {
  double travel = 1e300;
  for (const Tool& tool : tools) travel = std::min(travel, travel_for(tool, voxel));
  return travel;
}

TissuePatch empty_patch_for(std::span<const Tool> tools, double voxel) {
  return empty_patch_for(tools, voxel, patch_edge_for(tools, voxel));
}

TissuePatch empty_patch_for(std::span<const Tool> tools, double voxel, int edge) {
  TissuePatch patch;
  patch.resize(edge);
  const CoarseGrid coarse = coarse_grid_for(tools, voxel, patch_travel_for(tools, voxel) * voxel / voxel);
  if (coarse.edge > 0) {
    patch.coarse_levels.emplace_back();
    patch.coarse_levels.front().resize(coarse.edge);
    patch.coarse_levels.front().every = coarse.every;
  }
  return patch;
}

}  // namespace typodont::haptics
