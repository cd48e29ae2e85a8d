// A picture on the host, and PNG files.
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

/// Resizes a picture with bilinear filtering, as the screen resizes the smaller pictures of a lower quality level.
Picture scaled_to(const Picture& picture, glm::ivec2 size);
/// Writes an opaque PNG completely or not at all. Throws Error if the file cannot be written.
void write_png(const std::filesystem::path& file, const Picture& picture);
/// Reads a PNG file. Throws Error if the file is not a readable PNG.
Picture read_png(const std::filesystem::path& file);

}  // namespace typodont::render
