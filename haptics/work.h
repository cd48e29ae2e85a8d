// What a thread has done so far, in plain integers of its own: read them on that thread.
#pragma once

#include <cstdint>

namespace typodont::haptics {

/// Looks into the field: calls of the samplers of surface_patch.h.
std::uint64_t queries_of_this_thread() noexcept;
/// Looks for tissue near the head, by the form that the contact model has it in.
struct ModelLooks {
  std::uint64_t spheres = 0;    // packing
  std::uint64_t triangles = 0;  // mesh_lod
  std::uint64_t vertices = 0;   // vertex
};
ModelLooks looks_of_this_thread() noexcept;
/// Voxels that TissueVolume's carve() and fill() went through in leaves that changed.
std::uint64_t voxels_cut_by_this_thread() noexcept;

}  // namespace typodont::haptics
