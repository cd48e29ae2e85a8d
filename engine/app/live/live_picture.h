// What a live session shows: the trainee's picture on the rig's screen, and one from a viewpoint of one's own; the
// views, the debris, the level of detail and the ladder of quality they share. Drawing thread only.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/live/session.h"
#include "engine/app/picture/debris_view.h"
#include "engine/app/picture/detail.h"
#include "engine/app/picture/live_views.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/quality_ladder.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/work_counts.h"

namespace typodont {

class LivePicture {
 public:
  struct Options {
    bool operated = false;          // the operator's window says what else stands in the picture
    bool embedded = false;          // shown in the operator's window, not in one of its own
    bool cursor = false;            // one in space, for a hand that is seen on the screen only
    int monitor = -1;               // full screen on this one; -1: a window on the desktop
    gpu::Device* device = nullptr;  // the operator's; null: one of its own
  };
  /// `above`: m, W, where the tool starts; `left_hand`: one holds the mouth mirror. The scene and the session outlive
  /// this. Nothing is drawn yet.
  LivePicture(const Scene& scene, const Options& options, LiveSession& session, const dvec3& above, bool left_hand);
  LivePicture(const LivePicture&) = delete;
  LivePicture& operator=(const LivePicture&) = delete;

  /// The trainee's picture on the screen of this rig, which outlives this; what of it is active goes to `explanations`.
  /// Throws like PictureStage.
  void open(const display::DisplayRig& rig, std::vector<std::string>& explanations);
  /// The session begins: the first turn's time is counted from here.
  void begin() { last_turn_ = now(); }
  /// Null where the trainee's is not drawn here.
  PictureStage* stage() { return stage_ ? &*stage_ : nullptr; }
  /// Null once closed.
  LiveViews* views() { return views_.get(); }
  /// The session is over: where the mass of all that was cut went.
  std::optional<debris::DebrisLedger> settle_debris();
  /// The session is over: waits for what is still being made. The trainee's last picture stays.
  void close();

  /// The device is about to go, or is lost: drawn no more …
  void drop();
  /// … until there is another; null: one of its own.
  void make(gpu::Device* device);
  /// The lost device made anew; false when it was lost just before, too.
  bool revive();

  /// What the carver changed since the last turn.
  void collect();
  /// One turn: a frame of each picture that shows something new, or a short wait. `tick`: the newest is put there.
  void draw(ServoTick& tick, const std::string& hint, WorkCounts& work);
  /// The picture from a viewpoint of one's own, where it is wanted and due; `dt`: s since the last turn.
  void draw_own(const ServoTick& tick, double dt, WorkCounts& work);
  /// Pixels of 0: no more.
  void look_from(const Viewpoint& from, glm::ivec2 pixels);
  const gpu::Image* own_picture() const { return own_stage_ && own_frames_ > 0 ? &own_stage_->pictures() : nullptr; }

  /// As it looks, cut open where the bur is, as glass, against the ideal where the scene has one, and again as it
  /// looks. In an implant exercise it is cut open along the arch and then across it, through the implant's axis.
  void show_next_view(const ServoTick& tick);
  /// The suction on or off, where there is debris.
  void switch_suction();
  bool shows_debris() const { return debris_.has_value(); }
  bool sucking() const { return sucking_; }
  /// Another colour of a tissue, sRGB, in both pictures.
  void color(Tissue tissue, const dvec3& color);

  const QualityLadder& ladder() const { return ladder_; }
  std::uint64_t frames() const { return frames_; }
  std::uint64_t own_frames() const { return own_frames_; }
  /// When the first was on the screen, at the latest; 0: there was none.
  Nanos first_shown() const { return first_shown_; }
  /// s, smoothed: what a frame takes, how long after the last it comes, and from hand to screen (estimated).
  double frame_seconds() const { return frame_seconds_; }
  double frame_period() const { return frame_period_; }
  double photon_seconds() const { return photon_seconds_; }

 private:
  void look_for_tissue();
  bool in_one_window() const { return options_.embedded && own_size_.x > 0; }
  MouthMirror mirror_for(const Look& look);
  void suck(bool on);
  void move_debris(double dt, WorkCounts& work);
  void follow(const render::FrameStats& stats, double dt, const ServoTick& tick);
  void frame_shown();
  void record_view();
  glm::dvec4 section_through_implant(const ServoTick& tick) const;
  void follow_implant(const ServoTick& tick);

  const Scene& scene_;
  const Options options_;
  LiveSession& session_;
  const dvec3 above_;
  const bool left_hand_;
  const display::DisplayRig* rig_ = nullptr;
  haptics::ServoSettings shown_;             // the scene's, with tissues in the colours they are drawn in
  Surroundings around_;                      // of the tooth
  std::optional<render::BoxInWorld> reach_;  // of the tissue
  QualityLadder ladder_;
  std::optional<Detail> detail_;  // of the tooth in the trainee's picture
  std::optional<DebrisView> debris_;
  bool sucking_ = false;
  std::optional<PictureStage> stage_, own_stage_;
  std::unique_ptr<LiveViews> views_;  // after the pictures, which they refer to

  Viewpoint own_from_;
  glm::ivec2 own_size_{0};  // 0: there is none
  Nanos own_drawn_ = 0;
  Nanos last_turn_ = 0, last_drawn_ = 0;
  Nanos revived_;  // when the picture was last made anew
  std::uint64_t frames_ = 0, own_frames_ = 0;
  int turns_since_first_ = 0;
  Nanos first_shown_ = 0;
  double frame_seconds_ = 0, frame_period_ = 0, photon_seconds_ = 0;
  bool drew_last_ = false;         // the last turn drew a frame
  std::uint64_t ladder_cuts_ = 0;  // when the ladder last looked at one
  std::optional<SeenFrom> seen_;   // as last given to the recording
  int implant_section_ = 0;        // 0: along the arch, 1: across it
};

}  // namespace typodont
