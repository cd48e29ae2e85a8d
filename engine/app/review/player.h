// Plays back a recorded session: tissue and tool at any time, forward and backward. It applies the recorded cuts in
// order, including strokes that were undone later. Drawing thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "engine/app/picture/tissue_view.h"
#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "engine/session/session_file.h"
#include "haptics/carver.h"

namespace typodont {

/// The second hand, which holds the mouth mirror or the suction tip.
struct OtherHand {
  Pose X_WT;
};

class SessionPlayer {
 public:
  /// Opens a session at its first tick. Throws Error if the file is not a session with ticks, or if its tissue is
  /// missing or has changed.
  explicit SessionPlayer(const std::filesystem::path& session);

  const session::SessionReader& session() const { return session_; }
  const Scene& scene() const { return scene_; }
  double begin() const { return begin_; }  // s, time of the first recorded tick
  double end() const { return end_; }

  /// Moves to time t, s. A move forward applies the cuts in between. A move backward undoes the strokes in between
  /// and repeats a part of the last one.
  void seek(double t);
  /// The last tick that is not after the present time.
  const ServoTick& tick() const { return tick_; }
  /// Cuts applied by the last forward seek(); they create the chips.
  std::span<const Cut> fresh_cuts() const { return fresh_; }
  /// Pose of the second hand at the present time; empty if the session has none.
  std::optional<OtherHand> other_hand() const;
  /// Water and suction at the present time: as recorded, otherwise as the scene begins.
  WaterSwitch water() const;
  const haptics::TissueVolume& tissue() const { return carver_->volume(); }
  /// Sets the mesh tolerance in voxels; all bricks are then meshed again.
  void smooth_to(float tolerance);
  /// Bricks that changed since the last call.
  std::vector<render::MeshUpdate> take_surface();

 private:
  /// A change of the tissue: a cut or an edit.
  struct Deed {
    Nanos t = 0;
    const Cut* cut = nullptr;  // the cut; null: the change is an edit
    bool redo = false;
  };
  /// Data that is needed to undo a change.
  struct Done {
    enum class Kind { kStroke, kUndo, kRedo } kind;
    std::size_t first;    // index of the first change in deeds_
    std::size_t strokes;  // number of the tissue's strokes before the change
    bool forgets;         // the change discards undone strokes, so it cannot be undone here
  };
  void from_the_start();
  void go_back(Nanos t);
  void go_on(Nanos t);

  /// The recorded stream of this name; null if there is none.
  const session::StreamData* stream(std::string_view name) const;

  session::SessionReader session_;
  Scene scene_;
  double begin_ = 0, end_ = 0;
  std::vector<Deed> deeds_;
  std::optional<haptics::Carver> carver_;
  std::size_t next_ = 0;  // index in deeds_ of the next change
  std::vector<Done> done_;
  std::vector<Cut> fresh_;
  std::vector<ServoTick> block_;  // ticks that were read together
  ServoTick tick_;
  float tolerance_ = 0.1f;
  std::optional<TissueView> view_;
  std::set<std::uint64_t> shown_;  // bricks with triangles that take_surface() returned
  bool anew_ = false;              // the carver was restarted since the last take_surface()
};

/// State of the playback: position, speed, loop. Independent of any clock.
struct PlayClock {
  double begin = 0, end = 1;  // s, range that can be played
  double from = 0, to = 1;    // s, range of the loop
  double at = 0;              // s, present position
  double speed = 1;           // factor on the recorded speed; negative: backwards
  bool paused = false, loop = false;
  bool over = false;  // playback has reached its end; never true with a loop

  void set_range(double a, double b);
  /// Advances by `dt` seconds of real time.
  void advance(double dt);
  void seek(double t);
  /// Doubles or halves the speed, between 1/8 and 16.
  void faster(bool up);
};

}  // namespace typodont
