// Fits an autoregressive model to a recording: trims and checks the sound, then estimates. Not for real time.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "audio/ar_model.h"

namespace typodont::audio {

/// The drill's state in a part of a recording.
enum class DrillPart { kRunUp, kIdle, kLoad, kRunDown };
/// Returns the name: "run-up", "idle", "load" or "run-down".
std::string_view name_of(DrillPart part) noexcept;
struct SoundPart {
  DrillPart part = DrillPart::kIdle;
  double from = 0, to = 0;  // s, begin and end of the part in the recording
  double level_dB = 0;      // dB re full scale, mean level of the part
};

struct FitOptions {
  std::string method = "burg";  // method of the fit: burg, yule-walker or modified-covariance
  // order of the model: a number, or "aic" or "bic", the criterion by which the fit chooses the order
  std::string order = "300";
  int max_order = 600;  // highest order that the criterion (aic or bic) may choose
  /// name of the window: none, hann, hamming or blackman; the window weights the errors (Burg) or the samples
  /// (Yule–Walker)
  std::string window = "none";
  double rate = 0;   // Hz, sampling rate of the model; 0: the recording's rate
  int channel = -1;  // index of the channel that is used; -1: the mean of all channels
  /// s, begin and end of the part of the recording that is fitted; to = 0: the end of the recording
  double from = 0, to = 0;
  bool trim = true;     // true: silence at both ends is removed
  bool steady = false;  // true: only the longest interval of constant level is used
  // name of the part that is fitted: "run-up", "idle", "load" or "run-down" (the longest part with this name); empty:
  // the whole recording
  std::string part;
  std::string hum = "auto";  // removal of mains hum: auto, off, 50 or 60 (Hz)
  double spindle = 0;        // rad/s, speed of the drill in the recording; 0: estimated from spectral lines
  bool lines = true;         // true: steady spectral lines are modelled as sinusoids; false: the whole sound as noise
  // Fraction (0 to 0.9) at the end of the fitted part that is held out: it is not used for the fit, but compared with
  // the model afterwards.
  double hold_out = 0;
  std::string name, source, licence;
};

/// Agreement of a model with the held-out part of the recording.
struct HeldOut {
  double from = 0, to = 0;  // s, begin and end of the held-out part in the recording
  double distance_dB = 0;   // dB, log-spectral distance between the held-out part and the model's expected spectrum
  // dB, expected distance if the held-out part had exactly the model's spectrum. It is not 0, because a spectrum that
  // is estimated from a short sound has an error.
  double chance_dB = 0;
  // for each spectral line: standard deviation of its amplitude divided by the mean amplitude, in the held-out part
  std::vector<double> line_variation;
};

struct FitReport {
  ArModel model;
  double duration = 0, from = 0, to = 0;  // s: duration of the recording, begin and end of the fitted part
  double level_dB = 0;                    // dB re full scale, level of the fitted part
  double hum = 0;                         // Hz, mains frequency that was removed with its harmonics; 0: none
  // dB, log-spectral distance between two spectra: the Welch spectrum of the fitted part, and the Welch spectrum that
  // is expected for the model
  double distance_dB = 0;
  // dB, log-spectral distance between the fitted part's Welch spectrum and the model's own spectrum, in which the peaks
  // are not broadened by the analysis window
  double unsmoothed_distance_dB = 0;
  double itakura_saito = 0;
  double up_to = 0;  // Hz, highest frequency that the distances include: 16 kHz, or 0.45 of the rate if this is less
  double largest_reflection = 0;
  double condition = 0;  // condition number of the direct form, see ar/filter.h
  std::string form;      // filter form that the synthesizer will use: float, double, lattice
  std::vector<double> variance_by_order;
  /// `frequencies`: Hz; `recording_dB`, `model_dB`: power spectra of the recording and of the model at these
  /// frequencies, dB re 1/Hz
  std::vector<double> frequencies, recording_dB, model_dB;
  std::vector<SoundPart> parts;  // parts of the whole recording, in order
  // For each spectral line of the model: standard deviation of its amplitude divided by the mean amplitude, in the
  // fitted part. It includes the effect of the noise in the band in which the line was followed.
  std::vector<double> line_variation;
  // Speed of the spindle over the fitted part, if a spectral line could be followed: times in s from the part's
  // beginning, and ratios of the speed to its mean. Empty if no line is steady.
  std::vector<double> speed_times, speed_ratio;
  std::optional<HeldOut> held_out;
  std::vector<std::string> notes;  // notes about the processing of the recording, as sentences for the user
};

/// Fits a model to a recording. Throws Error with the reason if nothing can be fitted: silence, clipping, a pure tone,
/// a recording too short for the order, a sample that is not finite, an unknown method.
FitReport fit_recording(const std::filesystem::path& file, const FitOptions& options);

}  // namespace typodont::audio
