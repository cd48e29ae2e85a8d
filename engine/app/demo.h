// The showcase: a scripted hand prepares a cavity in the CT molar, offscreen, without any hardware.
#pragma once

#include <filesystem>
#include <string>

namespace typodont {

struct DemoOptions {
  std::filesystem::path out = "demo";
  std::string scene;     // empty: molar-caries of the assets
  std::string rig;       // empty: closeup of the assets
  std::string model;     // contact model; empty: the scene's
  double fps = 25;       // of the film
  double seconds = 1e9;  // stop after so much session time
};

/// Makes pictures, film, sound, session and report in `out`. Throws Error or RunFailure; prints what it made.
void run_demo(const DemoOptions& options);

}  // namespace typodont
