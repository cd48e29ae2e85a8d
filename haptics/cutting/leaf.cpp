// Cuts by a ball in a leaf (8³ samples) of the carver's volume.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "engine/base/dispatch.h"
#include "haptics/cutting/lane_ops.h"
#include "haptics/cutting/listed.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

// Compiled for each vector width. Results are bit-identical.
namespace eight {
namespace {
#include "haptics/cutting/leaf_kernel.h"

TYPODONT_DISPATCH("avx2", "default")
Sweep::LeafCut carve(bool capsule, const Capsule& c, const glm::ivec3& lo, float* distance) {
  return capsule ? carve_leaf<true>(c, lo, distance) : carve_leaf<false>(c, lo, distance);
}

}  // namespace
}  // namespace eight

#ifdef TYPODONT_SIXTEEN_LANES
#pragma GCC push_options
#pragma GCC target("arch=x86-64-v4")
namespace sixteen {
namespace {
#include "haptics/cutting/leaf_kernel.h"

Sweep::LeafCut carve(bool capsule, const Capsule& c, const glm::ivec3& lo, float* distance) {
  return capsule ? carve_leaf<true>(c, lo, distance) : carve_leaf<false>(c, lo, distance);
}

}  // namespace
}  // namespace sixteen
#pragma GCC pop_options
#endif

namespace {

Sweep::LeafCut carve_on_this_processor(bool capsule, const Capsule& c, const glm::ivec3& lo, float* distance) {
#ifdef TYPODONT_SIXTEEN_LANES
  if (__builtin_cpu_supports("x86-64-v4")) return sixteen::carve(capsule, c, lo, distance);
#endif
  return eight::carve(capsule, c, lo, distance);
}

}  // namespace

Sweep::LeafCut Sweep::carve_leaf_ball(const glm::ivec3& lo, float* distance) const noexcept {
  const Capsule capsule{a_.x, a_.y, a_.z, ab_.x, ab_.y, ab_.z, inverse_length2_, radius_, continues_};
  const glm::ivec3 from = lo - base_;
  // voxels, distance from a leaf's centre to its corner: |(3.5, 3.5, 3.5)|, rounded up
  constexpr float kHalf = 6.1f;
  // voxels: largest distance from the ball's centre at which samples change; rounding error of a depth
  const float outer = radius_ + kMargin, slip = 1e-3f + 2e-6f * outer;
  const float away = glm::length(glm::vec3(from) + 3.5f - a_ - ab_) - (kHalf + outer + slip);
  // A leaf that is farther from the motion's end B than the sweep reaches does not change.
  if (away > glm::length(ab_)) return {false, false, away};
  LeafCut cut = carve_on_this_processor(!is_ball(), capsule, from, distance);
  cut.safe_travel -= slip;
  return cut;
}

}  // namespace typodont::haptics
