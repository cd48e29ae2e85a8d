#include "calibration/bench_simulator.h"

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"
#include "engine/base/units.h"

namespace typodont::calibration {

namespace {

dquat small_turn(Noise& random, double angle) {
  const dvec3 v = random.in_box(dvec3(-angle), dvec3(angle));
  return glm::normalize(dquat(1, 0.5 * v.x, 0.5 * v.y, 0.5 * v.z));
}

// Origin in the workspace, 120 mm below the mirror; y up, z to the user. The panel is above the mirror, and its image
// perpendicular to the line of sight.
RigGeometry drawn_rig() {
  RigGeometry rig;
  const dvec3 eye(0, 0.42, 0.40);
  const dvec3 to_eye = glm::normalize(eye), right(1, 0, 0), up = glm::cross(to_eye, right);
  const MirrorPlane mirror{dvec3(0, 1, 0), 0.12};
  const double width = 0.345, height = 0.194;  // m, a 15.6" panel
  const dvec3 corner = -0.5 * width * right - 0.5 * height * up;
  rig.mirror = mirror;
  // The mirror exchanges left and right.
  rig.panel = {mirror.reflect(corner + width * right), mirror.reflect(corner),
               mirror.reflect(corner + width * right + height * up)};
  rig.eyes = {eye, 0.063, right};
  // The arm's base is behind the workspace: x to the user, y right, z up.
  rig.X_WH = {dvec3(0, 0.03 + 0.12, -0.08), dquat(0.5, -0.5, -0.5, -0.5)};
  return rig;
}

}  // namespace

std::size_t BenchSimulator::many(double count) const {
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(count * options_.touches)));
}

BenchSimulator::BenchSimulator(const SimulationOptions& options) : options_(options), random_(options.seed) {
  if (options.arm_errors) {
    auto parameters = to_vector(arm_);
    const auto scales = arm_parameter_scales();
    for (std::size_t i = 0; i < parameters.size(); ++i) parameters[i] += random_.uniform(-1, 1) * scales[i];
    for (std::size_t i = kArmParameters - 2; i < kArmParameters; ++i)
      parameters[i] = 0.5 * options.soft * random_.uniform(-1, 1) * scales[i];
    arm_ = to_geometry(parameters);
  }
  truth_ = drawn_rig();
  const double e = options.placement_error;
  const auto shift = [&] { return random_.in_box(dvec3(-e), dvec3(e)); };
  const Pose panel_moved{shift(), small_turn(random_, 2 * e)};
  const double larger = 1 + 0.5 * (random_.uniform(-e, e) + random_.uniform(-e, e));
  const dvec3 right = truth_.panel.lower_right - truth_.panel.lower_left,
              up = truth_.panel.upper_left - truth_.panel.lower_left;
  truth_.panel.lower_left = panel_moved * truth_.panel.lower_left;
  truth_.panel.lower_right = truth_.panel.lower_left + panel_moved.rotate(right) * larger;
  truth_.panel.upper_left = truth_.panel.lower_left + panel_moved.rotate(up) * larger;
  truth_.mirror->normal = small_turn(random_, e) * truth_.mirror->normal;
  truth_.mirror->offset += random_.uniform(-e, e);
  truth_.eyes.center += shift();
  truth_.eyes.ipd += random_.uniform(-0.2, 0.2) * e;
  truth_.eyes.right = small_turn(random_, 2 * e) * truth_.eyes.right;
  truth_.X_WH = Pose{shift(), small_turn(random_, 2 * e)} * truth_.X_WH;
  if (options.soft > 0) {
    truth_.panel.bow = random_.in_box(dvec3(-6e-4), dvec3(6e-4)) * options.soft;
    // A plate of 0.3 m whose middle is lower than its edges.
    constexpr double kHalf = 0.15;  // m
    truth_.mirror->curvature =
        random_.in_box(dvec3(0, -5e-5, 0), dvec3(5e-4, 5e-5, 5e-4)) * (options.soft * 2 / (kHalf * kHalf));
    truth_.mirror->middle = truth_.mirror->normal * truth_.mirror->offset + random_.in_box(dvec3(-0.02), dvec3(0.02));
  }
}

BenchState BenchSimulator::drawings() const {
  BenchState bench;
  bench.rig = drawn_rig();
  return bench;
}

