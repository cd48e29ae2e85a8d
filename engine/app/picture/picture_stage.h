// Draws the pictures of a World and its tissue, offscreen or in a window (workbench.h). Contains a Vulkan device, a
// renderer and the screen of a display rig. Render thread only.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "engine/app/picture/detail.h"
#include "engine/app/picture/film_picture.h"
#include "engine/app/picture/look.h"
#include "engine/app/picture/mouth_light.h"
#include "engine/app/picture/temperature_picture.h"
#include "engine/app/picture/world.h"
#include "engine/app/scene.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/work_counts.h"
#include "engine/contract/contact.h"
#include "engine/display/display_rig.h"
#include "engine/display/head_tracker.h"
#include "engine/display/output.h"
#include "engine/render/picture.h"
#include "engine/render/renderer.h"
#include "engine/render/sight.h"
#include "engine/session/strings.h"
#include "haptics/servo.h"

namespace typodont {

/// A tool and the handpiece that holds it, in the form in which they are drawn.
struct DrawnTool {
  render::ToolMesh tool;
  Handpiece handpiece;  // the drawn handpiece; without parts if there is none
  Pose X_GH;            // pose of the handpiece (frame H) relative to the drawn tool (frame G)
  /// True: the handpiece is not drawn where it hides the working point (see render::ToolState::open).
  bool open = false;
};
/// Makes the drawn form of a tool. `placed`: the tool's head (an implant) stays in the tissue, so only its driver is
/// drawn. Throws Error. The handpiece rotates with the hand about the tool's axis. If the input device measures only
/// the direction of the axis, the rotation is the shortest one from z of W to this axis (rotation_between), which
/// changes continuously.
DrawnTool drawn_tool(const haptics::Tool& tool, const haptics::Spindle& spindle, const HandpieceView& view,
                     bool placed = false);
/// True if the tool is an implant or screw that has been placed in the bone at this tick.
bool is_placed(const haptics::Tool& tool, const ServoTick& tick);
/// Gives the meshes of the surroundings to the renderer. `coarse`: true chooses the coarse meshes.
void surround(render::Renderer& renderer, const Surroundings& around, bool coarse = false);

/// Adds tool, mouth mirror and suction tip to a frame.
void add_held(const World& world, const Look& look, render::Frame& frame);

/// The state of a World that a renderer has received: tool, soft gum, film of water and temperatures.
class ShownWorld {
 public:
  explicit ShownWorld(const HandpieceView& handpieces) : handpieces_(handpieces) {}
  /// Makes the next frame send the deformed gum to the renderer. Call after surround(), which has sent the gum at rest.
  void gum_at_rest() { gum_version_ = 0; }
  /// Passes changes to the renderer, and adds the world to the frame. `coarse`: true if surround() passed
  /// coarse meshes, false if it passed fine ones; empty: it passed none.
  void add(World& world, const Look& look, std::optional<bool> coarse, render::Renderer& renderer,
           render::Frame& frame);

 private:
  HandpieceView handpieces_;
  std::optional<std::uint32_t> tool_;  // index in the tool set; empty: none drawn yet
  bool placed_ = false;                // true: the tool's head (an implant) stays in the tissue
  Pose X_GH_;                          // pose of the handpiece (frame H) relative to the drawn tool (frame G)
  bool open_ = false;                  // true: the handpiece is not drawn where it hides the working point
  std::uint64_t gum_version_ = 0;
  FilmPicture::Shown film_;
  ShownTemperatures temperatures_;
};

/// Box outside of which no tissue can appear during the session. Empty if a tool of the tool set adds tissue, or if
/// undo can restore tissue that was removed before the session was resumed.
std::optional<render::BoxInWorld> tissue_reach(const Scene& scene, const haptics::TissueVolume& tissue);

/// Adds the statistics of a frame to the work counts.
void count_frame(const render::FrameStats& stats, WorkCounts& work);

/// True if the tool moves by at most a hundredth of a pixel between the two poses, so that the picture looks the same.
bool looks_same(const Pose& a, const Pose& b);

class PictureStage {
 public:
  struct Options {
    render::Quality quality = render::kQualityLadder[0];
    bool validation = false;
    bool window = false;    // false: the pictures are drawn offscreen; the user's head is tracked only with a window
    bool embedded = false;  // true: only pictures() are drawn, for the caller's window; no screen is composed
    gpu::Device* device = nullptr;  // the caller's GPU device; null: the PictureStage creates its own
    display::UrgentKeys urgent;     // keys that the window handles at once, without waiting for a frame
    int monitor = -1;               // monitor number for full screen; −1: no full screen
    bool hud = true;
    bool warnings = false;  // true: warnings are shown even if `hud` is false
    bool force_in_hud = true;
    session::Language language = session::Language::kEnglish;  // language of the text over the picture
    bool chips_on_gpu = true;                                  // false: another PictureStage moves this GPU's chips
    /// True: draws a row of dots from the tool's end to the point below it on the tissue, and a ring there.
    bool cursor = false;
    MouthLight::When light = MouthLight::When::kAtOnce;
    double force_limit = 3;  // N, force at the end of the force bar
    HandpieceView handpieces;
  };
  /// Creates GPU device, renderer and screen. Throws Error if the computer has no Vulkan device, or no desktop for a
  /// window.
  PictureStage(const display::DisplayRig& rig, const haptics::ServoSettings& servo, const Options& options);
  ~PictureStage();
  PictureStage(const PictureStage&) = delete;
  PictureStage& operator=(const PictureStage&) = delete;

