// A fast generator of random numbers.
#pragma once

#include <cstdint>

namespace typodont {

/// SplitMix64 (Steele, Lea & Flood 2014). Equal states give equal sequences of numbers.
struct SplitMix64 {
  std::uint64_t state = 0;

  std::uint64_t next() {
    std::uint64_t z = state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
  }
};

}  // namespace typodont
