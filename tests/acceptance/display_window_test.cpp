// Tests a real window on a desktop in memory (Xvfb): the screen shows the composed picture, whatever the desktop does
// to the window.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <thread>

#include "engine/base/clock.h"
#include "tests/support/default_colors.h"
#include "tests/support/desktop.h"
#include "tests/support/stage.h"
#include "tests/support/tooth_mesh.h"

namespace typodont::test {
namespace {

constexpr glm::ivec2 kEye{200, 300};

struct Window : testing::Test {
  Desktop desktop;
  gpu::Device device;
  gpu::FrameRing ring;
  std::optional<render::Renderer> renderer;
  std::optional<display::Compositor> compositor;
  std::unique_ptr<display::Output> window;
  render::Frame frame = frame_of(desk(0.03, 0.0225, 0.35));
  bool shown_in_parts = false;

  void SetUp() override {
    ASSERT_GT(desktop.server.process, 0) << "Xvfb is needed (apt install xvfb)";
    const auto extensions = display::window_extensions();
    device = gpu::Device::create({.validation = true, .instance_extensions = extensions, .present = true});
    ring = gpu::FrameRing::create(device);
    renderer.emplace(device, kEye, render::kQualityLadder[0], render::default_colors());
    renderer->update(0, tooth_mesh(2e-3, 0.5e-3));
    compositor.emplace(device);
    window = display::make_window(device, {.size = {400, 300}, .composed = true});
  }
  void TearDown() override {
    if (!device.device) return;
    ring.wait_idle(device);
    window.reset();
    compositor.reset();
    renderer.reset();
    ring.destroy(device);
    EXPECT_EQ(device.validation_messages(), 0);
    device.destroy();
  }

