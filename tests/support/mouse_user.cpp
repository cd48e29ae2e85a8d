#include "tests/support/mouse_user.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "engine/app/hands/mouse_hand.h"
#include "engine/app/recording/resume.h"
#include "engine/app/stepped.h"
#include "engine/base/units.h"

namespace typodont::test {

namespace {

constexpr double kRate = 1000;                          // Hz, rate of the servo
constexpr int kTicksATurn = 33;                         // ticks of the servo between two movements of the mouse
constexpr double kTurn = kTicksATurn / kRate;           // s
constexpr double kCutPace = 6e-3, kTravelPace = 20e-3;  // m/s, speed of the hand while cutting, and between cuts
constexpr double kMaxPush = 0.85e-3;                    // m, largest displacement of the hand beyond its goal
constexpr double kPushing = 0.4;  // growth of this displacement per turn / distance of the tool from its goal
// m, distance at which a goal counts as reached: in the bulk, and at a wall
constexpr double kBulk = 0.2e-3, kFine = 0.03e-3;
constexpr double kHoleGap = 0.05e-3;  // m, width of the hole beyond the radius of the bur that follows
constexpr double kPitch = 0.25e-3;    // m, descent per turn of the bur that enters
constexpr double kOver = 1.0e-3;      // m above everything, height of travel
constexpr int kCorners = 16;          // goals per circle

/// A point that the tool's free end should reach.
struct Goal {
  dvec3 p;      // m, frame W
  double near;  // m, distance at which the goal counts as reached; 0: a motion through the air
  std::uint32_t tool;
};

/// What the difference view (key D) shows on the untouched tooth: the part of the surface that is to be removed.
struct Outline {
  dvec3 middle{0};  // m, frame W
  dvec3 along{0};   // unit vector along the longer side, horizontal
};
Outline outline_of(const session::Preparation& untouched) {
  Outline outline;
  std::vector<dvec3> points;
  const glm::ivec3 size = untouched.before.size;
  const auto distance = [&](int x, int y, int z) {
    return static_cast<double>(untouched.before.distance[untouched.before.at(x, y, z)]);
  };
  for (int x = 0; x < size.x; ++x) {
    for (int y = 0; y < size.y; ++y) {
      int z = size.z - 1;
      while (z > 0 && distance(x, y, z - 1) > 0) --z;
      if (z == 0 || distance(x, y, z) <= 0) continue;
      const double outside = distance(x, y, z);
      const dvec3 surface(x, y, z - outside / (outside - distance(x, y, z - 1)));
      constexpr double kShown = 0.2;  // voxels, smallest difference that has a colour
      if (untouched.ideal.sample(surface) > kShown) points.push_back(untouched.frame.to_world(surface));
    }
  }
  for (const dvec3& p : points) outline.middle += p / static_cast<double>(points.size());
  glm::dmat2 spread(0);
  for (const dvec3& p : points) {
    const glm::dvec2 off = p - outline.middle;
    spread += glm::outerProduct(off, off);
  }
  const double angle = 0.5 * std::atan2(2 * spread[0][1], spread[0][0] - spread[1][1]);
  outline.along = {std::cos(angle), std::sin(angle), 0};
  return outline;
}

/// The index of the tool that a step of the task names.
std::uint32_t tool_of_step(const Scene& scene, std::size_t step) {
  const std::vector<std::string> names = tool_names(scene);
  return static_cast<std::uint32_t>(std::ranges::find(names, scene.task->steps.at(step).tool) - names.begin());
}

/// Plans the slot as the steps of the task say: a hole to the full depth at one end, then along the slot at this depth,
/// then along its walls. `top`: height (m, frame W) above which there is no obstacle.
std::vector<Goal> goals_in(const Scene& scene, const Outline& outline, const SlotSize& slot, double top) {
  const std::span<const haptics::Tool> tools = haptics::tool_set(scene.servo);
  const std::uint32_t enters = tool_of_step(scene, 0), widens = tool_of_step(scene, 2);
  const dvec3 up(0, 0, 1), along = outline.along, across = glm::cross(up, along);
  const double straight = slot.length - slot.width, floor = -slot.depth, over = top + kOver - outline.middle.z;
  const auto at = [&](double a, double b, double height) {
    return outline.middle + a * along + b * across + height * up;
  };
  const double first = -0.5 * straight, last = 0.5 * straight;
  std::vector<Goal> goals{{at(first, 0, over), 0, enters}};
  const double hole = tools[widens].radius() + kHoleGap - tools[enters].radius();
  const auto around = [&](double center, double from, double to, double radius, double height, double descent,
                          double near, std::uint32_t tool) {
    for (int i = 0; i <= kCorners; ++i) {
      const double fraction = static_cast<double>(i) / kCorners, angle = glm::mix(from, to, fraction);
      goals.push_back(
          {at(center + radius * std::cos(angle), radius * std::sin(angle), height - descent * fraction), near, tool});
    }
  };
  double height = 0.5 * slot.depth;
  for (; height > floor + kPitch; height -= kPitch) around(first, 0, 2 * kPi, hole, height, kPitch, kBulk, enters);
  around(first, 0, 2 * kPi, hole, height, height - floor, kBulk, enters);
  around(first, 0, 2 * kPi, hole, floor, 0, kBulk, enters);
  goals.push_back({at(first, 0, over), 0, enters});
  goals.push_back({at(first, 0, over), 0, widens});
  goals.push_back({at(first, 0, 0), 0, widens});
  goals.push_back({at(first, 0, floor), kFine, widens});
  goals.push_back({at(last, 0, floor), kBulk, widens});
  const double wall = 0.5 * slot.width - tools[widens].radius();
  for (int round = 0; round < 2; ++round) {
    around(last, -0.5 * kPi, 0.5 * kPi, wall, floor, 0, kFine, widens);
    around(first, 0.5 * kPi, 1.5 * kPi, wall, floor, 0, kFine, widens);
  }
  goals.push_back({at(last, -wall, floor), kFine, widens});
  goals.push_back({at(last, -wall, over), 0, widens});
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
                              const SlotSize& slot, double max_seconds) {
  haptics::TissueVolume start = load_tissue(scene);
  glm::ivec3 lo, hi;
  start.bounds(lo, hi);
  const dvec3 above = start.frame().to_world(dvec3((lo.x + hi.x) / 2.0, (lo.y + hi.y) / 2.0, hi.z)) + dvec3(0, 0, 1e-3);
  const std::span<const haptics::Tool> tools = haptics::tool_set(scene.servo);
  const std::vector<Goal> goals =
      goals_in(scene, outline_of(TaskEvaluator(scene, start).preparation(start)), slot, above.z - 1e-3);
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
  dvec3 aim = wanted.X_WT.p;  // desired position of the head's centre
  dvec3 push(0);              // m, displacement of the hand beyond `aim`
  for (std::size_t next = 0; next < goals.size() && session.seconds < max_seconds;) {
    const Goal& goal = goals[next];
    MouseStep step;
    step.t = session.seconds;
    step.tool = goal.tool;
    step.left = tick.tool == goal.tool;  // the tool can be changed when the drill stands still
    const bool cuts = goal.near > 0;
    const double near = cuts ? goal.near : kFine;
    // The user moves on when the tool has followed.
    if (step.left && (!cuts || glm::length(tick.X_WG.p - aim) < near)) {
      const dvec3 p = goal.p + dvec3(0, 0, tools[goal.tool].half());
      const double far = glm::length(p - aim), way = kTurn * (cuts ? kCutPace : kTravelPace);
      aim = far > way ? aim + way / far * (p - aim) : p;
      if (far <= way && glm::length(tick.X_WG.p - aim) < near) ++next;
    }
    // The user pushes until the tool follows, and releases when it is there.
    const dvec3 off = aim - tick.X_WG.p;
    push = cuts ? push + kPushing * off : dvec3(0);
    const double most = std::min(kMaxPush, kMaxPush * glm::length(off) / near);
    if (glm::length(push) > most) push *= most / glm::length(push);
    mouse.go(aim + push, wanted.X_WT.p, step);
    if (session.steps.size() <= 2) step.wheel = 0;  // a leaning bur would move to the side
    wanted = pointer.follow(mouse.input(step), static_cast<Nanos>(1e9 * session.seconds) + 1,
                            tick.depth > 0 ? std::optional(tick.X_WG.p) : std::nullopt);
    session.steps.push_back(step);
    for (int i = 0; i < kTicksATurn; ++i, ++ticks) {
      haptics::HandSample sample = smoothing.next(wanted, ticks * 1'000'000);
      sample.tool = step.tool;
      tick = stepped.tick(sample);
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
