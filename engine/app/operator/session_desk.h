// The session in the operator's window. The object starts the session, shows its state, executes requests, ends the
// session and stores its results. Main thread.
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

/// Result of an authoring session: the data for an exercise.
struct Authored {
  Scene scene;  // the scene that was edited
  haptics::TissueVolume tissue;
  std::vector<PaintStroke> strokes;
  bool unsaved = false;  // true: tissue was painted or drilled, but is not yet saved as an exercise
};

/// Result of a session that is scored without a recording.
struct Unscored {
  Scene scene;
  haptics::TissueVolume tissue;
  FinishedHand hand;
};

class SessionDesk {
 public:
  SessionDesk(OperatorState& s, InterfaceWindow& w) : s_(s), window_(w) {}

  bool running() const { return bench_.has_value(); }
  /// Starts a session. If this fails, throws the error, and no session runs.
  void start(const Scene& scene, const RigChoice& rig, const std::string& hand);
  enum class Turn { kSame, kChanged, kOver };
  /// Executes one step. kChanged: the trainee's picture changed or the clock shows the next second; kOver: the
  /// session must be ended.
  Turn step();
  /// Valid after step(). True if, apart from the clock, nothing on the session's page has changed or will change
  /// without input.
  bool at_rest() const { return at_rest_; }
  /// Ends the session and moves the recording to its final place. `why`: reason of an abnormal end. If the session
  /// must be scored without a recording, returns its result. Returns null if there is a recording, or if there is
  /// nothing to score (an author's session, or a session that failed).
  std::shared_ptr<const Unscored> end(const std::string& why);

  /// Executes a request that concerns a running session; returns false for any other request.
  bool carry_out(const Request& r);
  void emergency_stop() { bench_->emergency_stop(); }

  /// Result of the last session if it was an authoring session.
  Authored* authored() { return authored_.get(); }
  void forget_authored() { authored_.reset(); }

  /// Call this function before the window's device is destroyed. The session continues without a picture until a new
  /// device exists.
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
  std::optional<Scene> scene_;  // scene of the session
  std::unique_ptr<Authored> authored_;
  bool brush_down_ = false;
  dvec3 brush_at_{0};
  std::filesystem::path recording_, written_,
      saved_;  // final path of the recording; its path during the session; path of the tissue
  Nanos score_time_ = 0, curve_time_ = 0;
  bool at_rest_ = false;
  Pose rests_at_;  // final pose of the tool
};

}  // namespace typodont
