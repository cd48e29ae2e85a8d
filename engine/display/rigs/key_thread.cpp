#include "engine/display/rigs/key_thread.h"

#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>
#include <xcb/xcb.h>

#include <array>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <memory>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/late_library.h"
#include "engine/base/realtime.h"

namespace typodont::display {

namespace {

constinit LateLibrary xcb{TYPODONT_LATE_XCB};
TYPODONT_LATE(xcb, xcb_connect, xcb_connection_has_error, xcb_request_check, xcb_change_window_attributes_checked,
              xcb_disconnect, xcb_get_setup, xcb_get_keyboard_mapping, xcb_get_keyboard_mapping_reply,
              xcb_get_keyboard_mapping_keysyms, xcb_get_file_descriptor, xcb_poll_for_event)

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
  // Other clients of the X server may receive this window's key events, too.
  constexpr std::uint32_t kMask = XCB_EVENT_MASK_KEY_PRESS;
  try {
    if (end_ < 0 || xcb_connection_has_error(server_) ||
        owned(xcb_request_check(server_,
                                xcb_change_window_attributes_checked(server_, window, XCB_CW_EVENT_MASK, &kMask))))
      throw Error("window", server, "refuses a second connection", "one, for the emergency keys");
    read_labels();
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

/// Reads the labels of all keys. Called again after the server has reported a change of the keyboard layout.
void KeyThread::read_labels() noexcept {
  const xcb_setup_t& setup = *xcb_get_setup(server_);
  const int first = setup.min_keycode, count = setup.max_keycode - first + 1;
  const auto request = xcb_get_keyboard_mapping(server_, setup.min_keycode, static_cast<std::uint8_t>(count));
  const auto reply = owned(xcb_get_keyboard_mapping_reply(server_, request, nullptr));
  if (!reply) return;
  const std::size_t columns = reply->keysyms_per_keycode;  // columns of the table of labels: two for each layout
  const xcb_keysym_t* const symbols = xcb_get_keyboard_mapping_keysyms(reply.get());
  for (std::size_t key = 0; key < static_cast<std::size_t>(count); ++key)
    for (std::size_t layout = 0; layout < 4; ++layout) {
      const xcb_keysym_t symbol = symbols[columns * key + (2 * layout < columns ? 2 * layout : 0)];
      const bool latin = symbol > ' ' && symbol <= '~';
      labels_[static_cast<std::size_t>(first) + key][layout] =
          latin ? static_cast<char>(std::toupper(static_cast<int>(symbol))) : '\0';
    }
}

void KeyThread::run() noexcept {
  // This thread's priority is below that of the servo, and above that of all threads that draw.
  enter_realtime({.priority = 79, .core = -1, .lock_memory = false});
  ::pthread_setname_np(::pthread_self(), "typodont-keys");
  std::array<pollfd, 2> sources{{{xcb_get_file_descriptor(server_), POLLIN, 0}, {end_, POLLIN, 0}}};
  while (sources[1].revents == 0 && !xcb_connection_has_error(server_)) {
    while (const auto event = owned(xcb_poll_for_event(server_))) {
      constexpr unsigned kSynthetic = 0x80;
      if ((event->response_type & ~kSynthetic) == XCB_MAPPING_NOTIFY) read_labels();
      if ((event->response_type & ~kSynthetic) != XCB_KEY_PRESS) continue;
      const auto& key = reinterpret_cast<const xcb_key_press_event_t&>(*event);
      const char label = labels_[key.detail][key.state >> 13 & 3];  // the layout in use
      for (const Key& k : keys_)
        if (label != 0 ? label == k.code : key.detail == k.scancode) pressed_(k.code);
    }
    if (::poll(sources.data(), sources.size(), -1) < 0 && errno != EINTR) return;
  }
}

}  // namespace typodont::display
