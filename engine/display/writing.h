// Text over a picture, without disparity, at the target's resolution. Render thread.
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

/// "800 rpm", "300 krpm".
std::string spindle_text(double krpm, const HudWords& words = {});
/// Returns true if the font has all characters of `text` (UTF-8).
bool can_write(std::string_view text);

/// The values that the text shows.
struct Hud {
  bool visible = false;
  std::string tool;  // name of the tool, for example "round 1.2 mm"
  double speed_krpm = 0;
  // false: would reveal a blind experiment
  bool force_shown = true;
  double force = 0;        // N, force that the text shows
  double force_limit = 5;  // N, force at which the bar is full
  std::string hint;        // lines break at three spaces
  HudWords words;
  double least_letters = 0;  // of half the height; readable_letters()
  glm::dmat2 upright{1.0};   // display::upright()
  double aspect = 0;         // width / height; 0: by pixels
};

/// rad of lower-case x, stricter than ISO 9241-303's 20 to 22' for characters.
inline constexpr double kLeastXHeight = 20.0 / 60 * 3.14159265358979323846 / 180;
/// Letters of half the picture's height at which x subtends kLeastXHeight in the middle; 0: not a mirror bench.
double readable_letters(const DisplayRig& rig);

/// Pixels of the eye's region.
struct WritingBox {
  glm::ivec2 lo{0}, size{0};
};

/// Panels; the rest stays.
class Writing {
 public:
  struct Panel {
    WritingBox box;
    std::vector<std::uint8_t> rgba;  // rows of box.size.x; premultiplied, sRGB
  };

  /// Returns true if write() would change a pixel.
  bool differs(const Hud& hud, glm::ivec2 place) const { return shown(hud, place) != shown_; }
  /// Changed text for a region. 13 pixels or more (Chinese 19), as large as possible; long hints break. Returns changed
  /// boxes.
  std::vector<WritingBox> write(const Hud& hud, glm::ivec2 place);
  std::span<const Panel> panels() const { return panels_; }

  /// On 4-byte pixels, rows `pitch` apart; `place`: origin of the region; `blue_first`: BGRA.
  static void lay_over(const Panel& panel, std::uint8_t* pixels, std::size_t pitch, glm::ivec2 place, bool blue_first);

 private:
  static std::string shown(const Hud& hud, glm::ivec2 place);

  std::string shown_;  // drawn again if changed
  std::vector<Panel> panels_;
};

}  // namespace typodont::display
