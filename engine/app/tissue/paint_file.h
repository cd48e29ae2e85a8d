// Tissue painted by hand: strokes of a round brush, stored in a file to which scenes refer.
//
//   { "strokes": [ { "tissue": "caries", "a_mm": [7, 6, 19], "b_mm": [7.2, 6, 18.5], "radius_mm": 0.4,
//   "hardness": 0.4 } ] }
//
// "hardness" applies only to the tissue that this stroke paints; "stiffness_factor" changes the stiffness of the tissue
// everywhere.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/json.h"
#include "engine/contract/tissue.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// A brush stroke. All tissue within `radius` of the line from a to b gets the label `tissue`. Lengths in m, frame W.
struct PaintStroke {
  Tissue tissue = Tissue::kCaries;
  dvec3 a_W{0}, b_W{0};
  double radius = 0.5e-3;
  double stiffness_factor = 1;  // factor by which the tissue's own stiffness is multiplied; below 1: softer
  double hardness = 1;          // 0..1, hardness of the painted tissue; 1: its full hardness
};

/// Reads the strokes from a file. Throws Error.
std::vector<PaintStroke> read_paint(const std::filesystem::path& file);

/// Applies the strokes in order, so a later stroke covers an earlier one. Returns false if no stroke touched tissue.
bool paint(haptics::TissueVolume& volume, const std::vector<PaintStroke>& strokes);

/// Returns the factor by which a tissue's own stiffness is multiplied in the whole volume: the mean of
/// PaintStroke::stiffness_factor over all strokes that painted this tissue, weighted by the strokes' volumes. 1 if no
/// stroke painted it.
double stiffness_factor(const std::vector<PaintStroke>& strokes, Tissue tissue);

}  // namespace typodont
