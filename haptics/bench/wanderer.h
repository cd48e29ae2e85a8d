// A hand that no human has, for the hostile tests of all contact models and `typodont bench models`.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "engine/base/pose.h"

namespace typodont::haptics::bench {

/// A hand that wanders around a place at up to 0.2 m/s, with accelerations of up to 20 m/s²: ten times what the energy
/// controller foresees and more than an arm can. It turns the tool in every direction meanwhile, and every so often
/// changes its speed.
class Wanderer {
 public:
  Wanderer(std::uint64_t seed, dvec3 home) : random_(seed), home_(home), p_(home) {}
  Pose next(double dt) {
    if (random_() % 400 == 0) {
      constexpr double kSpeeds[] = {0.01, 0.03, 0.1, 0.2};  // m/s
      speed_ = kSpeeds[random_() % 4];
    }
    v_ += std::sqrt(dt) * 3.0 * speed_ * anywhere() - dt * (6.0 * v_ + 60.0 * (p_ - home_));
    if (const double length = glm::length(v_); length > speed_) v_ *= speed_ / length;
    turn_ += std::sqrt(dt) * 10.0 * anywhere() - dt * 4.0 * turn_;  // rad/s
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

}  // namespace typodont::haptics::bench
