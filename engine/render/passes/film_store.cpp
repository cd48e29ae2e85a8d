#include "engine/render/passes/film_store.h"

#include <algorithm>
#include <cstring>

namespace typodont::render {

namespace {

constexpr VkFormat kFilmFormat = VK_FORMAT_R8G8B8A8_UNORM;

}  // namespace

void FilmStore::set(gpu::Device& device, const FilmGrid& wanted) {
  destroy(device);
  grid = wanted;
  image.create(device, on() ? grid.size : glm::ivec3(1), kFilmFormat);
}

void FilmStore::update(std::span<const FilmTexel> all, std::span<const FilmBox> boxes) {
  // If no frame was drawn for a long time, many changed parts wait to be copied. When they have more texels than the
  // whole grid, one copy of the whole grid replaces them.
  const FilmBox whole{glm::ivec3(0), grid.size - 1};
  if (texels.size() > all.size()) {
    parts.clear();
    texels.clear();
    boxes = {&whole, 1};
  }
  for (const FilmBox& box : boxes) {
    const glm::ivec3 size = box.hi - box.lo + 1;
    parts.push_back({box.lo, size, texels.size()});
    for (int x = box.lo.x; x <= box.hi.x; ++x)
      for (int y = box.lo.y; y <= box.hi.y; ++y) {
        const FilmTexel* row = all.data() + (static_cast<std::size_t>(x) * grid.size.y + y) * grid.size.z + box.lo.z;
        texels.insert(texels.end(), row, row + size.z);
      }
  }
}

void FilmStore::mark(const glm::dmat4& clip_from_world, const glm::ivec2& picture, Tiles& tiles) const {
  for (const Part& part : parts) {
    // The shader interpolates between texels. So a changed texel changes the picture as far as the neighbouring texels.
    const dvec3 lo = grid.origin + grid.spacing * (dvec3(part.lo) - 1.0),
                hi = grid.origin + grid.spacing * dvec3(part.lo + part.size);
    tiles.mark(seen_in(clip_from_world, glm::vec3(lo), glm::vec3(hi), picture));
  }
}

std::uint64_t FilmStore::record(gpu::Device& device, VkCommandBuffer commands, int slot) {
  if (parts.empty()) return 0;
  const std::size_t bytes = texels.size() * sizeof(FilmTexel);
  gpu::Buffer& buffer = staging.at_least(device, slot, bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
  std::memcpy(buffer.memory.mapped, texels.data(), bytes);
  std::vector<VkBufferImageCopy> copies;
  for (const Part& part : parts)
    copies.push_back({.bufferOffset = part.first * sizeof(FilmTexel),
                      .bufferRowLength = 0,
                      .bufferImageHeight = 0,
                      .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                      .imageOffset = {part.lo.z, part.lo.y, part.lo.x},
                      .imageExtent = VolumeImage::extent_of(part.size)});
  image.copy(commands, buffer.buffer, copies);
  parts.clear();
  texels.clear();
  return bytes;
}

void FilmStore::destroy(gpu::Device& device) {
  image.destroy(device);
  staging.destroy(device);
  *this = {};
}

}  // namespace typodont::render
