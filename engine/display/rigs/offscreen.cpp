// An output that draws into memory instead of a window.
#include <chrono>
#include <cstdlib>
#include <thread>
#include <utility>

#include "engine/display/output.h"

namespace typodont::display {

namespace {

class Offscreen final : public Output {
 public:
  Offscreen(gpu::Device& device, ivec2 size) : device_(device), size_(size) {
    image_ =
        gpu::Image::create(device, {.size = {static_cast<std::uint32_t>(size.x), static_cast<std::uint32_t>(size.y)},
                                    .format = VK_FORMAT_R8G8B8A8_UNORM,
                                    .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT});
  }
  ~Offscreen() override {
    vkDeviceWaitIdle(device_.device);
    image_.destroy(device_);
  }
  Offscreen(const Offscreen&) = delete;
  Offscreen& operator=(const Offscreen&) = delete;

  std::optional<Target> acquire() override {
    const bool kept = std::exchange(drawn_, true);
    return Target{.image = image_.image,
                  .layers = {image_.layer_views[0]},
                  .size = size_,
                  .format = image_.options.format,
                  .final_layout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                  .kept = kept};
  }
  void present(const std::optional<std::vector<Part>>&, std::function<void()>) override {}
  ivec2 size() const override { return size_; }
  std::vector<std::uint8_t> read() override {
    return gpu::read_back(device_, image_, 0, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  }

 private:
  gpu::Device& device_;
  ivec2 size_;
  gpu::Image image_;
  bool drawn_ = false;
};

}  // namespace

void Output::wait(Nanos most) {
  std::this_thread::sleep_for(std::chrono::nanoseconds(most));
}

bool has_desktop() {
  return std::getenv("DISPLAY") || std::getenv("WAYLAND_DISPLAY");
}

std::unique_ptr<Output> make_offscreen(gpu::Device& device, ivec2 size) {
  return std::make_unique<Offscreen>(device, size);
}

}  // namespace typodont::display
