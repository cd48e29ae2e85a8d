// A sound as a picture: its spectrum over time, with its axes.
#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <string>

#include "engine/render/picture.h"

namespace typodont {

struct SoundPicture {
  render::Picture picture;
  glm::ivec2 plot_lo{0}, plot_size{0};  // pixels: its upper left corner, and how large the plot in it is
  double to = 0;                        // Hz at the plot's upper edge; 0 Hz at the lower one
  double seconds = 0;                   // from its left edge to its right one
};

/// `to`: Hz. Throws Error where the file is no sound, or `to` lies above half its rate.
SoundPicture picture_of_sound(const std::filesystem::path& sound, double to, glm::ivec2 pixels);

}  // namespace typodont
