#include "haptics/contact/implant/implant_method.h"

#include <fmt/format.h>

#include <utility>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/contact/implant/implant_body.h"
#include "haptics/contact/implant/implant_model.h"

namespace typodont::haptics::implant {

namespace {

class ImplantMethod final : public ContactMethod {
 public:
  explicit ImplantMethod(Parameters parameters) : parameters_(std::move(parameters)) {}
  std::string_view name() const override { return kName; }
  std::unique_ptr<ContactModel> make_model(const ServoSettings& settings) const override {
    return std::make_unique<ImplantModel>(settings, parameters_);
  }
  std::unique_ptr<TissueBody> make_body(TissueVolume tissue, std::span<const Tool> tools) const override {
    return std::make_unique<ImplantBody>(std::move(tissue), tools, parameters_.beds);
  }

 private:
  Parameters parameters_;
};

Bed read_bed(const Json& json) {
  json.allow_only({"entry_mm", "axis", "depth_mm", "diameter_mm"});
  Bed bed;
  bed.entry_W = json["entry_mm"].vec3() * kMillimetre;
  const dvec3 axis = json["axis"].vec3();
  if (!(glm::length(axis) > 1e-9)) json["axis"].fail("a direction into the bone, not zero");
  bed.axis_W = glm::normalize(axis);
  bed.depth = json["depth_mm"].number(0.5, 30) * kMillimetre;
  bed.radius = json["diameter_mm"].number(0.5, 10) / 2 * kMillimetre;
  return bed;
}

void read_grey(const Json& json, Parameters& p) {
  json.allow_only({"cortical_bone", "cancellous_bone", "teeth", "implants", "source"});
  p.cortical_grey = json.number_or("cortical_bone", p.cortical_grey, 1, 1e5);
  p.cancellous_grey = json.number_or("cancellous_bone", p.cancellous_grey, 1, 1e5);
  p.tooth_grey = json.number_or("teeth", p.tooth_grey, 1, 1e5);
  p.metal_grey = json.number_or("implants", p.metal_grey, 1, 1e5);
}

void read_torque(const Json& json, Parameters& p) {
  json.allow_only({"torque_Ncm", "grey_HU", "exponent", "surface_mm2", "tapped_share", "source"});
  p.torque = json.number_or("torque_Ncm", p.torque * 100, 0, 500) / 100;
  p.torque_grey = json.number_or("grey_HU", p.torque_grey, 1, 1e5);
  p.torque_exponent = json.number_or("exponent", p.torque_exponent, 0, 10);
  p.torque_surface = json.number_or("surface_mm2", p.torque_surface / kSquareMillimetre, 1, 1e4) * kSquareMillimetre;
  p.tapped_fraction = json.number_or("tapped_share", p.tapped_fraction, 0, 1);
}

}  // namespace

SharedContactMethod read(const std::optional<Json>& json) {
  Parameters p;
  if (json) {
    json->allow_only({"tool_voxel_mm", "layers", "centre_tolerance_mm", "radius_tolerance_mm", "axis_tolerance_deg",
                      "enter_force_N", "leave_mm", "mass_g", "turn_stiffness_Nm_per_rad", "as_printed", "grey_HU",
                      "insertion_torque", "beds", "source"});
    p.tool_voxel = json->number_or("tool_voxel_mm", p.tool_voxel / kMillimetre, 0.02, 0.5) * kMillimetre;
    if (const auto layers = json->find("layers")) p.layers = static_cast<int>(layers->integer(1, 2));
    const auto length = [&](std::string_view key, double& value, double least, double most) {
      value = json->number_or(key, value / kMillimetre, least, most) * kMillimetre;
    };
    length("centre_tolerance_mm", p.centre_tolerance, 0.05, 3);
    length("radius_tolerance_mm", p.radius_tolerance, 0, 1);
    length("leave_mm", p.leave, 0.05, 3);
    p.axis_tolerance = json->number_or("axis_tolerance_deg", p.axis_tolerance / kDegree, 0.1, 45) * kDegree;
    p.enter_force = json->number_or("enter_force_N", p.enter_force, 0.01, 20);
    p.mass = json->number_or("mass_g", p.mass * 1e3, 0, 1000) * 1e-3;
    p.turn_stiffness = json->number_or("turn_stiffness_Nm_per_rad", p.turn_stiffness, 0, 50);
    p.as_printed = json->boolean_or("as_printed", false);
    if (const auto grey = json->find("grey_HU")) read_grey(*grey, p);
    if (const auto torque = json->find("insertion_torque")) read_torque(*torque, p);
    if (const auto beds = json->find("beds")) {
      for (const Json& bed : beds->items()) p.beds.push_back(read_bed(bed));
      if (p.beds.size() > 32) beds->fail("at most 32 beds");
    }
  }
  return std::make_shared<ImplantMethod>(std::move(p));
}

}  // namespace typodont::haptics::implant
