// A simulated subject with a known threshold. It judges nominal values, or forces that the real servo computes for a
// scripted hand. One thread only.
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

/// Judges differences with Gaussian noise and lapses.
class SimulatedObserver {
 public:
  SimulatedObserver(const Psychometric& truth, std::uint64_t seed) : truth_(truth), random_(seed) {}
  /// The answer. `difference`: second − first, in the question's unit.
  Answer judge(double difference);

 private:
  Psychometric truth_;
  std::mt19937_64 random_;
};

/// second stimulus minus first, in the question's unit. Percentages refer to the smaller stimulus.
double nominal_difference(const Trial& trial);

/// Properties measured during one stimulus.
struct Felt {
  /// Least-squares slope of force over depth, along the normal of the first contact, N/m.
  double stiffness = 0;
  double force = 0;  // N, largest force during the stimulus
  double delay = 0;  // s, time from the first contact until the force is a tenth of its maximum
};

/// Runs the real servo with a scripted hand, as fast as possible; nothing is cut. Stimuli with the same contact model
/// share a servo, as in a live session.
class ScriptedTouch {
 public:
  /// `hand`: a file HAND.csv or HAND.json whose path begins and ends in the air. `rate`: Hz. Throws Error.
  ScriptedTouch(const Scene& scene, const std::string& hand, double rate);
  ~ScriptedTouch();
  /// Runs one stimulus. Throws Error if the hand touches no tissue, or begins or ends inside it.
  Felt feel(const Stimulus& stimulus);
  /// second − first of the measured property, in the question's unit.
  double measured_difference(Question question, const Trial& trial);

 private:
  struct Loop;
  Scene scene_;
  std::string hand_;
  double rate_;
  std::map<std::string, std::unique_ptr<Loop>> loops_;  // one for each contact model
};

}  // namespace typodont
