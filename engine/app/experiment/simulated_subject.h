// A subject with a known threshold. Judges nominal values, or the forces that the real servo computes for a scripted
// hand. One thread only.
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

namespace typodont {

/// Adds Gaussian noise to the difference, with lapses.
class SimulatedObserver {
 public:
  SimulatedObserver(const Psychometric& truth, std::uint64_t seed) : truth_(truth), random_(seed) {}
  /// `difference`: second − first, in the question's unit.
  Answer judge(double difference);

 private:
  Psychometric truth_;
  std::mt19937_64 random_;
};

/// second − first in the question's unit; % are of the smaller stimulus.
double nominal_difference(const Trial& trial);

/// Measured during one stimulus.
struct Felt {
  /// N/m, least-squares slope of force over depth, along the first contact's normal
  double stiffness = 0;
  double force = 0;  // N, largest force during the stimulus
  double delay = 0;  // s, from the first contact to a tenth of the largest force
};

/// The real servo with a scripted hand, as fast as possible; nothing is cut. Stimuli of one model share a servo, as in
/// a live session.
class ScriptedTouch {
 public:
  /// `hand`: HAND.csv or HAND.json; begins and ends in the air. `rate`: Hz. Throws Error.
  ScriptedTouch(const Scene& scene, const std::string& hand, double rate);
  ~ScriptedTouch();
  /// Throws Error if the hand touches no tissue, or begins or ends inside it.
  Felt feel(const Stimulus& stimulus);
  /// second − first of the measured property, in the question's unit.
  double measured_difference(Question question, const Trial& trial);

 private:
  struct Loop;
  Scene scene_;
  std::string hand_;
  double rate_;
  std::map<std::string, std::unique_ptr<Loop>> loops_;  // one per contact model
};

}  // namespace typodont
