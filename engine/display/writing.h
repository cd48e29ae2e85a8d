// Text over a picture: tool, speed, force and a line of hints, drawn on the screen plane (no disparity). The text has
// the resolution of the target, even if the picture below it is drawn coarser. Render thread only.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/display/display_rig.h"

namespace typodont::display {

/// Units and decimal sign of the numbers, in the user's language.
struct HudWords {
  std::string rpm = "{} rpm", krpm = "{} krpm";  // formats of a slow and of a fast spindle's speed
  char decimal = '.';
};

/// Returns the speed of a spindle in the units of a clinician: "800 rpm", "300 krpm". Slow speeds are rounded to 10
/// rpm.
std::string spindle_text(double krpm, const HudWords& words = {});
/// Returns true if the font has all characters of `text` (UTF-8).
bool can_write(std::string_view text);

/// The values that the text shows.
struct Hud {
  bool visible = false;
  std::string tool;  // name of the tool, for example "round 1.2 mm"
  double speed_krpm = 0;
  // false: the force and its bar are not shown, because they would reveal the stimuli of a blind experiment
  bool force_shown = true;
  double force = 0;        // N, force that the text shows
  double force_limit = 5;  // N, force at which the bar is full
  std::string hint;        // text of the hint; three spaces separate its parts, and lines break there
  HudWords words;
  double least_letters = 0;  // least ratio of the letters' height to half the picture's height; see readable_letters()
  glm::dmat2 upright{1.0};   // matrix that makes the text upright on the screen; result of display::upright()
  double aspect = 0;         // width / height of the physical picture; 0: derived from the pixels
};

/// Least angle (rad) that the x-height of a text subtends at the eye. ISO 9241-303 recommends 20 to 22 minutes of arc
/// for the height of whole characters. Here the angle is that of lower-case letters, which is stricter.
inline constexpr double kLeastXHeight = 20.0 / 60 * 3.14159265358979323846 / 180;
/// For the rig of a mirror bench, returns the letters' height, as a ratio to half the picture's height, at which
/// lower-case letters in the middle of the picture subtend the angle kLeastXHeight. Returns 0 for other rigs, because
/// the size of a window on the desk is not known.
double readable_letters(const DisplayRig& rig);

/// A box in pixels from the upper left corner of an eye's region on the screen.
struct WritingBox {
  glm::ivec2 lo{0}, size{0};
};

/// The text as pixels in a few panels. Pixels of the region outside the panels are not drawn.
class Writing {
 public:
  struct Panel {
    WritingBox box;
    std::vector<std::uint8_t> rgba;  // pixels of the panel, in rows of box.size.x pixels; premultiplied alpha, sRGB
  };

  /// Returns true if write() would change a pixel.
  bool differs(const Hud& hud, glm::ivec2 place) const { return shown(hud, place) != shown_; }
  /// Lays out and draws the changed text for an eye's region of the given size. Letters are at least 13 pixels high (19
  /// pixels if the text contains Chinese characters) and as large as the picture allows. Hints that are wider than the
  /// picture are broken into lines. Returns the boxes in which a pixel may have changed since the last call.
  std::vector<WritingBox> write(const Hud& hud, glm::ivec2 place);
  std::span<const Panel> panels() const { return panels_; }

  /// Blends a panel into a picture with 4 bytes per pixel and rows `pitch` bytes apart. `place`: origin of the eye's
  /// region in the picture. `blue_first`: the bytes are BGRA, otherwise RGBA.
  static void lay_over(const Panel& panel, std::uint8_t* pixels, std::size_t pitch, glm::ivec2 place, bool blue_first);

 private:
  static std::string shown(const Hud& hud, glm::ivec2 place);

  std::string shown_;  // text that the panels show; they are drawn again if the text changes
  std::vector<Panel> panels_;
};

}  // namespace typodont::display
