// Composes the pictures of two eyes on the CPU. Used with software rendering, where a shader takes 13 ms to stretch two
// eyes to 2560 × 1024 and this code takes 2 ms.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/display/compose/places.h"
#include "engine/display/output.h"

namespace typodont::display {

/// The pictures of the two eyes in RGBA bytes. If there is only one picture, both entries point to its pixels.
struct EyePixels {
  std::array<const std::uint8_t*, 2> first{};
  ivec2 size{0};
};

/// Composes parts of a picture on the CPU, like shaders/compose.frag on the GPU. If the picture is stretched, the
/// colours differ from the shader's, and from exact bilinear interpolation, by at most two of 255 levels.
class ProcessorComposer {
 public:
  /// Composes a part of the target. `part`: target pixels inside `place`, the eye's region. `eye`: the eye to draw; if
  /// rows alternate, the eye of the target's first row. `out`: the target's BGRA bytes, with rows `pitch` bytes apart.
  void compose(const EyePixels& eyes, Mix mix, const Place& place, int eye, const Part& part, std::uint8_t* out,
               std::size_t pitch);

 private:
  // A target pixel lies between two source pixels. For each target pixel: the index of the first of these source
  // pixels, and the weight of the second one, 0..256.
  struct SourcePixels {
    std::vector<std::int32_t> from;
    std::vector<std::uint32_t> on;
    int source = 0, target = 0;
    void fit(int source_size, int target_size);
  };
  SourcePixels across_, down_;
  struct Row {
    std::vector<std::uint32_t> pixels;  // pixels of a row, BGRA, as wide as the target
    int of = -1;                        // index of the source row; -1: none
  };
  /// Returns a row of an eye's picture, stretched to the target's columns.
  const std::uint32_t* stretched(const EyePixels& eyes, int eye, int row, int first, int count);
  std::array<std::array<Row, 2>, 2> rows_;  // the last two requested rows for each eye
  std::vector<std::uint32_t> other_;        // row of the second eye, if both eyes are mixed into one row
};

}  // namespace typodont::display
