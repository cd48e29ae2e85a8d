// Two pictures beside each other on one screen: a student's session and an expert's, as one person sees both. Each is a
// stage of its own; the screen is composed of their left eyes' pictures. Drawing thread.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "engine/app/picture/picture_stage.h"

namespace typodont {

class PairStage {
 public:
  /// Of each side: its tools and materials. `options`: window, monitor, quality, hud. Throws like PictureStage.
  PairStage(const display::DisplayRig& rig, const std::array<haptics::ServoSettings, 2>& servo,
            const PictureStage::Options& options);
  ~PairStage();
  PairStage(const PairStage&) = delete;
  PairStage& operator=(const PairStage&) = delete;

  PictureStage& side(std::size_t which) { return *stages_[which]; }
  /// Both drawn, and shown together. What each side's picture took.
  std::array<render::FrameStats, 2> draw(const std::array<ServoTick, 2>& ticks,
                                         const std::array<std::span<const render::Particle>, 2>& particles, double dt,
                                         const std::array<std::string, 2>& hints);
  /// What is on the screen; only where it is not a window.
  render::Picture screen();
  display::Output& output() { return *output_; }

 private:
  void follow_size();
  /// The picture of both to what each is drawn at.
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
