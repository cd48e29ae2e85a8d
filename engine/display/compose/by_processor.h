// Composes the pictures of both eyes on the CPU, six times as fast as a shader with software rendering.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/display/compose/places.h"
#include "engine/display/output.h"

namespace typodont::display {

/// Pixels of the eyes' pictures, RGBA; with one picture, both entries are the same.
struct EyePixels {
  std::array<const std::uint8_t*, 2> first{};
  ivec2 size{0};
};

/// Does the same as shaders/compose.frag. If the picture is stretched, bytes differ from the shader's by at most 2.
class ProcessorComposer {
 public:
  /// Writes the piece `part` of the output's region `place`. `eye`: the eye shown there; with alternating rows: the eye
  /// shown in the first row. `out`: BGRA, rows `pitch` bytes apart.
  /// `warp`: null if panel and mirror are plane.
  void compose(const EyePixels& eyes, Mix mix, const Place& place, int eye, const Part& part, std::uint8_t* out,
               std::size_t pitch, const Warp* warp = nullptr);

 private:
  // For each target pixel: first source pixel, and weight of the second one, 0..256.
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
  /// Returns a row of the eye's picture, stretched to the target's columns.
  const std::uint32_t* stretched(const EyePixels& eyes, int eye, int row, int first, int count);
  std::array<std::array<Row, 2>, 2> rows_;  // the last two requested rows for each eye
  std::vector<std::uint32_t> other_;        // row of the second eye's picture, if both eyes are mixed in one row
};

}  // namespace typodont::display
