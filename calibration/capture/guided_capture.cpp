#include "calibration/guided_capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/statistics.h"
#include "engine/base/error.h"

namespace typodont::calibration {

namespace {

// Number of touches in each step. For the arm: four sockets, then a plate with 5×5 points in two positions.
constexpr std::size_t kSockets = 4, kSocketTouches = 30, kPlates = 2, kPlateTouches = 25, kPanelTouches = 54,
                      kMirrorTouches = 60, kEyeTouches = 120, kPairTouches = 120, kVerifyTouches = 60,
                      kDriftTouches = 3;

// The nine marks on the panel, corners first.
constexpr PanelPoint kMarks[9] = {{0.03, 0.03}, {0.97, 0.03}, {0.97, 0.97}, {0.03, 0.97}, {0.5, 0.03},
                                  {0.97, 0.5},  {0.5, 0.97},  {0.03, 0.5},  {0.5, 0.5}};

std::vector<dvec3> grid(const Box& box) {
  std::vector<dvec3> points;
  for (int k = 0; k < 27; ++k) {
    const dvec3 s(0.5 * (k % 3), 0.5 * (k / 3 % 3), 0.5 * (k / 9));
    points.push_back(box.low + (box.high - box.low) * s);
  }
  return points;
}

dvec3 scattered(const Box& box, std::size_t index, std::uint64_t seed) {
  Noise random(seed + index);
  return random.in_box(box.low, box.high);
}

double rms_of(const std::vector<double>& residuals, const std::vector<std::size_t>& rejected) {
  double sum = 0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    if (!std::binary_search(rejected.begin(), rejected.end(), i)) sum += residuals[i] * residuals[i];
  }
  return std::sqrt(sum / std::max<double>(1, static_cast<double>(residuals.size() - rejected.size())));
}

/// Calls `visit` with the list of a step's captures.
template <class List, class Visit>
auto of_step(List& captures, Step step, Visit visit) {
  switch (step) {
    case Step::kArm:
      return visit(captures.arm);
    case Step::kScreen:
      return visit(captures.marks);
    case Step::kMirror:
      return visit(captures.mirror);
    case Step::kEyes:
      return visit(captures.eyes);
    case Step::kRegister:
      return visit(captures.registration);
    case Step::kVerify:
      return visit(captures.verification);
    case Step::kDrift:
      break;
  }
  return visit(captures.drift_marks);
}

}  // namespace

const char* name(Step step) {
  constexpr const char* kNames[] = {"arm", "screen", "mirror", "eyes", "register", "verify", "drift"};
  return kNames[static_cast<int>(step)];
}

std::optional<Step> step_named(std::string_view text) {
  for (const Step step : kSteps) {
    if (text == name(step)) return step;
  }
  return std::nullopt;
}

GuidedCapture::GuidedCapture(BenchState bench, std::filesystem::path folder, double plate_pitch)
    : bench_(std::move(bench)), folder_(std::move(folder)), plate_pitch_(plate_pitch) {
  if (std::filesystem::is_directory(folder_)) captures_ = read_captures(folder_);
}

void GuidedCapture::begin(Step step) {
  step_ = step;
  astray_W_.reset();
}

std::size_t GuidedCapture::taken() const {
  return of_step(captures_, step_, [](const auto& list) { return list.size(); });
}

std::size_t GuidedCapture::planned() const {
  constexpr std::size_t kPlanned[] = {kSockets * kSocketTouches + kPlates * kPlateTouches,
                                      kPanelTouches,
                                      kMirrorTouches,
                                      kEyeTouches,
                                      kPairTouches,
                                      kVerifyTouches,
                                      kDriftTouches};
  return kPlanned[static_cast<int>(step_)];
}

bool GuidedCapture::done() const {
  return taken() >= planned();
}

