// Counters of a thread's work so far. Read them on that thread.
#pragma once

#include <cstdint>

namespace typodont::haptics {

/// Number of field queries: calls of the samplers of surface_patch.h.
std::uint64_t queries_of_this_thread() noexcept;
/// Adds to the number of field queries. For code that evaluates many samples at once without the samplers of
/// surface_patch.h.
void count_queries(std::uint64_t count) noexcept;
/// Number of tissue elements examined near the head, by contact model.
struct SearchCounts {
  std::uint64_t spheres = 0;    // spheres, model "packing"
  std::uint64_t triangles = 0;  // triangles, model "mesh_lod"
  std::uint64_t vertices = 0;   // vertices, model "vertex"
};
SearchCounts looks_of_this_thread() noexcept;
/// Number of voxels that TissueVolume's carve() and fill() visited in leaves that changed.
std::uint64_t voxels_cut_by_this_thread() noexcept;

}  // namespace typodont::haptics
