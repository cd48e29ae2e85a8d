// The pictures of a live session: the trainee's picture on the display rig's screen, and a picture from a free
// viewpoint. Owns what both share: views, debris, level of detail, choice of the quality. Render thread only.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/live/session.h"
#include "engine/app/picture/detail.h"
#include "engine/app/picture/frame_report.h"
#include "engine/app/picture/live_views.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/quality_ladder.h"
#include "engine/app/picture/world.h"
#include "engine/app/work_counts.h"

namespace typodont {

class LivePicture {
 public:
  struct Options {
    // True: the operator's window shows the session's texts, so this picture shows none.
    bool operated = false;
    bool steered = false;        // true: an experiment asks about the force, so the picture does not show the force
    bool embedded = false;       // true: the picture is part of the operator's window; false: it has its own window
    display::UrgentKeys urgent;  // keys of the picture's own window that are handled without waiting for a frame
    /// True: draws dots and a ring at the point below the tool, for a hand that the user sees only on the screen.
    bool cursor = false;
    int monitor = -1;                                          // monitor number for full screen; -1: no full screen
    session::Language language = session::Language::kEnglish;  // language of the text over the picture
    std::string quality;  // quality level's name; empty: chosen from the frames' drawing times
    /// The operator's GPU device; null: the picture creates its own.
    gpu::Device* device = nullptr;
  };
  /// Prepares the pictures without drawing. `start`: state of the tool before the first tick. The scene and the session
  /// must outlive this object.
  LivePicture(const Scene& scene, const Options& options, LiveSession& session, const ServoTick& start);
  LivePicture(const LivePicture&) = delete;
  LivePicture& operator=(const LivePicture&) = delete;

  /// Opens the trainee's picture on the screen of `rig`. The rig must outlive this object. Adds to `explanations` a
  /// text about each active feature. Throws Error if no Vulkan device or no window is available.
  void open(const display::DisplayRig& rig, std::vector<std::string>& explanations);
  /// Stores the time at which the drawing loop starts. The duration of its first pass is measured from this time.
  void begin() { last_turn_ = now(); }
  /// The object that draws the trainee's picture; null if this computer does not draw it.
  PictureStage* stage() { return stage_ ? &*stage_ : nullptr; }
  /// The views for teaching; null after close() was called.
  LiveViews* views() { return views_.get(); }
  /// The debris' mass balance. Call at the session's end.
  std::optional<DebrisBalance> settle_debris();
  /// Ends unfinished work at the session's end. The trainee's last picture stays visible.
  void close();

  /// Releases all GPU objects, because the GPU device is lost or about to be destroyed.
  void drop();
  /// Creates the pictures again on this GPU device. If `device` is null, the pictures create their own device.
  void make(gpu::Device* device);
  /// Creates the GPU device again after it was lost. False if the device was already lost a short time before.
  bool recreate_lost_device();

  /// Before the surface arrives: lets another thread create pipelines of the trainee's picture (PictureStage::prepare).
  void prepare() { stage_->prepare(world_, views_->look(Eyes::kTrainee)); }
  /// Receives the parts of the surface that the carver thread has computed since the last call.
  void collect();
  /// True after collect() has received the whole surface once.
  bool has_surface() const { return has_surface_; }
  /// Computes the temperatures, if the scene has the key "heat". Call before the first event. `rate`: ticks per second,
  /// Hz.
  void add_heat(double rate) { world_.add_heat(session_.carver.volume(), rate); }
  /// Adds the warnings of these levels. Call before the first event. Throws Error.
  void add_warnings(const session::WarningLevels& levels) { world_.add_warnings(session_.carver.volume(), levels); }
  /// Applies an event of the servo to the state of the session that the pictures show.
  void apply(const ServoEvent& event) { world_.apply(event); }
  void apply(const CarverEvent& event) { world_.apply(event); }
  /// Runs one pass of the drawing loop: draws a frame of each picture that has changed, or waits for a short time.
  void draw(const std::string& hint, WorkCounts& work);
  /// Draws the picture from the free viewpoint if it is requested and the interval since its last frame has passed.
  void draw_own(WorkCounts& work);
  /// Sets the free viewpoint and the size of its picture in pixels. A size of 0 switches this picture off.
  void look_from(const Viewpoint& from, glm::ivec2 pixels);
  const gpu::Image* own_picture() const { return own_stage_ && own_frames_ > 0 ? &own_stage_->pictures() : nullptr; }