ArmReading BenchSimulator::hold(const dvec3& p_W) {
  const dvec3 p_H = inverse(truth_.X_WH) * p_W;
  // Draws random angles of the wrist; Newton's method then gives those of the first three joints.
  for (int attempt = 0; attempt < 50; ++attempt) {
    ArmReading reading;
    reading.angle = {0, 0.1, 1.6, random_.uniform(-0.6, 0.6), random_.uniform(-0.6, 0.6), random_.uniform(-0.5, 0.5)};
    for (int round = 0; round < 60; ++round) {
      const dvec3 e = p_H - tip_position(arm_, reading);
      if (glm::length(e) < 1e-15) break;
      glm::dmat3 J;
      for (int joint = 0; joint < 3; ++joint) {
        ArmReading plus = reading, minus = reading;
        plus.angle[static_cast<std::size_t>(joint)] += 1e-6, minus.angle[static_cast<std::size_t>(joint)] -= 1e-6;
        J[joint] = (tip_position(arm_, plus) - tip_position(arm_, minus)) / 2e-6;
      }
      dvec3 step = glm::inverse(J) * e;
      const double size = glm::length(step);
      if (!(size < 1e6)) break;
      if (size > 0.3) step *= 0.3 / size;
      for (int joint = 0; joint < 3; ++joint) reading.angle[static_cast<std::size_t>(joint)] += step[joint];
    }
    if (glm::length(p_H - tip_position(arm_, reading)) < 1e-12) return reading;
  }
  constexpr bool kArmReachesEveryPointOfTheBench = false;
  TYPODONT_CHECK(kArmReachesEveryPointOfTheBench);
  return {};
}

Touch BenchSimulator::touch(const dvec3& p_W, const ArmGeometry& believed_arm) {
  dvec3 reached = p_W + random_.normal3(options_.touch_noise);
  if (random_.uniform(0, 1) < options_.slipped) reached += random_.normal3(4e-3);
  Touch touch;
  touch.reading = hold(reached);
  touch.p_H = tip_position(believed_arm, *touch.reading);
  return touch;
}

dvec3 BenchSimulator::reached_for(const RigGeometry& believed, const dvec3& p_W) const {
  return perceived(believed, truth_, p_W) + options_.user_offset;
}

void BenchSimulator::capture_arm(Captures& captures, const BenchState& bench) {
  // Captures four sockets, then a plate with 5×5 points 40 mm apart in two places.
  int group = 0;
  for (const dvec3 socket :
       {dvec3(-0.08, -0.06, 0.0), dvec3(0.08, -0.06, 0.04), dvec3(0, 0.05, -0.05), dvec3(0.02, -0.02, 0.09)}) {
    for (std::size_t i = 0; i < many(40); ++i) {
      captures.arm.push_back({group, std::nullopt, *touch(socket, bench.arm).reading});
    }
    ++group;
  }
  for (const Pose X_WP : {Pose{{0, -0.06, 0.02}, glm::normalize(dquat(1, -0.7, 0.05, 0.02))},
                          Pose{{0.01, 0, 0}, glm::normalize(dquat(1, -0.2, 0.3, 0.1))}}) {
    for (std::size_t i = 0; i < many(75); ++i) {
      const dvec3 known((static_cast<double>(i % 5) - 2) * 0.04, (static_cast<double>(i / 5 % 5) - 2) * 0.04, 0);
      captures.arm.push_back({group, known, *touch(X_WP * known, bench.arm).reading});
    }
    ++group;
  }
}

void BenchSimulator::capture_screen(Captures& captures, const BenchState& bench) {
  arm_.tip_S += slip();
  const double places[3] = {0.03, 0.5, 0.97};
  for (std::size_t i = 0; i < many(90); ++i) {
    const PanelPoint mark{places[i % 3], places[i / 3 % 3]};
    captures.marks.push_back({mark, touch(truth_.panel.at(mark.u, mark.v), bench.arm)});
  }
  const dvec3 n = truth_.mirror->normal, a = glm::normalize(glm::cross(n, dvec3(0, 0, 1))), b = glm::cross(n, a);
  for (std::size_t i = 0; i < many(90); ++i) {
    dvec3 p = n * truth_.mirror->offset + a * random_.uniform(-0.12, 0.12) + b * random_.uniform(-0.1, 0.12);
    p -= n * truth_.mirror->shape().height(sight::vec<double>(p));
    captures.mirror.push_back(touch(p, bench.arm));
  }
}