Prompt GuidedCapture::prompt() const {
  Prompt prompt;
  const std::size_t i = taken();
  const auto show = [&](const dvec3& target) {
    prompt.target_D = target;
    prompt.dots = dots_for(bench_.rig, target);
  };
  if (astray_W_) {
    // If the previous touch is an outlier, shows where it was: by a mark on the panel, or in other steps by a dot for
    // each eye.
    if (step_ == Step::kScreen) {
      const Panel& panel = bench_.rig.panel;
      const dvec3 right = panel.lower_right - panel.lower_left, up = panel.upper_left - panel.lower_left,
                  at = *astray_W_ - panel.lower_left;
      const PanelPoint mark{glm::dot(at, right) / glm::dot(right, right), glm::dot(at, up) / glm::dot(up, up)};
      prompt.astray = Dots{mark, mark};
    } else {
      prompt.astray = dots_for(bench_.rig, *astray_W_);
    }
  }
  switch (step_) {
    case Step::kArm:
      if (i < kSockets * kSocketTouches) {
        prompt.text = fmt::format("Hold the tip in socket {} and swing the handle; touch {} of {}.",
                                  i / kSocketTouches + 1, i % kSocketTouches + 1, kSocketTouches);
      } else {
        const std::size_t k = i - kSockets * kSocketTouches;
        prompt.text = fmt::format("Plate in place {}: touch row {}, column {}.", k / kPlateTouches + 1,
                                  k % kPlateTouches / 5 + 1, k % 5 + 1);
      }
      break;
    case Step::kScreen:
      prompt.mark = kMarks[i % 9];
      prompt.text = fmt::format("Touch the cross on the panel itself ({} of {}).", i + 1, planned());
      break;
    case Step::kMirror:
      prompt.text = fmt::format("Touch the mirror anywhere, far from the last touches ({} of {}).", i + 1, planned());
      break;
    case Step::kEyes: {
      // Left and right eye alternate; the dots vary in depth and position.
      const Box& box = bench_.workspace_D;
      const dvec3 wider = 0.15 * (box.high - box.low);
      show(scattered({box.low - wider, box.high + wider}, i / 2, 1000));
      prompt.left_eye = i % 2 == 0, prompt.right_eye = !prompt.left_eye;
      prompt.text = fmt::format("Close the {} eye. Hold the tip so that it covers the dot, {} ({} of {}).",
                                prompt.left_eye ? "right" : "left",
                                i / 2 % 3 == 0   ? "near"
                                : i / 2 % 3 == 1 ? "in the middle"
                                                 : "far",
                                i + 1, planned());
      break;
    }
    case Step::kRegister: {
      const auto candidates = grid(bench_.workspace_D);
      std::vector<dvec3> touched;
      for (const PairCapture& c : captures_.registration) touched.push_back(c.shown(bench_.rig));
      const std::size_t next = touched.empty() ? 0 : most_useful_touch(touched, candidates, bench_.workspace_D);
      show(candidates[next]);
      prompt.text = fmt::format("Touch the point where you see it, both eyes open ({} of {}).", i + 1, planned());
      break;
    }
    case Step::kVerify:
      show(scattered(bench_.workspace_D, i, 2000));
      prompt.text = fmt::format("Touch the point where you see it ({} of {}).", i + 1, planned());
      break;
    case Step::kDrift:
      prompt.text = fmt::format("Touch fixed mark {} of {}: the same three, in the same order, in every session.",
                                i + 1, planned());
      break;
  }
  if (done()) prompt.text = fmt::format("Done: {} of {} touches, d solves. More make it better.", i, planned());
  return prompt;
}

Live GuidedCapture::add(const Touch& touch) {
  const Prompt asked = prompt();
  switch (step_) {
    case Step::kArm:
      if (!touch.reading)
        throw Error("arm: found a touch without joint angles, expected an arm that gives its encoders");
      if (const std::size_t i = taken(); i < kSockets * kSocketTouches) {
        captures_.arm.push_back({static_cast<int>(i / kSocketTouches), std::nullopt, *touch.reading});
      } else {
        const std::size_t k = i - kSockets * kSocketTouches;
        const dvec3 known(static_cast<double>(k % 5), static_cast<double>(k % kPlateTouches / 5), 0);
        captures_.arm.push_back({static_cast<int>(kSockets + k / kPlateTouches), known * plate_pitch_, *touch.reading});
      }
      break;
    case Step::kScreen:
      captures_.marks.push_back({*asked.mark, touch});
      break;
    case Step::kMirror:
      captures_.mirror.push_back(touch);
      break;
    case Step::kEyes:
      captures_.eyes.push_back({asked.right_eye, asked.right_eye ? asked.dots->right : asked.dots->left, touch});
      break;
    case Step::kRegister:
      captures_.registration.push_back({*asked.target_D, touch, asked.dots});
      break;
    case Step::kVerify:
      captures_.verification.push_back({*asked.target_D, touch, asked.dots});
      break;
    case Step::kDrift:
      captures_.drift_marks.push_back(touch);
      break;
  }
  save();
  const Live live = judge(taken() - 1);
  astray_W_ = live.outlier ? live.p_W : std::nullopt;
  return live;
}

bool GuidedCapture::undo() {
  if (taken() == 0) return false;
  astray_W_.reset();
  of_step(captures_, step_, [](auto& list) { list.pop_back(); });
  save();
  return true;
}

void GuidedCapture::save() const {
  // Writes only the file of this step; the files of other steps are up to date.
  constexpr const char* kFiles[] = {"arm.csv",      "marks.csv",  "mirror.csv", "eyes.csv",
                                    "register.csv", "verify.csv", "drift.csv"};
  const char* const file = kFiles[static_cast<int>(step_)];
  write_captures(folder_, captures_, file);
  // Removes the file of a step without captures.
  std::error_code code;
  if (taken() == 0) std::filesystem::remove(folder_ / file, code);
}

