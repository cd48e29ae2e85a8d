// The carver's part of the contact model "implant": the tissue of "offset", with placed implants.
#pragma once

#include <span>
#include <vector>

#include "haptics/contact/implant/implant_method.h"
#include "haptics/contact/offset/field_body.h"

namespace typodont::haptics::implant {

/// The carver's part of the contact model "implant".
class ImplantBody final : public offset::FieldBody {
 public:
  /// Throws Error if an implant bed (drilled hole) is not inside bone.
  ImplantBody(TissueVolume tissue, std::span<const Tool> tools, const std::vector<Bed>& beds);

  /// Adds a placed implant at the pose of the cut.
  void fill(const Cut& cut) override;
  bool wants_snapshot(Nanos) const override { return placed_; }
  void cut_out(Snapshot& snapshot, std::uint32_t held) override;

 private:
  bool placed_ = false;  // true: an implant was placed since the last snapshot
};

}  // namespace typodont::haptics::implant
