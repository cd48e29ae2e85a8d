// Shows two sessions side by side on one screen, for example a student's and an expert's. Each session has a
// PictureStage of its own. The screen shows the left eye's picture of each session. Render thread only.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "engine/app/picture/picture_stage.h"

namespace typodont {

class PairStage {
 public:
  /// `servo`: tools and materials of each session. `options`: only window, monitor, quality and hud are used. Throws
  /// Error if no Vulkan device or no window is available.
  PairStage(const display::DisplayRig& rig, const std::array<haptics::ServoSettings, 2>& servo,
            const PictureStage::Options& options);
  ~PairStage();
  PairStage(const PairStage&) = delete;
  PairStage& operator=(const PairStage&) = delete;

  PictureStage& side(std::size_t which) { return *stages_[which]; }
  /// Draws both pictures and shows them together. Returns their statistics.
  std::array<render::FrameStats, 2> draw(const std::array<World*, 2>& worlds, const std::array<Look, 2>& looks);
  /// The content of the screen. Call only without a window.
  render::Picture screen();
  display::Output& output() { return *output_; }

 private:
  void follow_size();
  /// Adapts the size of the screen's picture to the sizes of the two pictures that it combines.
  void fit();

  gpu::Device device_;
  gpu::FrameRing ring_;
  std::array<std::unique_ptr<PictureStage>, 2> stages_;
  std::unique_ptr<display::Output> output_;
  std::optional<display::Compositor> compositor_;
  gpu::Image both_;
  glm::ivec2 size_{0};
};

}  // namespace typodont
