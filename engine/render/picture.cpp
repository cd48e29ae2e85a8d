#include "engine/render/picture.h"

#include <png.h>

#include <cmath>
#include <cstring>
#include <string>

#include "engine/base/error.h"
#include "engine/base/json.h"

namespace typodont::render {

namespace {

png_image header(const Picture& picture) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.size.x);
  image.height = static_cast<png_uint_32>(picture.size.y);
  image.format = PNG_FORMAT_RGB;
  image.flags = PNG_IMAGE_FLAG_FAST;
  return image;
}

}  // namespace

Picture scaled_to(const Picture& picture, glm::ivec2 size) {
  if (picture.size == size) return picture;
  Picture scaled{size,
                 std::vector<std::uint8_t>(4 * static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y))};
  const glm::dvec2 step = glm::dvec2(picture.size) / glm::dvec2(size);
  for (int y = 0; y < size.y; ++y) {
    for (int x = 0; x < size.x; ++x) {
      // Pixel centres have half-integer coordinates.
      const glm::dvec2 at =
          glm::clamp((glm::dvec2(x, y) + 0.5) * step - 0.5, glm::dvec2(0), glm::dvec2(picture.size - 1));
      const glm::ivec2 low = at, high = glm::min(low + 1, picture.size - 1);
      const glm::dvec2 fraction = at - glm::dvec2(low);
      std::uint8_t* const to =
          scaled.rgba.data() +
          4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) + static_cast<std::size_t>(x));
      for (int c = 0; c < 4; ++c) {
        const double top = glm::mix<double>(picture.at(low.x, low.y)[c], picture.at(high.x, low.y)[c], fraction.x);
        const double bottom = glm::mix<double>(picture.at(low.x, high.y)[c], picture.at(high.x, high.y)[c], fraction.x);
        to[c] = static_cast<std::uint8_t>(std::lround(glm::mix(top, bottom, fraction.y)));
      }
    }
  }
  return scaled;
}

void write_png(const std::filesystem::path& file, const Picture& picture) {
  std::vector<std::uint8_t> rgb;
  rgb.reserve(picture.rgba.size() / 4 * 3);
  for (std::size_t i = 0; i + 3 < picture.rgba.size(); i += 4)
    rgb.insert(rgb.end(), {picture.rgba[i], picture.rgba[i + 1], picture.rgba[i + 2]});
  png_image image = header(picture);
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (!png_image_write_to_memory(&image, bytes.data(), &size, 0, rgb.data(), 0, nullptr))
    throw Error(file.string(), "", image.message, "a picture that PNG can hold");
  bytes.resize(size);
  write_file_atomically(file, bytes, FileKind::kPicture);
}

Picture read_png(const std::filesystem::path& file) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_file(&image, file.c_str()))
    throw Error(file.string(), "", image.message, "a PNG picture");
  image.format = PNG_FORMAT_RGBA;
  Picture picture;
  picture.size = {static_cast<int>(image.width), static_cast<int>(image.height)};
  picture.rgba.resize(PNG_IMAGE_SIZE(image));
  if (!png_image_finish_read(&image, nullptr, picture.rgba.data(), 0, nullptr)) {
    const std::string message = image.message;
    png_image_free(&image);
    throw Error(file.string(), "", message, "a PNG picture");
  }
  return picture;
}

}  // namespace typodont::render
