// White Gaussian noise, the same bits on every machine, made sixteen at a time.
#pragma once

#include <cstdint>

namespace typodont::audio {

/// 64-bit mixer (Steele, Lea & Flood 2014, splitmix64): independent seeds from one.
constexpr std::uint64_t mixed(std::uint64_t seed) {
  seed += 0x9e3779b97f4a7c15u;
  seed = (seed ^ (seed >> 30)) * 0xbf58476d1ce4e5b9u;
  seed = (seed ^ (seed >> 27)) * 0x94d049bb133111ebu;
  return seed ^ (seed >> 31);
}

/// Unit variance, zero mean. No allocation, no library function, no table.
class GaussianNoise {
 public:
  explicit GaussianNoise(std::uint64_t seed) noexcept;
  /// `count` is a multiple of 32.
  void fill(float* out, int count) noexcept;
  /// One at a time, for slow uses.
  float next() noexcept;

 private:
  std::uint32_t state_[4][16];
  float spare_[32];
  int left_ = 0;
};

}  // namespace typodont::audio
