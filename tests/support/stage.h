// A device, a renderer and an offscreen screen for tests of pictures; one call draws a frame.
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

/// Uses the validation layer by default and counts its messages.
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

  /// Draws, composes if a layout is given, and waits.
  render::FrameStats draw(const render::Frame& frame, std::optional<display::Layout> layout = {});
  render::Picture eye(int layer);
  render::Picture screen;  // the last composed frame
};

/// A rig with a desk screen of this size in m, its middle at the origin, facing the eye at `distance` along `towards`.
display::DisplayRig desk(double width, double height, double distance, dvec3 towards = {0, -0.6, 0.8});
render::Frame frame_of(const display::DisplayRig& rig);

struct Difference {
  int pixels = 0;  // number of pixels that differ by more than the tolerance in any channel
  int worst = 0;   // largest difference, of 255
};
Difference compare(const render::Picture& a, const render::Picture& b, int tolerance);
/// Compares with tests/golden/NAME.png. On failure writes NAME.actual.png and NAME.difference.png to the build folder
/// and reports it. If TYPODONT_WRITE_GOLDEN is set, writes the golden picture instead and fails, so that somebody
/// inspects it.
bool matches_golden(const render::Picture& picture, const std::string& name, int tolerance, int pixels,
                    std::string& message);

}  // namespace typodont::test
