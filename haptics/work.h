// Work done by a thread, read on that thread.
#pragma once

#include <cstdint>

namespace typodont::haptics {

/// Field queries of surface_patch.h.
std::uint64_t queries_of_this_thread() noexcept;
/// For code that samples many at once without surface_patch.h.
void count_queries(std::uint64_t count) noexcept;
/// Elements near the head that each model examined.
struct SearchCounts {
  std::uint64_t spheres = 0;    // number of spheres that the contact model "packing" has examined
  std::uint64_t triangles = 0;  // number of triangles that the contact model "mesh_lod" has examined
  std::uint64_t vertices = 0;   // number of vertices that the contact model "vertex" has examined
};
SearchCounts looks_of_this_thread() noexcept;
/// Voxels in changed leaves of carve() and fill().
std::uint64_t voxels_cut_by_this_thread() noexcept;

}  // namespace typodont::haptics
