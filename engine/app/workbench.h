// A live session: every part on its own thread, joined by the channels of wiring.h. Which parts run is the scene's
// choice; a part that is not named costs nothing.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/scene.h"
#include "engine/display/head_tracker.h"

namespace typodont {

struct WorkbenchOptions {
  std::string rig;               // empty: a window where there is a desktop, otherwise no picture
  std::string hand;              // address; empty: the mouse where there is a window
  std::string audio;             // address; empty: a sound card where there is one
  std::filesystem::path record;  // empty: not recorded
  double seconds = 1e18;         // end by itself after so long
  bool explain = false;          // say what is active, and why the rest is not
};

struct WorkbenchSummary {
  double seconds = 0;
  std::uint64_t ticks = 0, frames = 0, cuts = 0;
  std::uint32_t faults = 0;  // bits seen
  std::uint64_t deadline_misses = 0;
  double tick_us_median = 0, tick_us_p999 = 0, worst_tick_us = 0;
  PerTissue removed{};
  std::optional<display::HeadTracker::Stats> tracker;  // where a rig's tracker was listened to
  std::vector<std::string> explanations;
};

/// Runs until the window closes, the hand's script ends, the time is over or the process is asked to stop (SIGINT,
/// SIGTERM). Every end sends zero force. Throws Error at set-up, RunFailure when the run fails.
WorkbenchSummary run_workbench(const Scene& scene, const WorkbenchOptions& options);

}  // namespace typodont
