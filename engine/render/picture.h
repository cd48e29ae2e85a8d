// A picture in main memory, and PNG files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <vector>

namespace typodont::render {

struct Picture {
  glm::ivec2 size{0};
  std::vector<std::uint8_t> rgba;  // sRGB, 4 bytes per pixel, top row first

  const std::uint8_t* at(int x, int y) const {
    return rgba.data() +
           4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) + static_cast<std::size_t>(x));
  }
};

/// Scales bilinearly, as the screen enlarges pictures of a lower quality level.
Picture scaled_to(const Picture& picture, glm::ivec2 size);
/// Writes an opaque PNG file, completely or not at all. Throws Error.
void write_png(const std::filesystem::path& file, const Picture& picture);
/// Reads a PNG file. Throws Error if this is impossible.
Picture read_png(const std::filesystem::path& file);

}  // namespace typodont::render
