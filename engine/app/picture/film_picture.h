// The film of water and slurry as texels for the renderer. Drawing thread.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/debris/film.h"
#include "engine/render/renderer.h"

namespace typodont {

class FilmPicture {
 public:
  /// `field`: the film's grid.
  explicit FilmPicture(const debris::CoarseField& field);

  /// Encodes the cells that changed visibly since the last call.
  void update(debris::Film& film);

  const render::FilmGrid& grid() const { return grid_; }
  std::uint64_t version() const { return version_; }
  std::uint64_t texels_written() const { return texels_written_; }

  /// State of the film that a renderer has received.
  struct Shown {
    const FilmPicture* picture = nullptr;
    std::uint64_t version = 0;
  };
  /// Updates a renderer; null: no film.
  static void show(const FilmPicture* picture, render::Renderer& renderer, Shown& shown);

 private:
  static constexpr int kBlock = 8;  // number of samples per side of a block; changes are counted per block

  std::size_t index(const glm::ivec3& s) const {
    return (static_cast<std::size_t>(s.x) * static_cast<std::size_t>(grid_.size.y) + static_cast<std::size_t>(s.y)) *
               static_cast<std::size_t>(grid_.size.z) +
           static_cast<std::size_t>(s.z);
  }
  void write(const debris::Film& film, const glm::ivec3& sample);

  render::FilmGrid grid_;
  glm::ivec3 blocks_{0};
  std::vector<render::FilmTexel> own_;  // texels of the cells
  // texels for the renderer; around the cells, they are the mean of the nearest cells
  std::vector<render::FilmTexel> texels_;
  std::vector<std::uint8_t> queued_;
  std::vector<glm::ivec3> changed_, queue_;
  std::vector<std::uint64_t> block_version_;  // version at which each block changed last
  std::uint64_t version_ = 0, texels_written_ = 0;
};

}  // namespace typodont
