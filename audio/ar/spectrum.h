// Spectra and what differs between them. Set-up time; FFTW behind.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace typodont::audio {

enum class Window { kNone, kHann, kHamming, kBlackman };
std::vector<double> window_samples(Window window, std::size_t n);

/// One-sided power density (1/Hz) at i·rate/n, i = 0…n/2: Welch's mean over half-overlapping Hann windows of n samples.
/// A sound shorter than one window is taken whole, padded with zeros.
std::vector<double> welch(std::span<const double> x, std::size_t n, double rate);

/// What welch() gives on average for a sound of power spectrum `power`, sampled on 2^m + 1 frequencies as the
/// double-sided density times the rate (see sampled_power): the spectrum seen through the window.
std::vector<double> expected_welch(const std::vector<double>& power, std::size_t n, double rate);

/// r_0…r_lags of the samples, biased: Σ x[i] x[i+l] / count.
std::vector<double> autocorrelation(std::span<const double> x, std::size_t lags);
/// From a power spectrum sampled at 0 … half the rate (2^m + 1 points): r_0 … r_(2^m).
std::vector<double> autocorrelation_of_power(const std::vector<double>& power);

/// |1 + Σ taps_i z^-i|² at `points` = 2^m + 1 frequencies from 0 to half the rate.
std::vector<double> power_of_taps(std::span<const double> taps, std::size_t points);

/// Power spectra as dB apart: root mean square of 10·log10(a/b).
double log_spectral_distance(std::span<const double> a, std::span<const double> b);
/// Itakura & Saito 1968: mean of a/b − ln(a/b) − 1; not symmetric, 0 when equal.
double itakura_saito(std::span<const double> a, std::span<const double> b);

}  // namespace typodont::audio
