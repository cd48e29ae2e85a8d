// Pictures of the bench: a Vulkan device, a renderer and the screen of a rig, drawn from the servo's ticks. The
// pictures are drawn offscreen or in a window (workbench.h). Render thread.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "engine/app/picture/detail.h"
#include "engine/app/picture/film_picture.h"
#include "engine/app/scene.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/work_counts.h"
#include "engine/contract/contact.h"
#include "engine/display/display_rig.h"
#include "engine/display/head_tracker.h"
#include "engine/display/output.h"
#include "engine/render/light_scene.h"
#include "engine/render/picture.h"
#include "engine/render/renderer.h"
#include "engine/render/sight.h"
#include "engine/session/strings.h"
#include "haptics/servo.h"

namespace typodont {

class SoftGumView;

/// A tool with the handpiece that holds it, as drawn.
struct DrawnTool {
  render::ToolMesh tool;
  Handpiece handpiece;  // without parts: none
  Pose X_GH;            // pose of the handpiece relative to the tool
  bool open = false;    // render::ToolState::open
};
/// `placed`: only the driver is drawn, because the tool's head stays in the tissue. The handpiece has a fixed pose
/// relative to the tool, so it rotates with the hand about the tool's axis. If a hand gives only the axis, the
/// shortest rotation from W's z to the axis is used (rotation_between). Then the body stays on its side, and its
/// direction changes continuously with the axis. Throws Error.
DrawnTool drawn_tool(const haptics::Tool& tool, const haptics::Spindle& spindle, const HandpieceView& view,
                     bool placed = false);
/// True if the tick belongs to an implant or screw that has been placed.
bool is_placed(const haptics::Tool& tool, const ServoTick& tick);
/// Speed in rad/s about the tool's z with which the tool is drawn: right-handed threads enter clockwise, as seen from
/// the shank.
double drawn_spin(const haptics::Tool& tool, double spindle);

/// Passes the surroundings of the working tooth to the renderer.
void surround(render::Renderer& renderer, const Surroundings& around, bool coarse = false);

/// Bounds outside of which the scene can never have tissue. Empty if no bounds exist, because a tool of the set adds
/// tissue or redo may restore earlier cuts.
std::optional<render::BoxInWorld> tissue_reach(const Scene& scene, const haptics::TissueVolume& tissue);

/// Adds the statistics of a frame to the work counts.
void count_frame(const render::FrameStats& stats, WorkCounts& work);

/// True if the difference between the poses is invisible: at most a hundredth of a pixel at the tool.
bool looks_same(const Pose& a, const Pose& b);

class PictureStage {
 public:
  struct Options {
    render::Quality quality = render::kQualityLadder[0];
    bool validation = false;
    bool window = false;    // false: offscreen; the user's head is tracked only with a window
    bool embedded = false;  // true: only pictures() are drawn, for the caller's window, and no screen is composed
    gpu::Device* device = nullptr;  // the caller's device; null: create one
    int monitor = -1;               // monitor for full screen; −1: a window
    bool hud = true;
    bool force_in_hud = true;
    session::Language language = session::Language::kEnglish;  // language of the text over the picture
    bool tool = true;
    bool cursor = false;  // draw a row of dots from the tool's end to the point where it would land, and a ring there
    double force_limit = 3;  // N, maximum of the force bar
    HandpieceView handpieces;
  };
  /// Creates device, renderer and screen. Throws Error if the machine has no Vulkan device, or no desktop for a window.
  PictureStage(const display::DisplayRig& rig, const haptics::ServoSettings& servo, const Options& options);
  ~PictureStage();
  PictureStage(const PictureStage&) = delete;
  PictureStage& operator=(const PictureStage&) = delete;

  /// Updates bricks of the working tooth; positions are relative to `origin` (m, W).
  void show(std::span<const render::MeshUpdate> bricks, const dvec3& origin);

  /// Adds the static surroundings; call before the first bricks, so that covered bricks are never drawn.
  void surround(const Surroundings& around);
  /// Updates the bricks of the soft gum that changed since the last call; call it before each frame.
  void show_gum(const SoftGumView& gum);

  /// Sets the mouth mirror from the next frame on; diameter 0: none.
  void hold_mirror(const MouthMirror& mirror) { mirror_ = mirror; }
  /// Sets the suction tip from the next frame on; opening 0: none.
  void hold_suction(const SuctionTip& tip) { tip_ = tip; }
  /// Sets the particles on the stage's device from the next frame on; null: none.
  void show_cloud(render::ParticleCloud* cloud) { cloud_ = cloud; }
  /// Updates the picture of the film on the surfaces; null: no film.
  void show_film(const FilmPicture* film) { FilmPicture::show(film, *renderer_, film_shown_); }
  /// Sets the view from the next frame on; `section` as in render::Frame. show_inside() provides the bodies that a view
  /// shows besides the surface (engine/app/picture/teaching_views.h).
  void show_as(render::View view, const glm::dvec4& section = {0, 0, 0, 1}) {
    view_ = view;
    section_ = section;
  }
  render::View view() const { return view_; }
  /// Shows or hides the tool.
  void show_tool(bool shown) { options_.tool = shown; }
  /// Uses screen and head of this rig from the next frame on.
  void look_from(const display::DisplayRig& rig);
  /// Replaces a body that only one view shows (for example render::kSectionFace); positions are relative to `origin`
  /// (m, W).
  void show_inside(render::MeshId body, std::span<const render::MeshUpdate> bricks, const dvec3& origin);

