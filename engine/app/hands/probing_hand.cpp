#include "engine/app/hands/probing_hand.h"

#include <algorithm>
#include <cmath>

#include "engine/app/hands/expert_hand.h"

namespace typodont {

namespace {

constexpr double kProbeTravel = 40e-3, kProbeTurn = 4;  // m/s and rad/s, between two sites
constexpr double kEnter = 8e-3, kLowerPace = 3e-3;      // m/s, towards the margin; in the pocket
constexpr double kYield = 30;                           // 1/s, rate at which the hand yields to the walls
constexpr double kOverMargin = 0.6e-3;                  // m, ball above the margin, at the entry
constexpr double kFromTooth = 3e-3, kOverCrown = 8e-3;  // m, on the way: beside the entry; above that
constexpr double kLongestWay = 14e-3;                   // m, longest motion into a pocket
constexpr double kHoldTime = 0.3, kMarkTime = 0.1;      // s, before a reading; with the pedal pressed

}  // namespace

ProbingHand::ProbingHand(const Scene& scene, double rate, const ProbingHabit& habit)
    : info_(ExpertHand::info_for(rate)), habit_(habit), dt_(1 / rate), ticker_(rate, /*paced=*/false) {
  const auto& sites = scene.task->sites;
  const dvec3 up = scene.task->axis_W;
  dvec3 middle(0);
  for (const session::ProbeSite& site : sites) middle += site.margin_W / static_cast<double>(sites.size());
  const double radius = haptics::tool_set(scene.servo).front().radius();
  for (const session::ProbeSite& site : sites) {
    const dvec3 shank = glm::normalize(site.margin_W - site.floor_W);
    dvec3 out = site.margin_W - middle;
    out = glm::normalize(out - glm::dot(out, up) * up);
    const dquat R = rotation_between({0, 0, 1}, shank);
    const dvec3 entry = site.margin_W + (kOverMargin + radius) * shank + habit.slip;
    const dvec3 beside = entry + kFromTooth * (out + up);
    out_.push_back(out);
    entries_.push_back({{beside + kOverCrown * up, R}, {beside, R}, {entry, R}});
  }
  at_ = entries_.front().front();
  way_ = entries_.front();
}

/// Moves towards the pose `to` for one tick.
void ProbingHand::go(const Pose& to) noexcept {
  const double left = glm::length(to.p - at_.p), turn = 2 * std::acos(std::min(1.0, std::abs(glm::dot(at_.R, to.R))));
  const double pace = stage_ == Stage::kTravel && leg_ + 1 == way_.size() ? kEnter : kProbeTravel;
  const double ticks = std::max({left / (pace * dt_), turn / (kProbeTurn * dt_), 1.0});
  at_ = {at_.p + (to.p - at_.p) / ticks, glm::slerp(at_.R, to.R, 1 / ticks)};
}

bool ProbingHand::read(haptics::HandSample& sample) noexcept {
  if (site_ == entries_.size()) return false;
  sample = {};
  sample.t = ticker_.next();
  waited_ += dt_;
  const auto next = [&](Stage stage) {
    stage_ = stage;
    waited_ = 0;
  };
  const dvec3 shank = at_.R * dvec3(0, 0, 1);
  const double force = glm::dot(seen_.f_T_W, shank);
  // Towards the tooth and away from it only: along the gum, the hand stays at its site.
  const auto yield = [&] {
    const dvec3 out = out_[site_];
    at_.p += std::min(1.0, kYield * dt_) * (glm::dot(seen_.X_WG.p - at_.p, out) - habit_.lean) * out;
  };
  switch (stage_) {
    case Stage::kTravel:
      go(way_[leg_]);
      if (at_.p == way_[leg_].p && ++leg_ == way_.size()) {
        depth_ = 0;
        next(Stage::kLower);
      }
      break;
    case Stage::kLower:
      yield();
      if (force < habit_.force && depth_ < kLongestWay) {
        at_.p -= kLowerPace * dt_ * shank;
        depth_ += kLowerPace * dt_;
      } else {
        next(Stage::kHold);
      }
      break;
    case Stage::kHold:
      yield();
      if (force < 0.9 * habit_.force && depth_ < kLongestWay) next(Stage::kLower);
      if (waited_ > kHoldTime) next(Stage::kMark);
      break;
    case Stage::kMark:
      sample.pedal = 1;
      if (waited_ > kMarkTime) {
        way_ = {{at_.p + depth_ * shank, at_.R}, entries_[site_][1], entries_[site_][0]};
        leg_ = 0;
        next(Stage::kRaise);
      }
      break;
    case Stage::kRaise:
      go(way_[leg_]);
      if (at_.p == way_[leg_].p && ++leg_ == way_.size() && ++site_ < entries_.size()) {
        way_ = entries_[site_];
        leg_ = 0;
        next(Stage::kTravel);
      }
      break;
  }
  sample.X_WT = at_;
  return true;
}

}  // namespace typodont
