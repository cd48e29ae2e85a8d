// Draws the bench for a headset. It creates Vulkan through the headset's runtime, creates a renderer, and draws each
// frame. Used by the headset's thread.
#pragma once

#include <optional>
#include <span>

#include "engine/app/picture/film_picture.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/contract/contact.h"
#include "engine/display/hmd.h"
#include "engine/render/renderer.h"
#include "haptics/servo.h"

namespace typodont {

class SoftGumView;

class XrStage {
 public:
  struct Options {
    render::Quality quality = render::kQualityLadder[2];
    bool validation = false;
    HandpieceView handpieces;
  };
  /// Opens the runtime, the headset, the GPU and the session with the runtime. `work_W`: m, frame W: the point that is
  /// in front of the user after recentring. Throws Error.
  XrStage(const display::DisplayRig& rig, const haptics::ServoSettings& servo, const dvec3& work_W,
          display::RuntimeGate& gate, const Options& options);
  ~XrStage();
  XrStage(const XrStage&) = delete;
  XrStage& operator=(const XrStage&) = delete;

  void show(std::span<const render::MeshUpdate> bricks, const dvec3& origin);
  /// Adds the static surroundings. Call it before the first bricks (mesh blocks) of the tissue are added.
  void surround(const Surroundings& around);
  /// Draws the changes of the soft gum since the last call. Call it after surround().
  void show_gum(const SoftGumView& gum);
  void set_quality(const render::Quality& quality);
  /// Updates the picture of the film of water and debris on the surfaces. Null: there is no film.
  void show_film(const FilmPicture* film) { FilmPicture::show(film, *renderer_, film_shown_); }

  /// All objects in the picture except the tissue.
  struct Scenery {
    ServoTick tick;
    double tool_opacity = 1;
    std::span<const render::Particle> particles;
    /// particles that are stored on the GPU of this XrStage; null: there are none
    render::ParticleCloud* cloud = nullptr;
    double dt = 0;       // s, time since the last frame; the bur rotates by the corresponding angle
    MouthMirror mirror;  // the mouth mirror; its diameter is 0 if there is none
    SuctionTip suction;  // the suction tip; its opening is 0 if there is none
  };
  /// Describes the frame for the renderer. `angle`: rad, rotation of the bur about its axis.
  static render::Frame picture(const display::HmdFrame& frame, const Scenery& scenery, double angle, bool see_through);
  /// Draws and submits the frame that hmd().wait() began. If the runtime needs no picture, it submits an empty frame.
  render::FrameStats draw(const display::HmdFrame& frame, const Scenery& scenery);

  display::Hmd& hmd() { return *hmd_; }
  std::string device_name() const { return device_.name(); }
  gpu::Device& device() { return device_; }
  bool processor() const { return device_.processor; }
  int validation_messages() const { return device_.validation_messages(); }

 private:
  void show_tool();

  std::unique_ptr<display::Hmd> hmd_;
  gpu::Device device_;
  gpu::FrameRing ring_;
  std::optional<render::Renderer> renderer_;
  FilmPicture::Shown film_shown_;
  std::uint64_t gum_version_ = 0;  // value of SoftGumView::version() for the bricks that the renderer has received
  std::vector<haptics::Tool> tools_;
  haptics::Spindle spindle_;
  HandpieceView handpieces_;
  Pose X_GH_;          // pose of the handpiece (frame H) relative to the drawn tool (frame G)
  bool open_ = false;  // true: the handpiece is not drawn where it hides the working point (render::ToolState::open)
  std::uint32_t shown_tool_ = 0;
  bool shown_placed_ = false;  // true after an implant was placed; its head then stays visible in the tissue
  double angle_ = 0;
};

}  // namespace typodont
