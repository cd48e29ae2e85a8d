// The session that runs in the operator's window. Starts the session, shows its state, executes requests, ends the
// session and stores its results. Main thread only.
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

/// Result of a session in authoring mode: the data from which an exercise can be made.
struct Authored {
  Scene scene;  // the scene that the author edited
  haptics::TissueVolume tissue;
  std::vector<PaintStroke> strokes;
  bool unsaved = false;  // true: tissue was painted or drilled, and not yet saved as an exercise
};

/// Data of a finished session that has no recording. Its score is computed from this data.
struct Unscored {
  Scene scene;
  haptics::TissueVolume tissue;
  FinishedHand hand;
};

class SessionDesk {
 public:
  SessionDesk(OperatorState& s, InterfaceWindow& w) : s_(s), window_(w) {}

  bool running() const { return bench_.has_value(); }
  /// Starts a session. If this fails, it throws the error, and no session runs.
  void start(const Scene& scene, const RigChoice& rig, const std::string& hand);
  enum class Turn { kSame, kChanged, kOver };
  /// Runs one step of the session. Returns kChanged if the trainee's picture changed or the clock shows the next
  /// second, and kOver if the session must be ended.
  Turn step();
  /// Returns true if nothing on the session's page, except the clock, has changed or will change without input. Valid
  /// after step().
  bool at_rest() const { return at_rest_; }
  /// Ends the session and moves the recording to its final folder. `why`: reason if the session ended abnormally. If
  /// the session has no recording but needs a score, returns the data for the score; otherwise null. Sessions in
  /// authoring mode and sessions that failed get no score.
  std::shared_ptr<const Unscored> end(const std::string& why);

  /// Executes a request that concerns a running session. Returns false for any other request.
  bool carry_out(const Request& r);
  void emergency_stop() { bench_->emergency_stop(); }

  /// Result of the last session if it ran in authoring mode; otherwise null.
  Authored* authored() { return authored_.get(); }
  void forget_authored() { authored_.reset(); }

  /// Frees the picture. Call it before the window's GPU device is destroyed. Until there is a new device, the session
  /// continues without a picture.
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
  std::optional<Scene> scene_;  // scene of the running session; no value if no session runs
  std::unique_ptr<Authored> authored_;
  bool brush_down_ = false;
  dvec3 brush_at_{0};
  std::filesystem::path recording_, written_,
      /// recording_: final path of the recording; written_: path of the recording during the session; saved_: path of
      /// the file with the saved tissue
      saved_;
  Nanos score_time_ = 0, curve_time_ = 0;
  Nanos picture_time_ = 0;  // time of the last new picture
  bool at_rest_ = false;
  Pose rests_at_;  // pose of the tool when it last moved visibly
};

}  // namespace typodont
