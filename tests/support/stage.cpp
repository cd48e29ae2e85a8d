#include "tests/support/stage.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "engine/base/units.h"
#include "tests/support/default_colors.h"

namespace typodont::test {

namespace {
gpu::Device create_device(bool validation) {
  // The driver stays loaded so that LeakSanitizer can name its functions when the program ends.
  dlopen("libvulkan_lvp.so", RTLD_NOW | RTLD_NODELETE);
  return gpu::Device::create({.validation = validation});
}
}  // namespace

render::ToolMesh round_bur(double diameter) {
  const double r = diameter / 2, neck = std::max(std::min(0.45 * r, 5e-4), std::min(0.8 * r, 2e-4)), grip = 0.8e-3;
  render::ToolShape shape;
  for (int i = 0; i <= 28; ++i) {
    const double angle = (kPi - std::asin(neck / r)) * i / 28;
    shape.head.push_back({r * std::sin(angle), -r * std::cos(angle)});
  }
  const double z = shape.head.back().y;
  for (int i = 0; i <= 10; ++i) {
    const double s = i / 10.0, blend = s * s * (3 - 2 * s);
    shape.shaft.push_back({neck + (grip - neck) * blend * blend, z + 4e-3 * s});
  }
  shape.shaft.insert(shape.shaft.end(), {{grip, z + 20e-3}, {0, z + 20e-3}});
  return make_tool_mesh(shape);
}

Stage::Stage(glm::ivec2 eye_size, const render::Quality& quality, Passes passes, bool validation)
    : device(create_device(validation)), size(eye_size) {
  if (passes != Passes::kBest) device.multiview = passes == Passes::kOne;
  ring = gpu::FrameRing::create(device);
  renderer.emplace(device, eye_size, quality, render::default_colors());
  compositor.emplace(device);
}

Stage::~Stage() {
  ring.wait_idle(device);
  compositor.reset();
  renderer.reset();
  ring.destroy(device);
  device.destroy();
}

render::FrameStats Stage::draw(const render::Frame& frame, std::optional<display::Layout> layout) {
  std::unique_ptr<display::Output> output;
  const VkCommandBuffer commands = ring.begin(device);
  const render::FrameStats stats = renderer->record(commands, frame, ring.slot(), ring.submitted, ring.finished);
  if (layout) {
    output = display::make_offscreen(device, display::screen_pixels(*layout, size));
    compositor->record(commands, renderer->pictures(), *layout, *output->acquire(), ring.slot(), 0, nullptr,
                       {&hud, &hud});
  }
  if (!stats.drawn && !layout) {
    ring.abandon(device);
    return stats;
  }
  ring.submit(device);
  ring.wait_idle(device);
  if (output) screen = {output->size(), output->read()};
  return stats;
}

render::Picture Stage::eye(int layer) {
  const VkExtent2D extent = renderer->pictures().options.size;
  return {{static_cast<int>(extent.width), static_cast<int>(extent.height)},
          gpu::read_back(device, renderer->pictures(), static_cast<std::uint32_t>(layer),
                         VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL)};
}

display::DisplayRig desk(double width, double height, double distance, dvec3 towards) {
  display::DisplayRig rig;
  const dvec3 n = glm::normalize(towards), right = glm::normalize(glm::cross(dvec3(0, 0, 1), n));
  const dvec3 up = glm::cross(n, right);
  rig.screen.lower_left = -0.5 * width * right - 0.5 * height * up;
  rig.screen.lower_right = rig.screen.lower_left + width * right;
  rig.screen.upper_left = rig.screen.lower_left + height * up;
  rig.head.eye_center = distance * n;
  rig.head.right = right;
  return rig;
}

render::Frame frame_of(const display::DisplayRig& rig) {
  render::Frame frame;
  const auto eyes = display::eye_views(rig);
  for (std::size_t e = 0; e < 2; ++e)
    frame.eyes[e] = {eyes[e].view, eyes[e].projection, eyes[e].position, eyes[e].flip};
  frame.views = rig.screen.layout == display::Layout::kMono ? 1 : 2;
  const dvec3 middle = 0.5 * (rig.screen.lower_right + rig.screen.upper_left);
  const dvec3 n = glm::normalize(rig.head.eye_center - (rig.mirror ? display::reflect(*rig.mirror, middle) : middle));
  const dvec3 up = glm::cross(n, rig.head.right);
  frame.lights.key = glm::normalize(0.55 * n + 0.6 * up - 0.65 * rig.head.right);
  frame.lights.up = up;
  return frame;
}

Difference compare(const render::Picture& a, const render::Picture& b, int tolerance) {
  Difference d;
  if (a.size != b.size) return {a.size.x * a.size.y, 255};
  for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
    int worst = 0;
    for (std::size_t c = 0; c < 3; ++c) worst = std::max(worst, std::abs(int{a.rgba[i + c]} - int{b.rgba[i + c]}));
    d.worst = std::max(d.worst, worst);
    if (worst > tolerance) ++d.pixels;
  }
  return d;
}

bool matches_golden(const render::Picture& picture, const std::string& name, int tolerance, int pixels,
                    std::string& message) {
  const std::filesystem::path golden = std::filesystem::path("tests/golden") / (name + ".png");
  if (std::getenv("TYPODONT_WRITE_GOLDEN")) {
    render::write_png(golden, picture);
    message = fmt::format("wrote {}: look at it, then run again without TYPODONT_WRITE_GOLDEN", golden.string());
    return false;
  }
  const render::Picture expected = render::read_png(golden);
  const Difference d = compare(picture, expected, tolerance);
  if (d.pixels <= pixels && picture.size == expected.size) return true;
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "typodont_golden";
  std::filesystem::create_directories(folder);
  render::Picture difference = picture;
  if (picture.size == expected.size)
    for (std::size_t i = 0; i < difference.rgba.size(); ++i)
      difference.rgba[i] =
          i % 4 == 3
              ? 255
              : static_cast<std::uint8_t>(std::min(255, 8 * std::abs(int{picture.rgba[i]} - int{expected.rgba[i]})));
  render::write_png(folder / (name + ".actual.png"), picture);
  render::write_png(folder / (name + ".difference.png"), difference);
  message = fmt::format("{} pixels differ by more than {} of 255 (allowed {}), the worst by {}: see {}", d.pixels,
                        tolerance, pixels, d.worst, (folder / (name + ".difference.png")).string());
  return false;
}

}  // namespace typodont::test
