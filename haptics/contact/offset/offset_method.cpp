#include "haptics/contact/offset/offset_method.h"

#include <utility>

#include "haptics/contact/offset/field_body.h"
#include "haptics/contact/offset/offset_model.h"

namespace typodont::haptics::offset {

namespace {

class OffsetMethod final : public ContactMethod {
 public:
  std::string_view name() const override { return kName; }
  std::unique_ptr<ContactModel> make_model(const ServoSettings& settings) const override {
    return std::make_unique<OffsetModel>(settings);
  }
  std::unique_ptr<TissueBody> make_body(TissueVolume tissue, std::span<const Tool> tools) const override {
    return std::make_unique<FieldBody>(std::move(tissue), tools);
  }
};

}  // namespace

SharedContactMethod read(Keys&) {
  return std::make_shared<OffsetMethod>();
}

}  // namespace typodont::haptics::offset
