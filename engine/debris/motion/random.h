// Random numbers for the particles.
#pragma once

#include <cstdint>

#include "engine/base/pose.h"

namespace typodont::debris {

/// Random numbers that depend only on the seed and on an index, for example the number of the cut (SplitMix64, Steele
/// et al. 2014).
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t number)
      : state_(seed * 0x9e3779b97f4a7c15u ^ number * 0xd1342543de82ef95u) {}
  double uniform() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return static_cast<double>((z ^ z >> 31) >> 11) * 0x1p-53;
  }
  double signed_unit() { return 2 * uniform() - 1; }
  dvec3 in_ball() {
    for (;;) {
      const double x = signed_unit(), y = signed_unit(), z = signed_unit();
      if (x * x + y * y + z * z <= 1) return {x, y, z};
    }
  }

 private:
  std::uint64_t state_;
};

}  // namespace typodont::debris
