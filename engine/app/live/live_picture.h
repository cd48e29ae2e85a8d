// The pictures of a live session: the trainee's picture on the rig's screen, and a picture from a free viewpoint.
// Also contains the objects that both pictures use: views, debris, level of detail, quality ladder. Drawing thread
// only.
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
#include "engine/app/picture/mirror_fog.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/quality_ladder.h"
#include "engine/app/picture/soft_gum_view.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/work_counts.h"

namespace typodont {

class LivePicture {
 public:
  struct Options {
    bool operated = false;  // the operator's window shows the texts of the session
    bool steered = false;   // an experiment asks about the force, so the force is not shown
    bool embedded = false;  // the picture is shown in the operator's window instead of a window of its own
    bool cursor = false;    // draws a cursor in space, for a hand that is visible only on the screen
    int monitor = -1;       // monitor for full screen; -1: a window
    session::Language language = session::Language::kEnglish;  // language of the text over the picture
    gpu::Device* device = nullptr;                             // the operator's device; null: create one
  };
  /// Draws nothing yet. `above`: m, W, initial position of the tool; `left_hand`: a second hand holds the mouth
  /// mirror. The scene and the session must outlive this object.
  LivePicture(const Scene& scene, const Options& options, LiveSession& session, const dvec3& above, bool left_hand);
  LivePicture(const LivePicture&) = delete;
  LivePicture& operator=(const LivePicture&) = delete;

  /// Opens the trainee's picture on the screen of `rig`; `rig` must outlive this object. Appends descriptions of the
  /// active features to `explanations`. Throws the same errors as PictureStage.
  void open(const display::DisplayRig& rig, std::vector<std::string>& explanations);
  /// Starts the measurement of time for the first turn.
  void begin() { last_turn_ = now(); }
  /// Stage of the trainee's picture; null if the picture is not drawn here.
  PictureStage* stage() { return stage_ ? &*stage_ : nullptr; }
  /// The views; null after close() was called.
  LiveViews* views() { return views_.get(); }
  /// Returns the balance of the removed mass. Call this function at the end of the session.
  std::optional<DebrisBalance> settle_debris();
  /// Waits for unfinished work at the end of the session. The trainee's last picture stays visible.
  void close();

  /// Stops drawing, because the device is about to be destroyed or is lost.
  void drop();
  /// Creates the pictures again. If the argument is null, on a device of their own.
  void make(gpu::Device* device);
  /// Creates a lost device again; returns false if the previous loss was too recent.
  bool recreate_lost_device();

  /// Collects the carver's changes since the last turn.
  void collect();
  /// One turn: draws a frame of each picture that changed, or waits briefly. `tick` receives the latest tick.
  void draw(ServoTick& tick, const std::string& hint, WorkCounts& work);
  /// Draws the picture from the free viewpoint if it is requested and due. `dt`: s since the last turn.
  void draw_own(const ServoTick& tick, double dt, WorkCounts& work);
  /// Sets the free viewpoint and the picture's size in pixels; a size of 0 switches the picture off.
  void look_from(const Viewpoint& from, glm::ivec2 pixels);
  const gpu::Image* own_picture() const { return own_stage_ && own_frames_ > 0 ? &own_stage_->pictures() : nullptr; }

  /// Switches to the next view: normal, section through the bur, glass, difference to the ideal (if the scene has one),
  /// and normal again. In an implant exercise the sections run along the arch and then across it, through the implant's
  /// axis.
  void show_next_view(const ServoTick& tick);
  /// Switches the suction on or off, if there is debris.
  void switch_suction();
  /// Switches the handpiece's water on or off, if the scene has spray.
  void switch_spray();
  bool has_spray() const { return debris_ && debris_->has_spray(); }
  bool spraying() const { return debris_ && debris_->spraying(); }
  bool shows_debris() const { return debris_.has_value(); }
  bool sucking() const { return sucking_; }
  double suction_flow() const;  // m³/s; 0: the suction is off
  /// Changes the colour of a tissue, sRGB, in both pictures.
  void color(Tissue tissue, const dvec3& color);

  const QualityLadder& ladder() const { return ladder_; }
  std::uint64_t frames() const { return frames_; }
  std::uint64_t own_frames() const { return own_frames_; }
  /// Latest time at which the first picture can have appeared on the screen; 0: no picture was shown.
  Nanos first_shown() const { return first_shown_; }
  /// Smoothed values in s: drawing time of a frame, interval between frames, and latency from hand to screen
  /// (estimated).
  double frame_seconds() const { return frame_seconds_; }
  double frame_period() const { return frame_period_; }
  double photon_seconds() const { return photon_seconds_; }

 private:
  void update_tissue_visibility();
  void follow_gum(const ServoTick& tick);
  bool in_one_window() const { return options_.embedded && own_size_.x > 0; }
  MouthMirror mirror_for(const Look& look);
  SuctionTip tip_for(const Look& look);
  void record_water();
  void suck(bool on);
  void move_debris(const ServoTick& tick, double dt, WorkCounts& work);
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
  haptics::ServoSettings shown_;             // the scene's settings, with the tissues' colours as displayed
  Surroundings around_;                      // surroundings of the tooth
  std::optional<MirrorFog> fog_;             // empty: the fog of the mouth mirror is constant
  std::optional<SoftGumView> gum_;           // empty if the gum is rigid
  std::optional<render::BoxInWorld> reach_;  // bounds of the tissue in world coordinates
  QualityLadder ladder_;
  std::optional<Detail> detail_;  // level of detail of the tooth in the trainee's picture
  std::optional<DebrisView> debris_;
  bool sucking_ = false;
  std::optional<WaterSwitch> water_;  // the state that was recorded last
  std::optional<PictureStage> stage_, own_stage_;
  std::unique_ptr<LiveViews> views_;  // declared after the pictures, to which they refer

  Viewpoint own_from_;
  glm::ivec2 own_size_{0};  // pixels, size of the picture from the free viewpoint; 0: it is not drawn
  Nanos own_drawn_ = 0;
  Nanos last_turn_ = 0, last_drawn_ = 0;
  Nanos revived_;  // time when the picture was last created again
  std::uint64_t frames_ = 0, own_frames_ = 0;
  int turns_since_first_ = 0;
  Nanos first_shown_ = 0;
  double frame_seconds_ = 0, frame_period_ = 0, photon_seconds_ = 0;
  bool drew_last_ = false;         // the last turn drew a frame
  std::uint64_t ladder_cuts_ = 0;  // number of cuts when the ladder last evaluated a frame
  std::optional<SeenFrom> seen_;   // the view that was recorded last
  int implant_section_ = 0;        // section of the implant: 0: along the arch, 1: across it
};

}  // namespace typodont
