// Plays a recorded session: restores its tissue and its World at any time, forward and backward. Render thread only.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "engine/app/picture/tissue_view.h"
#include "engine/app/picture/world.h"
#include "engine/app/recording/file_source.h"
#include "engine/app/recording/recorded_tissue.h"
#include "engine/app/scene.h"
#include "engine/session/session_file.h"

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

  /// Computes the temperatures from now on, if the scene has the key "heat".
  void add_heat();
  /// Moves to the time t, s. `backwards`: the playback runs backwards; chips and water are then not shown.
  void seek(double t, bool backwards = false);
  World& world() { return world_; }
  /// Event logs with the events up to the current time.
  const EventLogs& event_logs() const { return source_.event_logs(); }
  haptics::Carver& carver() { return tissue_.carver(); }
  const haptics::TissueVolume& tissue() const { return tissue_.carver().volume(); }
  /// Sets the tolerance of the mesh, voxels. All mesh bricks are then meshed again.
  void smooth_to(float tolerance);
  /// Bricks of the mesh that changed since the previous call.
  std::vector<render::MeshUpdate> take_surface();

 private:
  session::SessionReader session_;
  Scene scene_;
  RecordedTissue tissue_;
  FileSource source_;
  World world_;
  WorldReader reader_{world_, source_.event_logs()};
  double begin_ = 0, end_ = 0;
  bool backwards_ = false;
  float tolerance_ = 0.1f;
  std::optional<TissueView> view_;
  std::set<std::uint64_t> shown_;  // the mesh bricks that take_surface() returned with triangles
  int meshed_ = 0;                 // value of RecordedTissue::restarts() at the last take_surface()
};

/// State of the playback: position, speed, loop. It does not read a clock.
struct PlayClock {
  double begin = 0, end = 1;  // s, range of times that can be played
  double from = 0, to = 1;    // s, range of times that is repeated in a loop
  double at = 0;              // s, current time of the playback
  double speed = 1;           // multiple of the recorded speed; negative: backwards
  bool paused = false, loop = false;
  bool over = false;  // true: the playback has reached its end; never true if the range is repeated

  void set_range(double a, double b);
  /// Advances by `dt` seconds of real time, multiplied by the speed.
  void advance(double dt);
  void seek(double t);
  /// Doubles (`up`) or halves the speed, between 1/8 and 16.
  void faster(bool up);
};

}  // namespace typodont
