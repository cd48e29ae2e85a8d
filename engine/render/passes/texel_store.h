// A grid of texels around the working tooth: its film of water, or light inside tissue. Its values change during
// cutting. Without a grid, the image has one empty texel, because descriptor sets need an image.
#pragma once

#include <cstring>
#include <span>
#include <vector>

#include "engine/base/voxels.h"
#include "engine/render/passes/changed.h"
#include "engine/render/passes/context.h"
#include "engine/render/passes/volume_image.h"

namespace typodont::render {

template <class Texel>
struct TexelStore {
  dvec3 origin{0};     // m, frame W, position of the first texel
  double spacing = 0;  // m, distance between neighbouring texels
  glm::ivec3 size{0};  // 0: no grid
  VolumeImage image;
  SlotBuffers staging;
  struct Part {  // a changed part that waits for the next frame
    glm::ivec3 lo{0}, size{0};
    std::size_t first = 0;  // index in `texels` of the part's first texel
  };
  std::vector<Part> parts;
  std::vector<Texel> texels;

  bool on() const { return size.x > 0; }
  bool changed() const { return !parts.empty(); }
  /// Makes an empty image for a grid.
  template <class Grid>
  void set(gpu::Device& device, const Grid& wanted, VkFormat format) {
    destroy(device);
    origin = wanted.origin, spacing = wanted.spacing, size = wanted.size;
    image.create(device, on() ? size : glm::ivec3(1), format);
  }
  /// Adds changed parts. `texel(i)`: value with index i = (x·size.y + y)·size.z + z.
  template <class At>
  void update(const At& texel, std::span<const CellBox> boxes) {
    // If the list of changed texels is longer than the grid, the whole grid is copied once.
    const CellBox whole{glm::ivec3(0), size - 1};
    if (texels.size() > voxel_count(size)) {
      parts.clear();
      texels.clear();
      boxes = {&whole, 1};
    }
    for (const CellBox& box : boxes) {
      parts.push_back({box.lo, box.hi - box.lo + 1, texels.size()});
      for_each_voxel_between(box.lo, box.hi,
                             [&](const glm::ivec3& i) { texels.push_back(texel(voxel_index(i, size))); });
    }
  }
  /// Marks the tiles in which changed parts are visible.
  void mark(const glm::dmat4& clip_from_world, const glm::ivec2& picture, Tiles& tiles) const {
    for (const Part& part : parts) {
      // Texels are interpolated, so a part is visible up to the neighbouring texels.
      const dvec3 lo = origin + spacing * (dvec3(part.lo) - 1.0), hi = origin + spacing * dvec3(part.lo + part.size);
      tiles.mark(seen_in(clip_from_world, glm::vec3(lo), glm::vec3(hi), picture));
    }
  }
  /// Copies the changed parts; call before the frame. Returns the number of bytes.
  std::uint64_t record(gpu::Device& device, VkCommandBuffer commands, int slot) {
    if (parts.empty()) return 0;
    const std::size_t bytes = texels.size() * sizeof(Texel);
    gpu::Buffer& buffer = staging.at_least(device, slot, bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    std::memcpy(buffer.memory.mapped, texels.data(), bytes);
    std::vector<VkBufferImageCopy> copies;
    for (const Part& part : parts)
      copies.push_back({.bufferOffset = part.first * sizeof(Texel),
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
  void destroy(gpu::Device& device) {
    image.destroy(device);
    staging.destroy(device);
    *this = {};
  }
};

}  // namespace typodont::render
