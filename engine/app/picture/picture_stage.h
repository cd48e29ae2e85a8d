// Draws the pictures of the bench from the servo's ticks. Contains a Vulkan device, a renderer and the screen of a
// display rig. The pictures are drawn offscreen or in a window (workbench.h). Render thread only.
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
#include "engine/render/tissue_light.h"
#include "engine/session/strings.h"
#include "haptics/servo.h"

namespace typodont {

class SoftGumView;

/// A tool and the handpiece that holds it, in the form in which they are drawn.
struct DrawnTool {
  render::ToolMesh tool;
  Handpiece handpiece;  // the drawn handpiece; it has no parts if the tool has no handpiece
  Pose X_GH;            // pose of the handpiece (frame H) relative to the drawn tool (frame G)
  /// true: the handpiece is not drawn where it hides the working point (see render::ToolState::open)
  bool open = false;
};
/// Makes the drawn form of a tool. `placed`: true if the tool's head (an implant) stays in the tissue, so that only its
/// driver is drawn. The handpiece turns with the hand about the tool's axis. If a hand measures only the axis, the
/// shortest rotation from the z axis of frame W to this axis is used (rotation_between); then the handpiece turns
/// continuously with the axis. Throws Error.
DrawnTool drawn_tool(const haptics::Tool& tool, const haptics::Spindle& spindle, const HandpieceView& view,
                     bool placed = false);
/// Returns true if the tool is an implant or screw that has been placed in the bone at this tick.
bool is_placed(const haptics::Tool& tool, const ServoTick& tick);
/// Returns the speed (rad/s) at which the drawn tool rotates about its z axis. Right-handed threads turn clockwise, as
/// seen from the shank, when they enter.
double drawn_spin(const haptics::Tool& tool, double spindle);

/// Gives the meshes of the surroundings to the renderer. `coarse`: true chooses the coarse meshes.
void surround(render::Renderer& renderer, const Surroundings& around, bool coarse = false);
/// Gives the bricks of the soft gum that have changed since `version` to the renderer, and updates `version`. `coarse`:
/// true if surround() gave the coarse meshes. The first call after surround() must have the version 0.
void show_gum(render::Renderer& renderer, const SoftGumView& gum, bool coarse, std::uint64_t& version);

/// Returns a box outside of which no tissue can appear during the session. Empty if there is no such box: if a tool of
/// the tool set adds tissue, or if undo can restore tissue that was removed before the session was resumed.
std::optional<render::BoxInWorld> tissue_reach(const Scene& scene, const haptics::TissueVolume& tissue);

/// Adds the statistics of a frame to the work counts.
void count_frame(const render::FrameStats& stats, WorkCounts& work);

/// Returns true if the picture looks the same for both poses of the tool: between them, the tool moves by at most a
/// hundredth of a pixel.
bool looks_same(const Pose& a, const Pose& b);

class PictureStage {
 public:
  struct Options {
    render::Quality quality = render::kQualityLadder[0];
    bool validation = false;
    bool window = false;    // false: the pictures are drawn offscreen; the user's head is tracked only with a window
    bool embedded = false;  // true: only pictures() are drawn, for the caller's window; no screen is composed
    gpu::Device* device = nullptr;  // the caller's GPU device; null: the PictureStage creates its own
    int monitor = -1;               // number of the monitor for full screen; −1: no full screen
    bool hud = true;
    bool force_in_hud = true;
    session::Language language = session::Language::kEnglish;  // language of the text over the picture
    bool tool = true;
    /// true: draws a row of dots from the tool's end to the point below it on the tissue, and a ring there
    bool cursor = false;
    double force_limit = 3;  // N, force at the end of the force bar
    HandpieceView handpieces;
  };
  /// Creates GPU device, renderer and screen. Throws Error if the computer has no Vulkan device, or no desktop for a
  /// window.
  PictureStage(const display::DisplayRig& rig, const haptics::ServoSettings& servo, const Options& options);
  ~PictureStage();
  PictureStage(const PictureStage&) = delete;
  PictureStage& operator=(const PictureStage&) = delete;

