#include "engine/app/operator/steps.h"

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"

namespace typodont {

namespace {

// Duration of contact that completes a step with the action "touch", ns.
constexpr Nanos kTouch = 500'000'000;
constexpr double kDrilled = 0.05 * kCubicMillimetre;
// Length of the tool's path that completes a step with the action "move", m.
constexpr double kPathOfMove = 10 * kMillimetre;
// Longest plausible motion of the tool between two ticks, m.
constexpr double kMost = 20 * kMillimetre;

}  // namespace

bool StepWatcher::waits() const {
  return current_ < count() && !current_step().done.empty();
}

void StepWatcher::begin(const StepActions& now) {
  begun_ = true;
  start_ = now;
  touched_ = 0;
  path_ = 0;
  last_t_ = now.tick.t;
  last_p_ = now.tick.X_WT.p;
}

bool StepWatcher::follow(const StepActions& now) {
  if (current_ >= count()) return false;
  if (!begun_) {
    begin(now);
    return false;
  }
  const Nanos dt = now.tick.t - last_t_;
  const double distance = glm::length(now.tick.X_WT.p - last_p_);
  if (now.tick.contact_area > 0) touched_ += dt;
  if (distance < kMost) path_ += distance;
  last_t_ = now.tick.t;
  last_p_ = now.tick.X_WT.p;

  const std::string& deed = current_step().done;
  const bool done = deed == "move"    ? path_ > kPathOfMove
                    : deed == "touch" ? touched_ > kTouch
                    : deed == "drill" ? total(now.tick.removed) - total(start_.tick.removed) > kDrilled
                    : deed == "tool"  ? takes_another_tool(now)
                    : deed == "speed" ? std::abs(now.settings.speed_fraction - start_.settings.speed_fraction) > 0.01
                    : deed == "undo"  ? now.undone > start_.undone
                    : deed == "redo"  ? now.redone > start_.redone
                    : deed == "view"  ? now.views > start_.views
                    : deed == "viewpoint" ? now.viewpoints > start_.viewpoints
                    : deed == "hold"      ? now.held && !start_.held
                    : deed == "phase"     ? now.phase > static_cast<std::size_t>(current_)
                                          : false;
  // Begins the next step now, because the user's next action may come before the next call.
  if (done) next(), begin(now);
  return done;
}

bool StepWatcher::takes_another_tool(const StepActions& now) const {
  // The servo may take a tool long after it was chosen. A tool that was chosen before the step does not count.
  return now.tick.tool != start_.tick.tool && static_cast<std::int32_t>(now.tick.tool) != start_.chosen_tool;
}

void StepWatcher::next() {
  current_ = std::min(current_ + 1, count());
  begun_ = false;
}

void StepWatcher::back() {
  current_ = std::max(current_ - 1, 0);
  begun_ = false;
}

}  // namespace typodont
