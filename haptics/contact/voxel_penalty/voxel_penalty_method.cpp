#include "haptics/contact/voxel_penalty/voxel_penalty_method.h"

#include <utility>

#include "engine/base/keys.h"
#include "haptics/contact/offset/field_body.h"
#include "haptics/contact/voxel_penalty/voxel_penalty_model.h"
#include "haptics/cutting/voxel_stamp.h"

namespace typodont::haptics::voxel_penalty {

namespace {

/// Tissue as in the contact model "offset", except that a cut removes whole voxels.
class VoxelBody final : public offset::FieldBody {
 public:
  using FieldBody::FieldBody;
  void carve(const Cut& cut, bool) override {
    TissueVolume& volume = rasterize();
    take_out_pieces(cut, volume.carve(VoxelStamp(tool(cut), cut.X_WB, volume.frame())));
  }
};

class VoxelPenaltyMethod final : public ContactMethod {
 public:
  explicit VoxelPenaltyMethod(const Parameters& parameters) : parameters_(parameters) {}
  std::string_view name() const override { return kName; }
  std::unique_ptr<ContactModel> make_model(const ServoSettings& settings) const override {
    return std::make_unique<VoxelPenaltyModel>(settings, parameters_);
  }
  std::unique_ptr<TissueBody> make_body(TissueVolume tissue, std::span<const Tool> tools) const override {
    return std::make_unique<VoxelBody>(std::move(tissue), tools);
  }

 private:
  Parameters parameters_;
};

}  // namespace

SharedContactMethod read(Keys& keys) {
  Parameters parameters;
  keys("samples", parameters.samples, {8, 1024}, "number of sample points on the surface of the head");
  keys("shared_load", parameters.shared_load, {1, 1024},
       "the summed force of all points is divided by the number of points in contact, but at least by this number");
  return std::make_shared<VoxelPenaltyMethod>(parameters);
}

}  // namespace typodont::haptics::voxel_penalty
