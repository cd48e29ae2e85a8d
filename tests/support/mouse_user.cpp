#include "tests/support/mouse_user.h"

#include <algorithm>
#include <cmath>

#include "engine/app/hands/mouse_hand.h"
#include "engine/app/hands/stroke_planner.h"
#include "engine/app/recording/resume.h"
#include "engine/app/stepped.h"

namespace typodont::test {

namespace {

constexpr double kRate = 1000;                          // Hz, rate of the servo
constexpr int kTicksATurn = 33;                         // ticks of the servo between two movements of the mouse
constexpr double kTurn = kTicksATurn / kRate;           // s
constexpr double kCutPace = 6e-3, kTravelPace = 20e-3;  // m/s, speed of the hand while cutting, and between cuts
constexpr double kLead = 0.20e-3;                       // m by which the hand is ahead of the tool
constexpr double kPatience = 0.8;                       // s to wait for a tool that does not follow
// m, displacement of the hand beyond its goal: increase per turn, and limit
constexpr double kPressing = 0.08e-3, kMaxPress = 1.6e-3;
constexpr double kGain = 4;            // ratio of that displacement to the tool's distance from the goal
constexpr double kThere = 0.05e-3;     // m, distance at which a goal counts as reached
constexpr double kHeldBack = 0.06e-3;  // m by which the tool lags behind the hand when it is blocked
constexpr double kRow = 0.35e-3;       // m between rows and layers
constexpr double kInto = 0;            // m that a stroke may enter the ideal
constexpr double kJoined = 0.8e-3;     // m; strokes that are closer are connected without lifting
constexpr double kOver = 1.0e-3;       // m above everything, height of travel

/// A point that the tool should reach, and whether the drill is on along the path to this point.
struct Goal {
  dvec3 p;
  bool cut;
};

/// Plans the points from the present tissue to the ideal. `top`: height (m, frame W) above which there is no obstacle.
std::vector<Goal> goals_of(const TaskEvaluator& judge, const haptics::TissueVolume& tissue, const Scene& scene,
                           double top) {
  const haptics::Tool& tool = haptics::tool_set(scene.servo)[0];
  session::Preparation now = judge.preparation(tissue);
  now.before = now.after;
  now.ideal = session::redistanced(now.ideal);
  std::vector<Goal> goals;
  for (const Stroke& s : plan_strokes(now, tool, {.step = kRow, .into = kInto})) {
    if (goals.empty() || glm::length(s.from.p - goals.back().p) > kJoined) {
      const double over = top + tool.half() + kOver;
      if (!goals.empty()) goals.push_back({{goals.back().p.x, goals.back().p.y, over}, false});
      goals.push_back({{s.from.p.x, s.from.p.y, over}, false});
    }
    goals.push_back({s.from.p, true});
    goals.push_back({s.to.p, true});
  }
  return goals;
}

/// Position of the mouse in the window, and turns of its wheel.
class Mouse {
 public:
  Mouse(const display::DisplayRig& rig, const dvec3& start, double wheel_step)
      : screen_(rig.screen), eye_(rig.head.eye_center), start_(start), step_(wheel_step) {
    right_ = 0.5 * (screen_.lower_right - screen_.lower_left);
    up_ = 0.5 * (screen_.upper_left - screen_.lower_left);
    middle_ = screen_.lower_left + right_ + up_;
    normal_ = glm::normalize(glm::cross(right_, up_));
    nearer_ = glm::dot(start - middle_, normal_) / glm::dot(eye_ - middle_, normal_);
    in_plane_ = glm::mix(middle_, eye_, nearer_);
  }
  /// Moves an upright tool from `now` as near to p as pixels and wheel notches allow. At wheel zero, the pointer moves
  /// the tool in the plane through `start`, parallel to the screen; the wheel moves it vertically.
  void go(const dvec3& p, const dvec3& now, MouseStep& step) {
    const double slid = now.z - in_plane_.z, slide = glm::dot(p - start_, normal_) / normal_.z;
    // notches per step that a finger can turn
    step.wheel = std::clamp(static_cast<int>(std::lround((slide - slid) / step_)), -6, 6);
    const dvec3 in_plane = p - dvec3(0, 0, slide), on_screen = eye_ + (in_plane - eye_) / (1 - nearer_);
    const glm::dvec2 at(glm::dot(on_screen - middle_, right_) / glm::dot(right_, right_),
                        glm::dot(on_screen - middle_, up_) / glm::dot(up_, up_));
    step.pixel = glm::ivec2(glm::round(glm::dvec2(at.x + 1, 1 - at.y) / 2.0 * glm::dvec2(screen_.pixels)));
    const glm::dvec2 over = input(step).pointer;
    in_plane_ = glm::mix(middle_ + over.x * right_ + over.y * up_, eye_, nearer_);
  }
  display::UserInput input(const MouseStep& step) const {
    display::UserInput input;
    const glm::dvec2 at = glm::dvec2(step.pixel) / glm::dvec2(screen_.pixels);
    input.pointer = {2 * at.x - 1, 1 - 2 * at.y};
    input.wheel = step.wheel;
    input.left = step.left;
    return input;
  }

