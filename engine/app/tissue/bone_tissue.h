// Jaw bone as tissue: the closed mesh of a jaw, with a cortical shell, cancellous bone of a class, and the canal of its
// nerve. No openly licensed scan of a jaw has its grey values, so they are synthetic: the class's mean, varied by
// voxel.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/base/json.h"
#include "haptics/dense_tissue.h"
#include "haptics/solid.h"

namespace typodont {

/// The label of what runs in the canal, nerve and vessels: the soft tissue there is.
inline constexpr Tissue kNerve = Tissue::kPulp;

/// What a class of bone is made of (assets/materials/bone_classes.json, with sources). SI; grey in Hounsfield units.
struct BoneClass {
  double cortical_thickness = 0;  // m
  double cortical_grey = 0, cancellous_grey = 0;
};
/// Hounsfield units of each tissue at hardness 1: hardness is grey over that, so stiffness and specific cutting energy
/// go with the grey value (haptics/hardness.h; Zhao 2020, eq. 6).
struct BoneGrey {
  double cortical = 1650, cancellous = 1250;
};

/// assets/materials/bone_classes.json.
std::filesystem::path bone_classes_file();
/// "I" to "IV". Throws Error naming the classes there are.
BoneClass load_bone_class(const Json& name);
BoneGrey load_bone_grey();

/// The polyline of a bone's canal, frame W; empty where the tissue has none. Throws Error.
struct NerveCanal {
  std::vector<dvec3> path_W;  // m
  double radius = 0;          // m
  /// m from a point to the canal's wall, negative inside; infinite where there is no canal.
  double distance(const dvec3& p_W) const;
};
NerveCanal read_nerve_canal(const Json& tissue);

/// The "tissue" object {"bone": {…}} of a scene (docs/interface.md). Throws Error.
haptics::DenseTissue sample_bone(const Json& bone, const haptics::SolidFiles& files);
/// Reads and checks it, without sampling. Throws Error.
void check_bone(const Json& bone);

}  // namespace typodont
