// Jaw bone as tissue: the closed mesh of a jaw is filled with a shell of dense bone, cancellous (spongy) bone of a
// class, and the nerve canal. No openly licensed scan of a jaw contains grey values. So the grey values are synthetic:
// the mean of the class plus a variation per voxel.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/base/json.h"
#include "haptics/dense_tissue.h"
#include "haptics/solid.h"

namespace typodont {

/// The label of the nerve and the vessels in the nerve canal. There is no tissue label for nerves, so the label of the
/// pulp is used.
inline constexpr Tissue kNerve = Tissue::kPulp;

constexpr bool is_bone(Tissue tissue) noexcept {
  return tissue == Tissue::kCorticalBone || tissue == Tissue::kCancellousBone;
}
/// Returns true for the hard tissues of a tooth.
constexpr bool is_tooth(Tissue tissue) noexcept {
  return tissue == Tissue::kEnamel || tissue == Tissue::kDentin || tissue == Tissue::kCaries;
}

/// Composition of a class of bone (assets/materials/bone_classes.json states the sources). SI units; grey values in
/// Hounsfield units.
struct BoneClass {
  double cortical_thickness = 0;  // m, thickness of the cortical shell
  double cortical_grey = 0, cancellous_grey = 0;
};
/// Hounsfield units, for each tissue: the grey value of a voxel with hardness 1. The hardness of any voxel is its grey
/// value divided by this value. So stiffness and specific energy are proportional to the grey value
/// (haptics/hardness.h; Zhao 2020, eq. 6).
struct BoneGrey {
  double cortical = 1650, cancellous = 1250;
};

/// Returns the path of assets/materials/bone_classes.json.
std::filesystem::path bone_classes_file();
/// Loads a class of bone, "I" to "IV". Throws Error that names the available classes.
BoneClass load_bone_class(const Json& name);
BoneGrey load_bone_grey();

/// The nerve canal of a bone: a polyline in frame W with a radius. It has no points if the tissue has no canal.
struct NerveCanal {
  std::vector<dvec3> path_W;  // m, points of the canal's axis
  double radius = 0;          // m, radius of the nerve canal
  /// Returns the distance from a point to the canal's wall, m, negative inside; infinite if there is no canal.
  double distance(const dvec3& p_W) const;
};
NerveCanal read_nerve_canal(const Json& tissue);
/// Reads a canal with the keys {"path_mm", "diameter_mm"}. Throws Error.
NerveCanal read_canal(const Json& json);

/// Samples the tissue {"bone": {…}} of a scene (docs/scene_format.md). Throws Error.
haptics::DenseTissue sample_bone(const Json& bone, const haptics::SolidFiles& files);
/// Checks the tissue {"bone": {…}} of a scene without sampling it. Throws Error.
void check_bone(const Json& bone);

}  // namespace typodont