 private:
  display::Screen screen_;
  dvec3 eye_, start_, right_, up_, middle_, normal_;
  dvec3 in_plane_;  // m, W: where the pointer is
  double step_;
  double nearer_;  // fraction of the way from the screen to the eye, of the plane
};

}  // namespace

MouseSession drill_with_mouse(const Scene& scene, const display::DisplayRig& rig, double wheel_step,
                              double max_seconds) {
  haptics::TissueVolume start = load_tissue(scene);
  glm::ivec3 lo, hi;
  start.bounds(lo, hi);
  const dvec3 above = start.frame().to_world(dvec3((lo.x + hi.x) / 2.0, (lo.y + hi.y) / 2.0, hi.z)) + dvec3(0, 0, 1e-3);
  const double top = above.z - 1e-3;
  const TaskEvaluator judge(scene, start);
  std::vector<Goal> goals = goals_of(judge, start, scene, top);
  SteppedSession stepped(scene, std::move(start), kRate);
  Pointer pointer(rig, above, wheel_step, scene.task->axis_W);
  Mouse mouse(rig, above, wheel_step);

  haptics::HandSample wanted = pointer.follow({}, 0);
  PointerSmoothing smoothing(wanted.X_WT, kRate);
  MouseSession session{{}, 0, stepped.carver().volume().clone(), {}};
  session::HandMeter meter(kRate);
  ServoTick tick;
  tick.X_WT = tick.X_WG = wanted.X_WT;
  Nanos ticks = 0;
  std::size_t next = 0;
  dvec3 aim = wanted.X_WT.p;  // desired position of the hand
  double waited = 0, press = 0;
  while (session.seconds < max_seconds) {
    if (next == goals.size()) {  // plan again for the remaining tissue
      goals = goals_of(judge, stepped.carver().volume(), scene, top);
      next = 0;
      if (goals.empty()) break;
    }
    MouseStep step;
    step.t = session.seconds;
    step.left = true;
    const bool held_back = glm::length(tick.X_WT.p - tick.X_WG.p) > kHeldBack;
    const bool follows = !held_back || glm::length(tick.X_WG.p - aim) < kLead;
    waited = follows ? 0 : waited + kTurn;
    if (follows || waited > kPatience) {
      double way = kTurn * (held_back ? kCutPace : kTravelPace);
      for (; next < goals.size(); ++next) {
        const double far = glm::length(goals[next].p - aim);
        if (far > way) {
          aim += way / far * (goals[next].p - aim);
          break;
        }
        aim = goals[next].p;
        way -= far;
        // The user turns a corner only after the tool has reached it.
        if (goals[next].cut && glm::length(tick.X_WG.p - aim) > 0.5 * kLead && waited <= kPatience) break;
      }
    }
    // If the tool is blocked, the user presses harder and harder; when it is free, the user releases.
    const dvec3 off = aim - tick.X_WG.p;
    const bool presses = held_back && goals[next].cut && glm::length(off) > kThere;
    press = presses ? std::min({press + kPressing, kMaxPress, kGain * glm::length(off)}) : 0.5 * press;
    const dvec3 hand = glm::length(off) > 1e-6 ? aim + press * glm::normalize(off) : aim;
    mouse.go(hand, wanted.X_WT.p, step);
    if (session.steps.size() <= 2) step.wheel = 0;  // a leaning bur would move to the side
    wanted = pointer.follow(mouse.input(step), static_cast<Nanos>(1e9 * session.seconds) + 1,
                            tick.depth > 0 ? std::optional(tick.X_WG.p) : std::nullopt);
    session.steps.push_back(step);
    for (int i = 0; i < kTicksATurn; ++i, ++ticks) {
      tick = stepped.tick(smoothing.next(wanted, ticks * 1'000'000));
      meter.add({&tick, 1});
    }
    session.seconds += kTurn;
  }
  session.tissue = stepped.carver().volume().clone();
  FinishedHand finished;
  finished.input.hand = meter.result();
  session.score = final_score(scene, session.tissue, std::move(finished));
  return session;
}

}  // namespace typodont::test