  /// Draws and shows one frame; if offscreen, waits for it. `dt`: s since the last frame, which rotates the bur.
  render::FrameStats draw(const ServoTick& tick, std::span<const render::Particle> particles, double dt,
                          const std::string& hint = "");

  /// True if the next frame may show something inside the box; an empty `box` means the whole space.
  bool in_sight(const std::optional<render::BoxInWorld>& box) const;

  /// The eyes' pictures in the image layout for shaders.
  const gpu::Image& pictures() const { return renderer_->pictures(); }
  /// Sets the size of the pictures in pixels; the rig's panel gets their aspect ratio. Call this only if embedded.
  /// Returns true if the size changed.
  bool resize(glm::ivec2 eye_size);

  /// Sets the quality from the next frame on.
  void set_quality(const render::Quality& quality);
  const render::Quality& quality() const { return options_.quality; }

  /// The triangles of the drawn tool without its handpiece, and the lamp.
  render::ToolMesh tool_triangles() const;
  render::Lights lights() const { return look().lights; }

  /// The last frame's picture of one eye (0 left, 1 right), without text.
  render::Picture eye(int index);
  /// Draws the last frame's text over an eye's picture of any size.
  void write_over(render::Picture& picture) const;
  /// Text of the last frame.
  const display::Hud& hud() const { return hud_; }
  /// The last frame's composed screen.
  render::Picture screen();

  /// Timing of the last frame.
  struct Timing {
    double record = 0;  // s, preparation and submission on the CPU
    double gpu = 0;     // s, GPU time of the latest finished frame
    double shown = 0;   // s, estimated time from the start of draw() to the middle of the screen's next refresh
    /// The larger one of CPU and GPU time, without the wait for the screen.
    double cost() const { return gpu > record ? gpu : record; }
  };
  const Timing& timing() const { return timing_; }
  /// True if the tool did not move between the last two calls of draw().
  bool tool_at_rest() const { return at_rest_; }

  /// Numbers of accepted and dropped packets of the head tracker; empty if the rig has none.
  std::optional<display::HeadTracker::Stats> tracker_stats() const;

  /// The screen. An embedded stage has no screen.
  display::Output& output() { return *output_; }
  const display::DisplayRig& rig() const { return rig_; }
  gpu::Device& device() { return device_; }
  std::string device_name() const { return device_.name(); }
  int validation_messages() const { return device_.validation_messages(); }

 private:
  render::Frame look() const;
  void follow_size();
  void take_up(std::uint32_t tool_index, bool placed = false);
  const haptics::Tool& tool() const;
  void follow_head();
  void follow_pixels(double pixel);
  void follow_light(const render::Lights& lights);
  /// Adds the cursor of a tool at this pose: a ring to the frame, and dots to the particles.
  void add_cursor(const Pose& X_WG, render::Frame& frame);

  display::DisplayRig rig_;
  display::Head rest_;  // the head's pose in the rig file
  std::optional<display::HeadTracker> tracker_;
  double latency_ = 1.0 / 30;  // s, running mean of the time from reading the tracker to the picture on the screen
  haptics::ServoSettings servo_;
  Options options_;
  std::optional<gpu::Device> own_device_;
  gpu::Device& device_;
  gpu::FrameRing ring_;
  std::optional<render::Renderer> renderer_;
  std::optional<display::Compositor> compositor_;
  std::unique_ptr<display::Output> output_;
  Timing timing_;
  bool missed_ = false;  // true if the last frame was not shown, or if the window is minimised
  glm::ivec2 screen_size_{0};
  std::array<dvec3, 2> first_panel_{};  // m, right and up edges of the panel in the rig file
  display::Hud hud_;
  Surroundings around_;
  std::vector<render::LitTriangle> tooth_;  // the working tooth as it was in the first frame
  bool tooth_known_ = false;                // true from the first frame on
  // Light between the bodies, and the lights for which it was computed; only in scenes with a mouth.
  std::optional<render::LightScene> light_scene_;
  render::Lights lit_by_;
  bool coarse_around_ = false;
  std::uint64_t gum_version_ = 0;  // SoftGumView::version() in the renderer
  // s, time since the displayed numbers changed; N, displayed force; rad/s, displayed spindle speed
  double read_age_ = 1, read_force_ = 0, read_spindle_ = 0;
  MouthMirror mirror_;
  SuctionTip tip_;
  render::ParticleCloud* cloud_ = nullptr;
  FilmPicture::Shown film_shown_;
  render::View view_ = render::View::kLook;
  glm::dvec4 section_{0, 0, 0, 1};
  double pixel_ = 0;                         // m, size of a pixel of the last frame on the tooth
  std::vector<render::Particle> with_dots_;  // the debris particles and the cursor's dots
  double angle_ = 0;
  bool open_ = false;  // render::ToolState::open
  Pose X_GH_;          // pose of the handpiece relative to the tool
  Pose shown_at_;      // the tool's pose in the last frame
  bool at_rest_ = false;
  std::size_t shown_tool_ = 0;  // index of the drawn tool in the tool set
  bool shown_placed_ = false;   // true if the head of the drawn tool stays in the tissue
};

/// Creates a device for pictures with these options, with a window's extensions if necessary. Throws the same errors as
/// PictureStage.
gpu::Device make_picture_device(const PictureStage::Options& options);

}  // namespace typodont
