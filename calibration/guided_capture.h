// Guides the user through the touches of a calibration. Asks for each touch, shows its residual at once, and stores it,
// so that the routine can be continued later. Has no access to devices: the caller passes touches to add().
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calibration/routine.h"

namespace typodont::calibration {

enum class Step { kArm, kScreen, kMirror, kEyes, kRegister, kVerify, kDrift };
inline constexpr Step kSteps[] = {Step::kArm,      Step::kScreen, Step::kMirror, Step::kEyes,
                                  Step::kRegister, Step::kVerify, Step::kDrift};
const char* name(Step step);
std::optional<Step> step_named(std::string_view name);

/// Events for which cue_sound() makes a sound.
enum class Cue { kReady, kTaken, kOutlier, kUndone, kDone };

struct Prompt {
  std::string text;                        // text of the prompt, one or two sentences
  std::optional<PanelPoint> mark;          // mark to show on the panel's surface; none: no mark
  std::optional<Dots> dots;                // dots to show to the left and the right eye
  bool left_eye = true, right_eye = true;  // true: the dot for this eye is shown
  std::optional<dvec3> target_D;           // m, position in the display's frame D at which the point should appear
  // Rings, one per eye, around the previous touch if it is an outlier.
  std::optional<Dots> astray;
};

/// Evaluation of a touch, available at once.
struct Live {
  std::size_t index = 0;  // index of the touch in its step
  double residual = 0;    // m, residual of this touch; 0 with too few touches
  double rms = 0;         // m, rms of the residuals of this step's touches so far
  // Rms error in the workspace that is predicted for the registration (step "register"), m.
  double predicted_tre = 0;
  bool outlier = false;               // true if this touch is an outlier
  std::optional<dvec3> p_W;           // m, frame W, position of the touch
  std::vector<std::size_t> outliers;  // indices of all outliers of the step up to now
  Cue cue = Cue::kTaken;
  std::string text;  // one line of text for the user
};

class GuidedCapture {
 public:
  /// Continues a calibration with the captures in `folder`. The calibration plate has 5×5 points; `plate_pitch` is the
  /// distance between neighbouring points, m. Throws Error.
  GuidedCapture(BenchState bench, std::filesystem::path folder, double plate_pitch = 0.04);

  void begin(Step step);
  Step step() const { return step_; }
  bool done() const;  // true if the step has all its planned touches
  std::size_t taken() const;
  std::size_t planned() const;
  Prompt prompt() const;
  /// Adds one touch, writes it to disk, and evaluates it.
  Live add(const Touch& touch);
  /// Deletes the last touch of the step. Returns false if there is none.
  bool undo();
  /// Solves the step from all its captures.
  void solve();

  const BenchState& bench() const { return bench_; }
  const Captures& captures() const { return captures_; }

 private:
  Live judge(std::size_t index) const;
  void save() const;
  BenchState bench_;
  std::filesystem::path folder_;
  Captures captures_;
  Step step_ = Step::kArm;
  double plate_pitch_;
  std::optional<dvec3> astray_W_;  // m, frame W, previous touch if it is an outlier
};

/// Picture in 8-bit grey, rows from the top.
struct Picture {
  int width = 0, height = 0;
  std::vector<unsigned char> grey;
};
/// The marks of a prompt; 0 where there is no mark.
Picture prompt_marks(const Prompt& prompt, int width, int height);

/// Returns the samples of a short tone, mono, -1..1.
std::vector<float> cue_sound(Cue cue, double sample_rate);

}  // namespace typodont::calibration
