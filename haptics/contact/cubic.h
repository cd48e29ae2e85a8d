// Tricubic interpolation of a patch (dense copy of the distance field). Private to haptics/contact.
#pragma once

#include <cstddef>

namespace typodont::haptics {

/// Returns the number of doubles per SIMD operation on this processor: 8, 4 or 2. The result has the same bits for each
/// of these numbers.
int widest_cubic() noexcept;

/// Tricubic interpolation: computes a weighted sum over 6 × 6 rows of eight samples. The first two samples of a row
/// have weight zero. `corner`: start of the first row. `fractions`: position 0..1 of the point in its cell along x, y
/// and z. The rows run along z, and the cell lies between the fifth and the sixth sample of a row. `out`: value and
/// gradient. `lanes`: 8, 4 or 2, at most widest_cubic().
void cubic(const float* corner, std::size_t stride_x, std::size_t stride_y, const double* fractions, double* out,
           int lanes) noexcept;

}  // namespace typodont::haptics
