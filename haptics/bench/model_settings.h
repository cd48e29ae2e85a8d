// Default settings of the contact models, for measurements that do not vary the settings: the comparison of the models
// and the stress tests.
#pragma once

#include <fmt/format.h>

#include <string>

#include "engine/base/json.h"
#include "haptics/contact_method.h"

namespace typodont::haptics::bench {

inline constexpr double kDefaultVoxel = 0.1;  // mm, voxel size of the distance field

inline SharedContactMethod method_of(const std::string& json) {
  return read_contact_method(Json::parse(json, "bench"));
}

/// A contact method with its default setting. `knob` describes the setting, for example "10000 spheres".
struct DefaultMethod {
  std::string knob;
  SharedContactMethod method;
};
inline DefaultMethod default_method(const std::string& model) {
  if (model == "packing") return {"10000 spheres", method_of(R"({"packing": {"spheres": 10000}})")};
  if (model == "mesh_lod") return {"8000 vertices", method_of(R"({"mesh_lod": {"vertices": 8000, "levels": [8000]}})")};
  return {fmt::format("voxel {:g} mm", kDefaultVoxel), contact_method(model, "bench")};
}

}  // namespace typodont::haptics::bench
