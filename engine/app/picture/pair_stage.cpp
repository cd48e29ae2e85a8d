#include "engine/app/picture/pair_stage.h"

#include <algorithm>

#include "engine/base/error.h"

namespace typodont {

namespace {

glm::ivec2 half_of(glm::ivec2 screen) {
  return glm::max(glm::ivec2(screen.x / 2, screen.y), glm::ivec2(16));
}

}  // namespace

PairStage::PairStage(const display::DisplayRig& rig, const std::array<haptics::ServoSettings, 2>& servo,
                     const PictureStage::Options& options)
    : device_(make_picture_device(options)) {
  ring_ = gpu::FrameRing::create(device_);
  display::DisplayRig mono = rig;
  const glm::ivec2 eye = display::eye_pixels(rig.screen.layout, rig.screen.pixels);
  mono.screen.layout = display::Layout::kMono;
  mono.screen.pixels = eye;
  PictureStage::Options own = options;
  own.window = false;
  own.embedded = true;
  own.device = &device_;
  for (std::size_t k = 0; k < 2; ++k) stages_[k] = std::make_unique<PictureStage>(mono, servo[k], own);
  const glm::ivec2 screen{2 * eye.x, eye.y};
#ifdef TYPODONT_WINDOW
  if (options.window) {
    display::WindowOptions window;
    window.size = {std::min(screen.x, 1600), std::min(screen.x, 1600) * screen.y / screen.x};
    window.output = options.monitor;
    window.fits_screen = true;
    output_ = display::make_window(device_, window);
  }
#endif
  if (!output_) output_ = display::make_offscreen(device_, screen);
  compositor_.emplace(device_);
  follow_size();
}

PairStage::~PairStage() {
  vkDeviceWaitIdle(device_.device);
  both_.destroy(device_);
  compositor_.reset();
  output_.reset();
  for (auto& stage : stages_) stage.reset();
  ring_.destroy(device_);
  device_.destroy();
}

void PairStage::follow_size() {
  const glm::ivec2 size = output_->size();
  if (size == size_ || size.x <= 0 || size.y <= 0) return;
  ring_.wait_idle(device_);
  size_ = size;
  const glm::ivec2 half = half_of(size);
  for (auto& stage : stages_) stage->resize(half);
  fit();
}

void PairStage::fit() {
  const gpu::ImageOptions like = stages_[0]->pictures().options;
  const VkExtent2D had = both_.options.size;
  if (both_.image && had.width == like.size.width && had.height == like.size.height) return;
  ring_.wait_idle(device_);
  both_.destroy(device_);
  both_ = gpu::Image::create(device_, {.size = like.size,
                                       .layers = 2,
                                       .format = like.format,
                                       .alias = like.alias,
                                       .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
}

std::array<render::FrameStats, 2> PairStage::draw(const std::array<World*, 2>& worlds,
                                                  const std::array<Look, 2>& looks) {
  follow_size();
  bool drawn = output_->needs_frame();
  std::array<render::FrameStats, 2> stats;
  for (std::size_t k = 0; k < 2; ++k) {
    stats[k] = stages_[k]->draw(*worlds[k], looks[k]);
    drawn |= stats[k].drawn;
  }
  const display::Compositor::Huds huds{&stages_[0]->hud(), &stages_[1]->hud()};
  if (!drawn && !compositor_->text_changed(huds, display::Layout::kSideBySide)) return stats;
  fit();
  const auto target = output_->acquire();
  if (!target) return stats;
  const VkCommandBuffer commands = ring_.begin(device_);
  gpu::transition(commands, both_, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                  VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, 0, VK_PIPELINE_STAGE_2_TRANSFER_BIT,
                  VK_ACCESS_2_TRANSFER_WRITE_BIT);
  for (std::uint32_t k = 0; k < 2; ++k) {
    const gpu::Image& picture = stages_[k]->pictures();
    gpu::transition(commands, picture, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                    VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, 0, VK_PIPELINE_STAGE_2_TRANSFER_BIT,
                    VK_ACCESS_2_TRANSFER_READ_BIT);
    VkImageCopy region{};
    region.srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, k, 1};
    region.extent = {both_.options.size.width, both_.options.size.height, 1};
    vkCmdCopyImage(commands, picture.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, both_.image,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
    gpu::transition(commands, picture, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                    VK_PIPELINE_STAGE_2_TRANSFER_BIT, 0, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                    VK_ACCESS_2_SHADER_READ_BIT);
  }
  gpu::transition(commands, both_, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                  VK_PIPELINE_STAGE_2_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                  VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_SHADER_READ_BIT);
  compositor_->record(commands, both_, display::Layout::kSideBySide, *target, ring_.slot(), 0, nullptr, huds);
  ring_.submit(device_, target->ready, target->done);
  output_->present(std::nullopt, [this, slot = ring_.slot()] { ring_.wait(device_, slot); });
  ring_.wait_idle(device_);
  return stats;
}

render::Picture PairStage::screen() {
  ring_.wait_idle(device_);
  return {output_->size(), output_->read()};
}

}  // namespace typodont
