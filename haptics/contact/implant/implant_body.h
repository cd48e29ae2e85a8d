// The part of the contact model "implant" that runs on the carver thread: the tissue. It stores the tissue in the same
// distance field as the contact model "offset", and adds placed implants to this field.
#pragma once

#include <span>
#include <vector>

#include "haptics/contact/implant/implant_method.h"
#include "haptics/contact/offset/field_body.h"

namespace typodont::haptics::implant {

/// The part of the contact model "implant" that runs on the carver thread.
class ImplantBody final : public offset::FieldBody {
 public:
  /// Throws Error if a bed does not lie in bone.
  ImplantBody(TissueVolume tissue, std::span<const Tool> tools, const std::vector<Bed>& beds);

  /// Adds the tool's head (a placed implant) to the tissue, at the pose of the cut.
  void fill(const Cut& cut) override;
  bool wants_snapshot(Nanos) const override { return placed_; }
  void cut_out(Snapshot& snapshot, std::uint32_t held) override;

 private:
  bool placed_ = false;  // true if an implant was placed since the last snapshot was taken
};

}  // namespace typodont::haptics::implant
