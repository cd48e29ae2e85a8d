#include "tests/support/carver_stalls.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "engine/app/recording/resume.h"
#include "engine/app/stepped.h"
#include "engine/base/units.h"
#include "haptics/scripted_hand.h"

namespace typodont::test {

namespace {

using namespace literals;

constexpr const char* kTools[] = {"round_006", "round_012",         "round_023", "cylinder_010",     "flame_012",
                                  "pear_010",  "inverted_cone_010", "explorer",  "implant_drill_028"};
constexpr double kLanded = 0.5;     // s, time after the start at which the hand rests on the surface
constexpr double kAfter = 1.0;      // s, time that a run continues after the stall of the carver thread has ended
constexpr double kOwnMotion = 1.1;  // a change of the force above this × stiffness × displacement is a step
constexpr double kRow = 5e-3;       // s, time between two rows of the table that contains the hand's planned positions

/// The planned motion and the parameters of the simulated hand. Times are in s from the start of the run.
struct Course {
  haptics::HandModel model;
  haptics::HandPath path;
  double stall_at = 0;  // s, time at which the stall of the carver thread begins
};

struct Dice {
  std::mt19937_64 random;
  double operator()(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
};

Course make_course(const StallRun& run, Dice& dice, const Pose& at_surface) {
  Course course;
  course.stall_at = kLanded + dice(0.0, 0.3);
  const double end = course.stall_at + run.stall + kAfter;
  const double push = dice(0.4, 2.0), way = dice(0.3_mm, 2.5_mm), turns = dice(0.4, 1.5), phase = dice(0, 2 * kPi);
  const double spring = dice(300, 1000), taps = dice(2, 5), lift = dice(0.3_mm, 1.5_mm);
  const double leave_at = course.stall_at + dice(0, 0.05), leave_speed = dice(20e-3, 150e-3);
  const double drop_speed = dice(20e-3, 100e-3), drop_from = dice(1.5_mm, 4.0_mm);
  const dvec3 across = glm::normalize(dvec3(dice(-1, 1), dice(-1, 1), 0));
  const dvec3 leave = glm::normalize(dvec3(dice(-1, 1), dice(-1, 1), 1.2));
  const bool drills =
      run.gesture == StallGesture::kDrill || (run.gesture == StallGesture::kWithdraw && dice(0, 1) < 0.5);
  const bool by_spring = run.gesture == StallGesture::kTap || run.gesture == StallGesture::kDropIn ||
                         run.gesture == StallGesture::kWithdraw;
  course.model.stiffness = dvec3(2000, 2000, by_spring ? spring : 0.0);
  const double in = push / spring;  // m, depth below the surface at which the spring pushes with the force `push`
  for (double t = 0; t < end + 2 * kRow; t += kRow) {
    haptics::HandPath::Row row;
    row.t = t;
    const double landing = std::clamp(t / (0.6 * kLanded), 0.0, 1.0);
    dvec3 p = across * (way * landing * std::sin(2 * kPi * turns * t + phase));
    switch (run.gesture) {
      case StallGesture::kSlide:
      case StallGesture::kDrill:
        row.push = dvec3(0, 0, -push * landing);
        break;
      case StallGesture::kTap:
        p.z = (lift + in) / 2 * std::cos(2 * kPi * taps * t) + (lift - in) / 2;
        break;
      case StallGesture::kWithdraw:
        p.z = -in * landing;
        if (t > leave_at) p += leave * std::min(leave_speed * (t - leave_at), 10.0_mm);
        break;
      case StallGesture::kDropIn:
        p.z = drop_from - std::min(std::max(0.0, t - course.stall_at) * drop_speed, drop_from + in);
        break;
    }
    row.X_WT = {at_surface.p + p, at_surface.R};
    row.pedal = drills ? 1 : 0;
    course.path.rows.push_back(row);
  }
  return course;
}

/// Returns the pose at which the tool, lowered from the pose `X`, first touches the tissue. The height of this pose is
/// found with a resolution of 0.01 mm.
Pose land(const Scene& scene, Pose X) {
  SteppedSession session(scene, load_tissue(scene), 1000);
  Nanos t = 0;
  for (const double lowest = X.p.z - 15.0_mm; session.last().depth == 0 && X.p.z > lowest; t += 1'000'000) {
    X.p.z -= 0.01_mm;
    session.tick({t, X});
  }
  return X;
}

Scene scene_with(const std::string& tool, const char* model) {
  return parse_scene(
      Json::parse(fmt::format(R"({{"tissue": {{"volume": "teeth/molar.vdb"}}, "tool": "{}", "model": "{}",
                                                  "spindle": "air_turbine", "friction": false, "parts": ["haptics"]}})",
                              tool, model),
                  "stalls"),
      {});
}

}  // namespace

const char* name_of(StallGesture gesture) {
  switch (gesture) {
    case StallGesture::kDrill:
      return "drill";
    case StallGesture::kTap:
      return "tap";
    case StallGesture::kWithdraw:
      return "withdraw";
    case StallGesture::kDropIn:
      return "drop in";
    case StallGesture::kSlide:
      break;
  }
  return "slide";
}

StallResult simulate_stall(const StallRun& run) {
  Dice dice{std::mt19937_64(run.seed * 7919 + static_cast<std::uint64_t>(run.gesture))};
  StallResult felt;
  felt.tool = kTools[static_cast<std::size_t>(dice(0, std::size(kTools) - 1e-9))];
  const Scene scene = scene_with(felt.tool, run.model);
  const double tilt = dice(0, 0.5), around = dice(0, 2 * kPi);
  Pose X{{dice(5.5_mm, 8.0_mm), dice(4.5_mm, 7.0_mm), 22.0_mm + scene.servo.tool.half()},
         glm::angleAxis(tilt, dvec3(std::cos(around), std::sin(around), 0))};
  X = land(scene, X);
  const Course course = make_course(run, dice, X);
  SteppedSession session(scene, load_tissue(scene), run.rate);
  const auto hand = haptics::make_simulated_hand(course.path, course.model, run.rate, /*paced=*/false);

  const double dt = 1 / run.rate, end = course.stall_at + run.stall + kAfter;
  haptics::HandSample sample;
  dvec3 force(0), before(0);
  double given = 0, least = 1e300;
  bool first = true;
  while (hand->read(sample) && to_seconds(sample.t) < end) {
    const double t = to_seconds(sample.t);
    session.hold_carver(run.stalls && t >= course.stall_at && t < course.stall_at + run.stall);
    const ServoTick& tick = session.tick(sample);
    const dvec3 moved = first ? dvec3(0) : sample.X_WT.p - before;
    before = sample.X_WT.p;
    first = false;

    const dvec3 f = tick.f_T_W;
    hand->write(f, tick.tau_T_W);

    if (t >= course.stall_at) {
      given += glm::dot(force, moved);
      felt.energy = std::max(felt.energy, given - least);
      least = std::min(least, given + glm::length(f) * tick.depth / 2);
      const double own = kOwnMotion * scene.servo.stiffness * glm::length(moved);
      felt.worst_step = std::max(felt.worst_step, glm::length(f - force) - own);
      felt.max_force = std::max(felt.max_force, glm::length(f));
      felt.max_speed = std::max(felt.max_speed, glm::length(moved) / dt);
      if (t > course.stall_at + dt) felt.held_back = std::max(felt.held_back, -f.z);
      felt.end_force = glm::length(f);
      felt.faults |= tick.faults;
    }
    force = f;
  }
  return felt;
}

}  // namespace typodont::test
