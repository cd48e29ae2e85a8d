// Simulates hands that push a tool into the molar with a constant force, and measures the force steps that
// they feel.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/app/scene.h"
#include "haptics/scripted_hand.h"
#include "haptics/tissue_volume.h"

namespace typodont::test {

/// s, time after the start of a contact during which the hand may still bounce
inline constexpr double kPushLanding = 0.3;
/// N; the force may always change by this amount from one tick to the next; only a larger change can count as a step
inline constexpr double kPushStep = 0.02;

/// A simulated hand that pushes: a mass of 0.15 kg with a damper of 5 N·s/m, at a servo rate of 1 kHz.
struct PushHand {
  std::string tool, spindle;  // spindle: empty if the tool does not rotate
  double push = 0;            // N, force of the push, along -z of frame W
  haptics::HandPath path;
};
/// kTouches: the tool neither rotates nor scrapes, for example a probe or a condenser.
enum class ToolKind { kTurns, kScrapes, kTouches };
/// Returns the sorted names of all tools of this kind in the assets.
std::vector<std::string> tools_of(ToolKind kind);
/// Returns a random hand that depends only on the seed. The hand holds one of `tools`, and falls from a height of 0.2
/// to 4 mm onto the chewing surface. It pushes a rotating tool with 0.2 to 0.8 N, other tools with 1 to 4 N. The tool
/// is tilted by up to 0.5 rad, and moves sideways at up to 8 mm/s. Throws Error.
PushHand random_push(const std::vector<std::string>& tools, std::uint32_t seed);

/// A change of the force from one tick to the next.
struct ForceStep {
  double size = 0;   // N, size of the force change
  double t = 0;      // s, time at which the force changed
  double speed = 0;  // m/s, speed of the hand when the force changed
};

/// The largest force steps (changes of the force from one tick to the next) that a hand felt. The limit for a step is
/// kPushStep, or 1.1 N/mm times the distance that the hand moved in this tick if that is larger. `over` is the largest
/// amount by which a step exceeds its limit.
struct PushSteps {
  ForceStep largest, beyond_spring;
  double over = 0;  // N, largest amount by which a force step exceeds its limit (see PushSteps)
};
struct PushResult {
  PushSteps any;             // largest force steps in all ticks
  PushSteps after_landing;   // largest force steps, without the ticks in the first kPushLanding seconds of each contact
  double min_energy = 0;     // J, lowest value of the energy ledger in the run
  std::uint32_t faults = 0;  // bits of enum Fault that any tick set
  bool begins_inside = false;  // true: the hand begins in tissue, so the tool is led out of it first
};

/// Returns the tissue that all hands drill: a molar with caries. Throws Error.
haptics::TissueVolume pushed_tissue();
/// Simulates one hand in a copy of the tissue. Equal hands give equal results. Throws Error.
PushResult simulate_push(const PushHand& hand, const haptics::TissueVolume& tissue);
/// Returns one line for a message: tool, spindle, push and start position of the hand.
std::string text_of(const PushHand& hand);

}  // namespace typodont::test
