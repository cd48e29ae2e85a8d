// A simulated observer with a known threshold. It judges either the nominal values of the stimuli, or the forces that a
// scripted hand received from the real servo. One thread.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <string>

#include "engine/app/experiment/experiment.h"
#include "engine/app/scene.h"
#include "haptics/force_delay.h"
#include "haptics/lockstep.h"

namespace typodont {

/// Judges a difference with Gaussian noise, and sometimes answers at random (lapses).
class SimulatedObserver {
 public:
  SimulatedObserver(const Psychometric& truth, std::uint64_t seed) : truth_(truth), random_(seed) {}
  /// `difference`: second − first, in the unit of the question.
  Answer judge(double difference);

 private:
  Psychometric truth_;
  std::mt19937_64 random_;
};

/// Nominal difference second − first, in the unit of the question; a difference in % is relative to the lesser
/// stimulus.
double nominal_difference(const Trial& trial);

/// Measures of the force that a hand received with a stimulus.
struct Felt {
  double stiffness = 0;  // N/m, least-squares slope of force over depth, along the normal of the first contact
  double force = 0;      // N, largest force
  double delay = 0;      // s, time from the first contact until the force reaches a tenth of its largest value
};

/// Presents each stimulus to a scripted hand through the real servo, as fast as possible. Nothing is cut. Stimuli
/// with the same model use the same servo, one after the other, as in a live session.
class ScriptedTouch {
 public:
  /// Prepares the runs. `hand`: HAND.csv or HAND.json; the path must begin and end in the air. `rate`: Hz. Throws
  /// Error.
  ScriptedTouch(const Scene& scene, const std::string& hand, double rate);
  ~ScriptedTouch();
  /// Runs the hand with this stimulus. Throws Error if the hand does not touch the tissue, or begins or ends inside it.
  Felt feel(const Stimulus& stimulus);
  /// Difference second − first of the measures that feel() returns, in the unit of the question.
  double measured_difference(Question question, const Trial& trial);

 private:
  struct Loop;
  Scene scene_;
  std::string hand_;
  double rate_;
  std::map<std::string, std::unique_ptr<Loop>> loops_;  // servo and hand for each contact model
};

}  // namespace typodont
