// A recorded session as it can be watched: tissue and tool at any moment, forward and back. What is shown is what was
// recorded: the same cuts in the same order, the strokes that were taken back taken back. Drawing thread.
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

class SessionPlayer {
 public:
  /// Throws Error when the file is no session with ticks, or its tissue is not there or has changed.
  explicit SessionPlayer(const std::filesystem::path& session);

  const session::SessionReader& session() const { return session_; }
  const Scene& scene() const { return scene_; }
  double begin() const { return begin_; }  // s, of the recording's ticks
  double end() const { return end_; }

  /// To this moment, s. Forward it costs the cuts on the way; back, the strokes on the way and part of one.
  void seek(double t);
  /// The last one not after that moment.
  const ServoTick& tick() const { return tick_; }
  /// Made on the way there, when it was forward: for chips.
  std::span<const Cut> fresh_cuts() const { return fresh_; }
  const haptics::TissueVolume& tissue() const { return carver_->volume(); }
  /// Whose surface this changes: from now on smooth to `tolerance` voxels, everything once more.
  void smooth_to(float tolerance);
  /// Bricks whose surface changed since it was last asked.
  std::vector<render::MeshUpdate> take_surface();

 private:
  /// What happened to the tissue, one after another.
  struct Deed {
    Nanos t = 0;
    const Cut* cut = nullptr;  // null: an edit
    bool redo = false;
  };
  /// What has to be taken back to go back.
  struct Done {
    enum class Kind { kStroke, kUndo, kRedo } kind;
    std::size_t first;    // of deeds_
    std::size_t strokes;  // in the tissue once it was begun
    bool forgets;         // strokes that were undone: no way back
  };
  void from_the_start();
  void go_back(Nanos t);
  void go_on(Nanos t);

  session::SessionReader session_;
  Scene scene_;
  double begin_ = 0, end_ = 0;
  std::vector<Deed> deeds_;
  std::optional<haptics::Carver> carver_;
  std::size_t next_ = 0;  // of deeds_
  std::vector<Done> done_;
  std::vector<Cut> fresh_;
  std::vector<ServoTick> block_;  // some ticks, read at once
  ServoTick tick_;
  float tolerance_ = 0.1f;
  std::optional<TissueView> view_;
  std::set<std::uint64_t> shown_;  // bricks with triangles that take_surface() gave
  bool anew_ = false;              // the carver began again since
};

/// Where playing stands: seeking, speed, a loop. Pure.
struct PlayClock {
  double begin = 0, end = 1;  // s, of what can be played
  double from = 0, to = 1;    // s, of the loop
  double at = 0;              // s
  double speed = 1;           // negative: backwards
  bool paused = false, loop = false;
  bool over = false;  // came to its end, which a loop never does

  void set_range(double a, double b);
  /// `dt` seconds pass for who watches.
  void advance(double dt);
  void seek(double t);
  /// Twice or half as fast, from an eighth to sixteen times.
  void faster(bool up);
};

}  // namespace typodont
