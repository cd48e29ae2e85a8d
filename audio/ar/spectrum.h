// Power spectra and distances between them, computed with FFTW. Not for real time.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace typodont::audio {

enum class Window { kNone, kHann, kHamming, kBlackman };
std::vector<double> window_samples(Window window, std::size_t n);

/// Estimates the one-sided power density (1/Hz) at i·rate/n, i = 0…n/2, by Welch's method: the mean over Hann windows
/// of n samples that overlap by half. A sound shorter than one window is padded with zeros.
std::vector<double> welch(std::span<const double> x, std::size_t n, double rate);

/// Returns the expected value of welch() for a sound with the power spectrum `power`: `power` convolved with the
/// window's spectrum. `power` is the double-sided density times the rate, at 2^m + 1 frequencies (see sampled_power()).
std::vector<double> expected_welch(const std::vector<double>& power, std::size_t n, double rate);

/// Returns the biased autocorrelation r_0…r_lags of the samples: r_l = Σ x[i] x[i+l] / count.
std::vector<double> autocorrelation(std::span<const double> x, std::size_t lags);
/// Returns the autocorrelation r_0 … r_(2^m) of a power spectrum that is sampled at 2^m + 1 frequencies from 0 to half
/// the rate.
std::vector<double> autocorrelation_of_power(const std::vector<double>& power);

/// Returns the power response |1 + Σ taps_i z^-i|² of a filter at `points` = 2^m + 1 frequencies from 0 to half the
/// rate.
std::vector<double> power_of_taps(std::span<const double> taps, std::size_t points);

/// Returns the log-spectral distance in dB: the root mean square of 10·log10(a/b).
double log_spectral_distance(std::span<const double> a, std::span<const double> b);
/// Returns the expected log-spectral distance (dB) between an estimated and the true spectrum of Gaussian noise. The
/// estimate is the result of welch() for `count` samples with windows of n samples (Welch 1967: variance of overlapping
/// Hann windows).
double chance_distance(std::size_t count, std::size_t n);
/// Returns the Itakura–Saito distance (1968): the mean of a/b − ln(a/b) − 1. It is not symmetric, and 0 for equal
/// spectra.
double itakura_saito(std::span<const double> a, std::span<const double> b);

}  // namespace typodont::audio
