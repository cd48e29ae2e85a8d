// Text over a picture, without stereo disparity, at the resolution of the target. Render thread only.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/display/display_rig.h"

namespace typodont::display {

/// Number formats in the user's language: units, decimal sign.
struct HudWords {
  std::string rpm = "{} rpm", krpm = "{} krpm";  // formats of a slow and of a fast spindle's speed
  char decimal = '.';
};

/// Speed of the spindle as text: "800 rpm", "300 krpm".
std::string spindle_text(double krpm, const HudWords& words = {});
/// Returns true if the font has all of `text` (UTF-8).
bool can_write(std::string_view text);

/// The values that the text shows.
struct Hud {
  bool visible = false;
  std::string tool;  // name of the tool, for example "round 1.2 mm"; empty: only the hint is shown
  double speed_krpm = 0;
  // false: the force is hidden, because it would reveal the condition of a blind experiment.
  bool force_shown = true;
  double force = 0;        // N, force that the text shows
  double force_limit = 5;  // N, force at which the bar is full
  std::string hint;        // hint; lines may break where the text has three spaces
  std::string warning;     // a sentence below the hint, in dark letters on amber; empty: none
  HudWords words;
  // smallest height of letters in units of half the picture's height, from readable_letters()
  double min_letters = 0;
  glm::dmat2 upright{1.0};  // orientation of the picture, from display::upright()
  double aspect = 0;        // width / height of the shown picture; 0: width / height in pixels
};

/// Smallest visual angle of a lower-case x, rad: 20 arc minutes. ISO 9241-303 requires less: 20 to 22 arc minutes for a
/// whole character.
inline constexpr double kMinXHeight = 20.0 / 60 * 3.14159265358979323846 / 180;
/// Smallest readable height of letters, in units of half the picture's height: the letter x in the picture's middle
/// then has the visual angle kMinXHeight. 0 if the display is not a mirror bench.
double readable_letters(const DisplayRig& rig);

/// Width of a line of text in the unit of `height`, the height of the font.
double text_width(std::string_view text, double height);
/// Draws a line of text over a picture of 4-byte pixels, for example an axis label. `at`: left end of the baseline,
/// pixels from the upper left corner; `height`: pixels; `color`: sRGB.
void write_line(std::uint8_t* rgba, const glm::ivec2& size, const glm::dvec2& at, double height, std::string_view text,
                const glm::u8vec3& color);

/// A rectangle in the region of an eye, pixels.
struct WritingBox {
  glm::ivec2 lo{0}, size{0};
};

/// The text as panels with pixels; the rest of the picture stays.
class Writing {
 public:
  struct Panel {
    WritingBox box;
    std::vector<std::uint8_t> rgba;  // rows of box.size.x pixels; premultiplied, sRGB
  };

  /// Returns true if write() would change a pixel.
  bool differs(const Hud& hud, glm::ivec2 place) const { return shown(hud, place) != shown_; }
  /// Draws the text for a region of the size `place`. Letters are as large as possible, at least 13 pixels (Chinese
  /// 19); long hints are divided into lines. Returns the boxes of changed panels.
  std::vector<WritingBox> write(const Hud& hud, glm::ivec2 place);
  std::span<const Panel> panels() const { return panels_; }

  /// Draws a panel over 4-byte pixels, rows `pitch` bytes apart. `place`: origin of the region; `blue_first`: BGRA.
  static void lay_over(const Panel& panel, std::uint8_t* pixels, std::size_t pitch, glm::ivec2 place, bool blue_first);

 private:
  static std::string shown(const Hud& hud, glm::ivec2 place);

  std::string shown_;  // content that was drawn last; the text is drawn again if it changes
  std::vector<Panel> panels_;
};

}  // namespace typodont::display
