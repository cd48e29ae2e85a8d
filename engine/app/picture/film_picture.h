// Converts the film of water and slurry to texels for the renderer. Render thread only.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/base/voxels.h"
#include "engine/debris/film.h"
#include "engine/render/renderer.h"

namespace typodont {

class FilmPicture {
 public:
  /// `field`: distance field with the grid of the film of water. `version`: larger than that of an earlier FilmPicture
  /// at the same memory address; otherwise show() would not send the new, empty film.
  explicit FilmPicture(const debris::CoarseField& field, std::uint64_t version = 0);

  /// Updates the texels of those cells of the film of water that have changed visibly since the last call.
  void update(debris::Film& film);

  const render::FilmGrid& grid() const { return grid_; }
  std::uint64_t version() const { return version_; }
  std::uint64_t texels_written() const { return texels_written_; }

  /// The version of the water film that a renderer has received.
  struct Shown {
    const FilmPicture* picture = nullptr;
    std::uint64_t version = 0;
  };
  /// Sends the changes of the film of water to a renderer. `picture`: null if there is no film.
  static void show(const FilmPicture* picture, render::Renderer& renderer, Shown& shown);

 private:
  /// Side of a block, samples. Changes are sent to the renderer block by block.
  static constexpr int kBlock = 8;

  std::size_t index(const glm::ivec3& s) const { return voxel_index(s, grid_.size); }
  void write(const debris::Film& film, const glm::ivec3& sample);

  render::FilmGrid grid_;
  glm::ivec3 blocks_{0};
  std::vector<render::FilmTexel> own_;  // one texel per cell of the film of water, except the cells at the border
  // Texels for the renderer. A grid point outside of the film's cells gets the mean of the nearest cells' texels.
  std::vector<render::FilmTexel> texels_;
  std::vector<std::uint8_t> queued_;
  std::vector<glm::ivec3> changed_, queue_;
  std::vector<std::uint64_t> block_version_;  // version of the water film when each block last changed
  std::uint64_t version_, texels_written_ = 0;
};

}  // namespace typodont
