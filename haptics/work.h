// Counters of the work that a thread has done so far. They must be read on the same thread.
#pragma once

#include <cstdint>

namespace typodont::haptics {

/// Returns the number of calls of the sampling functions in surface_patch.h (field queries) on this thread.
std::uint64_t queries_of_this_thread() noexcept;
/// Adds `count` to the number of field queries. For code that evaluates many samples at once without the functions in
/// surface_patch.h.
void count_queries(std::uint64_t count) noexcept;
/// For each contact model: number of tissue elements that it examined near the head.
struct SearchCounts {
  std::uint64_t spheres = 0;    // examined by the contact model "packing"
  std::uint64_t triangles = 0;  // examined by the contact model "mesh_lod"
  std::uint64_t vertices = 0;   // examined by the contact model "vertex"
};
SearchCounts looks_of_this_thread() noexcept;
/// Returns how many voxels carve() and fill() of TissueVolume have processed on this thread. Only leaves (8³ voxels) in
/// which a voxel changed are counted.
std::uint64_t voxels_cut_by_this_thread() noexcept;

}  // namespace typodont::haptics
