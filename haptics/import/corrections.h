// Corrections of an imported tissue by hand: a brush, and seeds that spread through similar grey values. Positions are
// in m, in the coordinates of the imported file, before rotations (ImportOptions::turn). Any thread, one at a time.
#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "haptics/dense_tissue.h"

namespace typodont::haptics {

struct Imported;

/// What a correction makes of the tissue. The grey value decides between enamel and dentin, and between cortical and
/// cancellous bone (ImportReport::kinds). A canal gets the label pulp, metal the label amalgam, as in a jaw's import.
enum class LabelKind : std::uint8_t { kBone, kTooth, kMetal, kCanal, kNothing };
inline constexpr int kLabelKinds = 5;

/// The volume within `radius` of a polyline. `only_tissue`: changes the label of existing tissue only. Otherwise the
/// brush also adds tissue, at most up to three voxels from the walls of the imported box. kNothing removes tissue.
struct LabelStroke {
  LabelKind kind = LabelKind::kBone;
  std::vector<dvec3> path;  // m
  double radius = 1e-3;     // m
  bool only_tissue = true;
};

/// The connected part of the tissue around `point` whose grey values are similar to those at the point: the relation of
/// fuzzy connectedness with a fixed limit (Udupa & Samarasekera 1996). The limit is `tolerance` times the contrast
/// between the softer tissue and the surroundings. The part ends `reach` from the point.
struct LabelSeed {
  LabelKind kind = LabelKind::kBone;
  dvec3 point{0};       // m
  double reach = 5e-3;  // m
  double tolerance = 0.3;
};

using Correction = std::variant<LabelStroke, LabelSeed>;

/// The samples of a box, before or after a correction.
struct BoxContent {
  VoxelBox box;  // empty: the correction changed nothing
  std::vector<float> distance;
  std::vector<Tissue> tissue;
  std::vector<std::uint8_t> hardness;  // empty if the tissue has no hardness of its own
};

/// Changes the tissue, and returns the former samples of the box that changed. Where tissue was added, distances
/// inside it are lower limits, as after drilling; the surface is exact. Throws Error for a radius or a reach of less
/// than half a voxel.
BoxContent correct(Imported& imported, const Correction& correction);

/// Exchanges the samples of a box with those in `content`: undoes a correction, or repeats an undone one.
void exchange(Imported& imported, BoxContent& content);

/// Volume of each tissue in a box, m³, as in ImportReport::volume. `voxel`: m.
PerTissue volumes_in(const DenseTissue& tissue, const VoxelBox& box);
PerTissue volumes_in(const BoxContent& content, double voxel);

}  // namespace typodont::haptics
