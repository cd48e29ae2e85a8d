// The guided part of the routine: says what to touch next, takes touches, shows residuals as they come, and keeps every
// touch on disk, so that a routine broken off goes on where it was. Knows no device: whoever owns one calls add().
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

/// Sounds that go with what happens; see cue_sound().
enum class Cue { kReady, kTaken, kOutlier, kUndone, kDone };

struct Prompt {
  std::string text;                        // one or two sentences
  std::optional<PanelPoint> mark;          // to be shown on the panel as it is
  std::optional<Dots> dots;                // to be shown to the left and the right eye
  bool left_eye = true, right_eye = true;  // which eye sees its dot
  std::optional<dvec3> target_D;           // where the point ought to appear
  std::optional<Dots> astray;  // where the last touch lies, when it does not fit the others: a ring for each eye
};

/// After a touch.
struct Live {
  std::size_t index = 0;              // of the touch in its step
  double residual = 0;                // m, of this touch; 0 while the step has too few
  double rms = 0;                     // m, of the step so far
  double predicted_tre = 0;           // m, over the workspace; only while registering
  bool outlier = false;               // this touch was set aside
  std::optional<dvec3> p_W;           // where it lies
  std::vector<std::size_t> outliers;  // of the whole step so far
  Cue cue = Cue::kTaken;
  std::string text;  // one line
};

class GuidedCapture {
 public:
  /// Goes on from the captures in `folder`, if there are any. Throws Error when they cannot be read.
  /// `plate_pitch` m, between the 5×5 points of the arm's plate.
  GuidedCapture(BenchState bench, std::filesystem::path folder, double plate_pitch = 0.04);

  void begin(Step step);
  Step step() const { return step_; }
  bool done() const;  // the step has all the touches it was planned to have
  std::size_t taken() const;
  std::size_t planned() const;
  Prompt prompt() const;
  /// Takes one touch, writes it to disk, and says how it fits.
  Live add(const Touch& touch);
  /// Forgets the last touch of this step; false when there is none.
  bool undo();
  /// Solves this step from all its captures and takes the result over.
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
  std::optional<dvec3> astray_W_;  // the last touch, when it does not fit
};

/// A prompt as a picture for the panel: text and marks, 8-bit grey, row by row from the top. The text can be mirrored
/// left to right or turned over top to bottom, so that it reads right in a mirror, wherever that stands; marks lie
/// where they lie.
struct Picture {
  int width = 0, height = 0;
  std::vector<unsigned char> grey;
};
Picture prompt_picture(const Prompt& prompt, int width, int height, bool mirrored, bool upside_down = false);

/// A short tone, mono, -1..1.
std::vector<float> cue_sound(Cue cue, double sample_rate);

}  // namespace typodont::calibration
