// The implant method, carver's half: the field of the offset model, in which implants stay.
#pragma once

#include <span>
#include <vector>

#include "haptics/contact/implant/implant_method.h"
#include "haptics/contact/offset/field_body.h"

namespace typodont::haptics::implant {

/// Carver's thread.
class ImplantBody final : public offset::FieldBody {
 public:
  /// Throws Error for a bed that does not lie in bone.
  ImplantBody(TissueVolume tissue, std::span<const Tool> tools, const std::vector<Bed>& beds);

  /// Puts the head of the tool in, where the cut says.
  void fill(const Cut& cut) override;
  bool wants_snapshot(Nanos) const override { return placed_; }
  void cut_out(Snapshot& snapshot) override;

 private:
  bool placed_ = false;  // since the last snapshot
};

}  // namespace typodont::haptics::implant
