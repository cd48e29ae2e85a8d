// Fits an autoregressive model to a recording, not in real time.
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
  // Order of the model: a number, or the criterion "aic" or "bic" that chooses it.
  std::string order = "300";
  int max_order = 600;  // highest order that the criterion (aic or bic) may choose
  /// Window none, hann, hamming or blackman: weights the errors (Burg) or the samples (Yule–Walker).
  std::string window = "none";
  double rate = 0;   // Hz, sampling rate of the model; 0: the recording's rate
  int channel = -1;  // -1: mean of all channels
  /// Begin and end of the fitted part, s; to = 0: the end of the recording.
  double from = 0, to = 0;
  bool trim = true;     // true: silence at both ends of the recording is removed
  bool steady = false;  // true: only the longest interval of constant level is used
  // Fits only the longest part named "run-up", "idle", "load" or "run-down"; empty: all parts.
  std::string part;
  std::string hum = "auto";  // removal of mains hum: auto, off, 50 or 60 (Hz)
  double spindle = 0;        // rad/s, spindle speed in the recording; 0: estimated
  bool lines = true;  // true: spectral lines are modelled separately; false: the whole sound is modelled as noise
  // This fraction (0 to 0.9) at the end of the recording is not fitted, but compared with the model.
  double hold_out = 0;
  std::string name, source, licence;
};

/// How well the model agrees with the part of the recording that was not fitted.
struct HeldOut {
  double from = 0, to = 0;  // s, begin and end of the part in the recording
  double distance_dB = 0;   // dB, distance of this part's spectrum from the model's expected spectrum
  // Expected distance for a sound of the same length that has exactly the model's spectrum, dB. Not 0, because the
  // measured spectrum of a short sound has a random error.
  double chance_dB = 0;
  // For each spectral line: standard deviation of its amplitude divided by the mean, in the held-out part.
  std::vector<double> line_variation;
};

struct FitReport {
  ArModel model;
  double duration = 0, from = 0, to = 0;  // s, duration of the recording; begin and end of the fitted part
  double level_dB = 0;                    // dB re full scale, level of the fitted part
  double hum = 0;                         // Hz, removed mains frequency; 0: none
  // Distance between the Welch spectra of the fitted part and of the model, dB.
  double distance_dB = 0;
  // Distance of the fitted part's Welch spectrum from the model's exact spectrum (without the window's effect), dB.
  double unsmoothed_distance_dB = 0;
  double itakura_saito = 0;
  double up_to = 0;  // Hz, highest compared frequency: 16 kHz or 0.45 of the sampling rate
  double max_reflection = 0;
  double condition = 0;  // condition number of the model's filter in direct form, see ar/filter.h
  std::string form;      // filter form that the synthesizer will use: float, double, lattice
  std::vector<double> variance_by_order;
  /// Spectra of recording and model: frequencies (Hz) and densities (dB re 1/Hz).
  std::vector<double> frequencies, recording_dB, model_dB;
  std::vector<SoundPart> parts;  // parts of the whole recording, in order
  // For each spectral line: standard deviation of its amplitude divided by the mean, in the fitted part. Noise at
  // nearby frequencies contributes to it.
  std::vector<double> line_variation;
  // Spindle speed over time: s from the begin of the fitted part; speed / mean speed. Empty: no steady spectral line.
  std::vector<double> speed_times, speed_ratio;
  std::optional<HeldOut> held_out;
  std::vector<std::string> notes;  // sentences for the user
};

/// Fits a model to a recording. Throws Error for silence, clipping, a pure tone, a recording too short for the order, a
/// sample that is not finite, and an unknown method.
FitReport fit_recording(const std::filesystem::path& file, const FitOptions& options);

}  // namespace typodont::audio
