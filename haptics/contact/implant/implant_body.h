// "implant" on the carver thread: the field of "offset", with placed implants.
#pragma once

#include <span>
#include <vector>

#include "haptics/contact/implant/implant_method.h"
#include "haptics/contact/offset/field_body.h"

namespace typodont::haptics::implant {

/// The part of the contact model "implant" that runs on the carver thread.
class ImplantBody final : public offset::FieldBody {
 public:
  /// Throws Error for a bed outside bone.
  ImplantBody(TissueVolume tissue, std::span<const Tool> tools, const std::vector<Bed>& beds);

  /// A placed implant, at the cut's pose.
  void fill(const Cut& cut) override;
  bool wants_snapshot(Nanos) const override { return placed_; }
  void cut_out(Snapshot& snapshot, std::uint32_t held) override;

 private:
  bool placed_ = false;  // since the last snapshot
};

}  // namespace typodont::haptics::implant
