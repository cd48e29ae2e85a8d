// The bone of a jaw: a closed mesh filled with a dense shell, cancellous bone of a bone class, and the nerve canal; on
// it, neighbouring teeth, and gum with an opened flap.
// Grey values are synthetic (mean of the class and variation), because no openly licensed scan has them.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/base/json.h"
#include "haptics/dense_tissue.h"
#include "haptics/solid.h"

namespace typodont {

/// Nerves and vessels have no label of their own; they use the label of the pulp.
inline constexpr Tissue kNerve = Tissue::kPulp;

constexpr bool is_bone(Tissue tissue) noexcept {
  return tissue == Tissue::kCorticalBone || tissue == Tissue::kCancellousBone;
}
/// True for the hard tissues of a tooth.
constexpr bool is_tooth(Tissue tissue) noexcept {
  return tissue == Tissue::kEnamel || tissue == Tissue::kDentin || tissue == Tissue::kCaries;
}

/// A class of bone (sources: assets/materials/bone_classes.json). SI units; grey values in Hounsfield units.
struct BoneClass {
  double cortical_thickness = 0;  // m, thickness of the cortical shell
  double cortical_grey = 0, cancellous_grey = 0;
};
/// Grey value of each tissue at hardness 1, Hounsfield units. Hardness = grey value divided by this value. Stiffness
/// and specific energy are proportional to the hardness (haptics/dense_tissue.h; Zhao 2020, eq. 6).
struct BoneGrey {
  double cortical = 1650, cancellous = 1250;
};

/// The shipped files that define the object "bone": bone classes, and the forms of its teeth.
std::vector<std::filesystem::path> bone_files(const Json& bone);
/// Loads class "I" to "IV". Throws Error that lists these classes.
BoneClass load_bone_class(const Json& name);
BoneGrey load_bone_grey();

/// A nerve canal: a polyline in frame W with a radius. Without points, there is no canal.
struct NerveCanal {
  std::vector<dvec3> path_W;  // m, points of the canal's axis
  double radius = 0;          // m, radius of the nerve canal
  /// Signed distance to the canal's wall, m, negative inside; infinite if there is no canal.
  double distance(const dvec3& p_W) const;
};
NerveCanal read_nerve_canal(const Json& tissue);
void describe_canal(Keys& keys, NerveCanal& canal);

/// Samples {"bone": {…}} of a scene (docs/scene_format.md). Throws Error.
haptics::DenseTissue sample_bone(const Json& bone, const haptics::SolidFiles& files);
/// Declares the keys of the object "bone"; checks an object without sampling it. Throws Error.
void describe_bone(Keys& keys);

}  // namespace typodont
