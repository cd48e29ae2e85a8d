#include "haptics/cutting/listed.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "haptics/cutting/lane_ops.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

// Compiled for each vector width. Results are bit-identical: samples are independent, volumes integers, FMA is off.
namespace halves {
namespace {
#include "haptics/cutting/listed_kernel.h"
}  // namespace
}  // namespace halves

#ifdef TYPODONT_SIXTEEN_LANES
#pragma GCC push_options
#pragma GCC target("avx2")
namespace eight {
namespace {
#include "haptics/cutting/listed_kernel.h"
}  // namespace
}  // namespace eight
#pragma GCC target("arch=x86-64-v4")
namespace sixteen {
namespace {
#include "haptics/cutting/listed_kernel.h"
}  // namespace
}  // namespace sixteen
namespace eight_masked {
namespace {
#include "haptics/cutting/listed_kernel.h"
}  // namespace
}  // namespace eight_masked
#pragma GCC pop_options
#endif

int widest_group() noexcept {
#ifdef TYPODONT_SIXTEEN_LANES
  if (__builtin_cpu_supports("x86-64-v4")) return sixteen::kLanes;
#endif
  return halves::kLanes;
}

bool carve_listed_ball(const BallFront& front, bool capsule, int lanes, RemovedVolume* removed) noexcept {
#ifdef TYPODONT_SIXTEEN_LANES
  if (lanes == sixteen::kLanes) {
    const bool wide = sixteen::carve_ball(front, capsule, false, removed);
    return eight_masked::carve_ball(front, capsule, true, removed) || wide;
  }
  if (__builtin_cpu_supports("avx2")) return eight::carve_ball(front, capsule, false, removed);
#endif
  (void)lanes;
  return halves::carve_ball(front, capsule, false, removed);
}

bool carve_listed_head(const HeadFront& front, int lanes, RemovedVolume* removed) noexcept {
#ifdef TYPODONT_SIXTEEN_LANES
  if (lanes == sixteen::kLanes) {
    // One kernel cuts the narrow groups of samples (Run::narrow), another one all other groups. Skips unneeded kernels.
    bool is_listed[2] = {};
    for (int r = 0; r < front.run_count; ++r) is_listed[front.runs[r].narrow] = true;
    const bool wide = is_listed[false] && sixteen::carve_head(front, false, removed);
    const bool narrow = is_listed[true] && eight_masked::carve_head(front, true, removed);
    return wide || narrow;
  }
  if (__builtin_cpu_supports("avx2")) return eight::carve_head(front, false, removed);
#endif
  (void)lanes;
  return halves::carve_head(front, false, removed);
}

}  // namespace typodont::haptics
