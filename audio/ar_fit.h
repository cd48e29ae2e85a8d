// Fits an autoregressive model to a recording. Not for real time.
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
  // a number, "aic" or "bic"
  std::string order = "300";
  int max_order = 600;  // highest order that the criterion (aic or bic) may choose
  /// none, hann, hamming or blackman: weights errors (Burg) or samples (Yule–Walker)
  std::string window = "none";
  double rate = 0;   // Hz, sampling rate of the model; 0: the recording's rate
  int channel = -1;  // -1: mean of all channels
  /// s, fitted part; to = 0: the end
  double from = 0, to = 0;
  bool trim = true;     // true: silence at both ends is removed
  bool steady = false;  // true: only the longest interval of constant level is used
  // longest "run-up", "idle", "load" or "run-down"; empty: all
  std::string part;
  std::string hum = "auto";  // removal of mains hum: auto, off, 50 or 60 (Hz)
  double spindle = 0;        // rad/s in the recording; 0: estimated
  bool lines = true;         // false: the whole sound as noise
  // fraction (0 to 0.9) at the end, compared with the model instead of fitted
  double hold_out = 0;
  std::string name, source, licence;
};

/// Agreement with the held-out part.
struct HeldOut {
  double from = 0, to = 0;  // s in the recording
  double distance_dB = 0;   // dB, to the model's expected spectrum
  // dB, expected for exactly the model's spectrum: a short sound's estimate has an error
  double chance_dB = 0;
  // σ / mean amplitude of each line in the held-out part
  std::vector<double> line_variation;
};

struct FitReport {
  ArModel model;
  double duration = 0, from = 0, to = 0;  // s: recording; fitted part
  double level_dB = 0;                    // dB re full scale, level of the fitted part
  double hum = 0;                         // Hz, removed mains frequency; 0: none
  // dB, between the Welch spectra of the fitted part and of the model
  double distance_dB = 0;
  // dB, to the model's own spectrum, with unbroadened peaks
  double unsmoothed_distance_dB = 0;
  double itakura_saito = 0;
  double up_to = 0;  // Hz, 16 kHz or 0.45 of the rate
  double largest_reflection = 0;
  double condition = 0;  // condition number of the direct form, see ar/filter.h
  std::string form;      // filter form that the synthesizer will use: float, double, lattice
  std::vector<double> variance_by_order;
  /// Hz; dB re 1/Hz
  std::vector<double> frequencies, recording_dB, model_dB;
  std::vector<SoundPart> parts;  // parts of the whole recording, in order
  // σ / mean amplitude of each line in the fitted part, with the noise of its band
  std::vector<double> line_variation;
  // s from the part's beginning; speed / mean. Empty: no steady line.
  std::vector<double> speed_times, speed_ratio;
  std::optional<HeldOut> held_out;
  std::vector<std::string> notes;  // sentences for the user
};

/// Throws Error for silence, clipping, a pure tone, a recording too short for the order, a sample that is not finite,
/// an unknown method.
FitReport fit_recording(const std::filesystem::path& file, const FitOptions& options);

}  // namespace typodont::audio
