#include "engine/app/live/xr_stage.h"

#include <cmath>
#include <cstring>

#include "engine/app/picture/hud.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

gpu::Device make_device(display::Hmd& hmd, bool validation) {
  gpu::DeviceOptions options = hmd.device_options();
  options.validation = validation;
  return gpu::Device::create(options);
}

}  // namespace

XrStage::XrStage(const display::DisplayRig& rig, const haptics::ServoSettings& servo, const dvec3& work_W,
                 display::RuntimeGate& gate, const Options& options)
    : hmd_(display::Hmd::open(rig, gate)),
      device_(make_device(*hmd_, options.validation)),
      options_(options),
      shown_(options.handpieces) {
  try {
    ring_ = gpu::FrameRing::create(device_);
    hmd_->begin(device_, work_W);
    renderer_.emplace(device_, hmd_->eye_pixels(), options.quality, servo.materials);
    renderer_->keep_depth(hmd_->wants_depth());
  } catch (...) {
    hmd_->end();
    renderer_.reset();
    ring_.destroy(device_);
    device_.destroy();
    throw;
  }
}

XrStage::~XrStage() {
  // Waits until the GPU has finished. Does not wait by `ring_`, which would throw if the GPU is lost.
  vkDeviceWaitIdle(device_.device);
  hmd_->end();
  for (gpu::Buffer& panels : panels_) panels.destroy(device_);
  renderer_.reset();
  ring_.destroy(device_);
  device_.destroy();
}

void XrStage::show(std::span<const render::MeshUpdate> bricks, const dvec3& origin) {
  renderer_->update(render::kWorkingTooth, bricks);
  renderer_->place(render::kWorkingTooth, {origin, {1, 0, 0, 0}});
}

void XrStage::surround(const Surroundings& around) {
  typodont::surround(*renderer_, around);
}

void XrStage::set_quality(const render::Quality& quality) {
  ring_.wait_idle(device_);
  renderer_->set_quality(quality);
}

render::Frame XrStage::picture(const display::HmdFrame& hmd_frame, const World& world, double tool_opacity,
                               bool see_through) {
  render::Frame frame;
  for (std::size_t e = 0; e < 2; ++e) {
    const display::EyeView& eye = hmd_frame.eyes[e];
    frame.eyes[e] = {eye.view, eye.projection, eye.position, eye.flip};
  }
  // Direction to the lamp. It is fixed in the room: over the left shoulder of a user who sits at negative y of frame W.
  frame.lights.key = glm::normalize(dvec3(-0.65, 0.2, 0.95));
  frame.lights.up = {0, 0, 1};
  // No background picture: one picture cannot fit both eyes of a headset, because their image planes are not parallel.
  frame.background = see_through ? render::Background::kClear : render::Background::kBlack;
  add_held(world, {}, frame);
  frame.tool.opacity = tool_opacity;
  return frame;
}

