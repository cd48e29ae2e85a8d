// Reads the keys of an X11 window on a separate connection and thread, so that no key waits for a frame.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>
#include <vector>

struct xcb_connection_t;

namespace typodont::display {

class KeyThread {
 public:
  struct Key {
    int scancode = 0;  // X11's keycode (position on the keyboard), for keys without a Latin label
    int code = 0;      // code of the key's label (upper case); argument of `pressed`
  };
  /// `server`: name as in DISPLAY. `window`: X11's number of a window, which must exist until the destructor, which
  /// ends the thread. Throws Error.
  KeyThread(const std::string& server, std::uint32_t window, std::vector<Key> keys, std::function<void(int)> pressed);
  ~KeyThread();
  KeyThread(const KeyThread&) = delete;
  KeyThread& operator=(const KeyThread&) = delete;

 private:
  void run() noexcept;
  void read_labels() noexcept;

  std::vector<Key> keys_;
  std::array<std::array<char, 4>, 256> labels_{};  // Latin letter by keycode and layout; 0: none
  std::function<void(int)> pressed_;
  xcb_connection_t* server_;
  int end_;  // descriptor of the event that ends the thread
  std::thread thread_;
};

}  // namespace typodont::display
