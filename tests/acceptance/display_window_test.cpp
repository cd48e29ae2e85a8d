// A real window, on a desktop in memory (Xvfb): what arrives on the screen is what was composed.
#include <gtest/gtest.h>

#include "tests/support/desktop.h"
#include "tests/support/stage.h"
#include "tests/support/tooth_mesh.h"

namespace typodont::test {
namespace {

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
        const render::Picture eyes[2] = {
            {eye_size, gpu::read_back(device, renderer.pictures(), 0, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL)},
            {eye_size, gpu::read_back(device, renderer.pictures(), 1, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL)}};
        int wrong = 0;
        for (int y = 0; y < size.y; ++y)
          for (int x = 0; x < size.x; ++x) {
            const glm::ivec2 half(size.x / 2, size.y);
            const glm::ivec2 p(x % half.x * eye_size.x / half.x, y * eye_size.y / half.y);
            for (int c = 0; c < 3; ++c)
              if (std::abs(int{screen.at(x, y)[c]} - int{eyes[x >= half.x].at(p.x, p.y)[c]}) >
                  (half == eye_size ? 1 : 60)) {
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