  /// Switches to the next view: normal, section through the bur, transparent tooth, difference from the target shape
  /// (if the exercise has one), normal again. An implant exercise has two sections through the implant's axis, along
  /// the arch and across it.
  void show_next_view();
  /// Switches the suction on or off. Has an effect only if the scene has debris.
  void switch_suction();
  /// Switches the handpiece's water on or off. Has an effect only if the scene has spray.
  void switch_spray();
  const World& world() const { return world_; }

  const QualityLadder& ladder() const { return ladder_; }
  /// Text about the quality level and what would improve the picture; empty: the level is good and did not change.
  std::string quality_notice() const;
  /// GPU times and late frames of the trainee's picture since the first tick.
  const FrameReport& report() const { return report_; }
  std::uint64_t frames() const { return frames_; }
  std::uint64_t own_frames() const { return own_frames_; }
  /// Time at which the first picture appeared on the screen, or slightly later, ns. 0: no picture was shown.
  Nanos first_shown() const { return first_shown_; }
  /// The next functions return smoothed times, s: drawing time of a frame, interval between two frames, estimated
  /// latency from hand to screen.
  double frame_seconds() const { return frame_seconds_; }
  double frame_period() const { return frame_period_; }
  double photon_seconds() const { return photon_seconds_; }

 private:
  void update_tissue_visibility();
  bool in_one_window() const { return options_.embedded && own_size_.x > 0; }
  void record_water();
  void follow(const render::FrameStats& stats, double dt);
  RefreshPeriod refresh_period();
  void frame_shown();
  void record_view();
  glm::dvec4 section_through_implant() const;
  void follow_implant();

  const Scene& scene_;
  const Options options_;
  LiveSession& session_;
  World world_;
  EventLog<haptics::HandSample>::Reader left_;
  const display::DisplayRig* rig_ = nullptr;
  haptics::ServoSettings shown_;             // copy of the scene's servo settings, for the pictures
  std::optional<render::BoxInWorld> reach_;  // m, frame W: box that contains the tissue
  QualityLadder ladder_;
  FrameReport report_;
  std::optional<Detail> detail_;      // level of detail of the tooth in the trainee's picture
  std::optional<WaterSwitch> water_;  // state of water and suction that was recorded last
  std::optional<PictureStage> stage_, own_stage_;
  std::unique_ptr<LiveViews> views_;  // declared after the pictures, because this object refers to them

  Viewpoint own_from_;
  glm::ivec2 own_size_{0};  // pixels, size of the picture from the free viewpoint; 0: it is not drawn
  Nanos own_drawn_ = 0;
  Nanos last_turn_ = 0, last_drawn_ = 0;
  Nanos drawn_turn_ = 0;  // ns, start of the last call of draw() that drew the trainee's picture
  Nanos revived_;         // ns, when the GPU device was last created again
  std::uint64_t frames_ = 0, own_frames_ = 0;
  int turns_since_first_ = 0;
  Nanos first_shown_ = 0;
  double frame_seconds_ = 0, frame_period_ = 0, photon_seconds_ = 0;
  bool drew_last_ = false;  // true if the last drawing pass drew a frame
  bool has_surface_ = false;
  bool new_quality_ = false;  // true: the next frame has the quality of ladder_
  // Number of cuts in the session when ladder_ (QualityLadder) last evaluated a frame.
  std::uint64_t ladder_cuts_ = 0;
  std::optional<SeenFrom> seen_;  // viewpoint and view that were recorded last
  int implant_section_ = 0;       // section through the implant: 0 along the arch, 1 across
};

}  // namespace typodont
