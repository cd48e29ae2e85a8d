// The demonstration: a scripted hand removes the caries of the CT molar. It needs no window and no hardware.
#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <optional>
#include <string>

#include "engine/session/strings.h"

namespace typodont {

struct DemoOptions {
  std::filesystem::path out = "demo";
  std::string scene;                                         // scene file; empty: the shipped scene molar-caries
  std::string rig;                                           // rig file or name; empty: the shipped rig `film`
  std::optional<glm::ivec2> eye_size;                        // pixels, size of one eye's picture; empty: the rig's size
  std::string model;                                         // contact model; empty: the scene's model
  double fps = 25;                                           // frames per second of the film
  double seconds = 1e9;                                      // s, limit of the session's duration
  session::Language language = session::Language::kEnglish;  // language of the text over the picture
};

/// Runs the demonstration. Writes pictures, films (stereo and mono), sound, session and report to the folder `out`, and
/// prints their names. Throws Error or RunFailure.
void run_demo(const DemoOptions& options);

}  // namespace typodont
