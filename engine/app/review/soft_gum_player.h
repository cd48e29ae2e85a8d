// The soft gum of a recorded session at any time. A recording does not contain the gum, so the gum is computed again.
// For each recorded tick, the tool is placed at the pose at which it was drawn, where it presses and cuts the gum.
#pragma once

#include <memory>
#include <optional>

#include "engine/app/picture/soft_gum_view.h"
#include "engine/app/review/player.h"
#include "haptics/soft_tissue.h"

namespace typodont {

/// Computes the soft gum again while a recording is shown. Render thread only.
class SoftGumPlayer {
 public:
  /// `player` and `around` must outlive this object.
  SoftGumPlayer(const SessionPlayer& player, std::shared_ptr<const haptics::SoftSurface> surface,
                const Surroundings& around);
  /// Continues up to the player's present tick. If the player has moved backward, starts again at the beginning of the
  /// session.
  void follow();
  const SoftGumView& view() const { return view_; }

 private:
  void press(const ServoTick& tick);

  const SessionPlayer& player_;
  std::shared_ptr<const haptics::SoftSurface> surface_;
  std::optional<haptics::SoftTissue> tissue_;
  SoftGumView view_;
  std::uint64_t next_ = 0;  // index of the next tick to process
  Nanos last_t_ = 0;
};

}  // namespace typodont
