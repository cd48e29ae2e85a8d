// Sounds and models for the tests of audio/.
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "audio/ar/filter.h"
#include "audio/ar/noise.h"
#include "audio/ar_model.h"
#include "audio/sound_file.h"
#include "engine/base/units.h"
#include "tests/support/folder.h"

namespace typodont::test {

inline audio::ArModel model_of(std::vector<double> reflection, double gain = 0.05, double rate = 48000) {
  audio::ArModel model;
  model.reflection = std::move(reflection);
  model.gain = gain;
  model.rate = rate;
  model.name = "test";
  return model;
}

/// Returns a model with one pair of poles at radius r and angle θ (a1 = −2 r cos θ, a2 = r²).
inline audio::ArModel resonance(double r, double theta, double gain = 0.05) {
  const double a1 = -2 * r * std::cos(theta), a2 = r * r;
  return model_of({a1 / (1 + a2), a2}, gain);
}

inline audio::ArModel random_model(std::mt19937& random, std::size_t order, double largest = 0.9) {
  std::uniform_real_distribution<double> k(-largest, largest);
  std::vector<double> reflection(order);
  for (std::size_t i = 0; i < order; ++i) reflection[i] = k(random) / (1 + 0.2 * static_cast<double>(i));
  return model_of(reflection);
}

inline std::vector<double> white(std::size_t count, std::uint64_t seed) {
  std::vector<float> noise((count + 31) / 32 * 32);
  audio::GaussianNoise(seed).fill(noise.data(), static_cast<int>(noise.size()));
  return {noise.begin(), noise.begin() + static_cast<std::ptrdiff_t>(count)};
}

/// Returns the model's output after its start-up transient.
inline std::vector<double> sound_of(const audio::ArModel& model, std::size_t count, std::uint64_t seed) {
  const std::size_t before = 20000;
  const auto noise = white(count + before, seed);
  std::vector<double> out(noise.size());
  audio::DirectFilter<double>(model).process(noise.data(), out.data(), static_cast<int>(out.size()));
  return {out.begin() + before, out.end()};
}

inline double power_of_samples(const auto& x) {
  double sum = 0;
  for (const auto v : x) sum += static_cast<double>(v) * static_cast<double>(v);
  return sum / static_cast<double>(x.size());
}

inline void write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file) << text;
}

template <class T>
void write_wav(const std::filesystem::path& file, const std::vector<T>& x, double rate,
               audio::SampleFormat format = audio::SampleFormat::kFloat32) {
  audio::WavWriter wav(file, rate, format);
  const std::vector<float> samples(x.begin(), x.end());
  wav.write(samples);
  wav.finish();
}

}  // namespace typodont::test
