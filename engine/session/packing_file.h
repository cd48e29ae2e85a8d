// Stores sphere packings in files (.h5). So a tissue must be packed only once, and every session uses the same
// spheres.
#pragma once

#include <filesystem>

#include "engine/contract/sphere_packing.h"

namespace typodont::session {

/// Writes a packing, completely or not at all. Equal packings give equal bytes. Throws Error if the file cannot be
/// written. The file contains the datasets "center_m" (n×3 doubles, frame W), "radius_m" (n doubles), "tissue" (n
/// bytes, see contract/tissue.h) and "solid_volume_m3" (a double per tissue). Its attributes are "format",
/// "format_version", "seed", "tissue_hash", "max_radius_m", "largest_hole_m" and "checksum" (FNV-1a hash of all these
/// values except format and version).
void save_packing(const std::filesystem::path& file, const SpherePacking& packing);

/// Reads a packing. Throws Error if the file is no packing, is damaged, or contains a sphere with impossible values.
SpherePacking load_packing(const std::filesystem::path& file);

}  // namespace typodont::session
