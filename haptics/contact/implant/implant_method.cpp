#include "haptics/contact/implant/implant_method.h"

#include <fmt/format.h>

#include <utility>

#include "engine/base/error.h"
#include "engine/base/keys.h"
#include "engine/base/units.h"
#include "haptics/contact/implant/implant_body.h"
#include "haptics/contact/implant/implant_model.h"
#include "haptics/described.h"

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

void describe_bed(Keys& keys, Bed& bed) {
  keys(must("entry_mm"), bed.entry_W, kMillimetre, "middle of the bed's entry");
  keys(must("axis"), bed.axis_W, read_direction_into_bone, "direction of the bed into the bone");
  keys(must("depth_mm"), bed.depth, {0.5, 30, kMillimetre}, "depth");
  keys(must("diameter_mm"), bed.radius, {0.5, 10, kMillimetre / 2}, "diameter");
}

void describe_grey(Keys& keys, Parameters& p) {
  keys("cortical_bone", p.cortical_grey, {1, 1e5}, "grey value of cortical bone");
  keys("cancellous_bone", p.cancellous_grey, {1, 1e5}, "grey value of cancellous bone");
  keys("teeth", p.tooth_grey, {1, 1e5}, "grey value of teeth");
  keys("implants", p.metal_grey, {1, 1e5}, "grey value of implants");
  keys.ignore("source");
}

void describe_torque(Keys& keys, Parameters& p) {
  keys("torque_Ncm", p.torque, {0, 500, 1e-2}, "insertion torque in bone with the grey value `grey_HU`");
  keys("grey_HU", p.torque_grey, {1, 1e5}, "grey value of the bone in which the torque is `torque_Ncm`");
  keys("exponent", p.torque_exponent, {0, 10}, "the torque grows with this power of the grey value");
  keys("surface_mm2", p.torque_surface, {1, 1e4, kSquareMillimetre}, "implant's surface in bone at `torque_Ncm`");
  keys("tapped_share", p.tapped_fraction, {0, 1}, "torque in a tapped bed, as a fraction of that in an untapped bed");
  keys.ignore("source");
}

}  // namespace

SharedContactMethod read(Keys& keys) {
  Parameters p;
  keys("tool_voxel_mm", p.tool_voxel, {0.02, 0.5, kMillimetre}, "size of the tool's voxels");
  keys("centre_tolerance_mm", p.centre_tolerance, {0.05, 3, kMillimetre},
       "largest distance of an entering tip from the bed's axis and from its entry");
  keys("radius_tolerance_mm", p.radius_tolerance, {0, 1, kMillimetre},
       "a tool that does not widen the bed may be wider than the bed by at most this radius");
  keys("axis_tolerance_deg", p.axis_tolerance, {0.1, 45, kDegree}, "largest angle between tool and bed at entry");
  keys("enter_force_N", p.enter_force, {0.01, 20}, "smallest axial force at entry");
  keys("leave_mm", p.leave, {0.05, 3, kMillimetre}, "distance from the entry at which the tool leaves the bed");
  keys("mass_g", p.mass, {0, 1000, 1e-3}, "mass of the tool in a bed");
  keys("turn_stiffness_Nm_per_rad", p.turn_stiffness, {0, 50}, "stiffness that aligns the tool with the bed");
  keys("as_printed", p.as_printed, "true: equation (7) of the paper as published");
  keys("grey_HU", p, describe_grey, "grey values at hardness 1");
  keys("insertion_torque", p, describe_torque, "law of the [torque](../haptics/contact/implant/README.md#parameters)");
  keys("beds", p.beds, describe_bed, "at most 32 beds that exist at the start. A bed outside bone is an error");
  if (keys.json() && p.beds.size() > 32) (*keys.json())["beds"].fail("at most 32 beds");
  keys.ignore("source");
  return std::make_shared<ImplantMethod>(std::move(p));
}

}  // namespace typodont::haptics::implant