void GuidedCapture::solve() {
  switch (step_) {
    case Step::kArm:
      solve_arm_step(bench_, captures_);
      break;
    case Step::kScreen:
    case Step::kMirror:
      solve_screen_step(bench_, captures_);
      break;
    case Step::kEyes:
      solve_eyes_step(bench_, captures_);
      break;
    case Step::kRegister:
      solve_register_step(bench_, captures_);
      break;
    case Step::kVerify:
      solve_verify_step(bench_, captures_);
      break;
    case Step::kDrift:
      // The calibration step "drift" only stores touches. Later sessions compare their touches with the stored touches.
      break;
  }
}

Live GuidedCapture::judge(std::size_t index) const {
  Live live;
  live.index = index;
  const auto take = [&](const std::vector<double>& residuals, const std::vector<std::size_t>& rejected) {
    if (index < residuals.size()) live.residual = residuals[index];
    live.outliers = rejected;
    live.rms = rms_of(residuals, rejected);
    live.outlier = std::binary_search(rejected.begin(), rejected.end(), index);
  };
  const auto place = [&](const Touch& touch) { return bench_.rig.X_WH * touch.at(bench_.arm); };
  switch (step_) {
    case Step::kArm: {
      live.p_W = bench_.rig.X_WH * tip_position(bench_.arm, captures_.arm[index].reading);
      if (index + 1 < 12) break;
      const ArmResult result = solve_arm(captures_.arm, bench_.arm);
      take(result.residuals, result.rejected);
      break;
    }
    case Step::kScreen: {
      live.p_W = place(captures_.marks[index].touch);
      std::vector<MarkTouch> marks;
      for (const MarkCapture& c : captures_.marks) marks.push_back({c.mark, place(c.touch)});
      if (marks.size() < 4) break;
      const PanelResult result = solve_panel(marks);
      take(result.residuals, result.rejected);
      break;
    }
    case Step::kMirror: {
      live.p_W = place(captures_.mirror[index]);
      std::vector<dvec3> touches;
      for (const Touch& t : captures_.mirror) touches.push_back(place(t));
      if (touches.size() < 4) break;
      const MirrorResult result = solve_mirror(touches, bench_.rig.eyes.center);
      take(result.residuals, result.rejected);
      break;
    }
    case Step::kEyes: {
      live.p_W = place(captures_.eyes[index].touch);
      const EyesResult result = eyes_of(bench_, captures_);
      take(result.residuals, result.rejected);
      break;
    }
    case Step::kRegister: {
      live.p_W = place(captures_.registration[index].touch);
      std::vector<dvec3> h, d;
      for (const PairCapture& c : captures_.registration)
        h.push_back(c.touch.at(bench_.arm)), d.push_back(c.shown(bench_.rig));
      if (h.size() < 4) break;
      const RegistrationResult result = register_points(h, d);
      take(result.residuals, result.outliers);
      live.predicted_tre = result.predicted_tre_rms;
      break;
    }
    case Step::kVerify: {
      const PairCapture& c = captures_.verification[index];
      live.p_W = place(c.touch);
      std::vector<double> residuals;
      for (const PairCapture& each : captures_.verification) {
        residuals.push_back(glm::length(bench_.rig.X_WH * each.touch.at(bench_.arm) - each.shown(bench_.rig)));
      }
      take(residuals, {});
      break;
    }
    case Step::kDrift:
      live.p_W = place(captures_.drift_marks[index]);
      break;
  }
  live.cue = live.outlier ? Cue::kOutlier : done() ? Cue::kDone : Cue::kTaken;
  live.text =
      fmt::format("touch {}: {:.3f} mm off, {:.3f} mm rms so far", index + 1, live.residual * 1e3, live.rms * 1e3);
  if (live.predicted_tre > 0) live.text += fmt::format(", {:.3f} mm predicted error", live.predicted_tre * 1e3);
  if (live.outlier) live.text += "; it does not fit the others: undo it, or leave it set aside";
  return live;
}

std::vector<float> cue_sound(Cue cue, double sample_rate) {
  // Two tones for each Cue, Hz: ready, touch recorded (rising), outlier (low), touch deleted (falling), step done.
  constexpr double kTones[][2] = {{660, 660}, {880, 1320}, {220, 196}, {1320, 880}, {1047, 1568}};
  const auto& tones = kTones[static_cast<int>(cue)];
  std::vector<float> sound(static_cast<std::size_t>(0.16 * sample_rate));
  double phase = 0;
  for (std::size_t i = 0; i < sound.size(); ++i) {
    const double s = static_cast<double>(i) / static_cast<double>(sound.size());
    phase += 2 * 3.14159265358979323846 * tones[s < 0.5 ? 0 : 1] / sample_rate;
    sound[i] = static_cast<float>(0.3 * std::sin(phase) * std::min({1.0, 20 * s, 8 * (1 - s)}));
  }
  return sound;
}

}  // namespace typodont::calibration
