// Jaw bone as tissue: the closed mesh of a jaw, with a cortical shell, cancellous bone of a class, and the nerve
// canal. No openly licensed scan of a jaw includes grey values, so the grey values are synthetic: the mean of the
// class plus a variation per voxel.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/base/json.h"
#include "haptics/dense_tissue.h"
#include "haptics/solid.h"

namespace typodont {

/// The label for nerve and vessels in the canal: an existing soft tissue.
inline constexpr Tissue kNerve = Tissue::kPulp;

constexpr bool is_bone(Tissue tissue) noexcept {
  return tissue == Tissue::kCorticalBone || tissue == Tissue::kCancellousBone;
}
/// Hard tissue of a tooth.
constexpr bool is_tooth(Tissue tissue) noexcept {
  return tissue == Tissue::kEnamel || tissue == Tissue::kDentin || tissue == Tissue::kCaries;
}

/// Composition of a bone class (assets/materials/bone_classes.json, with sources). SI; grey values in Hounsfield units.
struct BoneClass {
  double cortical_thickness = 0;  // m, thickness of the shell
  double cortical_grey = 0, cancellous_grey = 0;
};
/// Hounsfield units of each tissue at hardness 1. The hardness of a voxel is its grey value divided by this value, so
/// stiffness and specific cutting energy are proportional to the grey value (haptics/hardness.h; Zhao 2020, eq. 6).
struct BoneGrey {
  double cortical = 1650, cancellous = 1250;
};

/// Path of assets/materials/bone_classes.json.
std::filesystem::path bone_classes_file();
/// Loads a class, "I" to "IV". Throws Error that names the available classes.
BoneClass load_bone_class(const Json& name);
BoneGrey load_bone_grey();

/// The nerve canal of a bone as a polyline, frame W; empty if the tissue has none. Throws Error.
struct NerveCanal {
  std::vector<dvec3> path_W;  // m
  double radius = 0;          // m
  /// Distance from a point to the canal's wall, m, negative inside; infinite if there is no canal.
  double distance(const dvec3& p_W) const;
};
NerveCanal read_nerve_canal(const Json& tissue);
/// Reads {"path_mm", "diameter_mm"}. Throws Error.
NerveCanal read_canal(const Json& json);

/// Samples the "tissue" object {"bone": {…}} of a scene (docs/interface.md). Throws Error.
haptics::DenseTissue sample_bone(const Json& bone, const haptics::SolidFiles& files);
/// Reads and checks the object {"bone": {…}} without sampling. Throws Error.
void check_bone(const Json& bone);

}  // namespace typodont
