// A simulated subject with a known threshold. This subject judges either the nominal values of the stimuli, or forces:
// the real servo then computes the forces on a scripted hand for each stimulus. For one thread only.
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

/// Judges the difference of two stimuli after adding Gaussian noise to it, and sometimes answers at random (lapses).
class SimulatedObserver {
 public:
  SimulatedObserver(const Psychometric& truth, std::uint64_t seed) : truth_(truth), random_(seed) {}
  /// Returns the answer for the present trial. `difference`: second stimulus minus first stimulus, in the unit of the
  /// question.
  Answer judge(double difference);

 private:
  Psychometric truth_;
  std::mt19937_64 random_;
};

/// Returns the nominal difference second − first of a trial, in the unit of the question. A difference in % is relative
/// to the smaller stimulus.
double nominal_difference(const Trial& trial);

/// Measured properties of the force that a hand felt during one stimulus.
struct Felt {
  /// N/m, stiffness: least-squares slope of the force over the depth, along the normal of the first contact
  double stiffness = 0;
  double force = 0;  // N, largest force during the stimulus
  double delay = 0;  // s, delay: time from the first contact until the force reaches a tenth of its largest value
};

/// Presents each stimulus to a scripted hand, with the real servo, as fast as possible. The tool cuts nothing. Stimuli
/// with the same contact model use the same servo one after the other, as in a live session.
class ScriptedTouch {
 public:
  /// Prepares the runs. `hand`: path of a HAND.csv or HAND.json file, whose motion must begin and end in the air.
  /// `rate`: Hz. Throws Error.
  ScriptedTouch(const Scene& scene, const std::string& hand, double rate);
  ~ScriptedTouch();
  /// Moves the hand through the scene with this stimulus and measures the force. Throws Error if the hand does not
  /// touch the tissue, or if it begins or ends inside the tissue.
  Felt feel(const Stimulus& stimulus);
  /// Runs both stimuli with feel() and returns the difference second − first of the measured property, in the unit of
  /// the question.
  double measured_difference(Question question, const Trial& trial);

 private:
  struct Loop;
  Scene scene_;
  std::string hand_;
  double rate_;
  std::map<std::string, std::unique_ptr<Loop>> loops_;  // one servo and one hand for each contact model
};

}  // namespace typodont
