// Files of sphere packings (.h5). A tissue is packed once, and all sessions use the file.
#pragma once

#include <filesystem>

#include "engine/contract/sphere_packing.h"

namespace typodont::session {

/// Writes a packing completely or not at all; equal packings give equal bytes. Throws Error. Datasets: "center_m" (n×3
/// doubles, frame W), "radius_m" (n doubles), "tissue" (n bytes, contract/tissue.h), "solid_volume_m3" (a double for
/// each tissue).
/// Attributes: "format", "format_version", "seed", "tissue_hash", "max_radius_m", "largest_hole_m", "checksum" (FNV-1a
/// of everything except format and version).
void save_packing(const std::filesystem::path& file, const SpherePacking& packing);

/// Reads a packing. Throws Error if the file is no packing, is damaged, or has impossible spheres.
SpherePacking load_packing(const std::filesystem::path& file);

}  // namespace typodont::session
