// Tricubic interpolation in a tissue patch. Private to haptics/contact.
#pragma once

#include <cstddef>

namespace typodont::haptics {

/// Returns how many doubles this processor computes at once (8, 4 or 2). All widths give a bit-identical result.
int widest_cubic() noexcept;

/// Interpolates 6 × 6 rows of 8 samples along z, at a point between the fifth and the sixth sample of a row; the first
/// two samples have the weight zero. `corner`: first sample of all. `fractions`: position in the cell along x, y, z,
/// 0..1. `out`: value and gradient. `lanes`: doubles per vector, at most widest_cubic().
void cubic(const float* corner, std::size_t stride_x, std::size_t stride_y, const double* fractions, double* out,
           int lanes) noexcept;

}  // namespace typodont::haptics
