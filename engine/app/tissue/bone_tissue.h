// A jaw's closed mesh filled with a dense shell, cancellous bone of a class, and the nerve canal. No openly licensed
// scan has grey values, so they are synthetic: the class's mean and a variation.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/base/json.h"
#include "haptics/dense_tissue.h"
#include "haptics/solid.h"

namespace typodont {

/// No label exists for nerves and vessels: the pulp's.
inline constexpr Tissue kNerve = Tissue::kPulp;

constexpr bool is_bone(Tissue tissue) noexcept {
  return tissue == Tissue::kCorticalBone || tissue == Tissue::kCancellousBone;
}
/// Hard tissues only.
constexpr bool is_tooth(Tissue tissue) noexcept {
  return tissue == Tissue::kEnamel || tissue == Tissue::kDentin || tissue == Tissue::kCaries;
}

/// Sources: assets/materials/bone_classes.json. SI units; grey values in Hounsfield units.
struct BoneClass {
  double cortical_thickness = 0;  // m, thickness of the cortical shell
  double cortical_grey = 0, cancellous_grey = 0;
};
/// Hounsfield units at hardness 1, per tissue. Hardness is grey value / this, so stiffness and specific energy are
/// proportional to it (haptics/dense_tissue.h; Zhao 2020, eq. 6).
struct BoneGrey {
  double cortical = 1650, cancellous = 1250;
};

/// Returns the path of assets/materials/bone_classes.json.
std::filesystem::path bone_classes_file();
/// "I" to "IV". Throws Error that names them.
BoneClass load_bone_class(const Json& name);
BoneGrey load_bone_grey();

/// Polyline in W with a radius; no points: no canal.
struct NerveCanal {
  std::vector<dvec3> path_W;  // m, points of the canal's axis
  double radius = 0;          // m, radius of the nerve canal
  /// m from the wall, negative inside; infinite without canal.
  double distance(const dvec3& p_W) const;
};
NerveCanal read_nerve_canal(const Json& tissue);
/// {"path_mm", "diameter_mm"}. Throws Error.
NerveCanal read_canal(const Json& json);

/// {"bone": {…}} of a scene (docs/scene_format.md). Throws Error.
haptics::DenseTissue sample_bone(const Json& bone, const haptics::SolidFiles& files);
/// Without sampling. Throws Error.
void check_bone(const Json& bone);

}  // namespace typodont
