// White Gaussian noise, sixteen samples at a time, bit-identical on every processor.
#pragma once

#include <cstdint>

namespace typodont::audio {

/// splitmix64 (Steele, Lea & Flood 2014): derives independent seeds from one seed.
constexpr std::uint64_t mixed(std::uint64_t seed) {
  seed += 0x9e3779b97f4a7c15u;
  seed = (seed ^ (seed >> 30)) * 0xbf58476d1ce4e5b9u;
  seed = (seed ^ (seed >> 27)) * 0x94d049bb133111ebu;
  return seed ^ (seed >> 31);
}

/// Noise of zero mean and unit variance. Uses no allocation, library function or table.
class GaussianNoise {
 public:
  explicit GaussianNoise(std::uint64_t seed) noexcept;
  /// Writes `count` samples; `count` is a multiple of 32.
  void fill(float* out, int count) noexcept;
  /// Returns one sample, for uses that are not time-critical.
  float next() noexcept;

 private:
  std::uint32_t state_[4][16];
  float spare_[32];
  int left_ = 0;
};

}  // namespace typodont::audio