  /// Updates mesh bricks of the working tooth. Positions are relative to `origin` (m, frame W).
  void show(std::span<const render::MeshUpdate> bricks, const dvec3& origin);

  /// Adds the static surroundings. Call before the first bricks, so that mesh bricks behind the gum are not drawn.
  void surround(const Surroundings& around);
  /// Sets the spheres that the next frames show, e.g. those of a sphere packing.
  void show_spheres(std::span<const render::Particle> spheres) { spheres_ = spheres; }
  /// Sets the view from the next frame on. `section`: tissue is drawn where section · (p_W, 1) > 0. show_inside() sets
  /// the other bodies of a view (engine/app/picture/teaching_views.h).
  void show_as(render::View view, const glm::dvec4& section = {0, 0, 0, 1}) {
    view_ = view;
    section_ = section;
  }
  render::View view() const { return view_; }
  /// Uses the screen and the user's head position of this display rig from the next frame on.
  void look_from(const display::DisplayRig& rig);
  /// Replaces a body that only one view shows, for example render::kSectionFace. Positions are relative to `origin` (m,
  /// frame W).
  void show_inside(render::MeshId body, std::span<const render::MeshUpdate> bricks, const dvec3& origin);

  /// Before the working tooth is shown: lets another thread create the shader pipelines of the tools
  /// (render::Renderer::prepare).
  void prepare(World& world, const Look& look) { prepare(next_frame(world, look)); }
  /// Draws and shows one frame of the world. Offscreen, waits until it is finished, unless one eye is drawn. `look`:
  /// which parts of the world are shown; show_as() sets its view. `take_last`: called before text and pictures of the
  /// last frame are replaced, but after work for which the GPU need not be finished.
  render::FrameStats draw(World& world, const Look& look = {}, const std::function<void()>& take_last = {});

  /// True if something inside the box may be visible in the next frame. An empty `box` means the whole space.
  bool in_sight(const std::optional<render::BoxInWorld>& box) const;

  /// Both eyes' pictures, in the image layout for shaders.
  const gpu::Image& pictures() const { return renderer_->pictures(); }
  /// True if pictures() contain no frame, because none was drawn since their size or quality changed.
  bool blank() const { return blank_; }
  /// Sets the size of the pictures in pixels. The display rig's panel gets the same aspect ratio. Call only if
  /// Options::embedded is true. True if the size changed.
  bool resize(glm::ivec2 eye_size);

  /// True: the next frames are drawn for the left eye only; eye(0) waits for them and returns them, the screen does not
  /// show them.
  void draw_one_eye(bool on) { one_eye_ = on; }
  bool draws_one_eye() const { return one_eye_; }

  /// True: draw() does not wait for the renderer's pipelines. While other threads create them, it draws nothing, and
  /// waits() is true.
  /// It does not wait for offscreen pictures; the caller waits until finished(). Lavapipe takes seconds for a first
  /// picture, because it compiles shaders while it draws.
  void draw_ahead(bool on) { ahead_ = on; }
  bool waits() const { return waits_; }
  /// True if the GPU has finished the last frame.
  bool finished() const { return ring_.done(device_, ring_.slot()); }

