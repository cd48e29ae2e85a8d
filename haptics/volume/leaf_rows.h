// Copies whole leaves into a dense block such as a tissue patch. `to`: first sample of the leaf in the block; strides
// in samples. In a leaf, z is the fastest index.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "haptics/volume/leaf_key.h"

namespace typodont::haptics {

/// Copies the distances of a leaf (8³ samples), eight at a time.
void copy_distances(const float* from, float* to, std::ptrdiff_t stride_x, std::ptrdiff_t stride_y);
/// Sets all distances of a leaf (8³ samples) to `value`, eight at a time.
void fill_distances(float value, float* to, std::ptrdiff_t stride_x, std::ptrdiff_t stride_y);

/// Copies a leaf's values of one byte (labels, hardness).
template <class Byte>
void copy_bytes(const Byte* from, Byte* to, std::ptrdiff_t stride_x, std::ptrdiff_t stride_y) {
  static_assert(sizeof(Byte) == 1);
  for (int x = 0; x < kLeafSide; ++x, to += stride_x) {
    for (int y = 0; y < kLeafSide; ++y, from += kLeafSide) std::memcpy(to + y * stride_y, from, kLeafSide);
  }
}
/// Sets all samples of a leaf to `value`.
template <class T>
void fill_leaf(T value, T* to, std::ptrdiff_t stride_x, std::ptrdiff_t stride_y) {
  for (int x = 0; x < kLeafSide; ++x, to += stride_x) {
    for (int y = 0; y < kLeafSide; ++y) std::fill_n(to + y * stride_y, kLeafSide, value);
  }
}

/// Prefetches the rows to which a leaf will be copied.
template <class T>
void prefetch_rows(const T* to, std::ptrdiff_t stride_x, std::ptrdiff_t stride_y) {
  for (int x = 0; x < kLeafSide; ++x, to += stride_x) {
    for (int y = 0; y < kLeafSide; ++y) __builtin_prefetch(to + y * stride_y, 1);
  }
}

}  // namespace typodont::haptics
