// Brush and seeds on imported tissue. m, in the file's coordinates before ImportOptions::turn. Any thread, one at a
// time.
#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "haptics/dense_tissue.h"

namespace typodont::haptics {

struct Imported;

/// Grey values decide between enamel and dentin, cortical and cancellous bone (ImportReport::kinds). Canals are pulp,
/// metal amalgam, as in jaws.
enum class LabelKind : std::uint8_t { kBone, kTooth, kMetal, kCanal, kNothing };
inline constexpr int kLabelKinds = 5;

/// Volume within `radius` of a polyline. kNothing removes; otherwise relabels, and without `only_tissue` also adds,
/// except within three voxels of the box's walls.
struct LabelStroke {
  LabelKind kind = LabelKind::kBone;
  std::vector<dvec3> path;  // m, points of the polyline
  double radius = 1e-3;     // m, radius of the brush
  bool only_tissue = true;
};

/// Connected part around `point` of similar grey values (fuzzy connectedness, Udupa & Samarasekera 1996): within
/// `tolerance` × contrast of softer tissue and surroundings, up to `reach`.
struct LabelSeed {
  LabelKind kind = LabelKind::kBone;
  dvec3 point{0};       // m, position from which the corrected part grows
  double reach = 5e-3;  // m, largest distance of the corrected part from `point`
  double tolerance = 0.3;
};

using Correction = std::variant<LabelStroke, LabelSeed>;

/// Samples of a box, before or after.
struct BoxContent {
  VoxelBox box;  // the box; empty if the correction changed nothing
  std::vector<float> distance;
  std::vector<Tissue> tissue;
  std::vector<std::uint8_t> hardness;  // empty without hardness
};

/// Returns the box as it was. Added tissue has an exact surface, but lower bounds inside. Throws Error for a radius or
/// reach below half a voxel.
BoxContent correct(Imported& imported, const Correction& correction);

/// Undoes, and the next call repeats.
void exchange(Imported& imported, BoxContent& content);

/// m³ by tissue, partial voxels as in ImportReport::volume.
PerTissue volumes_in(const DenseTissue& tissue, const VoxelBox& box);
PerTissue volumes_in(const BoxContent& content, double voxel);

}  // namespace typodont::haptics
