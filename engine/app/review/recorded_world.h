// The World of a recorded session at any time, from the events in its file. A recording does not contain the soft gum:
// at each recorded tick, the tool is placed at the pose at which it was drawn, where it presses and cuts the gum.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/app/picture/world.h"
#include "engine/session/session_file.h"
#include "haptics/soft_tissue.h"

namespace typodont {

class RecordedWorld {
 public:
  /// `tissue`: at the start of the session; used only here. Session and scene must outlive this object.
  RecordedWorld(const session::SessionReader& session, const Scene& scene, const haptics::TissueVolume& tissue);

  World& world() { return world_; }
  /// Folds the recorded events up to the time t. Back in time, it starts again at the beginning. `backwards`: true: the
  /// playback runs backwards; chips and water, which cannot, are omitted.
  void go(Nanos t, bool backwards = false);

 private:
  void start();
  void apply_events(Nanos t);
  void press(const ServoTick& tick);

  const session::SessionReader& session_;
  std::shared_ptr<const haptics::SoftSurface> surface_;  // null if the gum is rigid
  World world_;
  std::optional<haptics::SoftTissue> gum_;
  std::vector<LoosePiece> pieces_;
  const session::StreamData *water_ = nullptr, *left_hand_ = nullptr;
  // indices of the next events
  std::uint64_t next_tick_ = 0;
  std::size_t next_cut_ = 0, next_piece_ = 0, next_water_ = 0, next_hand_ = 0;
  std::vector<ServoTick> block_;  // ticks from block_first_ on
  std::uint64_t block_first_ = 0;
  bool backwards_ = false;
};

}  // namespace typodont
