// Runs a session in the operator's window, from the start to the stored results. Main thread only.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/long_work.h"
#include "engine/app/operator/state.h"
#include "engine/app/scene.h"
#include "engine/app/workbench.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Result of authoring mode, usable for an exercise.
struct Authored {
  Scene scene;  // the scene that the author edited
  haptics::TissueVolume tissue;
  std::vector<PaintStroke> strokes;
  bool unsaved = false;  // true: the author has painted or drilled since the last save
};

/// A finished session without a recording, still to be scored.
struct Unscored {
  Scene scene;
  haptics::TissueVolume tissue;
  FinishedHand hand;
};

class SessionDesk {
 public:
  SessionDesk(OperatorState& s, InterfaceWindow& w, BackgroundTask& work) : s_(s), window_(w), work_(work) {}

  /// Shows the loading page, and sets up a session in the background. `read`: reads the scene, on another thread. If
  /// this fails or is cancelled, shows the page from before, with the reason.
  void start(std::function<Scene()> read, const RigChoice& rig, const std::string& hand);
  /// Cancels start(), if the session's time does not run yet.
  void cancel_start();
  /// True from the end of the set-up to the end of the session: step() must be called.
  bool running() const { return bench_ != nullptr; }
  /// True while the session's time runs.
  bool started() const { return started_; }
  /// True while the GPU draws a first picture. A page would be shown only after that.
  bool drawing() const;
  enum class Turn { kSame, kChanged, kOver };
  /// Runs one step: draws a first picture, or continues the session. kChanged: the trainee's picture has changed, or a
  /// second has passed. kOver: the session must be ended.
  Turn step();
  /// True after step() if nothing on the page moves except the clock.
  bool at_rest() const { return at_rest_; }
  /// Ends a started session; moves its recording to its folder or deletes it. `why`: reason of an abnormal end. Returns
  /// the data for a score if no recording is kept. Returns null if one is kept, and after authoring mode or a failure.
  std::shared_ptr<const Unscored> end(const std::string& why);

  /// Executes a request that concerns the session. False: a request of another kind; nothing was done.
  bool carry_out(const Request& r);
  void emergency_stop() { bench_->emergency_stop(); }

  /// Result of the last session in authoring mode; otherwise null.
  Authored* authored() { return authored_.get(); }
  void forget_authored() { authored_.reset(); }

  /// Removes the picture before the GPU device is destroyed. The session has no picture until make_picture() is called.
  void drop_picture();
  void make_picture();

 private:
  struct SetUp;
  void open(SetUp made);
  Turn begin();
  void give_up();
  void show_task(const Scene& scene);
  void begin_views(const Scene& scene);
  void show_own_view(bool own);
  /// Chooses the tool of the step that begins. Does nothing if the hand chooses its tools itself.
  void take_step_tool();
  void paint();
  void keep_recording();
  bool nothing_moves(const WorkbenchStatus& before) const;

  OperatorState& s_;
  InterfaceWindow& window_;
  BackgroundTask& work_;  // sets up the session
  std::unique_ptr<Workbench> bench_;
  std::optional<Scene> scene_;       // the scene of `bench_`
  Page page_before_ = Page::kStart;  // page from which the session was started
  bool wanted_ = false;              // false: the user has cancelled the start
  bool started_ = false;
  std::unique_ptr<Authored> authored_;
  bool brush_down_ = false;
  dvec3 brush_at_{0};
  // recording_: final path of the recording; written_: its path during the session; saved_: path of saved tissue.
  std::filesystem::path recording_, written_, saved_;
  Nanos score_time_ = 0, curve_time_ = 0;
  Nanos picture_time_ = 0;  // ns, time of the last new picture
  bool at_rest_ = false;
  Viewpoint seen_from_;  // viewpoint of the last step()
  Pose rests_at_;        // pose of the tool when it last moved visibly
};

}  // namespace typodont
