#include "calibration/routine.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "calibration/joint_solver.h"
#include "engine/base/error.h"

namespace typodont::calibration {

dvec3 PairCapture::shown(const RigGeometry& rig) const {
  if (!dots) return shown_D;
  const dvec3 left = rig.eyes.left_eye(), right = rig.eyes.right_eye();
  return closest_point(left, rig.appears(dots->left.u, dots->left.v, left), right,
                       rig.appears(dots->right.u, dots->right.v, right));
}

namespace {

// X_WH from touches of marks, which do not depend on the user's sight. The X_WH of the registration includes the user's
// error.
Pose true_touches(const BenchState& bench, const Captures& captures) {
  std::vector<MarkTouch> marks;
  for (const MarkCapture& capture : captures.marks)
    marks.push_back({capture.mark, bench.rig.X_WH * capture.touch.at(bench.arm)});
  const PanelResult touched = solve_panel(marks);
  if (!touched.not_determined.empty()) return bench.rig.X_WH;
  const std::array from{touched.panel.at(0, 0), touched.panel.at(1, 0), touched.panel.at(0, 1)};
  const std::array to{bench.rig.panel.at(0, 0), bench.rig.panel.at(1, 0), bench.rig.panel.at(0, 1)};
  return fit_rigid(from, to) * bench.rig.X_WH;
}

}  // namespace

void solve_arm_step(BenchState& bench, const Captures& captures) {
  if (captures.arm.empty()) throw Error("arm: found no captures, expected the tip held in sockets or on a plate");
  bench.arm_result = solve_arm(captures.arm, bench.arm);
  if (bench.arm_result->misfit.empty()) bench.arm = bench.arm_result->geometry;
}

void solve_screen_step(BenchState& bench, const Captures& captures, double tip_radius) {
  std::vector<MarkTouch> marks;
  for (const MarkCapture& capture : captures.marks) {
    marks.push_back({capture.mark, bench.rig.X_WH * capture.touch.at(bench.arm)});
  }
  bench.panel_result = solve_panel(marks, tip_radius);
  if (bench.panel_result->not_determined.empty()) bench.rig.panel = bench.panel_result->panel;
  if (captures.mirror.empty()) return;
  std::vector<dvec3> touches;
  for (const Touch& touch : captures.mirror) touches.push_back(bench.rig.X_WH * touch.at(bench.arm));
  bench.mirror_result = solve_mirror(touches, bench.rig.eyes.center, tip_radius);
  if (bench.mirror_result->not_determined.empty()) bench.rig.mirror = bench.mirror_result->mirror;
}

EyesResult eyes_of(const BenchState& bench, const Captures& captures) {
  const Pose X = true_touches(bench, captures);
  std::vector<EyeAlignment> alignments;
  for (const EyeCapture& capture : captures.eyes) {
    alignments.push_back({capture.right, capture.dot, X * capture.touch.at(bench.arm)});
  }
  return solve_eyes(alignments, bench.rig);
}

void solve_eyes_step(BenchState& bench, const Captures& captures, bool user_offset) {
  bench.eyes_result = eyes_of(bench, captures);
  if (bench.eyes_result->not_determined.empty()) bench.rig.eyes = bench.eyes_result->eyes;
  if (!user_offset) return;
  // Uses the positions at which the user saw the points, computed with the new eye positions if they are determined.
  const Pose X = true_touches(bench, captures);
  std::vector<SeenTouch> touches;
  for (const auto* list : {&captures.registration, &captures.verification}) {
    for (const PairCapture& capture : *list) {
      touches.push_back({capture.shown(bench.rig), X * capture.touch.at(bench.arm)});
    }
  }
  if (touches.size() < 4)
    throw Error(
        fmt::format("eyes: found {} touches of seen points, expected four or more for the user's offset; see typodont "
                    "calibrate guide register",
                    touches.size()));
  bench.eyes_result->user_offset = user_offset_of(touches);
}

void solve_register_step(BenchState& bench, const Captures& captures) {
  const auto dots = std::count_if(captures.registration.begin(), captures.registration.end(),
                                  [](const PairCapture& c) { return c.dots.has_value(); });
  if (captures.marks.size() >= 3 && captures.eyes.size() >= 4 && dots >= 10) {
    const auto joint = std::make_shared<JointResult>(solve_jointly(bench, captures));
    bench.arm = joint->arm;
    bench.rig.panel = joint->panel, bench.rig.mirror = joint->mirror, bench.rig.eyes = joint->eyes;
    bench.joint = joint;
  }
  std::vector<dvec3> h, d;
  for (const PairCapture& capture : captures.registration) {
    h.push_back(capture.touch.at(bench.arm)), d.push_back(capture.shown(bench.rig));
  }
  bench.registration = register_points(h, d);
  if (bench.registration->trusted()) bench.rig.X_WH = bench.registration->X_DH;
}

void solve_delay_step(BenchState& bench, const Captures& captures) {
  bench.delay = estimate_delay(captures.delay_a, captures.delay_b);
}

void solve_verify_step(BenchState& bench, const Captures& captures) {
  std::vector<dvec3> h, d;
  for (const PairCapture& capture : captures.verification) {
    h.push_back(capture.touch.at(bench.arm)), d.push_back(capture.shown(bench.rig));
  }
  bench.verification = verify(h, d, bench.rig.X_WH, bench.tolerance, bench.workspace_D);
}

void solve_all(BenchState& bench, const Captures& captures) {
  if (!captures.arm.empty()) solve_arm_step(bench, captures);
  if (!captures.marks.empty()) solve_screen_step(bench, captures);
  if (!captures.eyes.empty()) solve_eyes_step(bench, captures);
  if (!captures.registration.empty()) solve_register_step(bench, captures);
  if (!captures.delay_a.t.empty() && !captures.delay_b.t.empty()) solve_delay_step(bench, captures);
  if (!captures.verification.empty()) solve_verify_step(bench, captures);
}

}  // namespace typodont::calibration
