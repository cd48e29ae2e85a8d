// A subject without a person: an observer of known threshold, who feels either the stimulus as it is meant or what a
// scripted hand felt of it in the real servo. One thread.
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

/// Judges a difference with Gaussian noise, and now and then answers by chance.
class SimulatedObserver {
 public:
  SimulatedObserver(const Psychometric& truth, std::uint64_t seed) : truth_(truth), random_(seed) {}
  /// `difference`: second − first, in the unit of the question.
  Answer judge(double difference);

 private:
  Psychometric truth_;
  std::mt19937_64 random_;
};

/// second − first as the experiment means it: in the unit of the question, relative to the lesser where that is %.
double meant_difference(const Trial& trial);

/// What a hand felt of a stimulus.
struct Felt {
  double stiffness = 0;  // N/m: force over depth, along the normal of the first contact, least squares
  double force = 0;      // N, the greatest
  double delay = 0;      // s from the touch to a tenth of the greatest force
};

/// Feels stimuli with a scripted hand in the real servo, as fast as it can. Nothing is cut. All stimuli of a model are
/// felt one after the other by the same servo, as in a live session.
class ScriptedTouch {
 public:
  /// `hand`: HAND.csv or HAND.json, whose path begins and ends in the air. `rate`: Hz. Throws Error.
  ScriptedTouch(const Scene& scene, const std::string& hand, double rate);
  ~ScriptedTouch();
  /// Throws Error where the hand does not touch the tissue, or begins or ends inside it.
  Felt feel(const Stimulus& stimulus);
  /// second − first as it was felt.
  double felt_difference(Question question, const Trial& trial);

 private:
  struct Loop;
  Scene scene_;
  std::string hand_;
  double rate_;
  std::map<std::string, std::unique_ptr<Loop>> loops_;  // by model
};

}  // namespace typodont
