#include "haptics/cutting/listed.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "haptics/cutting/lane_ops.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

#ifdef TYPODONT_SIXTEEN_LANES
// Compiled for each vector width of x86-64. Results are bit-identical: samples are independent, volumes integers, FMA
// is off. Other processors cut without lists.
namespace eight {
namespace {

#include "haptics/cutting/cut_kernel.h"
#include "haptics/cutting/depth_kernel.h"
#include "haptics/cutting/path_kernel.h"
// Included last, because it uses the three files above.
#include "haptics/cutting/listed_kernel.h"

__attribute__((target("avx2"))) bool ball(const BallFront* f, RemovedVolume* removed) {
  return carve_ball<false>(*f, false, removed);
}
__attribute__((target("avx2"))) bool capsule(const BallFront* f, RemovedVolume* removed) {
  return carve_ball<true>(*f, false, removed);
}
__attribute__((target("avx2"))) bool head(const HeadFront* f, RemovedVolume* removed) {
  return carve_head(*f, false, removed);
}

}  // namespace
}  // namespace eight

#pragma GCC push_options
#pragma GCC target("arch=x86-64-v4")
namespace sixteen {
namespace {

#include "haptics/cutting/cut_kernel.h"
#include "haptics/cutting/depth_kernel.h"
#include "haptics/cutting/path_kernel.h"
// Included last, because it uses the three files above.
#include "haptics/cutting/listed_kernel.h"

bool ball(const BallFront* f, RemovedVolume* removed) {
  return carve_ball<false>(*f, false, removed);
}
bool capsule(const BallFront* f, RemovedVolume* removed) {
  return carve_ball<true>(*f, false, removed);
}
bool head(const HeadFront* f, RemovedVolume* removed) {
  return carve_head(*f, false, removed);
}

}  // namespace
}  // namespace sixteen

namespace eight_masked {
namespace {

#include "haptics/cutting/cut_kernel.h"
#include "haptics/cutting/depth_kernel.h"
#include "haptics/cutting/path_kernel.h"
// Included last, because it uses the three files above.
#include "haptics/cutting/listed_kernel.h"

bool ball(const BallFront* f, RemovedVolume* removed) {
  return carve_ball<false>(*f, true, removed);
}
bool capsule(const BallFront* f, RemovedVolume* removed) {
  return carve_ball<true>(*f, true, removed);
}
bool head(const HeadFront* f, RemovedVolume* removed) {
  return carve_head(*f, true, removed);
}

}  // namespace
}  // namespace eight_masked
#pragma GCC pop_options
#endif

int widest_group() noexcept {
#ifdef TYPODONT_SIXTEEN_LANES
  if (__builtin_cpu_supports("x86-64-v4")) return sixteen::kLanes;
  if (__builtin_cpu_supports("avx2")) return eight::kLanes;
#endif
  return 0;
}

bool carve_listed_ball(const BallFront& front, bool capsule, int lanes, RemovedVolume* removed) noexcept {
#ifdef TYPODONT_SIXTEEN_LANES
  if (lanes == sixteen::kLanes) {
    const bool wide = capsule ? sixteen::capsule(&front, removed) : sixteen::ball(&front, removed);
    const bool narrow = capsule ? eight_masked::capsule(&front, removed) : eight_masked::ball(&front, removed);
    return wide || narrow;
  }
  return capsule ? eight::capsule(&front, removed) : eight::ball(&front, removed);
#else
  (void)front, (void)capsule, (void)lanes, (void)removed;
  return false;
#endif
}

bool carve_listed_head(const HeadFront& front, int lanes, RemovedVolume* removed) noexcept {
#ifdef TYPODONT_SIXTEEN_LANES
  if (lanes == sixteen::kLanes) {
    // One kernel cuts the narrow groups of samples (Run::narrow), another one all other groups. Skips unneeded kernels.
    bool is_listed[2] = {};
    for (int r = 0; r < front.run_count; ++r) is_listed[front.runs[r].narrow] = true;
    const bool wide = is_listed[false] && sixteen::head(&front, removed);
    const bool narrow = is_listed[true] && eight_masked::head(&front, removed);
    return wide || narrow;
  }
  return eight::head(&front, removed);
#else
  (void)front, (void)lanes, (void)removed;
  return false;
#endif
}

}  // namespace typodont::haptics
