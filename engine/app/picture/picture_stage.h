// Pictures of the bench: a Vulkan device, a renderer and the screen of a rig, drawn from what the servo says.
// Render thread. Offscreen here; the window adds its own output (workbench.h).
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "engine/app/picture/detail.h"
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
#include "haptics/servo.h"

namespace typodont {

/// What a tool looks like. `placed`: its head stays in the tissue, the hand holds its driver.
render::ToolMesh tool_mesh(const haptics::Tool& tool, bool placed = false);
/// Whether the tick is that of an implant or a screw that has been placed.
bool is_placed(const haptics::Tool& tool, const ServoTick& tick);
/// rad/s about its z with which a tool is drawn: right-handed threads go in clockwise, as seen from the shank.
double drawn_spin(const haptics::Tool& tool, double spindle);

/// Gives the renderer what stands around the working tooth.
void surround(render::Renderer& renderer, const Surroundings& around, bool coarse = false);

/// Where tissue may be while the scene is worked on: what is seen of it elsewhere is none. Nothing: anywhere, for some
/// tool of the tray puts tissue down, or what was cut before the session can be brought again.
std::optional<render::BoxInWorld> tissue_reach(const Scene& scene, const haptics::TissueVolume& tissue);

/// One more frame is drawn.
void count_frame(const render::FrameStats& stats, WorkCounts& work);

/// What no pixel tells apart: a hundredth of what one shows of the tool.
bool looks_same(const Pose& a, const Pose& b);

class PictureStage {
 public:
  struct Options {
    render::Quality quality = render::kQualityLadder[0];
    bool validation = false;
    bool window = false;            // else offscreen; only before a window is the user's head tracked
    bool embedded = false;          // pictures() only, for a window of the caller's; no screen is composed
    gpu::Device* device = nullptr;  // the caller's; null: one of its own
    int monitor = -1;               // full screen on this one; −1: a window on the desktop
    bool hud = true;
    bool tool = true;
    bool cursor = false;     // a row of dots from the tool's end to where it would land, and a ring there
    double force_limit = 3;  // N, the end of the force bar
  };
  /// Throws Error where the machine has no Vulkan device, or no desktop for a window.
  PictureStage(const display::DisplayRig& rig, const haptics::ServoSettings& servo, const Options& options);
  ~PictureStage();
  PictureStage(const PictureStage&) = delete;
  PictureStage& operator=(const PictureStage&) = delete;

  /// Bricks of the working tooth; positions relative to `origin` (m, W).
  void show(std::span<const render::MeshUpdate> bricks, const dvec3& origin);

  /// What stands still around it; before its first bricks, so that what the gum covers need never be drawn.
  void surround(const Surroundings& around);

  /// The mouth mirror in the other hand, from the next frame on; diameter 0: none.
  void hold_mirror(const MouthMirror& mirror) { mirror_ = mirror; }
  /// Particles that live on the stage's device, from the next frame on; null: none.
  void show_cloud(render::ParticleCloud* cloud) { cloud_ = cloud; }
  /// How the scene is shown, from the next frame on; `section` as in render::Frame. What a view shows beside the
  /// surface (engine/app/picture/teaching_views.h) is given with show_inside().
  void show_as(render::View view, const glm::dvec4& section = {0, 0, 0, 1}) {
    view_ = view;
    section_ = section;
  }
  render::View view() const { return view_; }
  /// The tool is drawn, or not.
  void show_tool(bool shown) { options_.tool = shown; }
  /// From another viewpoint, from the next frame on: screen and head of this rig.
  void look_from(const display::DisplayRig& rig);
  /// A body that one view shows (render::kSectionFace …), instead of what it was; relative to `origin` (m, W).
  void show_inside(render::MeshId body, std::span<const render::MeshUpdate> bricks, const dvec3& origin);

  /// Draws and shows one frame; waits for it when offscreen. `dt`: s since the last, turns the bur.
  render::FrameStats draw(const ServoTick& tick, std::span<const render::Particle> particles, double dt,
                          const std::string& hint = "");

  /// Whether the next frame could show anything of what lies within the box; nothing: it may lie anywhere.
  bool in_sight(const std::optional<render::BoxInWorld>& box) const;

  /// The eyes' pictures as they are drawn, for a shader.
  const gpu::Image& pictures() const { return renderer_->pictures(); }
  /// Where embedded: the pictures' size. The rig's panel takes their proportions. True when it changed.
  bool resize(glm::ivec2 eye_size);

  /// Another step of the quality ladder, from the next frame on.
  void set_quality(const render::Quality& quality);
  const render::Quality& quality() const { return options_.quality; }

  /// The eyes (0 left, 1 right), without writing, and the composed screen of the last frame.
  render::Picture eye(int index);
  /// Lays the last frame's writing over an eye's picture of any size.
  void write_over(render::Picture& picture) const;
  /// What is written over the last frame.
  const display::Hud& hud() const { return hud_; }
  render::Picture screen();

  /// What the last frame drawn took.
  struct Timing {
    double record = 0;  // s: preparing it and handing it over
    double gpu = 0;     // s: drawing it, of the newest frame that is done
    double shown = 0;   // s, estimated: from the start of draw() to the middle of the screen's next picture
    /// What the picture costs, wherever its time goes; waiting for the screen is none of it.
    double cost() const { return gpu > record ? gpu : record; }
  };
  const Timing& timing() const { return timing_; }
  /// The last call of draw() had the tool where the one before it had it.
  bool tool_at_rest() const { return at_rest_; }

  /// Packets of the head tracker taken and dropped; nothing where the rig has none.
  std::optional<display::HeadTracker::Stats> tracker_stats() const;

  /// Not where embedded.
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
  /// The cursor of a tool that is held there: its ring goes to the frame, its dots are added to the particles.
  void add_cursor(const Pose& X_WG, render::Frame& frame);

  display::DisplayRig rig_;
  display::Head rest_;  // the head as the rig file has it
  std::optional<display::HeadTracker> tracker_;
  double latency_ = 1.0 / 30;  // s from reading the tracker to the picture on the screen, running mean
  haptics::ServoSettings servo_;
  Options options_;
  std::optional<gpu::Device> own_device_;
  gpu::Device& device_;
  gpu::FrameRing ring_;
  std::optional<render::Renderer> renderer_;
  std::optional<display::Compositor> compositor_;
  std::unique_ptr<display::Output> output_;
  Timing timing_;
  bool missed_ = false;  // a frame was drawn that no target took, or none at all in a window that is minimised
  glm::ivec2 screen_size_{0};
  std::array<dvec3, 2> first_panel_{};  // m, right and up, as the rig file has it
  display::Hud hud_;
  Surroundings around_;
  bool coarse_around_ = false;
  double read_age_ = 1, read_force_ = 0, read_spindle_ = 0;  // s, N, rad/s: what the writing says, and how long it has
  MouthMirror mirror_;
  render::ParticleCloud* cloud_ = nullptr;
  render::View view_ = render::View::kLook;
  glm::dvec4 section_{0, 0, 0, 1};
  double pixel_ = 0;                         // m that a pixel of the last frame covered of the tooth
  std::vector<render::Particle> with_dots_;  // what flies, and the cursor's dots
  double angle_ = 0;
  Pose shown_at_;  // the tool
  bool at_rest_ = false;
  std::size_t shown_tool_ = 0;  // of the tray
  bool shown_placed_ = false;   // its head stays in the tissue
};

/// A device for such pictures, with what a window needs where there is one. Throws like PictureStage.
gpu::Device make_picture_device(const PictureStage::Options& options);

}  // namespace typodont