  /// Draws and shows one frame. Returns false if there was no window to show it in. `parts`: only the tool moves, and
  /// the window gets only the changed parts of the picture.
  bool show(bool parts = false) {
    if (parts) {
      frame.tool.visible = true;
      frame.tool.X_WG.p.x += 2e-5;
    } else {
      frame.lights.ambient += 1e-6;  // a new frame
    }
    const VkCommandBuffer commands = ring.begin(device);
    renderer->record(commands, frame, ring.slot(), ring.submitted, ring.finished);
    const auto target = window->acquire();
    std::array<std::vector<display::Part>, 2> changed;
    for (int e = 0; e < 2; ++e)
      for (const render::PixelBox& b : renderer->redrawn(e))
        changed[static_cast<std::size_t>(e)].push_back({b.x, b.y, b.width, b.height});
    std::optional<std::vector<display::Part>> drawn;
    if (target)
      drawn = compositor->record(commands, renderer->pictures(), display::Layout::kSideBySide, *target, ring.slot(),
                                 window->first_row(), parts ? &changed : nullptr);
    ring.submit(device, target ? target->ready : VK_NULL_HANDLE, target ? target->done : VK_NULL_HANDLE);
    if (target)
      window->present(drawn, [this, slot = ring.slot()] {
        ring.wait(device, slot);
        compositor->compose(slot);
      });
    shown_in_parts = drawn.has_value();
    EXPECT_FALSE(window->poll().close);
    EXPECT_FALSE(window->poll().close);  // by the second one it is shown
    return target.has_value();
  }
  bool shown_as_drawn(glm::ivec2 size, bool parts = false) {
    // The desktop shows a frame a little after it was presented.
    for (int attempt = 0; attempt < 100; ++attempt) {
      show(parts);
      const render::Picture screen = desktop.screen(size);
      const render::Picture eyes[2] = {
          {kEye, gpu::read_back(device, renderer->pictures(), 0, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL)},
          {kEye, gpu::read_back(device, renderer->pictures(), 1, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL)}};
      int wrong = 0;
      for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
          const glm::ivec2 half(size.x / 2, size.y);
          const glm::ivec2 p(x % half.x * kEye.x / half.x, y * kEye.y / half.y);
          for (int c = 0; c < 3; ++c)
            if (std::abs(int{screen.at(x, y)[c]} - int{eyes[x >= half.x].at(p.x, p.y)[c]}) > (half == kEye ? 1 : 60)) {
              ++wrong;
              break;
            }
        }
      if (wrong <= size.x * size.y / 50) return true;
    }
    return false;
  }
};

TEST_F(Window, ShowsTheComposedPictureAndSurvivesResizing) {
  EXPECT_EQ(window->size(), glm::ivec2(400, 300)) << "before its first frame, too";
  EXPECT_TRUE(shown_as_drawn({400, 300}));
  window->resize({600, 450});
  EXPECT_TRUE(shown_as_drawn({600, 450})) << "stretched into the larger window";
  EXPECT_EQ(window->size(), glm::ivec2(600, 450));
  window->resize({320, 200});
  for (int i = 0; i < 20; ++i) show();
  EXPECT_EQ(window->size(), glm::ivec2(320, 200));
}

TEST_F(Window, APartialUpdateKeepsTheRestOfThePicture) {
  EXPECT_TRUE(shown_as_drawn({400, 300}));
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(show(true));
  EXPECT_TRUE(shown_in_parts);
  EXPECT_TRUE(shown_as_drawn({400, 300}, true));
  window->resize({600, 450});
  EXPECT_TRUE(shown_as_drawn({600, 450}, true)) << "all of it, where nothing was kept";
}

TEST_F(Window, UrgentKeysReachTheirListenerInOrderWhileNobodyPollsTheWindow) {
  std::mutex mutex;
  std::vector<int> heard;
  const auto so_far = [&] {
    const std::lock_guard lock(mutex);
    return heard;
  };
  const std::unique_ptr<display::Output> other = display::make_window(
      device, {.title = "urgent", .size = {200, 150}, .urgent = {{' ', 256, 'R'}, [&](int code) {
                                                                   const std::lock_guard lock(mutex);
                                                                   heard.push_back(code);
                                                                 }}});
  Desktop::xdotool("search --sync --name urgent windowfocus sleep 0.3 key --delay 50 Escape r x space");
  for (int i = 0; i < 1200 && so_far().size() < 3; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const std::vector<int> expected{256, 'R', ' '};
  EXPECT_EQ(so_far(), expected);
  std::vector<int> polled;
  for (int i = 0; i < 1200 && polled.size() < 4; ++i) {
    const std::vector<int> pressed = other->poll().pressed;
    polled.insert(polled.end(), pressed.begin(), pressed.end());
    other->wait(kNanosPerSecond / 10);
  }
  EXPECT_EQ(polled, (std::vector<int>{256, 'R', 'X', ' '})) << "poll() returns them as well";
  EXPECT_EQ(so_far(), expected) << "once each";
}

// Z and Y, A and Q, W, M and R lie elsewhere on these keyboards; the punctuation needs Shift on some.
TEST_F(Window, KeysActByTheirLabelOnEveryLayout) {
  std::atomic<int> urgent{0};
  int layouts = 0;
  const std::unique_ptr<display::Output> other =
      display::make_window(device, {.title = "labels", .size = {200, 150}, .urgent = {{'R'}, [&](int) { ++urgent; }}});
  for (const char* layout : {"us", "de", "fr", "dvorak", "ru", "us"}) {
    ASSERT_EQ(std::system(fmt::format("setxkbmap {}", layout).c_str()), 0);
    const bool latin = std::string_view(layout) != "ru";
    Desktop::xdotool(fmt::format("search --sync --name labels windowfocus sleep 0.3 key --delay 50 {}",
                                 latin ? "z y a q w m r plus minus" : "Cyrillic_ka Cyrillic_ya"));
    const std::vector<int> expected =
        latin ? std::vector<int>{'Z', 'Y', 'A', 'Q', 'W', 'M', 'R'} : std::vector<int>{'R', 'Z'};
    std::vector<int> letters;
    std::string typed;
    for (int i = 0; i < 1200 && (letters.size() < expected.size() || (latin && typed.size() < 9)); ++i) {
      for (const auto& key : other->poll().keys) {
        if (key.typed != 0 && key.typed < 0x80) typed += static_cast<char>(key.typed);
        if (key.down && key.code >= 'A' && key.code <= 'Z') letters.push_back(key.code);
      }
      other->wait(kNanosPerSecond / 10);
    }
    EXPECT_EQ(letters, expected) << layout;
    EXPECT_EQ(urgent, ++layouts) << layout;
    EXPECT_EQ(typed, latin ? "zyaqwmr+-" : "") << layout;
  }
}

TEST_F(Window, SurvivesManyResizesInARow) {
  std::mt19937 random(7);
  for (int i = 0; i < 60; ++i) {
    window->resize({1 + static_cast<int>(random() % 700), 1 + static_cast<int>(random() % 500)});
    if (i % 3) show();
  }
  window->resize({400, 300});
  EXPECT_TRUE(shown_as_drawn({400, 300}));
}

TEST_F(Window, ShowsAgainAfterItWasHidden) {
  EXPECT_TRUE(shown_as_drawn({400, 300}));
  const std::string id = Desktop::xdotool("search --name Typodont");
  ASSERT_FALSE(id.empty());
  Desktop::xdotool("windowunmap " + id.substr(0, id.find('\n')));
  for (int i = 0; i < 10; ++i) show();
  Desktop::xdotool("windowmap " + id.substr(0, id.find('\n')));
  EXPECT_TRUE(shown_as_drawn({400, 300}));
}

TEST_F(Window, SendsNoRequestsWhileTheDesktopSendsNoEvents) {
  EXPECT_TRUE(shown_as_drawn({400, 300}));
  Desktop::xdotool("mousemove 200 150");
  window->wait(kNanosPerSecond);
  while (std::abs(window->poll().pixel.x - 200) > 0.5) window->wait(kNanosPerSecond);
  do {  // what it still has to say of the window's beginning
    show();
    window->wait(kNanosPerSecond / 2);
    window->poll();
  } while (window->needs_frame());
  const std::uint64_t before = window->requests();
  for (int i = 0; i < 1000; ++i) {
    EXPECT_NEAR(window->poll().pixel.y, 150, 0.5) << "known without asking";
    EXPECT_TRUE(window->visible());
    EXPECT_FALSE(window->needs_frame());
  }
  EXPECT_EQ(window->requests(), before);
}

TEST_F(Window, WaitsOnlyUntilTheNextEventOfTheDesktop) {
  EXPECT_TRUE(shown_as_drawn({400, 300}));
  constexpr Nanos kLong = 600 * kNanosPerSecond;
  std::thread mouse([] { Desktop::xdotool("mousemove 20 30 sleep 0.2 mousemove 120 130"); });
  const Nanos began = now();
  while (std::abs(window->poll().pixel.x - 120) > 0.5) window->wait(kLong);
  mouse.join();
  EXPECT_LT(now() - began, kLong) << "a wait would have lasted that long";
}

TEST_F(Window, ALostSurfaceIsRecreatedWithinOneFrame) {
  EXPECT_TRUE(shown_as_drawn({400, 300}));
  for (int i = 0; i < 3; ++i) {
    window->lose_surface();
    EXPECT_TRUE(window->needs_frame());
    EXPECT_TRUE(show());
  }
  EXPECT_TRUE(shown_as_drawn({400, 300}));
}

TEST_F(Window, ALostDeviceIsReportedByName) {
  EXPECT_TRUE(show());
  device.lose();
  EXPECT_THROW(show(), gpu::DeviceLost);
  EXPECT_NO_THROW(ring.wait_idle(device)) << "what was submitted before is still waited for";
}

TEST_F(Window, AStereoSurfaceIsRefusedByNameIfTheDesktopHasNone) {
  try {
    display::make_window(device, {.size = {100, 100}, .stereo_surface = true});
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("frame_sequential"), std::string::npos) << e.what();
    return;
  }
  // A desktop that can show windows with two layers makes the window, and then nothing is refused.
}

TEST_F(Window, AnUnknownMonitorIsReported) {
  EXPECT_EQ(display::monitors().size(), 1u);
  EXPECT_THROW(display::make_window(device, {.output = 3}), Error);
}

TEST_F(Window, FullScreenFillsTheChosenMonitor) {
  window = display::make_window(device, {.output = 0, .composed = true});
  for (int i = 0; i < 5; ++i) show();
  EXPECT_EQ(window->size(), glm::ivec2(800, 600));
}

TEST_F(Window, AClickBetweenTwoPollsIsReportedByTheSecondPoll) {
  ASSERT_TRUE(show());
  Desktop::xdotool("search --name Typodont windowfocus mousemove --window %1 100 100");
  // The click may arrive at any time. The press and the release are between two polls, or at least the press is.
  const auto pressed_after = [&](const char* click, bool display::UserInput::*button) {
    window->poll();
    Desktop::xdotool(click);
    bool seen = false;
    for (int i = 0; i < 200 && !seen; ++i) {
      seen = window->poll().*button;
      if (!seen) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return seen;
  };
  EXPECT_TRUE(pressed_after("click 1", &display::UserInput::left));
  EXPECT_TRUE(pressed_after("click 3", &display::UserInput::right));
  EXPECT_TRUE(pressed_after("click 2", &display::UserInput::middle));
  for (int i = 0; i < 3; ++i) window->poll();
  const display::UserInput after = window->poll();
  EXPECT_FALSE(after.left || after.right || after.middle) << "a click is a press once";
}

}  // namespace
}  // namespace typodont::test
