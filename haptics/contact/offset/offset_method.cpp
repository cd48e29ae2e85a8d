#include "haptics/contact/offset/offset_method.h"

#include <optional>
#include <utility>

#include "engine/base/keys.h"
#include "engine/base/units.h"
#include "haptics/contact/offset/field_body.h"
#include "haptics/contact/offset/intermediate_surface.h"

namespace typodont::haptics::offset {

namespace {

class OffsetMethod final : public ContactMethod {
 public:
  OffsetMethod(bool mean_stiffness, const std::optional<IntermediateSurface>& surface)
      : mean_stiffness_(mean_stiffness), surface_(surface) {}
  std::string_view name() const override { return kName; }
  std::unique_ptr<ContactModel> make_model(const ServoSettings& settings) const override {
    if (surface_) return std::make_unique<IntermediateModel>(settings, *surface_, mean_stiffness_);
    return std::make_unique<OffsetModel>(settings, mean_stiffness_);
  }
  std::unique_ptr<TissueBody> make_body(TissueVolume tissue, std::span<const Tool> tools) const override {
    return std::make_unique<FieldBody>(std::move(tissue), tools, surface_.has_value());
  }

 private:
  bool mean_stiffness_;
  std::optional<IntermediateSurface> surface_;
};

void describe_surface(Keys& keys, IntermediateSurface& surface) {
  keys("update_hz", surface.update_rate, {1, 1000}, "rate at which the felt surface learns of cuts and fillings");
  keys("mm3_per_N_s", surface.removal, {1e-3, 1e6, kCubicMillimetre},
       "the felt surface moves at this · force / (contact area · stiffness relative to enamel)");
  keys("max_mm_per_s", surface.max_speed, {0.1, 1e4, kMillimetre}, "largest speed, which is also that without contact");
}

}  // namespace

SharedContactMethod read(Keys& keys) {
  bool mean_stiffness = false;
  keys("mean_stiffness", mean_stiffness,
       "true: stiffness, friction and cutting energy of the mean tissue in the head at the hand's pose, as published");
  std::optional<IntermediateSurface> surface;
  keys("intermediate_surface", surface, describe_surface, "the felt surface of a published simulator, for comparisons");
  return std::make_shared<OffsetMethod>(mean_stiffness, surface);
}

}  // namespace typodont::haptics::offset
