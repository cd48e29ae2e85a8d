// The showcase: a scripted hand removes the caries of the CT molar, offscreen, without any hardware.
#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <optional>
#include <string>

namespace typodont {

struct DemoOptions {
  std::filesystem::path out = "demo";
  std::string scene;                   // empty: molar-caries of the assets
  std::string rig;                     // empty: film of the assets
  std::optional<glm::ivec2> eye_size;  // pixels of one eye's picture; nothing: the rig's
  std::string model;                   // contact model; empty: the scene's
  double fps = 25;                     // of the film
  double seconds = 1e9;                // stop after so much session time
};

/// Makes pictures, films (stereo and mono), sound, session and report in `out`. Throws Error or RunFailure; prints what
/// it made.
void run_demo(const DemoOptions& options);

}  // namespace typodont
