// Counters of the work that the calling thread has done.
#pragma once

#include <cstdint>

namespace typodont::haptics {

/// This thread's number of queries of the distance field (tissue_patch.h).
std::uint64_t queries_of_this_thread() noexcept;
/// Adds `count` to queries_of_this_thread(). For code that reads the distance field without tissue_patch.h.
void count_queries(std::uint64_t count) noexcept;
/// Numbers of elements near the head that this thread's contact models have examined.
struct SearchCounts {
  std::uint64_t spheres = 0;    // spheres examined by the model packing
  std::uint64_t triangles = 0;  // triangles examined by the model mesh_lod
  std::uint64_t vertices = 0;   // vertices examined by the model vertex
};
SearchCounts looks_of_this_thread() noexcept;
/// Number of voxels in the leaves that carve() and fill() have changed.
std::uint64_t voxels_cut_by_this_thread() noexcept;

}  // namespace typodont::haptics
