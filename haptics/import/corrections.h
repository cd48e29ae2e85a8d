// Corrections of an imported tissue by hand. There are two tools: a brush, and seeds (points from which a correction
// spreads through similar grey values). Positions are in m in the coordinates of the imported file, before its rotation
// (ImportOptions::turn). The functions may be called on any thread, but not on two threads at the same time.
#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "haptics/dense_tissue.h"

namespace typodont::haptics {

struct Imported;

/// The kind of tissue that a correction gives to samples. The grey value of a sample decides between enamel and dentin,
/// and between cortical and cancellous bone (ImportReport::kinds). A canal gets the label pulp, and metal gets the
/// label amalgam, as in the import of a jaw.
enum class LabelKind : std::uint8_t { kBone, kTooth, kMetal, kCanal, kNothing };
inline constexpr int kLabelKinds = 5;

/// A stroke with the brush. The stroke corrects the volume within `radius` of a polyline. With the label kNothing, the
/// stroke removes tissue. With another label and `only_tissue`, it changes only the label of existing tissue. With
/// another label and without `only_tissue`, it also adds tissue, except within three voxels of the walls of the
/// imported box.
struct LabelStroke {
  LabelKind kind = LabelKind::kBone;
  std::vector<dvec3> path;  // m, points of the polyline
  double radius = 1e-3;     // m, radius of the brush
  bool only_tissue = true;
};

/// A seed is a point from which a correction spreads: it corrects the connected part of the tissue around `point` whose
/// grey values are similar to the grey value at the point (fuzzy connectedness with a fixed limit, Udupa & Samarasekera
/// 1996). Two grey values are similar if they differ by at most `tolerance` times the contrast between the softer
/// tissue and the surroundings. The corrected part ends at the distance `reach` from the point.
struct LabelSeed {
  LabelKind kind = LabelKind::kBone;
  dvec3 point{0};       // m, position from which the corrected part grows
  double reach = 5e-3;  // m, largest distance of the corrected part from `point`
  double tolerance = 0.3;
};

using Correction = std::variant<LabelStroke, LabelSeed>;

/// A copy of the samples of a box of voxels, from before or after a correction.
struct BoxContent {
  VoxelBox box;  // the box; empty if the correction changed nothing
  std::vector<float> distance;
  std::vector<Tissue> tissue;
  std::vector<std::uint8_t> hardness;  // hardness of the samples; empty if the tissue stores no hardness
};

/// Applies a correction to the tissue. Returns the samples of the changed box as they were before. Where tissue was
/// added, the surface is exact, but the stored distances inside the tissue may be too small, as after drilling. Throws
/// Error if the radius of a stroke or the reach of a seed is less than half a voxel.
BoxContent correct(Imported& imported, const Correction& correction);

/// Exchanges the samples of a box with the samples in `content`. So the first call undoes a correction, and the next
/// call repeats it.
void exchange(Imported& imported, BoxContent& content);

/// Returns the volume (m³) of each tissue in a box. Partly filled voxels count as in ImportReport::volume.
PerTissue volumes_in(const DenseTissue& tissue, const VoxelBox& box);
PerTissue volumes_in(const BoxContent& content, double voxel);

}  // namespace typodont::haptics