  /// Sets the quality from the next frame on.
  void set_quality(const render::Quality& quality);
  const render::Quality& quality() const { return options_.quality; }

  render::Lights lights() const { return look().lights; }

  /// The picture of one eye in the last frame (0 left, 1 right), without text.
  render::Picture eye(int index);
  /// Draws the text of the last frame over an eye's picture. The picture may have any size.
  void write_over(render::Picture& picture) const;
  /// The text of the last frame.
  const display::Hud& hud() const { return hud_; }
  /// The content of the screen after the last frame.
  render::Picture screen();

  /// Measured times of the last frame.
  struct Timing {
    double record = 0;  // s, time of preparation and submission on the CPU
    double gpu = 0;     // s, GPU time of the latest finished frame
    double shown = 0;   // s, estimated time from the start of draw() to the middle of the screen's next refresh
    /// The larger one of CPU time and GPU time (s) of a frame. The wait for the screen is not included.
    double cost() const { return gpu > record ? gpu : record; }
  };
  const Timing& timing() const { return timing_; }
  /// GPU times of the latest finished frame, by part.
  const render::GpuTimes& gpu_times() const { return gpu_times_; }
  /// True if the tool did not move between the last two calls of draw().
  bool tool_at_rest() const { return at_rest_; }

  /// The numbers of packets from the head tracker that were accepted and dropped; empty if the rig file has no head
  /// tracker.
  std::optional<display::HeadTracker::Stats> tracker_stats() const;

  /// The window or memory in which the screen is composed. Call only if Options::embedded is false.
  display::Output& output() { return *output_; }
  const display::DisplayRig& rig() const { return rig_; }
  gpu::Device& device() { return device_; }
  std::string device_name() const { return device_.name(); }
  bool processor() const { return device_.processor; }
  int validation_messages() const { return device_.validation_messages(); }

 private:
  render::Frame look() const;
  /// The next frame of the world. Passes the world's changes to the renderer.
  render::Frame next_frame(World& world, const Look& shown);
  bool prepare(const render::Frame& frame) { return renderer_->prepare(frame, light_.has_value()); }
  void follow_size();
  void follow_head();
  void follow_bend();
  void follow_pixels(double pixel);
  /// Adds the cursor of a tool at this pose: a ring to the frame, and dots to the drawn particles.
  void add_cursor(const haptics::Tool& tool, const Pose& X_WG, render::Frame& frame);

  display::DisplayRig rig_;
  display::Head rest_;  // pose of the user's head that the rig file states
  std::optional<display::HeadTracker> tracker_;
  /// Running mean of the latency from the head tracker's reading to the picture on the screen, s.
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
  render::GpuTimes gpu_times_;
  bool one_eye_ = false, ahead_ = false, waits_ = false;
  std::optional<std::array<dvec3, 2>> bent_for_;  // positions of the eyes for which the compositor bends the pictures
  bool blank_ = true;    // true: no frame was drawn since the size or the quality of the pictures changed
  bool missed_ = false;  // true: last frame not shown, or window minimised
  glm::ivec2 screen_size_{0};
  /// Vectors along the panel's lower edge (rightwards) and left edge (upwards), as the rig file states them, m.
  std::array<dvec3, 2> first_panel_{};
  display::Hud hud_;
  Surroundings around_;
  std::optional<MouthLight> light_;  // empty in scenes without a mouth
  bool coarse_around_ = false;
  ShownWorld shown_;
  MouthMirror mirror_;
  SuctionTip tip_;
  std::span<const render::Particle> spheres_;
  render::View view_ = render::View::kLook;
  glm::dvec4 section_{0, 0, 0, 1};
  double pixel_ = 0;                         // m, last frame's pixel width at the tooth
  std::vector<render::Particle> with_dots_;  // debris particles, followed by the dots of the cursor
  Pose shown_at_;                            // pose of the tool in the last frame
  bool at_rest_ = false;
};

/// Creates a GPU device for pictures with these options. If the options request a window, the device can show it.
/// Throws Error if no Vulkan device or no window is available.
gpu::Device make_picture_device(const PictureStage::Options& options);

}  // namespace typodont
