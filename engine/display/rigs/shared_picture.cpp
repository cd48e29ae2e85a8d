#include "engine/display/rigs/shared_picture.h"

#include <sys/ipc.h>
#include <sys/shm.h>
// Included last: Xlib defines the macros None, Bool and Status.
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/extensions/XShm.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "engine/base/late_library.h"
#include "engine/display/rigs/desktop_events.h"

namespace typodont::display {

namespace {

constinit LateLibrary x11{TYPODONT_LATE_X11}, xext{TYPODONT_LATE_XEXT};
TYPODONT_LATE(x11, XCreateGC, XFlush, XFreeGC, XGetWindowAttributes, XSetErrorHandler, XSync)
TYPODONT_LATE(xext, XShmAttach, XShmCreateImage, XShmDetach, XShmPutImage, XShmQueryExtension)

// Picture rows per request to the X server, which handles keys between two requests.
constexpr int kBand = 64;

bool refused;  // true if the X server refused to attach the memory
int note_refusal(::Display*, XErrorEvent*) {
  refused = true;
  return 0;
}

class XPicture final : public SharedPicture {
 public:
  XPicture(gpu::Device& device, ::Display* display, ::Window window, const XWindowAttributes& looks, bool composed)
      : device_(device),
        display_(display),
        window_(window),
        visual_(looks.visual),
        depth_(looks.depth),
        composed_(composed),
        context_(XCreateGC(display, window, 0, nullptr)) {}
  ~XPicture() override {
    drop();
    XFreeGC(display_, context_);
  }
  XPicture(const XPicture&) = delete;
  XPicture& operator=(const XPicture&) = delete;

  bool resize(ivec2 size) override {
    drop();
    size_ = size;
    shared_ = XShmCreateImage(display_, visual_, static_cast<unsigned>(depth_), ZPixmap, nullptr, &segment_,
                              static_cast<unsigned>(size.x), static_cast<unsigned>(size.y));
    if (!shared_) return false;
    if (shared_->bits_per_pixel != 32 || shared_->byte_order != LSBFirst) return drop(), false;
    const auto bytes = static_cast<std::size_t>(shared_->bytes_per_line) * static_cast<std::size_t>(size.y);
    segment_.shmid = ::shmget(IPC_PRIVATE, bytes, IPC_CREAT | 0600);
    if (segment_.shmid < 0) return drop(), false;
    void* memory = ::shmat(segment_.shmid, nullptr, 0);
    if (memory != reinterpret_cast<void*>(-1)) {
      segment_.shmaddr = shared_->data = static_cast<char*>(memory);
      segment_.readOnly = True;  // the server may only read the memory
      refused = false;
      XSync(display_, False);
      const auto before = XSetErrorHandler(note_refusal);
      attached_ = XShmAttach(display_, &segment_) != 0;
      XSync(display_, False);
      XSetErrorHandler(before);
      attached_ = attached_ && !refused;
    }
    // Marks the memory for release, which happens when its last user detaches.
    ::shmctl(segment_.shmid, IPC_RMID, nullptr);
    if (!attached_) return drop(), false;
    if (composed_) return true;
    image_ =
        gpu::Image::create(device_, {.size = {static_cast<std::uint32_t>(size.x), static_cast<std::uint32_t>(size.y)},
                                     .format = VK_FORMAT_B8G8R8A8_UNORM,
                                     .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
                                     .mapped = true});
    return true;
  }

  Target target() override {
    if (composed_)
      return {
          .memory = {reinterpret_cast<std::uint8_t*>(shared_->data), static_cast<std::size_t>(shared_->bytes_per_line)},
          .size = size_,
          .kept = std::exchange(drawn_, true)};
    return {.image = image_.image,
            .layers = {image_.layer_views[0]},
            .size = size_,
            .format = image_.options.format,
            .final_layout = VK_IMAGE_LAYOUT_GENERAL,
            .kept = std::exchange(drawn_, true)};
  }

  void show(std::span<const Part> parts, const std::function<void()>& finish) override {
    XSync(display_, False);  // waits until the server has read the previous frame
    finish();
    if (!composed_) copy(parts);
    for (const Part& p : parts)
      for (int y = p.y; y < p.y + p.height; y += kBand)
        XShmPutImage(display_, window_, context_, shared_, p.x, y, p.x, y, static_cast<unsigned>(p.width),
                     static_cast<unsigned>(std::min(kBand, p.y + p.height - y)), False);
    XFlush(display_);
  }
  ivec2 size() const override { return size_; }

 private:
  void copy(std::span<const Part> parts) {
    const gpu::Image::Rows rows = image_.rows(device_);
    for (const Part& p : parts)
      for (int y = p.y; y < p.y + p.height; ++y) {
        const auto row = static_cast<std::size_t>(y), left = 4 * static_cast<std::size_t>(p.x);
        std::memcpy(shared_->data + row * static_cast<std::size_t>(shared_->bytes_per_line) + left,
                    rows.first + row * rows.pitch + left, 4 * static_cast<std::size_t>(p.width));
      }
  }

  void drop() {
    vkDeviceWaitIdle(device_.device);
    image_.destroy(device_);
    drawn_ = false;
    if (std::exchange(attached_, false)) {
      XShmDetach(display_, &segment_);
      XSync(display_, False);
    }
    if (char* memory = std::exchange(segment_.shmaddr, nullptr)) ::shmdt(memory);
    if (shared_) {
      shared_->data = nullptr;
      XDestroyImage(shared_);
      shared_ = nullptr;
    }
  }

  gpu::Device& device_;
  ::Display* display_;
  ::Window window_;
  ::Visual* visual_;
  int depth_;
  bool composed_;
  ::GC context_;
  ivec2 size_{0};
  gpu::Image image_;
  bool drawn_ = false, attached_ = false;
  XImage* shared_ = nullptr;
  XShmSegmentInfo segment_{};
};

}  // namespace

std::unique_ptr<SharedPicture> SharedPicture::open(gpu::Device& device, GLFWwindow* window, bool composed) {
  ::Display* const display = x_server();
  const ::Window id = x_window(window);
  if (id == 0 || !XShmQueryExtension(display)) return nullptr;
  XWindowAttributes looks{};
  if (!XGetWindowAttributes(display, id, &looks)) return nullptr;
  const ::Visual& v = *looks.visual;
  if (v.red_mask != 0xff0000 || v.green_mask != 0xff00 || v.blue_mask != 0xff) return nullptr;
  VkImageFormatProperties can{};
  if (vkGetPhysicalDeviceImageFormatProperties(device.physical, VK_FORMAT_B8G8R8A8_UNORM, VK_IMAGE_TYPE_2D,
                                               VK_IMAGE_TILING_LINEAR, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT, 0,
                                               &can) != VK_SUCCESS)
    return nullptr;
  auto picture = std::make_unique<XPicture>(device, display, id, looks, composed);
  if (!picture->resize({1, 1})) return nullptr;  // fails if the server is on another machine
  return picture;
}

}  // namespace typodont::display
