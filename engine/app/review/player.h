// Plays a recorded session: computes tissue and tool at any time, forward and backward. The recorded cuts are applied
// in order, including strokes that were undone later. Render thread only.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <vector>

#include "engine/app/picture/tissue_view.h"
#include "engine/app/scene.h"
#include "engine/session/session_file.h"
#include "haptics/carver.h"

namespace typodont {

class SessionPlayer {
 public:
  /// Reads a session and shows its first tick. Throws Error if the file is not a session with ticks, or if its tissue
  /// is missing or has changed.
  explicit SessionPlayer(const session::OpenedSession& session);

  const session::SessionReader& session() const { return session_; }
  const Scene& scene() const { return scene_; }
  double begin() const { return begin_; }  // s, time of the first recorded tick
  double end() const { return end_; }

  /// Moves to the time t, s. Forward: applies the cuts between the present time and t. Backward: undoes all strokes
  /// that end after t. If the first of these strokes began before t, its cuts before t are then applied again.
  void seek(double t);
  /// Returns the last tick at or before the present time.
  const ServoTick& tick() const { return tick_; }
  const haptics::TissueVolume& tissue() const { return carver_->volume(); }
  /// Sets the tolerance of the mesh, voxels. All bricks (mesh blocks) are then meshed again.
  void smooth_to(float tolerance);
  /// Returns the bricks (mesh blocks) that have changed since the last call.
  std::vector<render::MeshUpdate> take_surface();

 private:
  /// A change of the tissue: a cut, or an edit (undo or redo).
  struct Deed {
    Nanos t = 0;
    const Cut* cut = nullptr;  // the cut; null if the change is an edit
    bool redo = false;
  };
  /// An applied change of the tissue, with the data that is needed to revert it when the playback goes back in time.
  struct Done {
    enum class Kind { kStroke, kUndo, kRedo } kind;
    std::size_t first;    // index in deeds_ of the first cut or edit that belongs to this change
    std::size_t strokes;  // number of the carver's strokes after the change; only for kStroke
    bool forgets;         // true: the change discarded undone strokes, so the carver cannot revert it
  };
  void from_the_start();
  void go_back(Nanos t);
  void go_on(Nanos t);

  session::SessionReader session_;
  Scene scene_;
  double begin_ = 0, end_ = 0;
  std::vector<Deed> deeds_;
  std::optional<haptics::Carver> carver_;
  std::size_t next_ = 0;  // index of the next change in deeds_
  std::vector<Done> done_;
  std::vector<ServoTick> block_;  // consecutive ticks that were last read from the file
  ServoTick tick_;
  float tolerance_ = 0.1f;
  std::optional<TissueView> view_;
  std::set<std::uint64_t> shown_;  // the bricks (mesh blocks) that take_surface() returned with triangles
  /// true: playback has restarted with the initial tissue since the last call of take_surface()
  bool anew_ = false;
};

/// State of the playback: position, speed, loop. It does not read a clock.
struct PlayClock {
  double begin = 0, end = 1;  // s, range of times that can be played
  double from = 0, to = 1;    // s, range of times that is repeated in a loop
  double at = 0;              // s, present time of the playback
  double speed = 1;           // multiple of the recorded speed; negative: backwards
  bool paused = false, loop = false;
  bool over = false;  // true: the playback has reached its end; never true if the range is repeated

  void set_range(double a, double b);
  /// Advances the position by `dt` seconds of real time, multiplied by the speed.
  void advance(double dt);
  void seek(double t);
  /// Doubles (`up`) or halves the speed. The speed stays between 1/8 and 16.
  void faster(bool up);
};

}  // namespace typodont
