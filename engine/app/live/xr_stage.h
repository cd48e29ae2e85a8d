// Draws a session's World for a headset: creates Vulkan through the headset's runtime, creates a renderer, and draws
// each frame. Headset's thread only.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/world.h"
#include "engine/display/hmd.h"
#include "engine/display/writing.h"
#include "engine/render/renderer.h"
#include "engine/session/strings.h"
#include "haptics/servo.h"

namespace typodont {

class XrStage {
 public:
  struct Options {
    render::Quality quality = render::kQualityLadder[2];
    bool validation = false;
    HandpieceView handpieces;
    bool hud = true;
    bool force_in_hud = true;
    session::Language language = session::Language::kEnglish;  // language of the text over the picture
  };
  /// Opens the runtime, the headset, the GPU and the session with the runtime. `work_W`: m, frame W, the point that
  /// recentring puts in front of the user. Throws Error.
  XrStage(const display::DisplayRig& rig, const haptics::ServoSettings& servo, const dvec3& work_W,
          display::RuntimeGate& gate, const Options& options);
  ~XrStage();
  XrStage(const XrStage&) = delete;
  XrStage& operator=(const XrStage&) = delete;

  void show(std::span<const render::MeshUpdate> bricks, const dvec3& origin);
  /// Adds the static surroundings. Call before the first mesh bricks of the tissue are added.
  void surround(const Surroundings& around);
  void set_quality(const render::Quality& quality);
  /// Describes the frame for the renderer, without particles. `tool_opacity`: 0 to 1; less than 1 if the hand's
  /// tracking is lost.
  static render::Frame picture(const display::HmdFrame& frame, const World& world, double tool_opacity,
                               bool see_through);
  /// Draws the world and its texts, and submits the frame that hmd().wait() began. If the runtime needs no picture, it
  /// submits an empty frame.
  render::FrameStats draw(const display::HmdFrame& frame, World& world, double tool_opacity = 1);

  display::Hmd& hmd() { return *hmd_; }
  std::string device_name() const { return device_.name(); }
  gpu::Device& device() { return device_; }
  bool processor() const { return device_.processor; }
  /// GPU times of the latest finished frame, by part.
  render::GpuTimes gpu_times() { return renderer_->gpu_times(); }
  int validation_messages() const { return device_.validation_messages(); }

 private:
  void write_texts(VkCommandBuffer commands, const display::HmdFrame& frame, const World& world);

  std::unique_ptr<display::Hmd> hmd_;
  gpu::Device device_;
  gpu::FrameRing ring_;
  std::optional<render::Renderer> renderer_;
  Options options_;
  ShownWorld shown_;
  display::Writing writing_;
  std::uint64_t texts_ = 0;  // number of changes of the texts
  // The panels of the texts on the GPU, for each frame in flight, and the value of texts_ that they show.
  std::array<gpu::Buffer, gpu::FrameRing::kSlots> panels_;
  std::array<std::uint64_t, gpu::FrameRing::kSlots> panel_texts_{};
};

}  // namespace typodont
