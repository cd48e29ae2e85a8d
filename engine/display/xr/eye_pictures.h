// Swapchains for both eyes' pictures, and copies into them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/display/hmd.h"
#include "engine/display/xr/api.h"

namespace typodont::display::xr {

class EyePictures {
 public:
  /// `size`: pixels; `depth`: also creates swapchains for depth, if supported. Throws Error.
  EyePictures(Api& api, XrSession session, const std::string& headset, ivec2 size, bool depth);
  ~EyePictures();
  EyePictures(const EyePictures&) = delete;
  EyePictures& operator=(const EyePictures&) = delete;

  bool wants_depth() const { return wants_depth_; }

  /// Copies the pictures (Hmd::record). This program owns the swapchain images until release().
  void record(VkCommandBuffer commands, const gpu::Image& pictures, const std::array<Hmd::Depth, 2>& depth);
  void release();

  // The next functions describe the last call of record().
  bool has_depth() const { return has_depth_; }
  XrSwapchainSubImage color(std::uint32_t eye) const;
  XrSwapchainSubImage depth(std::uint32_t eye) const;

 private:
  struct Swapchain {
    XrSwapchain handle = XR_NULL_HANDLE;
    VkFormat format = VK_FORMAT_UNDEFINED;
    std::vector<VkImage> images;
    bool held = false;
  };
  Swapchain create(VkFormat format, XrSwapchainUsageFlags usage);
  VkImage acquire(Swapchain& chain);
  void release(Swapchain& chain);

  Api& api_;
  XrSession session_;
  ivec2 size_;
  Swapchain color_, depth_;
  bool wants_depth_ = false, has_depth_ = false;
  XrExtent2Di drawn_size_{1, 1};
};

}  // namespace typodont::display::xr
