// Corrections of imported tissue with a brush or from seed points. Positions in m, in the file's coordinates before
// ImportOptions::turn. Any thread, but one at a time.
#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "haptics/dense_tissue.h"

namespace typodont::haptics {

struct Imported;

/// What a correction sets. Grey values decide between enamel and dentin, and between cortical and cancellous bone
/// (ImportReport::kinds). kCanal sets pulp, and kMetal sets amalgam, as in the import of a jaw.
enum class LabelKind : std::uint8_t { kBone, kTooth, kMetal, kCanal, kNothing };
inline constexpr int kLabelKinds = 5;

/// Brush stroke: the volume within `radius` of a polyline. kNothing removes tissue; other kinds change labels, and
/// without `only_tissue` also add tissue, except within three voxels of the volume's outer faces.
struct LabelStroke {
  LabelKind kind = LabelKind::kBone;
  std::vector<dvec3> path;  // m, points of the polyline
  double radius = 1e-3;     // m, radius of the brush
  bool only_tissue = true;
};

/// Seed: the connected region around `point` with similar grey values (fuzzy connectedness, Udupa & Samarasekera 1996),
/// up to `reach`. `tolerance`: allowed difference as a fraction of the contrast between softer tissue and surroundings.
struct LabelSeed {
  LabelKind kind = LabelKind::kBone;
  dvec3 point{0};       // m, position from which the corrected part grows
  double reach = 5e-3;  // m, largest distance from `point` up to which the part extends
  double tolerance = 0.3;
};

using Correction = std::variant<LabelStroke, LabelSeed>;

/// Samples of a box, copied before or after a correction.
struct BoxContent {
  VoxelBox box;  // the box; empty if the correction changed nothing
  std::vector<float> distance;
  std::vector<Tissue> tissue;
  std::vector<std::uint8_t> hardness;  // empty if the tissue has no hardness
};

/// Applies a correction, and returns the box's content before it. Distances around added tissue are exact; inside it,
/// they are lower bounds. Throws Error if radius or reach is below half a voxel.
BoxContent correct(Imported& imported, const Correction& correction);

/// Exchanges the box's content with `content`: the first call undoes a correction, the next one repeats it.
void exchange(Imported& imported, BoxContent& content);

/// Volume of each tissue in a box, m³. Partial voxels count as in ImportReport::volume.
PerTissue volumes_in(const DenseTissue& tissue, const VoxelBox& box);
PerTissue volumes_in(const BoxContent& content, double voxel);

}  // namespace typodont::haptics
