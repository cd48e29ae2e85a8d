// A device, a renderer and an offscreen screen, for tests of pictures. One call draws a frame.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "engine/display/display_rig.h"
#include "engine/display/output.h"
#include "engine/render/look.h"
#include "engine/render/picture.h"
#include "engine/render/renderer.h"

namespace typodont::test {

enum class Passes { kBest, kOne, kTwo };  // rendering passes for the two eyes; kBest: the device's default

/// Uses Vulkan's validation layer by default, and counts its messages.
struct Stage {
  explicit Stage(glm::ivec2 eye_size, const render::Quality& quality = render::kQualityLadder[0],
                 Passes passes = Passes::kBest, bool validation = true);
  ~Stage();
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  gpu::Device device;
  gpu::FrameRing ring;
  std::optional<render::Renderer> renderer;
  std::optional<display::Compositor> compositor;
  glm::ivec2 size;
  display::Hud hud;  // text over the screen

  /// Draws the frame, composes the screen if a layout is given, and waits for the result.
  render::FrameStats draw(const render::Frame& frame, std::optional<display::Layout> layout = {});
  render::Picture eye(int layer);
  render::Picture screen;  // the last composed frame
};

/// Returns a rig with a desk screen. `width` and `height`: m. The middle of the screen is the origin. The eye is at
/// `distance` (m) from it in the direction `towards`.
display::DisplayRig desk(double width, double height, double distance, dvec3 towards = {0, -0.6, 0.8});
render::Frame frame_of(const display::DisplayRig& rig);

/// Returns the mesh of a round bur with a friction-grip shank. `diameter`: m.
render::ToolMesh round_bur(double diameter);

struct Difference {
  int pixels = 0;  // number of pixels that differ by more than the tolerance in any channel
  int worst = 0;   // largest difference, of 255
};
Difference compare(const render::Picture& a, const render::Picture& b, int tolerance);
/// Compares the picture with tests/golden/NAME.png. If they differ, writes NAME.actual.png and NAME.difference.png to
/// the build folder and reports it. If TYPODONT_WRITE_GOLDEN is set, writes the golden picture instead and fails, so
/// that a person inspects the picture.
bool matches_golden(const render::Picture& picture, const std::string& name, int tolerance, int pixels,
                    std::string& message);

}  // namespace typodont::test