  /// Updates bricks (mesh blocks) of the working tooth. Positions are relative to `origin` (m, frame W).
  void show(std::span<const render::MeshUpdate> bricks, const dvec3& origin);

  /// Adds the static surroundings. Call it before the first bricks, so that mesh blocks behind the gum are not drawn.
  void surround(const Surroundings& around);
  /// Updates the bricks (mesh blocks) of the soft gum that have changed since the last call. Call it before each frame.
  void show_gum(const SoftGumView& gum);

  /// Sets the mouth mirror from the next frame on. Its diameter is 0 if there is none.
  void hold_mirror(const MouthMirror& mirror) { mirror_ = mirror; }
  /// Sets the suction tip from the next frame on. Its opening is 0 if there is none.
  void hold_suction(const SuctionTip& tip) { tip_ = tip; }
  /// Sets the particles, which are stored on this object's GPU device, from the next frame on. Null: there are none.
  void show_cloud(render::ParticleCloud* cloud) { cloud_ = cloud; }
  /// Updates the picture of the film of water and debris on the surfaces. Null: there is no film.
  void show_film(const FilmPicture* film) { FilmPicture::show(film, *renderer_, film_shown_); }
  /// Sets the view from the next frame on. `section`: tissue is drawn where section · (p_W, 1) > 0. Bodies that a view
  /// shows besides the surface are set by show_inside() (engine/app/picture/teaching_views.h).
  void show_as(render::View view, const glm::dvec4& section = {0, 0, 0, 1}) {
    view_ = view;
    section_ = section;
  }
  render::View view() const { return view_; }
  /// Shows or hides the tool in the picture.
  void show_tool(bool shown) { options_.tool = shown; }
  /// Uses the screen and the user's head position of this display rig from the next frame on.
  void look_from(const display::DisplayRig& rig);
  /// Replaces a body that only one view shows, for example render::kSectionFace. Positions are relative to `origin` (m,
  /// frame W).
  void show_inside(render::MeshId body, std::span<const render::MeshUpdate> bricks, const dvec3& origin);

  /// Draws and shows one frame. If drawn offscreen, waits until the frame is finished. `dt`: s since the last frame;
  /// the bur rotates by the corresponding angle.
  render::FrameStats draw(const ServoTick& tick, std::span<const render::Particle> particles, double dt,
                          const std::string& hint = "");

  /// Returns true if something inside the box may be visible in the next frame. An empty `box` means the whole space.
  bool in_sight(const std::optional<render::BoxInWorld>& box) const;

  /// Returns the pictures of both eyes, in the image layout for shaders.
  const gpu::Image& pictures() const { return renderer_->pictures(); }
  /// Returns true if pictures() contain no frame, because none was drawn since their size or quality changed.
  bool blank() const { return blank_; }
  /// Sets the size of the pictures in pixels. The display rig's panel gets the same aspect ratio. Call it only if
  /// Options::embedded is true. Returns true if the size changed.
  bool resize(glm::ivec2 eye_size);

  /// Sets the quality from the next frame on.
  void set_quality(const render::Quality& quality);
  const render::Quality& quality() const { return options_.quality; }

  /// Returns the triangles of the drawn tool without its handpiece.
  render::ToolMesh tool_triangles() const;
  render::Lights lights() const { return look().lights; }

  /// Returns the picture of one eye in the last frame (0 left, 1 right), without text.
  render::Picture eye(int index);
  /// Draws the text of the last frame over an eye's picture. The picture may have any size.
  void write_over(render::Picture& picture) const;
  /// Returns the text of the last frame.
  const display::Hud& hud() const { return hud_; }
  /// Returns the content of the screen after the last frame.
  render::Picture screen();

