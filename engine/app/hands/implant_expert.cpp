#include "engine/app/hands/implant_expert.h"

#include <algorithm>
#include <cmath>

#include "engine/app/hands/expert_hand.h"
#include "engine/base/clock.h"
#include "engine/base/units.h"
#include "haptics/tool.h"

namespace typodont {

namespace {

namespace level = session::implant_level;
using session::ImplantAction;

constexpr double kAbove = 6e-3;  // m above the entry point, position for tool changes
// Height of the tool's tip above the entry point at which slow motion begins, m.
constexpr double kNear = 1.5e-3;
constexpr double kTravel = 40e-3;      // m/s, speed of the tool outside the tissue
constexpr double kLanding = 4e-3;      // m/s, speed of the hand towards the bone
constexpr double kWithdrawal = 15e-3;  // m/s, speed out of the drilled hole
constexpr double kSweepPace = 7e-3;    // m/s, speed of the smoothing bur
// The smoothing bur moves this far to each side of the axis, m.
constexpr double kSweepReach = 3.0e-3;
// Depth of the hand below the planned height of the ridge, m. The coupling yields, so the bur stays higher.
constexpr double kSweepBelow = 0.1e-3;
constexpr double kSweepApart = 1.0e-3;  // m, distance between two strokes of the smoothing bur
// Forces: drilling, cutting the thread, checking the depth, marking, N.
constexpr double kDrillForce = 3.0, kThreadForce = 1.0, kCheckForce = 0.8, kMarkForce = 1.5;
// Growth of the hand's lead over the tool, m/s per newton of missing force.
constexpr double kLeadPerForce = 1.5e-3;
constexpr double kMaxLead = 3e-3;  // m, largest lead of the hand over the tool
// 1/s and m: rate and largest value of the sideways correction that keeps the tip on the axis.
constexpr double kAsideRate = 5, kMaxAside = 0.3e-3;
constexpr double kPeck = 3e-3;  // m, depth that is drilled between two withdrawals
constexpr double kPull = 2e-3;  // m, length of a withdrawal, in which the bone cools
// Bone temperatures at which the tool is lifted (kHot) and at which work continues (kCool), °C.
constexpr double kHot = 42, kCool = 41;
// Height above the entry point at which the marking bur is out of the pit that it made, m.
constexpr double kClear = 0.5e-3;
// Distance of the tip from the planned depth at which slow motion begins, m.
constexpr double kSlowFrom = 0.3e-3;
constexpr double kPatience = 60;  // s, longest duration of one stage (for example tool change or drilling) of a phase

}  // namespace

ImplantExpert::ImplantExpert(const Scene& scene, double rate)
    : info_(ExpertHand::info_for(rate)),
      task_(*scene.implant),
      tools_(haptics::tool_set(scene.servo).begin(), haptics::tool_set(scene.servo).end()),
      meter_(*scene.implant),
      dt_(1 / rate),
      stiffness_(scene.servo.stiffness),
      motor_(scene.servo.spindle.free_speed),
      depth_(-kAbove) {
  bool there = true;
  for (double y = -kSweepReach; y <= kSweepReach; y += kSweepApart, there = !there) {
    sweep_.push_back({there ? -kSweepReach : kSweepReach, y, 0});
    sweep_.push_back({there ? kSweepReach : -kSweepReach, y, 0});
  }
}

double ImplantExpert::done() const {
  return static_cast<double>(phase_) / static_cast<double>(task_.phases.size());
}

std::string ImplantExpert::gave_up() const {
  return gave_up_ ? phase().name.in(session::Language::kEnglish) : std::string();
}

dvec3 ImplantExpert::tip_from_entry() const {
  return seen_.X_WG * dvec3(0, 0, -tool().half()) - task_.plan.entry_W;
}

double ImplantExpert::tip_depth() const {
  return glm::dot(tip_from_entry(), task_.plan.axis_W);
}

dvec3 ImplantExpert::tip_aside() const {
  const dvec3 aside_W = tip_from_entry() - tip_depth() * task_.plan.axis_W;
  return glm::conjugate(rotation_between({0, 0, -1}, task_.plan.axis_W)) * aside_W;
}

/// Pose parallel to the axis: the tip is `depth` (m) below the entry point, and `aside` (m) from the axis.
Pose ImplantExpert::at(double depth, const dvec3& aside) const {
  const dquat R = rotation_between({0, 0, -1}, task_.plan.axis_W);
  return {task_.plan.entry_W + (depth - tool().half()) * task_.plan.axis_W + R * aside, R};
}

void ImplantExpert::see(const ServoTick& tick) noexcept {
  seen_ = tick;
  meter_.add({&tick, 1});
}

/// Presses along the axis with `newton`, down to `depth` (m).
void ImplantExpert::press(haptics::HandSample& sample, double newton, double depth) {
  const double force = std::max(0.0, -glm::dot(seen_.f_T_W, task_.plan.axis_W));
  lead_ = std::clamp(lead_ + kLeadPerForce * (newton - force) * dt_, 0.02e-3, kMaxLead);
  const double here = tip_depth(), left = depth - here;
  const double lead = left < kSlowFrom ? std::min(lead_, std::max(0.0, left) + 0.02e-3) : lead_;
  depth_ = here + lead;
  aside_ = glm::clamp(aside_ - kAsideRate * dt_ * tip_aside(), -kMaxAside, kMaxAside);
  sample.X_WT = at(depth_, aside_);
}

/// Returns true from the time when the bone is too hot until it has cooled.
bool ImplantExpert::must_cool() {
  const double temperature = meter_.temperature();
  cooling_ = temperature > (cooling_ ? kCool : kHot);
  return cooling_;
}

bool ImplantExpert::worked() const {
  if (phase().deed == ImplantAction::kSmooth) return along_ < 0;
  if (phase().deed == ImplantAction::kMark) return waited_ > 0.5 && tip_depth() > phase().depth - 0.05e-3;
  const bool stays = phase().deed == ImplantAction::kPlace || phase().deed == ImplantAction::kClose;
  return stays ? seen_.level == level::kPlaced : meter_.phase() > phase_;
}

void ImplantExpert::work(haptics::HandSample& sample) {
  const auto& implant = *tool().implant;
  const double top = tool().free_speed(motor_);
  sample.pedal = implant.speed > 0 && top > 0 ? std::min(1.0, implant.speed / top) : 0;
  switch (phase().deed) {
    case ImplantAction::kSmooth: {
      // Sweeps the bur sideways to and fro, its tip at level_depth. Lifts the bur while the bone is too hot.
      const double level_depth = phase().depth + kSweepBelow;
      const double goal = must_cool() ? -kNear : level_depth;
      depth_ += std::clamp(goal - depth_, -kLanding * dt_, kLanding * dt_);
      double left = along_ += depth_ == level_depth ? kSweepPace * dt_ : 0;
      std::size_t i = 0;
      for (; i + 1 < sweep_.size(); ++i) {
        const double length = glm::length(sweep_[i + 1] - sweep_[i]);
        if (left < length) break;
        left -= length;
      }
      if (i + 1 >= sweep_.size()) {
        along_ = -1;
        sample.X_WT = at(depth_, sweep_.back());
        return;
      }
      const dvec3 segment = sweep_[i + 1] - sweep_[i];
      sample.X_WT = at(depth_, sweep_[i] + left / glm::length(segment) * segment);
      return;
    }
    case ImplantAction::kMark:
      press(sample, kMarkForce, phase().depth);
      return;
    case ImplantAction::kCheck:
      sample.pedal = 0;
      press(sample, kCheckForce, phase().depth + 0.3e-3);
      return;
    case ImplantAction::kTap:
    case ImplantAction::kPlace:
    case ImplantAction::kClose:
      press(sample, kThreadForce, phase().depth + 0.3e-3);
      return;
    case ImplantAction::kDrill:
      break;
  }
  // From time to time, withdraws the drill so that the bone cools.
  const bool hot = must_cool();
  if (!pulling_ && tip_depth() < phase().depth - 1e-3 && (hot || tip_depth() > pecked_ + kPeck)) {
    pulling_ = true;
    pecked_ = tip_depth();
  }
  if (pulling_) {
    const double back = std::max(pecked_ - kPull, 0.3e-3);
    if (tip_depth() > back) depth_ = std::min(depth_, tip_depth() + 0.2e-3) - kWithdrawal * dt_;
    sample.X_WT = at(depth_);
    pulling_ = hot || tip_depth() > back;
    lead_ = 0.2e-3;
    return;
  }
  press(sample, kDrillForce, phase().depth);
}

bool ImplantExpert::read(haptics::HandSample& sample) noexcept {
  if (stage_ == Stage::kOver) return false;
  sample = {};
  sample.t = static_cast<Nanos>(std::llround(static_cast<double>(ticks_++) * dt_ * 1e9));
  sample.tool = phase().tool;
  waited_ += dt_;
  const auto next = [&](Stage stage) {
    stage_ = stage;
    waited_ = 0;
  };
  if (waited_ > kPatience) {
    gave_up_ = true;
    // The stage takes too long. In the stage kWork, the tool first moves out of the
    // bone. Any other stage ends at once, for example if the tool does not change.
    if (stage_ != Stage::kWork) stage_ = Stage::kOver;
  }
  switch (stage_) {
    case Stage::kTake:
      sample.X_WT = at(depth_);
      if (ticks_ > 1 && seen_.tool == phase().tool && waited_ > 0.15) {
        along_ = 0, pecked_ = 0, lead_ = 0.1e-3, aside_ = dvec3(0), pulling_ = false;
        next(Stage::kApproach);
      }
      break;
    case Stage::kApproach: {
      const bool smooths = phase().deed == ImplantAction::kSmooth;
      depth_ += (depth_ < -kNear ? kTravel : kLanding) * dt_;
      sample.X_WT = at(depth_, smooths ? sweep_.front() : dvec3(0));
      const double force = std::abs(glm::dot(seen_.f_T_W, task_.plan.axis_W));
      if (smooths) sample.pedal = depth_ > -kNear ? tool().implant->speed / motor_ : 0;
      if (smooths ? depth_ >= phase().depth + kSweepBelow : (force > 0.2 || depth_ > 0.5e-3)) next(Stage::kWork);
      break;
    }
    case Stage::kWork:
      work(sample);
      if (worked() || gave_up_) {
        depth_ = std::min(depth_, tip_depth());
        next(Stage::kBack);
      }
      break;
    case Stage::kBack: {
      // A tap (thread cutter) turns backwards while its thread is in the bone. The servo's state shows this; the plan
      // does not, because the bone's surface may differ from the plan.
      const bool held = tool().implant->threaded() && seen_.level == level::kScrewing;
      if (held) {
        sample.pedal = -1;
        depth_ = tip_depth() - 0.1e-3;
      } else {
        // The bur keeps turning, because the walls of the pit would hold a bur that stands still.
        if (phase().deed == ImplantAction::kMark && depth_ > -kClear) sample.pedal = tool().implant->speed / motor_;
        const double pace = phase().deed == ImplantAction::kMark ? kLanding : kWithdrawal;
        depth_ -= (depth_ > -kNear ? pace : kTravel) * dt_;
      }
      sample.X_WT = at(depth_);
      if (depth_ <= -kAbove) {
        if (gave_up_ || phase_ + 1 == task_.phases.size()) {
          stage_ = Stage::kOver;
        } else {
          ++phase_;
          next(Stage::kTake);
        }
      }
      break;
    }
    case Stage::kOver:
      break;
  }
  return true;
}

}  // namespace typodont
