// Draws the spectrogram of a sound with axes.
#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <string>

#include "engine/render/picture.h"

namespace typodont {

struct SoundPicture {
  render::Picture picture;
  glm::ivec2 plot_lo{0}, plot_size{0};  // pixels: upper left corner and size of the plot
  double to = 0;                        // Hz, frequency at the plot's upper edge; lower edge: 0
  double seconds = 0;                   // s, duration that the plot shows
};

/// Draws the spectrogram of a sound file. `to`: Hz, frequency at the plot's upper edge. Throws Error if the file is not
/// a sound, or if `to` exceeds half its sample rate.
SoundPicture picture_of_sound(const std::filesystem::path& sound, double to, glm::ivec2 pixels);

}  // namespace typodont
