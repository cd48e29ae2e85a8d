// What a hand feels while the carver stands still: simulated hands on the molar, and laws to compare with the servo's.
#pragma once

#include <cstdint>
#include <string>

#include "engine/app/scene.h"

namespace typodont {

/// What becomes of the servo's force while the carver is late. All but the first are there to compare with: they
/// attenuate the force by the tick's fault bits, between servo and hand, so the servo's ledger does not know of it.
enum class StallLaw {
  kServo,        // as the servo gives it
  kFadeOnStale,  // fades with 0.1 s while Fault::kStalePatch is set, and comes back within 0.25 s
  kZeroAtEdge,   // zero while Fault::kPatchEdge is set
  kFadeAndZero,  // both
};
inline constexpr StallLaw kStallLaws[] = {StallLaw::kServo, StallLaw::kFadeOnStale, StallLaw::kZeroAtEdge,
                                          StallLaw::kFadeAndZero};
const char* name_of(StallLaw law);

/// What the hand does while the carver stands still.
enum class StallGesture {
  kSlide,     // goes to and fro on the surface under a constant push, the drill at rest
  kDrill,     // the same while it drills
  kTap,       // leaves the surface and comes back, by a spring
  kWithdraw,  // lifts the tool, from sliding or drilling, upward or aslant
  kDropIn,    // comes down from the air, by a spring to a place inside the tissue
};
inline constexpr StallGesture kStallGestures[] = {StallGesture::kSlide, StallGesture::kDrill, StallGesture::kTap,
                                                  StallGesture::kWithdraw, StallGesture::kDropIn};
const char* name_of(StallGesture gesture);

struct StallRun {
  StallGesture gesture = StallGesture::kSlide;
  double stall = 0;        // s; 0: the same hand without a stall
  double rate = 1000;      // Hz
  std::uint64_t seed = 1;  // of the hand, its tool and its place
  StallLaw law = StallLaw::kServo;
};

/// From the stall's first tick to a second after its last. SI.
struct StallFelt {
  std::string tool;
  double worst_step = 0;  // N, the largest change of the force from one tick to the next
  double energy = 0;      // J, given to the hand beyond what the coupling held
  double most_force = 0;  // N
  double most_speed = 0;  // m/s, of the hand
  double held_back = 0;   // N, greatest force against a hand that withdraws …
  double end_force = 0;   // N, in the last tick
  std::uint32_t faults = 0;
};

/// One hand: 0.15 kg, 5 N·s/m, held by a spring or under a constant push. Equal runs give equal results. Throws Error.
StallFelt feel_stall(const StallRun& run);

}  // namespace typodont
