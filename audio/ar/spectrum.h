// Power spectra and distances between them (FFTW). Offline.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace typodont::audio {

enum class Window { kNone, kHann, kHamming, kBlackman };
std::vector<double> window_samples(Window window, std::size_t n);

double mean_power(std::span<const double> x);
double in_dB(double power);
/// Level of each whole frame of `frame` samples, dB.
std::vector<double> frame_levels(std::span<const double> x, std::size_t frame);

/// Welch's method: one-sided power density (1/Hz) at the frequencies i·rate/n, i = 0…n/2. Mean over Hann windows of n
/// samples that overlap by half. A shorter sound is padded with zeros.
std::vector<double> welch(std::span<const double> x, std::size_t n, double rate);

/// Expected result of welch() for a sound with the spectrum `power` (double-sided density × rate, at 2^m + 1
/// frequencies as in sampled_power()).
std::vector<double> expected_welch(const std::vector<double>& power, std::size_t n, double rate);

/// Biased autocorrelation: r_l = Σ x[i] x[i+l] / count, l = 0…lags.
std::vector<double> autocorrelation(std::span<const double> x, std::size_t lags);
/// Autocorrelation r_0 … r_(2^m) of a spectrum given at 2^m + 1 frequencies from 0 to half the rate.
std::vector<double> autocorrelation_of_power(const std::vector<double>& power);

/// |1 + Σ taps_i z^-i|² at `points` = 2^m + 1 frequencies from 0 to half the rate.
std::vector<double> power_of_taps(std::span<const double> taps, std::size_t points);

/// Log-spectral distance of two power spectra: root mean square of 10·log10(a/b), dB.
double log_spectral_distance(std::span<const double> a, std::span<const double> b);
/// Expected log-spectral distance (dB) between a result of welch() and the exact spectrum, for Gaussian noise (Welch
/// 1967).
double chance_distance(std::size_t count, std::size_t n);
/// Itakura–Saito distance (1968) of two power spectra: mean of a/b − ln(a/b) − 1.
double itakura_saito(std::span<const double> a, std::span<const double> b);

}  // namespace typodont::audio
