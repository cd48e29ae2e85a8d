#include "audio/ar/noise.h"

#include <bit>
#include <cstring>

#include "audio/ar/simd.h"

namespace typodont::audio {

namespace {

// ln(x) for x in (0, 1]: exponent, and atanh series of the mantissa m in s = (m − 1)/(m + 1), |s| < 0.172.
inline __attribute__((always_inline)) Float16 log_of(Float16 x) {
  const UInt16x raw = std::bit_cast<UInt16x>(x);
  // Scales the mantissa to [√½, √2).
  UInt16x shifted = raw - 0x3f3504f3u;
  const Int16x exponent = std::bit_cast<Int16x>(shifted) >> 23;
  const UInt16x mantissa_bits = (shifted & 0x007fffffu) + 0x3f3504f3u;
  const Float16 m = std::bit_cast<Float16>(mantissa_bits);
  const Float16 s = (m - 1.0f) / (m + 1.0f);
  const Float16 z = s * s;
  const Float16 series = ((0.14285715f * z + 0.2f) * z + 0.33333334f) * z + 1.0f;
  return __builtin_convertvector(exponent, Float16) * 0.69314718f + 2.0f * s * series;
}

// sin(2π t) for t in [−½, ½): odd minimax polynomial for a quarter of the period, error 2e-7.
inline __attribute__((always_inline)) Float16 sine_of_turns(Float16 t) {
  const Float16 magnitude = t < 0.0f ? -t : t;
  const Float16 folded = magnitude > 0.25f ? 0.5f - magnitude : magnitude;
  const Float16 x = folded * 6.2831853f;
  const Float16 z = x * x;
  const Float16 p = ((((2.7557319e-6f * z - 1.9841270e-4f) * z + 8.3333333e-3f) * z - 0.16666667f) * z + 1.0f) * x;
  return t < 0.0f ? -p : p;
}

// Generates 32 values: xoshiro128++ (Blackman & Vigna 2018) in sixteen lanes, then Box–Muller (1958).
TYPODONT_CLONES void fill_32(std::uint32_t (*state)[16], float* out) {
  UInt16x s0, s1, s2, s3;
  std::memcpy(&s0, state[0], 64);
  std::memcpy(&s1, state[1], 64);
  std::memcpy(&s2, state[2], 64);
  std::memcpy(&s3, state[3], 64);
  UInt16x drawn[2];
  for (UInt16x& value : drawn) {
    const UInt16x sum = s0 + s3;
    value = ((sum << 7) | (sum >> 25)) + s0;
    const UInt16x t = s1 << 9;
    s2 ^= s0;
    s3 ^= s1;
    s1 ^= s2;
    s0 ^= s3;
    s2 ^= t;
    s3 = (s3 << 11) | (s3 >> 21);
  }
  std::memcpy(state[0], &s0, 64);
  std::memcpy(state[1], &s1, 64);
  std::memcpy(state[2], &s2, 64);
  std::memcpy(state[3], &s3, 64);

  // Uniform numbers with 24 bits: u in (0, 1), t in [−½, ½).
  const Int16x first = std::bit_cast<Int16x>(drawn[0]);
  const Float16 u = (__builtin_convertvector((first >> 8) & 0x00ffffff, Float16) + 0.5f) * 5.9604645e-8f;
  const Int16x second = std::bit_cast<Int16x>(drawn[1]);
  const Float16 t = __builtin_convertvector(second >> 8, Float16) * 5.9604645e-8f;
  const Float16 square = -2.0f * log_of(u);
  Float16 radius;
  for (int i = 0; i < 16; ++i) radius[i] = __builtin_sqrtf(square[i] > 0 ? square[i] : 0.0f);
  const Float16 quarter = t + 0.25f;
  const Float16 cosine = sine_of_turns(quarter >= 0.5f ? quarter - 1.0f : quarter);
  *reinterpret_cast<Float16Unaligned*>(out) = radius * sine_of_turns(t);
  *reinterpret_cast<Float16Unaligned*>(out + 16) = radius * cosine;
}

}  // namespace

GaussianNoise::GaussianNoise(std::uint64_t seed) noexcept {
  for (auto& word : state_) {
    for (auto& lane : word) lane = static_cast<std::uint32_t>((seed = mixed(seed)) >> 32);
  }
}

void GaussianNoise::fill(float* out, int count) noexcept {
  for (int i = 0; i < count; i += 32) fill_32(state_, out + i);
}

float GaussianNoise::next() noexcept {
  if (left_ == 0) {
    fill_32(state_, spare_);
    left_ = 32;
  }
  return spare_[32 - left_--];
}

}  // namespace typodont::audio