void BenchSimulator::capture_eyes(Captures& captures, const BenchState& bench) {
  arm_.tip_S += slip();
  const Box& box = bench.workspace_D;
  for (std::size_t i = 0; i < many(160); ++i) {
    // Shows a dot that, on the bench as estimated, this eye would see in the direction of `wanted`. The user holds the
    // tip on the true line of sight to the dot, at the point nearest to `wanted`.
    EyeCapture capture;
    capture.right = i % 2 == 1;
    const dvec3 wanted = random_.in_box(1.25 * box.low, 1.25 * box.high);
    capture.dot = pixel_for(bench.rig, capture.right ? bench.rig.eyes.right_eye() : bench.rig.eyes.left_eye(), wanted);
    const dvec3 eye = capture.right ? truth_.eyes.right_eye() : truth_.eyes.left_eye();
    const dvec3 sight = glm::normalize(truth_.appears(capture.dot.u, capture.dot.v, eye) - eye);
    capture.touch = touch(eye + sight * glm::dot(sight, wanted - eye), bench.arm);
    captures.eyes.push_back(capture);
  }
}

void BenchSimulator::capture_register(Captures& captures, const BenchState& bench) {
  arm_.tip_S += slip();
  const Box& box = bench.workspace_D;
  // Corners and edges of the workspace determine the rotation best.
  const double places[3] = {0, 0.5, 1};
  for (std::size_t i = 0; i < many(240); ++i) {
    const dvec3 s(places[i % 3], places[i / 3 % 3], places[i / 9 % 3]);
    const dvec3 shown = box.low + (box.high - box.low) * s;
    captures.registration.push_back(
        {shown, touch(reached_for(bench.rig, shown), bench.arm), dots_for(bench.rig, shown)});
  }
}

void BenchSimulator::capture_delay(Captures& captures, const BenchState&) {
  const auto path = [](double t) {
    return dvec3(0.03 * std::sin(1.9 * t) + 0.01 * std::sin(5.3 * t + 1), 0.02 * std::sin(2.7 * t + 2),
                 0.025 * std::cos(1.3 * t) + 0.006 * std::sin(9.7 * t));
  };
  for (int i = 0; i < 2000; ++i) {
    captures.delay_a.t.push_back(i * 0.01);
    captures.delay_a.p.push_back(path(i * 0.01) + random_.normal3(options_.touch_noise));
  }
  for (int i = 0; i < 1200; ++i) {
    const double t = 0.004 + i / 60.0;
    captures.delay_b.t.push_back(t);
    captures.delay_b.p.push_back(truth_.X_WH * path(t - options_.delay) + random_.normal3(options_.touch_noise));
  }
}

void BenchSimulator::capture_verify(Captures& captures, const BenchState& bench) {
  for (std::size_t i = 0; i < many(120); ++i) {
    const dvec3 shown = random_.in_box(bench.workspace_D.low, bench.workspace_D.high);
    captures.verification.push_back(
        {shown, touch(reached_for(bench.rig, shown), bench.arm), dots_for(bench.rig, shown)});
  }
  for (const dvec3 mark : {truth_.panel.at(0.03, 0.03), truth_.panel.at(0.97, 0.03), truth_.panel.at(0.5, 0.97)}) {
    captures.drift_marks.push_back(touch(mark, bench.arm));
  }
}

BenchSimulator::Colocation BenchSimulator::colocation(const BenchState& bench) {
  Colocation result;
  constexpr int kSide = 9;
  constexpr int kPoints = kSide * kSide * kSide;
  for (int k = 0; k < kPoints; ++k) {
    const dvec3 s(k % kSide, k / kSide % kSide, k / (kSide * kSide));
    const dvec3 p_W = bench.workspace_D.low + (bench.workspace_D.high - bench.workspace_D.low) * s / (kSide - 1.0);
    const dvec3 drawn = bench.rig.X_WH * tip_position(bench.arm, hold(p_W));
    const double e = glm::length(reached_for(bench.rig, drawn) - p_W);
    result.mean += e / kPoints, result.rms += e * e / kPoints, result.worst = std::max(result.worst, e);
  }
  result.rms = std::sqrt(result.rms);
  return result;
}

SimulatedRoutine simulate_routine(const SimulationOptions& options) {
  BenchSimulator simulator(options);
  SimulatedRoutine run;
  run.bench = simulator.drawings();
  run.before = simulator.colocation(run.bench);
  simulator.capture_arm(run.captures, run.bench);
  solve_arm_step(run.bench, run.captures);
  simulator.capture_screen(run.captures, run.bench);
  solve_screen_step(run.bench, run.captures);
  simulator.capture_eyes(run.captures, run.bench);
  solve_eyes_step(run.bench, run.captures);
  simulator.capture_register(run.captures, run.bench);
  solve_register_step(run.bench, run.captures);
  simulator.capture_delay(run.captures, run.bench);
  solve_delay_step(run.bench, run.captures);
  simulator.capture_verify(run.captures, run.bench);
  solve_verify_step(run.bench, run.captures);
  run.after = simulator.colocation(run.bench);
  return run;
}

}  // namespace typodont::calibration
