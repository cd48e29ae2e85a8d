// The guided part of the calibration: it asks the user for the next touch, receives touches, shows residuals at once,
// and stores every touch on disk, so that an interrupted routine can continue. This code has no access to devices; the
// owner of the devices calls add().
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

/// Events of the guided capture that a sound accompanies; see cue_sound().
enum class Cue { kReady, kTaken, kOutlier, kUndone, kDone };

struct Prompt {
  std::string text;                        // text of the prompt, one or two sentences
  std::optional<PanelPoint> mark;          // mark to show on the panel's surface; none: no mark
  std::optional<Dots> dots;                // dots to show to the left and the right eye
  bool left_eye = true, right_eye = true;  // true: the dot for this eye is shown
  std::optional<dvec3> target_D;           // m, frame D of the display: position at which the point should appear
  // for each eye, the position on the panel of a ring around the last touch; it is drawn only if this touch does not
  // fit the other touches
  std::optional<Dots> astray;
};

/// Evaluation of a touch, available at once.
struct Live {
  std::size_t index = 0;  // index of the touch in its step
  double residual = 0;    // m, residual of this touch; 0 while the step has too few touches
  double rms = 0;         // m, root mean square of all residuals of the step up to now
  // m, predicted error at the points of the workspace; only in the step that registers the haptic base
  double predicted_tre = 0;
  bool outlier = false;               // true if this touch is an outlier
  std::optional<dvec3> p_W;           // m, frame W, position of the touch
  std::vector<std::size_t> outliers;  // indices of all outliers of the step up to now
  Cue cue = Cue::kTaken;
  std::string text;  // one line of text for the user
};

class GuidedCapture {
 public:
  /// Continues from the captures in `folder` if there are any. Throws Error if they cannot be read. `plate_pitch`: m,
  /// distance between neighbouring points of the plate (5×5 points).
  GuidedCapture(BenchState bench, std::filesystem::path folder, double plate_pitch = 0.04);

  void begin(Step step);
  Step step() const { return step_; }
  bool done() const;  // true if the step has all its planned touches
  std::size_t taken() const;
  std::size_t planned() const;
  Prompt prompt() const;
  /// Adds one touch, writes it to disk, and evaluates it.
  Live add(const Touch& touch);
  /// Deletes the last touch of this step. Returns false if no touch exists.
  bool undo();
  /// Solves this step from all its captures and applies the result.
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
  std::optional<dvec3> astray_W_;  // m, frame W, position of the last touch, if it does not fit the other touches
};

/// A prompt as a picture for the panel: text and marks, 8-bit grey, rows from the top. The text can be flipped
/// horizontally or vertically, so that it is readable in a mirror; marks keep their positions.
struct Picture {
  int width = 0, height = 0;
  std::vector<unsigned char> grey;
};
Picture prompt_picture(const Prompt& prompt, int width, int height, bool mirrored, bool upside_down = false);

/// Returns the samples of a short tone, mono, -1..1.
std::vector<float> cue_sound(Cue cue, double sample_rate);

}  // namespace typodont::calibration