/// Copies the texts over the picture of each eye, so that both eyes see them at the same distance.
void XrStage::write_texts(VkCommandBuffer commands, const display::HmdFrame& frame, const World& world) {
  constexpr double kHalfWidth = 0.3, kHalfHeight = 0.3;  // tangents of half the angles over which the texts extend
  constexpr double kDistance = 10;  // distance of the texts from the eyes, divided by the distance between the eyes
  display::Hud hud = typodont::hud(world, options_.language);
  hud.force_shown = options_.force_in_hud;
  const gpu::Image& pictures = renderer_->pictures();
  const glm::dvec2 size(pictures.options.size.width, pictures.options.size.height);
  const auto& eyes = frame.eyes;
  const glm::ivec2 region(
      glm::dvec2(kHalfWidth * eyes[0].projection[0][0], kHalfHeight * std::abs(eyes[0].projection[1][1])) * size);
  if (writing_.differs(hud, region)) {
    writing_.write(hud, region);
    ++texts_;
  }
  const auto slot = static_cast<std::size_t>(ring_.slot());
  std::size_t bytes = 0;
  for (const auto& panel : writing_.panels()) bytes += panel.rgba.size();
  if (bytes == 0) return;
  gpu::Buffer& buffer = panels_[slot];
  if (buffer.size < bytes) {
    buffer.destroy(device_);
    buffer = gpu::Buffer::create(device_, 2 * bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    panel_texts_[slot] = 0;
  }
  const bool filled = panel_texts_[slot] == texts_;
  panel_texts_[slot] = texts_;

  // The head's forward direction is the mean of the eyes' directions, because their views may be turned outwards.
  const auto forward = [](const display::EyeView& eye) {
    return -dvec3(eye.view[0][2], eye.view[1][2], eye.view[2][2]);
  };
  const double apart = glm::length(eyes[1].position - eyes[0].position);
  const dvec3 middle = 0.5 * (eyes[0].position + eyes[1].position) +
                       kDistance * apart * glm::normalize(forward(eyes[0]) + forward(eyes[1]));
  std::vector<VkBufferImageCopy> copies;
  for (std::uint32_t e = 0; e < 2; ++e) {
    const glm::dvec4 clip = eyes[e].projection * eyes[e].view * glm::dvec4(middle, 1);
    const glm::ivec2 center((glm::dvec2(clip) / clip.w * 0.5 + 0.5) * size), lo = center - region / 2;
    std::size_t at = 0;
    for (const auto& panel : writing_.panels()) {
      const glm::ivec2 from = lo + panel.box.lo, to = from + panel.box.size;
      if (e == 0 && !filled) std::memcpy(buffer.memory.mapped + at, panel.rgba.data(), panel.rgba.size());
      if (from.x >= 0 && from.y >= 0 && to.x <= static_cast<int>(size.x) && to.y <= static_cast<int>(size.y))
        copies.push_back(
            {.bufferOffset = at,
             .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, std::min(e, pictures.options.layers - 1), 1},
             .imageOffset = {from.x, from.y, 0},
             .imageExtent = {static_cast<std::uint32_t>(panel.box.size.x), static_cast<std::uint32_t>(panel.box.size.y),
                             1}});
      at += panel.rgba.size();
    }
  }
  if (copies.empty()) return;
  gpu::transition(commands, pictures, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                  VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT, VK_PIPELINE_STAGE_2_TRANSFER_BIT,
                  VK_ACCESS_2_TRANSFER_WRITE_BIT);
  vkCmdCopyBufferToImage(commands, buffer.buffer, pictures.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                         static_cast<std::uint32_t>(copies.size()), copies.data());
  gpu::transition(commands, pictures, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                  VK_PIPELINE_STAGE_2_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                  VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_READ_BIT);
}

render::FrameStats XrStage::draw(const display::HmdFrame& hmd_frame, World& world, double tool_opacity) {
  if (!hmd_frame.draw) {
    hmd_->submit(hmd_frame);
    return {};
  }
  if (const auto hidden = hmd_->hidden()) {
    ring_.wait_idle(device_);
    renderer_->set_hidden(*hidden);
  }
  render::Frame frame = picture(hmd_frame, world, tool_opacity, hmd_->see_through());
  shown_.add(world, {}, /*coarse=*/false, *renderer_, frame);
  const VkCommandBuffer commands = ring_.begin(device_);
  const render::FrameStats stats = renderer_->record(commands, frame, ring_.slot(), ring_.submitted, ring_.finished);
  if (options_.hud) write_texts(commands, hmd_frame, world);
  std::array<display::Hmd::Depth, 2> depth;
  for (int e = 0; e < 2; ++e) {
    const render::Renderer::DepthPicture d = renderer_->depth(e);
    depth[static_cast<std::size_t>(e)] = {d.image, d.layer};
  }
  hmd_->record(commands, renderer_->pictures(), depth);
  ring_.submit(device_);
  hmd_->submit(hmd_frame);
  return stats;
}

}  // namespace typodont
