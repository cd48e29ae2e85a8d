// A hand that moves as no human does, and a source of invalid input. Tests and benchmarks of all
// contact models use them.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "engine/base/clock.h"
#include "engine/base/pose.h"
#include "engine/base/units.h"

namespace typodont::test {

/// A hand that wanders around a point at up to 0.2 m/s. Its acceleration is up to 20 m/s², which is ten times the
/// acceleration that the passivity controller expects, and more than an arm can have. It also rotates the tool in all
/// directions, and changes its speed from time to time.
class ErraticHand {
 public:
  ErraticHand(std::uint64_t seed, dvec3 home) : random_(seed), home_(home), p_(home) {}
  Pose next(double dt) {
    if (random_() % 400 == 0) {
      constexpr double kSpeeds[] = {0.01, 0.03, 0.1, 0.2};  // m/s, speeds between which the hand changes
      speed_ = kSpeeds[random_() % 4];
    }
    v_ += std::sqrt(dt) * 3.0 * speed_ * anywhere() - dt * (6.0 * v_ + 60.0 * (p_ - home_));
    if (const double length = glm::length(v_); length > speed_) v_ *= speed_ / length;
    turn_ += std::sqrt(dt) * 10.0 * anywhere() - dt * 4.0 * turn_;  // rad/s, angular velocity of the hand
    if (const double rate = glm::length(turn_); rate > 0) {
      R_ = glm::normalize(glm::angleAxis(rate * dt, turn_ / rate) * R_);
    }
    p_ += dt * v_;
    return {p_, R_};
  }
  void leap_to(const dvec3& p) { p_ = p; }

 private:
  dvec3 anywhere() {
    const double x = normal_(random_), y = normal_(random_), z = normal_(random_);
    return {x, y, z};
  }
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_{0, 1};
  double speed_ = 0.03;
  dvec3 home_, p_, v_{0}, turn_{0};
  dquat R_{1, 0, 0, 0};
};

/// Produces invalid input, as a broken device or a broken clock would.
class InvalidInput {
 public:
  /// Changes that the caller must make in a tick, because spoil() cannot make them.
  struct Other {
    Nanos clock = 0;    // ns, jump of the clock that the caller must add to its time
    bool undo = false;  // true if the caller must undo the last stroke
  };

  InvalidInput(std::uint64_t seed, dvec3 home) : random_(seed), home_(home) {}
  double pedal() { return uniform_(random_); }
  /// In one tick of 50, makes the input invalid: changes the hand, its pose or the pedal, or returns a change that the
  /// caller must make.
  Other spoil(ErraticHand& hand, Pose& X, double& pedal) {
    switch (random_() % 450) {
      case 0:
        hand.leap_to(home_ + anywhere(6 * kMillimetre));
        break;
      case 1:
        X.p = {std::numeric_limits<double>::quiet_NaN(), 0, 0};
        break;
      case 2:
        X.p = dvec3(std::numeric_limits<double>::infinity());
        break;
      case 3:
        X.R = dquat(0, 0, 0, 0);
        break;
      case 4:
        X.p = anywhere(1e30);
        break;
      case 5:
        pedal = std::numeric_limits<double>::quiet_NaN();
        break;
      case 6:
        return {.clock = -5'000'000};
      case 7:
        return {.clock = 3'000'000'000};
      case 8:
        return {.undo = true};
      default:
        break;
    }
    return {};
  }

 private:
  dvec3 anywhere(double size) {
    const double x = uniform_(random_), y = uniform_(random_), z = uniform_(random_);
    return size * dvec3(x, y, z);
  }
  std::mt19937_64 random_;
  std::uniform_real_distribution<double> uniform_{-1, 1};
  dvec3 home_;
};

}  // namespace typodont::test
