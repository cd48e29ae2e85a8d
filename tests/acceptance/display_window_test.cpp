// A real window, on a desktop in memory (Xvfb): what arrives on the screen is what was composed.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "tests/support/stage.h"
#include "tests/support/tooth_mesh.h"

namespace typodont::test {
namespace {

/// Xvfb with its framebuffer in a file (XWD format), gone with this object.
struct Desktop {
  pid_t process = -1;
  std::filesystem::path folder;

  Desktop() {
    char pattern[] = "/tmp/typodont_xvfb_XXXXXX";
    folder = mkdtemp(pattern);
    int fds[2];
    if (pipe(fds) != 0) return;
    process = fork();
    if (process == 0) {
      close(fds[0]);
      const std::string fd = std::to_string(fds[1]);
      execlp("Xvfb", "Xvfb", "-displayfd", fd.c_str(), "-screen", "0", "800x600x24", "-fbdir", folder.c_str(), "-nolisten",
             "tcp", static_cast<char*>(nullptr));
      _exit(127);
    }
    close(fds[1]);
    // It says its number in several writes, the last a new line, once it takes connections.
    std::string number;
    for (char c = 0; read(fds[0], &c, 1) == 1 && c != '\n';) number += c;
    close(fds[0]);
    setenv("DISPLAY", fmt::format(":{}", number).c_str(), 1);
    unsetenv("WAYLAND_DISPLAY");
  }
  ~Desktop() {
    if (process > 0) {
      kill(process, SIGTERM);
      waitpid(process, nullptr, 0);
    }
    std::filesystem::remove_all(folder);
  }
  Desktop(const Desktop&) = delete;
  Desktop& operator=(const Desktop&) = delete;

  /// The upper left part of the screen.
  render::Picture screen(glm::ivec2 size) const {
    std::ifstream in(folder / "Xvfb_screen0", std::ios::binary);
    const std::vector<char> bytes((std::istreambuf_iterator<char>(in)), {});
    const auto word = [&](std::size_t i) {  // XWD headers are big-endian
      std::uint32_t v = 0;
      for (std::size_t k = 0; k < 4; ++k) v = v << 8 | static_cast<std::uint8_t>(bytes.at(4 * i + k));
      return v;
    };
    const std::size_t start = word(0) + 12 * std::size_t{word(19)}, line = word(12);
    render::Picture p{size, {}};
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        const std::size_t at = start + static_cast<std::size_t>(y) * line + 4 * static_cast<std::size_t>(x);
        for (std::size_t c : {2, 1, 0}) p.rgba.push_back(static_cast<std::uint8_t>(bytes.at(at + c)));
        p.rgba.push_back(255);
      }
    return p;
  }
};

TEST(Window, ShowsTheComposedPictureAndSurvivesResizing) {
  Desktop desktop;
  ASSERT_GT(desktop.process, 0) << "Xvfb is needed (apt install xvfb)";
  const auto extensions = display::window_extensions();
  gpu::Device device = gpu::Device::create({.validation = true, .instance_extensions = extensions, .present = true});
  {
    gpu::FrameRing ring = gpu::FrameRing::create(device);
    const glm::ivec2 eye_size{200, 300};
    render::Renderer renderer(device, eye_size, render::kQualityLadder[0], render::default_colors());
    renderer.update(0, tooth_mesh(2e-3, 0.5e-3));
    display::Compositor compositor(device);
    const auto window = display::make_window(device, {.size = {400, 300}});
    render::Frame frame = frame_of(desk(0.03, 0.0225, 0.35));
    const auto show = [&] {
      frame.lights.ambient += 1e-6;  // a new frame
      const VkCommandBuffer commands = ring.begin(device);
      renderer.record(commands, frame, ring.slot(), ring.submitted, ring.finished);
      const auto target = window->acquire();
      if (target)
        compositor.record(commands, renderer.pictures(), display::Layout::kSideBySide, *target, ring.slot(),
                          window->first_row());
      ring.submit(device, target ? target->ready : VK_NULL_HANDLE, target ? target->done : VK_NULL_HANDLE);
      if (target) window->present();
      EXPECT_FALSE(window->poll().close);
      return target.has_value();
    };
    const auto shown_as_drawn = [&](glm::ivec2 size) {
      // The desktop shows a frame a little after it was presented.
      for (int attempt = 0; attempt < 100; ++attempt) {
        show();
        const render::Picture screen = desktop.screen(size);
        const render::Picture eyes[2] = {{eye_size, gpu::read_back(device, renderer.pictures(), 0, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL)},
                                         {eye_size, gpu::read_back(device, renderer.pictures(), 1, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL)}};
        int wrong = 0;
        for (int y = 0; y < size.y; ++y)
          for (int x = 0; x < size.x; ++x) {
            const glm::ivec2 half(size.x / 2, size.y);
            const glm::ivec2 p(x % half.x * eye_size.x / half.x, y * eye_size.y / half.y);
            for (int c = 0; c < 3; ++c)
              if (std::abs(int{screen.at(x, y)[c]} - int{eyes[x >= half.x].at(p.x, p.y)[c]}) > (half == eye_size ? 1 : 60)) {
                ++wrong;
                break;
              }
          }
        if (wrong <= size.x * size.y / 50) return true;
      }
      return false;
    };
    EXPECT_TRUE(shown_as_drawn({400, 300}));
    window->resize({600, 450});
    EXPECT_TRUE(shown_as_drawn({600, 450})) << "stretched into the larger window";
    EXPECT_EQ(window->size(), glm::ivec2(600, 450));
    window->resize({320, 200});
    for (int i = 0; i < 20; ++i) show();
    EXPECT_EQ(window->size(), glm::ivec2(320, 200));
    ring.wait_idle(device);
    ring.destroy(device);
  }
  EXPECT_EQ(device.validation_messages(), 0);
  device.destroy();
}

}  // namespace
}  // namespace typodont::test