  /// Measured times of the last frame.
  struct Timing {
    double record = 0;  // s, time of preparation and submission on the CPU
    double gpu = 0;     // s, GPU time of the latest finished frame
    double shown = 0;   // s, estimated time from the start of draw() to the middle of the screen's next refresh
    /// Returns the larger one of CPU time and GPU time (s) of a frame. The wait for the screen is not included.
    double cost() const { return gpu > record ? gpu : record; }
  };
  const Timing& timing() const { return timing_; }
  /// Returns true if the tool did not move between the last two calls of draw().
  bool tool_at_rest() const { return at_rest_; }

  /// Returns the numbers of packets from the head tracker that were accepted and dropped; empty if the rig file has no
  /// head tracker.
  std::optional<display::HeadTracker::Stats> tracker_stats() const;

  /// Returns the window or memory in which the screen is composed. Call it only if Options::embedded is false.
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
  /// Adds the cursor of a tool at this pose: a ring to the frame, and dots to the drawn particles.
  void add_cursor(const Pose& X_WG, render::Frame& frame);

  display::DisplayRig rig_;
  display::Head rest_;  // pose of the user's head that the rig file states
  std::optional<display::HeadTracker> tracker_;
  /// s, running mean of the latency from the reading of the head tracker to the picture on the screen
  double latency_ = 1.0 / 30;
  haptics::ServoSettings servo_;
  Options options_;
  std::optional<gpu::Device> own_device_;
  gpu::Device& device_;
  gpu::FrameRing ring_;
  std::optional<render::Renderer> renderer_;
  std::optional<display::Compositor> compositor_;
  std::unique_ptr<display::Output> output_;
  Timing timing_;
  bool blank_ = true;    // true: no frame was drawn since the size or the quality of the pictures changed
  bool missed_ = false;  // true: the last frame was not shown, or the window is minimised
  glm::ivec2 screen_size_{0};
  /// m, vectors along the panel's lower edge (rightwards) and left edge (upwards), as the rig file states them
  std::array<dvec3, 2> first_panel_{};
  display::Hud hud_;
  Surroundings around_;
  std::vector<render::LitTriangle> tooth_;  // triangles of the working tooth as it was in the first frame
  bool tooth_known_ = false;                // true after the first frame, when `tooth_` is filled
  // Light that bodies reflect to each other, and the lamps for which it was computed. Used only in scenes with a mouth.
  std::optional<render::LightScene> light_scene_;
  std::optional<render::TissueLight> tissue_light_;
  render::Lights lit_by_;
  bool coarse_around_ = false;
  std::uint64_t gum_version_ = 0;  // value of SoftGumView::version() for the mesh that the renderer has received
  // Displayed numbers. read_age_: s, time since the numbers last changed; read_force_: N, force; read_spindle_: rad/s,
  // spindle speed.
  double read_age_ = 1, read_force_ = 0, read_spindle_ = 0;
  MouthMirror mirror_;
  SuctionTip tip_;
  render::ParticleCloud* cloud_ = nullptr;
  FilmPicture::Shown film_shown_;
  render::View view_ = render::View::kLook;
  glm::dvec4 section_{0, 0, 0, 1};
  double pixel_ = 0;                         // m, width of a pixel at the tooth in the last frame
  std::vector<render::Particle> with_dots_;  // particles of the debris, followed by the dots of the cursor
  double angle_ = 0;
  bool open_ = false;  // true: the handpiece is not drawn where it hides the working point (render::ToolState::open)
  Pose X_GH_;          // pose of the handpiece (frame H) relative to the drawn tool (frame G)
  Pose shown_at_;      // pose of the tool in the last frame
  bool at_rest_ = false;
  std::size_t shown_tool_ = 0;  // index of the drawn tool in the tool set
  bool shown_placed_ = false;   // true: the tool's head (an implant) stays in the tissue; only its driver is drawn
};

/// Creates a GPU device for pictures with these options. If the options request a window, the device can show it.
/// Throws Error if no Vulkan device or no window is available.
gpu::Device make_picture_device(const PictureStage::Options& options);

}  // namespace typodont
