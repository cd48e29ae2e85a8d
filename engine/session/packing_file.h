// Stores sphere packings in files (.h5), so that a tissue is packed once and every session uses the same spheres.
#pragma once

#include <filesystem>

#include "engine/contract/sphere_packing.h"

namespace typodont::session {

/// Writes the file completely or not at all; equal packings give equal bytes. Throws Error if the file cannot be
/// written. Layout: datasets "center_m" (n×3 doubles, frame W), "radius_m" (n doubles), "tissue" (n bytes, see
/// contract/tissue.h), "solid_volume_m3" (a double per tissue); attributes "format", "format_version", "seed",
/// "tissue_hash", "max_radius_m", "largest_hole_m" and "checksum" (FNV-1a over all of these except format and version).
void save_packing(const std::filesystem::path& file, const SpherePacking& packing);

/// Reads a packing. Throws Error if the file is not a packing, is damaged, or contains an impossible sphere.
SpherePacking load_packing(const std::filesystem::path& file);

}  // namespace typodont::session
