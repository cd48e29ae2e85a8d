#include "haptics/volume/leaf_rows.h"

#include "engine/base/dispatch.h"
#include "haptics/cutting/lanes.h"

namespace typodont::haptics {

TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void copy_distances(const float* from, float* to, std::ptrdiff_t stride_x, std::ptrdiff_t stride_y) {
  for (int x = 0; x < kLeafSide; ++x, to += stride_x) {
    for (int y = 0; y < kLeafSide; ++y, from += kLeafSide)
      *reinterpret_cast<F8*>(to + y * stride_y) = *reinterpret_cast<const F8*>(from);
  }
}

TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void fill_distances(float value, float* to, std::ptrdiff_t stride_x, std::ptrdiff_t stride_y) {
  for (int x = 0; x < kLeafSide; ++x, to += stride_x) {
    for (int y = 0; y < kLeafSide; ++y) *reinterpret_cast<F8*>(to + y * stride_y) = F8{} + value;
  }
}

}  // namespace typodont::haptics
