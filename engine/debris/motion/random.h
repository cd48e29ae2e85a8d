// Random numbers for the particles.
#pragma once

#include <cstdint>

#include "engine/base/pose.h"
#include "engine/base/split_mix.h"

namespace typodont::debris {

/// Random numbers that depend only on the seed and the stream's number.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t number)
      : bits_{seed * 0x9e3779b97f4a7c15u ^ number * 0xd1342543de82ef95u} {}
  double uniform() { return static_cast<double>(bits_.next() >> 11) * 0x1p-53; }
  double signed_unit() { return 2 * uniform() - 1; }
  dvec3 in_ball() {
    for (;;) {
      const double x = signed_unit(), y = signed_unit(), z = signed_unit();
      if (x * x + y * y + z * z <= 1) return {x, y, z};
    }
  }

 private:
  SplitMix64 bits_;
};

}  // namespace typodont::debris
