// Measures the force on a simulated hand while the carver (the thread that updates the tissue) stalls. The hand touches
// the molar.
#pragma once

#include <cstdint>
#include <string>

#include "engine/app/scene.h"

namespace typodont::test {

/// Motion of the hand during the stall of the carver thread.
enum class StallGesture {
  kSlide,     // the tool moves to and fro on the surface under a constant force, with the drill off
  kDrill,     // the tool moves to and fro on the surface with the drill on
  kTap,       // a spring moves the tool off the surface and back
  kWithdraw,  // the tool is lifted after it has slid or drilled, straight up or at an angle
  kDropIn,    // a spring moves the tool from the air to a point inside the tissue
};
inline constexpr StallGesture kStallGestures[] = {StallGesture::kSlide, StallGesture::kDrill, StallGesture::kTap,
                                                  StallGesture::kWithdraw, StallGesture::kDropIn};
const char* name_of(StallGesture gesture);

struct StallRun {
  StallGesture gesture = StallGesture::kSlide;
  double stall = 0;              // s, duration of the carver thread's stall; 0: no stall, for comparison
  double rate = 1000;            // Hz, rate of the servo
  std::uint64_t seed = 1;        // random seed that determines the hand, its tool and its position
  const char* model = "offset";  // contact model
  bool stalls = true;            // false: the carver does not stall; for comparison with a run of equal length
};

/// Results of one run, measured from the first tick of the stall until one second after the end of the stall. SI units.
struct StallResult {
  std::string tool;
  // N, the largest change of the force from one tick to the next, beyond what the hand's own motion causes
  double worst_step = 0;
  // J, largest energy that the hand received beyond the energy that was stored in the coupling spring
  double energy = 0;
  double max_force = 0;  // N, largest force during the measured time
  double max_speed = 0;  // m/s, highest speed of the hand during the measured time
  // N, largest component of the force in the direction -z of frame W, that is, towards the tissue
  double held_back = 0;
  double end_force = 0;  // N, force on the hand in the last tick of the run
  std::uint32_t faults = 0;
};

/// Simulates one hand: mass 0.15 kg, damper 5 N·s/m, held by a spring or pushed by a constant force. Equal runs give
/// equal results. Throws Error.
StallResult simulate_stall(const StallRun& run);

}  // namespace typodont::test
