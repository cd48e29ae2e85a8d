// The settings and the anatomies with which contact models are compared.
#pragma once

#include <string>
#include <vector>

#include "haptics/contact_method.h"
#include "tests/support/model_tissues.h"

namespace typodont::bench {

inline constexpr double kDefaultVoxel = 0.1;  // mm

/// A contact model with one value of the setting by which it becomes more accurate or faster.
struct Setting {
  std::string model, knob;  // knob: for example "10000 spheres"
  haptics::SharedContactMethod method;
  double voxel_mm = kDefaultVoxel;
};
/// `json`: as a scene's `model`.
haptics::SharedContactMethod method_of(const std::string& json);
Setting default_setting(const std::string& model);
/// An anatomical tissue and the voxel sizes with which it is measured. The molar has those of its file.
struct Anatomy {
  const char* name;
  std::vector<double> voxels_mm;
};
std::vector<Anatomy> anatomies();
test::ModelTissue load_anatomy(const Anatomy& anatomy);

/// Returns the settings with which a model is measured, from fast to accurate. `anatomy`: null for a simple shape.
std::vector<Setting> settings_of(const std::string& model, const Anatomy* anatomy);

}  // namespace typodont::bench
