// Measures how long the emergency key takes to set the force to zero while a software renderer draws the slowest
// picture.
#include <gtest/gtest.h>
#include <xcb/xcb.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <thread>

#include "engine/app/scene.h"
#include "engine/app/workbench.h"
#include "engine/base/clock.h"
#include "engine/base/realtime.h"
#include "engine/base/temporary_folder.h"
#include "haptics/devices.h"
#include "tests/support/desktop.h"

namespace typodont::test {
namespace {

using namespace std::chrono_literals;

/// What the hand below feels.
std::atomic<Nanos> zero_since{1};  // ns, when the force became zero; 0: there is a force
std::atomic<bool> lifted{true};    // the hand is in the air; otherwise it presses on the ball

class PressingHand final : public haptics::HapticDevice {
 public:
  PressingHand() { info_.address = "pressing:", info_.force_limit = 1e6; }
  const haptics::DeviceInfo& info() const noexcept override { return info_; }
  bool read(haptics::HandSample& sample) noexcept override {
    constexpr Nanos kPeriod = 1'000'000;
    next_ = std::max(next_ + kPeriod, now());
    sleep_until(next_);
    height_ += std::clamp((lifted ? 5e-3 : 2.9e-3) - height_, -1e-5, 1e-5);  // m
    sample = {};
    sample.t = now();
    sample.X_WT.p = {2e-4 * std::sin(20 * to_seconds(sample.t)), 0, height_};  // every frame shows a motion
    return true;
  }
  void write(const dvec3& f_T_W, const dvec3&) noexcept override {
    if (f_T_W != dvec3(0))
      zero_since = 0;
    else if (zero_since == 0)
      zero_since = now();
  }

 private:
  haptics::DeviceInfo info_;
  double height_ = 5e-3;  // m
  Nanos next_ = 0;
};

/// Reads the server's times of key presses in a window.
class KeyTimes {
 public:
  explicit KeyTimes(std::uint32_t window) : server_(xcb_connect(nullptr, nullptr)) {
    constexpr std::uint32_t kMask = XCB_EVENT_MASK_KEY_PRESS;
    std::free(
        xcb_request_check(server_, xcb_change_window_attributes_checked(server_, window, XCB_CW_EVENT_MASK, &kMask)));
  }
  ~KeyTimes() { xcb_disconnect(server_); }
  KeyTimes(const KeyTimes&) = delete;
  KeyTimes& operator=(const KeyTimes&) = delete;
  /// Waits for the next press. ns of now(), rounded down to 1 ms; X counts the milliseconds of the same clock.
  Nanos next() const {
    using Event = std::unique_ptr<xcb_generic_event_t, decltype(&std::free)>;
    Event event(xcb_wait_for_event(server_), &std::free);
    while (event->response_type != XCB_KEY_PRESS) event.reset(xcb_wait_for_event(server_));
    const auto clock = static_cast<std::uint64_t>(now() / 1'000'000);
    const auto key = reinterpret_cast<const xcb_key_press_event_t*>(event.get());
    return static_cast<Nanos>(clock - (static_cast<std::uint32_t>(clock) - key->time)) * 1'000'000;
  }

 private:
  xcb_connection_t* server_;
};

TEST(EmergencyKey, SetsTheForceToZeroWithinFiveMillisecondsWhileThePictureTakesManyTimesAsLong) {
  const Desktop desktop({3840, 2160});
  ASSERT_GT(desktop.server.process, 0) << "Xvfb is needed (apt install xvfb)";
  const TemporaryFolder temporary;
  const std::filesystem::path& folder = temporary.path();
  std::ofstream(folder / "scene.json") << R"({"name": "ball", "tissue": {"voxel_mm": 0.2, "solids": [
    {"tissue": "dentin", "solid": {"sphere": {"radius_mm": 3}}}]}, "tool": "round_012", "parts": ["haptics", "render"]})";
  std::ofstream(folder / "rig.json") << R"({"display": "window", "screen": {"corners_mm": {"lower_left": [-8, -4.5, 0],
    "lower_right": [8, -4.5, 0], "upper_left": [-8, 4.5, 0]}, "pixels": [3840, 2160], "layout": "mono"},
    "head": {"eye_center_mm": [0, 0, 300], "ipd_mm": 63}})";
  haptics::Driver driver;
  driver.scheme = "pressing";
  driver.hardware = false;
  driver.open = [](const std::string&, const haptics::HandOptions&) { return std::make_unique<PressingHand>(); };
  haptics::add_driver(std::move(driver));

  const Scene scene = read_scene(folder / "scene.json");
  WorkbenchOptions options;
  options.rig = folder / "rig.json";
  options.hand = "pressing:";
  options.pedal = "none";
  options.audio = "none:";
  options.quality = "high";
  // One thread draws, as in the program.
  std::atomic<bool> drawn{false}, done{false};
  double frame_ms = 0;
  std::thread picture([&] {
    Workbench bench(scene, options);
    bench.start();
    while (!done && bench.step()) drawn = bench.status().frames > 1;
    frame_ms = bench.status().frame_ms;
    bench.stop();
    drawn = done = true;
  });
  const auto wait_for = [&](const auto& condition) {
    while (!condition() && !done) std::this_thread::sleep_for(1ms);
  };
  wait_for([&] { return drawn.load(); });
  const std::string id = Desktop::xdotool("search --name Typodont");
  const KeyTimes keys(static_cast<std::uint32_t>(std::strtoul(id.c_str(), nullptr, 10)));
  Desktop::xdotool("windowfocus " + id.substr(0, id.find('\n')));

  std::vector<double> delays;  // ms
  for (const char* key : {"space", "Escape", "space", "Escape", "space", "Escape", "space", "Escape", "space"}) {
    lifted = false;
    wait_for([] { return zero_since == 0; });
    std::this_thread::sleep_for(std::chrono::milliseconds(100 + 37 * delays.size()));  // anywhere in a frame
    Desktop::xdotool(std::string("key ") + key);
    const Nanos pressed = keys.next();
    wait_for([] { return zero_since != 0; });
    delays.push_back(to_seconds(zero_since - pressed) * 1e3);
    lifted = true;
    std::this_thread::sleep_for(300ms);  // 2.1 mm at 10 mm/s
    EXPECT_NE(zero_since, 0) << "until the key that ends it";
    Desktop::xdotool("key r");
    keys.next();
  }
  done = true;
  picture.join();
  std::sort(delays.begin(), delays.end());
  const double median = delays[delays.size() / 2];
  std::cout << "key to zero force: median " << median << " ms, longest " << delays.back() << " ms; a frame " << frame_ms
            << " ms\n";
  EXPECT_LE(median, 5);
  EXPECT_GT(frame_ms, 4 * median) << "the picture must be slow";
}

}  // namespace
}  // namespace typodont::test
