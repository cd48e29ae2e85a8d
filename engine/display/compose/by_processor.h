// Two eyes into one screen by the processor itself, where there is nothing quicker: through a shader that a processor
// plays, stretching two eyes to 2560 × 1024 takes 13 ms, this 2.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/display/compose/places.h"
#include "engine/display/output.h"

namespace typodont::display {

/// The eyes' pictures, RGBA bytes; one eye twice where there is but one.
struct EyePixels {
  std::array<const std::uint8_t*, 2> first{};
  ivec2 size{0};
};

/// Fills parts of a picture as shaders/compose.frag does, to a step or two of 255 where pixels are stretched.
class ProcessorComposer {
 public:
  /// `part`: pixels of the target, within `place`. `eye`: whose they are, or, where rows alternate, that of the
  /// target's first row. `out`: the target's BGRA bytes, rows `pitch` apart.
  void compose(const EyePixels& eyes, Mix mix, const Place& place, int eye, const Part& part, std::uint8_t* out,
               std::size_t pitch);

 private:
  // Which pixels a pixel of the target lies between, and how far on, of 256.
  struct Between {
    std::vector<std::int32_t> from;
    std::vector<std::uint32_t> on;
    int source = 0, target = 0;
    void fit(int source_size, int target_size);
  };
  Between across_, down_;
  struct Row {
    std::vector<std::uint32_t> pixels;  // of the target's width, BGRA
    int of = -1;                        // row of the source
  };
  /// A row of an eye, stretched to the target's columns.
  const std::uint32_t* stretched(const EyePixels& eyes, int eye, int row, int first, int count);
  std::array<std::array<Row, 2>, 2> rows_;  // of each eye the two last asked for
  std::vector<std::uint32_t> other_;        // the second eye's row, where one is made of both
};

}  // namespace typodont::display
