// The setting of each contact model where a question has no knob: the comparison of models, and what each survives.
#pragma once

#include <fmt/format.h>

#include <string>

#include "engine/base/json.h"
#include "haptics/contact_method.h"

namespace typodont::haptics::bench {

inline constexpr double kUsualVoxel = 0.1;  // mm, of the field

inline SharedContactMethod method_of(const std::string& json) {
  return read_contact_method(Json::parse(json, "bench"));
}

/// "10000 spheres"; and the method itself.
struct UsualMethod {
  std::string knob;
  SharedContactMethod method;
};
inline UsualMethod usual_method(const std::string& model) {
  if (model == "packing") return {"10000 spheres", method_of(R"({"packing": {"spheres": 10000}})")};
  if (model == "mesh_lod") return {"8000 vertices", method_of(R"({"mesh_lod": {"vertices": 8000, "levels": [8000]}})")};
  return {fmt::format("voxel {:g} mm", kUsualVoxel), contact_method(model, "bench")};
}

}  // namespace typodont::haptics::bench
