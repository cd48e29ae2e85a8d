#include "engine/display/rigs/key_thread.h"

#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>
#include <xcb/xcb.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <memory>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/realtime.h"

namespace typodont::display {

namespace {

template <class T>
std::unique_ptr<T, decltype(&std::free)> owned(T* reply) {
  return {reply, &std::free};
}

}  // namespace

KeyThread::KeyThread(const std::string& server, std::uint32_t window, std::vector<Key> keys,
                     std::function<void(int)> pressed)
    : keys_(std::move(keys)),
      pressed_(std::move(pressed)),
      server_(xcb_connect(server.c_str(), nullptr)),
      end_(::eventfd(0, EFD_CLOEXEC)) {
  // Other clients of the server may select the keys of a window, too.
  constexpr std::uint32_t kMask = XCB_EVENT_MASK_KEY_PRESS;
  try {
    if (end_ < 0 || xcb_connection_has_error(server_) ||
        owned(xcb_request_check(server_,
                                xcb_change_window_attributes_checked(server_, window, XCB_CW_EVENT_MASK, &kMask))))
      throw Error("window", server, "refuses a second connection", "one, for the emergency keys");
    thread_ = std::thread([this] { run(); });
  } catch (...) {
    xcb_disconnect(server_);
    if (end_ >= 0) ::close(end_);
    throw;
  }
}

KeyThread::~KeyThread() {
  ::eventfd_write(end_, 1);
  thread_.join();
  xcb_disconnect(server_);
  ::close(end_);
}

void KeyThread::run() const noexcept {
  // Its priority is below that of the servo, and above that of all threads that draw.
  enter_realtime({.priority = 79, .core = -1, .lock_memory = false});
  ::pthread_setname_np(::pthread_self(), "typodont-keys");
  std::array<pollfd, 2> sources{{{xcb_get_file_descriptor(server_), POLLIN, 0}, {end_, POLLIN, 0}}};
  while (sources[1].revents == 0 && !xcb_connection_has_error(server_)) {
    while (const auto event = owned(xcb_poll_for_event(server_))) {
      constexpr unsigned kSynthetic = 0x80;
      if ((event->response_type & ~kSynthetic) != XCB_KEY_PRESS) continue;
      const auto& key = reinterpret_cast<const xcb_key_press_event_t&>(*event);
      for (const Key& k : keys_)
        if (k.scancode == key.detail) pressed_(k.code);
    }
    if (::poll(sources.data(), sources.size(), -1) < 0 && errno != EINTR) return;
  }
}

}  // namespace typodont::display
