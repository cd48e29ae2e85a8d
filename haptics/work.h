// Counters of the work that a thread has done so far. They must be read on the same thread.
#pragma once

#include <cstdint>

namespace typodont::haptics {

/// Returns the number of calls of the sampling functions in surface_patch.h (field queries) on this thread.
std::uint64_t queries_of_this_thread() noexcept;
/// Adds `count` to the number of field queries. For code that evaluates many samples at once without the functions in
/// surface_patch.h.
void count_queries(std::uint64_t count) noexcept;
/// Numbers of tissue elements near the head that the contact models have examined, one number for each contact model.
struct SearchCounts {
  std::uint64_t spheres = 0;    // number of spheres that the contact model "packing" has examined
  std::uint64_t triangles = 0;  // number of triangles that the contact model "mesh_lod" has examined
  std::uint64_t vertices = 0;   // number of vertices that the contact model "vertex" has examined
};
SearchCounts looks_of_this_thread() noexcept;
/// Returns how many voxels carve() and fill() of TissueVolume have processed on this thread. Only leaves (8³ voxels) in
/// which a voxel changed are counted.
std::uint64_t voxels_cut_by_this_thread() noexcept;

}  // namespace typodont::haptics
