// Writing over a picture: tool, speed, force and a line of hints, drawn on the screen plane (no disparity). It has the
// resolution of what it is laid over, however coarse the picture beneath is drawn. Render thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

namespace typodont::display {

/// A spindle's speed as a clinician reads it: "800 rpm", "300 krpm". Slow speeds are rounded to 10 rpm.
std::string spindle_text(double krpm);

/// What the writing says.
struct Hud {
  bool visible = false;
  std::string tool;  // "round 1.2 mm"
  double speed_krpm = 0;
  double force = 0;         // N
  double force_limit = 5;   // N, the bar's end
  std::string hint;         // its parts are three spaces apart: lines break there
  glm::dmat2 upright{1.0};  // display::upright
  double aspect = 0;        // width / height of the physical picture, 0: of its pixels
};

/// Pixels from the upper left corner of an eye's place on the screen.
struct WritingBox {
  glm::ivec2 lo{0}, size{0};
};

/// The writing as pixels: a few panels, the rest of the place stays free.
class Writing {
 public:
  struct Panel {
    WritingBox box;
    std::vector<std::uint8_t> rgba;  // rows of box.size.x pixels; colour times opacity, sRGB
  };

  /// True when write() would change a pixel.
  bool differs(const Hud& hud, glm::ivec2 place) const { return shown(hud, place) != shown_; }
  /// Lays out and draws what is new, for an eye's place of that many pixels. Letters are at least 13 pixels high and as
  /// large as the picture allows; hints break into lines where they are wider than the picture. Returns the boxes in
  /// which a pixel may have changed since the last call.
  std::vector<WritingBox> write(const Hud& hud, glm::ivec2 place);
  std::span<const Panel> panels() const { return panels_; }

  /// Blends a panel into a picture of 4 bytes a pixel, rows `pitch` bytes apart. `place`: where the eye's place begins
  /// in it. `blue_first`: the bytes are BGRA, else RGBA.
  static void lay_over(const Panel& panel, std::uint8_t* pixels, std::size_t pitch, glm::ivec2 place, bool blue_first);

 private:
  static std::string shown(const Hud& hud, glm::ivec2 place);

  std::string shown_;  // what the panels say, to compare
  std::vector<Panel> panels_;
};

}  // namespace typodont::display
