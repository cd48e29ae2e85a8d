// The film of water and slurry on the GPU: a 3-D image of texels around the working tooth. Without a film, the image
// consists of one empty texel, because the descriptor sets need an image.
#pragma once

#include <span>
#include <vector>

#include "engine/render/passes/changed.h"
#include "engine/render/passes/context.h"
#include "engine/render/passes/volume_image.h"

namespace typodont::render {

struct FilmStore {
  FilmGrid grid;  // grid of the film; its size is 0 if there is no film
  VolumeImage image;
  SlotBuffers staging;
  struct Part {  // a changed part of the grid that waits for the next frame
    glm::ivec3 lo{0}, size{0};
    std::size_t first = 0;  // index in `texels` of the part's first texel
  };
  std::vector<Part> parts;
  std::vector<FilmTexel> texels;

  bool on() const { return grid.size.x > 0; }
  bool changed() const { return !parts.empty(); }
  /// Makes an empty image for the grid `wanted` of the film.
  void set(gpu::Device& device, const FilmGrid& wanted);
  void update(std::span<const FilmTexel> all, std::span<const FilmBox> boxes);
  /// Marks the tiles (squares of the picture) in which the changed parts are visible.
  void mark(const glm::dmat4& clip_from_world, const glm::ivec2& picture, Tiles& tiles) const;
  /// Copies the changed parts into the image before the frame is drawn. Returns the number of copied bytes.
  std::uint64_t record(gpu::Device& device, VkCommandBuffer commands, int slot);
  void destroy(gpu::Device& device);
};

}  // namespace typodont::render
