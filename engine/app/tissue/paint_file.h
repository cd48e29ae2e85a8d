// Tissue painted by hand: strokes of a round brush, stored in a file to which scenes refer.
//
//   { "strokes": [ { "tissue": "caries", "a_mm": [7, 6, 19], "b_mm": [7.2, 6, 18.5], "radius_mm": 0.4,
//   "hardness": 0.4, "color": [0.3, 0.2, 0.1] } ] }
//
// "hardness" and "color" apply only to the tissue that this stroke paints; "stiffness_factor" changes the stiffness of
// the tissue everywhere.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/json.h"
#include "engine/contract/tissue.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// A brush stroke: all tissue closer than `radius` to the segment from a to b. m, frame W.
struct PaintStroke {
  Tissue tissue = Tissue::kCaries;
  dvec3 a_W{0}, b_W{0};
  double radius = 0.5e-3;
  double stiffness_factor = 1;  // factor on the stiffness of this tissue; below 1: softer
  double hardness = 1;          // 0 to 1; 1: the full hardness of the tissue
  VoxelColor color = kTissueColor;
};

/// Declares the keys of a file with strokes. Throws Error.
void describe_paint_file(Keys& keys, std::vector<PaintStroke>& strokes);
std::vector<PaintStroke> read_paint(const std::filesystem::path& file);

/// Paints the strokes in order, so that later strokes cover earlier ones. Returns false if no stroke touched tissue.
bool paint(haptics::TissueVolume& volume, const std::vector<PaintStroke>& strokes);

/// Stiffness factor of a tissue in the whole volume: mean over its strokes, weighted by their volumes; 1 without
/// strokes.
double stiffness_factor(const std::vector<PaintStroke>& strokes, Tissue tissue);

}  // namespace typodont
