// Sphere packings (.h5): a tissue is packed once, for all sessions.
#pragma once

#include <filesystem>

#include "engine/contract/sphere_packing.h"

namespace typodont::session {

/// Completely or not at all; equal packings, equal bytes. Throws Error. Datasets "center_m" (n×3 doubles, W),
/// "radius_m" (n doubles), "tissue" (n bytes, contract/tissue.h), "solid_volume_m3" (a double per tissue); attributes
/// "format", "format_version", "seed", "tissue_hash", "max_radius_m", "largest_hole_m", "checksum" (FNV-1a of all but
/// format and version).
void save_packing(const std::filesystem::path& file, const SpherePacking& packing);

/// Throws Error for no packing, damage, or impossible spheres.
SpherePacking load_packing(const std::filesystem::path& file);

}  // namespace typodont::session
