// The session in the operator's window: begins it, shows turn by turn how it stands, passes on what is asked of it,
// ends it and keeps what it left. Main thread.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/state.h"
#include "engine/app/scene.h"
#include "engine/app/workbench.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// What an authoring session left: the makings of an exercise.
struct Authored {
  Scene scene;  // what it was made from
  haptics::TissueVolume tissue;
  std::vector<PaintStroke> strokes;
  bool unsaved = false;  // painted or drilled, and no exercise yet
};

/// What a session left that is scored without a recording.
struct Unscored {
  Scene scene;
  haptics::TissueVolume tissue;
  FinishedHand hand;
};

class SessionDesk {
 public:
  SessionDesk(OperatorState& s, InterfaceWindow& w) : s_(s), window_(w) {}

  bool running() const { return bench_.has_value(); }
  /// Throws what keeps it from beginning; then there is none.
  void start(const Scene& scene, const RigChoice& rig, const std::string& hand);
  enum class Turn { kSame, kChanged, kOver };
  /// kChanged: the trainee's picture is another, or the clock shows the next second; kOver: it has to be ended.
  Turn step();
  /// After a turn: nothing that the session's page shows has changed but the clock, nor will, of itself.
  bool at_rest() const { return at_rest_; }
  /// `why`: where that was no ordinary end. The recording is where it should be afterwards. Null where there is a
  /// recording to score, or nothing: an author's session, one that failed.
  std::shared_ptr<const Unscored> end(const std::string& why);

  /// What is asked of a running session; false where the request is about something else.
  bool carry_out(const Request& r);
  void emergency_stop() { bench_->emergency_stop(); }

  /// Of the last session, where it was one for authors.
  Authored* authored() { return authored_.get(); }
  void forget_authored() { authored_.reset(); }

  /// The window's device is about to go: the session goes on without a picture until there is another.
  void drop_picture();
  void make_picture();

 private:
  void show_task(const Scene& scene);
  void begin_views(const Scene& scene);
  void change_look();
  void show_own_view(bool own);
  void paint();
  void keep_recording();
  bool nothing_moves(const WorkbenchStatus& before) const;

  OperatorState& s_;
  InterfaceWindow& window_;
  std::optional<Workbench> bench_;
  std::optional<Scene> scene_;  // of the session
  std::unique_ptr<Authored> authored_;
  bool brush_down_ = false;
  dvec3 brush_at_{0};
  std::filesystem::path recording_, written_,
      saved_;  // where the recording should lie, where it is written; the tissue
  Nanos score_time_ = 0, curve_time_ = 0;
  bool at_rest_ = false;
  Pose rests_at_;  // where the tool came to rest
};

}  // namespace typodont
