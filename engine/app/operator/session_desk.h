// The session in the operator's window, from start to stored results. Main thread only.
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

/// Of authoring mode: what an exercise can be made from.
struct Authored {
  Scene scene;  // the scene that the author edited
  haptics::TissueVolume tissue;
  std::vector<PaintStroke> strokes;
  bool unsaved = false;  // painted or drilled, and not yet saved
};

/// A finished session without recording, to be scored.
struct Unscored {
  Scene scene;
  haptics::TissueVolume tissue;
  FinishedHand hand;
};

class SessionDesk {
 public:
  SessionDesk(OperatorState& s, InterfaceWindow& w) : s_(s), window_(w) {}

  bool running() const { return bench_.has_value(); }
  /// Throws; then no session runs.
  void start(const Scene& scene, const RigChoice& rig, const std::string& hand);
  enum class Turn { kSame, kChanged, kOver };
  /// kChanged: the trainee's picture, or the next second. kOver: must be ended.
  Turn step();
  /// After step(): the page rests, except for the clock.
  bool at_rest() const { return at_rest_; }
  /// Moves the recording to its folder. `why`: of an abnormal end. Returns what a score needs without a recording; null
  /// otherwise, also for authoring and failures.
  std::shared_ptr<const Unscored> end(const std::string& why);

  /// False: not a request to a running session.
  bool carry_out(const Request& r);
  void emergency_stop() { bench_->emergency_stop(); }

  /// Of the last session in authoring mode; otherwise null.
  Authored* authored() { return authored_.get(); }
  void forget_authored() { authored_.reset(); }

  /// Before the device is destroyed. Until the next one, the session has no picture.
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
  std::optional<Scene> scene_;  // empty: no session runs
  std::unique_ptr<Authored> authored_;
  bool brush_down_ = false;
  dvec3 brush_at_{0};
  std::filesystem::path recording_, written_,
      /// final path, path during the session, and saved tissue
      saved_;
  Nanos score_time_ = 0, curve_time_ = 0;
  Nanos picture_time_ = 0;  // time of the last new picture
  bool at_rest_ = false;
  Pose rests_at_;  // where the tool last moved visibly
};

}  // namespace typodont
