#include "engine/app/headset/xr_stage.h"

#include <cmath>

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
      tools_(haptics::tool_set(servo).begin(), haptics::tool_set(servo).end()),
      spindle_(servo.spindle),
      handpieces_(options.handpieces) {
  try {
    ring_ = gpu::FrameRing::create(device_);
    hmd_->begin(device_, work_W);
    renderer_.emplace(device_, hmd_->eye_pixels(), options.quality, servo.materials);
    renderer_->keep_depth(hmd_->wants_depth());
    show_tool();
  } catch (...) {
    hmd_->end();
    renderer_.reset();
    ring_.destroy(device_);
    device_.destroy();
    throw;
  }
}

XrStage::~XrStage() {
  // Waits here until the GPU has finished. The wait function of `ring_` is not used, because it throws if the GPU is
  // lost.
  vkDeviceWaitIdle(device_.device);
  hmd_->end();
  renderer_.reset();
  ring_.destroy(device_);
  device_.destroy();
}

void XrStage::show_tool() {
  const DrawnTool drawn = drawn_tool(tools_[shown_tool_], spindle_, handpieces_, shown_placed_);
  X_GH_ = drawn.X_GH;
  open_ = drawn.open;
  renderer_->set_tool(drawn.tool, drawn.handpiece);
}

void XrStage::show(std::span<const render::MeshUpdate> bricks, const dvec3& origin) {
  renderer_->update(render::kWorkingTooth, bricks);
  renderer_->place(render::kWorkingTooth, {origin, {1, 0, 0, 0}});
}

void XrStage::surround(const Surroundings& around) {
  typodont::surround(*renderer_, around);
}

void XrStage::show_gum(const SoftGumView& gum) {
  typodont::show_gum(*renderer_, gum, false, gum_version_);
}

void XrStage::set_quality(const render::Quality& quality) {
  ring_.wait_idle(device_);
  renderer_->set_quality(quality);
}

render::Frame XrStage::picture(const display::HmdFrame& hmd_frame, const Scenery& scenery, double angle,
                               bool see_through) {
  render::Frame frame;
  for (std::size_t e = 0; e < 2; ++e) {
    const display::EyeView& eye = hmd_frame.eyes[e];
    frame.eyes[e] = {eye.view, eye.projection, eye.position, eye.flip};
  }
  // Direction to the lamp. It is fixed in the room: over the left shoulder of a user who sits at negative y of frame W.
  frame.lights.key = glm::normalize(dvec3(-0.65, 0.2, 0.95));
  frame.lights.up = {0, 0, 1};
  // No background picture is drawn. One picture cannot fit both eyes of a headset, because their image planes are not
  // parallel.
  frame.background = see_through ? render::Background::kClear : render::Background::kBlack;
  const ServoTick& tick = scenery.tick;
  frame.tool = {
      .visible = true, .X_WG = tick.X_WG, .angle = angle, .spindle = tick.spindle, .opacity = scenery.tool_opacity};
  frame.particles = scenery.particles;
  frame.cloud = scenery.cloud;
  frame.mirror = scenery.mirror;
  frame.suction = scenery.suction;
  return frame;
}

render::FrameStats XrStage::draw(const display::HmdFrame& hmd_frame, const Scenery& scenery) {
  if (!hmd_frame.draw) {
    hmd_->submit(hmd_frame);
    return {};
  }
  if (const auto hidden = hmd_->hidden()) {
    ring_.wait_idle(device_);
    renderer_->set_hidden(*hidden);
  }
  const bool placed = scenery.tick.tool < tools_.size() && is_placed(tools_[scenery.tick.tool], scenery.tick);
  if ((scenery.tick.tool != shown_tool_ || placed != shown_placed_) && scenery.tick.tool < tools_.size()) {
    shown_tool_ = scenery.tick.tool;
    shown_placed_ = placed;
    ring_.wait_idle(device_);
    show_tool();
  }
  angle_ = std::fmod(angle_ + drawn_spin(tools_[shown_tool_], scenery.tick.spindle) * scenery.dt, 2 * kPi);
  render::Frame frame = picture(hmd_frame, scenery, angle_, hmd_->see_through());
  frame.tool.X_GH = X_GH_;
  frame.tool.open = open_;
  const VkCommandBuffer commands = ring_.begin(device_);
  const render::FrameStats stats = renderer_->record(commands, frame, ring_.slot(), ring_.submitted, ring_.finished);
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
