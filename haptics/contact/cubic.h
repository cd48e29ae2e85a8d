// Tricubic interpolation in a tissue patch. Private to haptics/contact.
#pragma once

#include <cstddef>

namespace typodont::haptics {

/// Returns how many doubles this processor computes at once (8, 4 or 2). All these widths give the same bits.
int widest_cubic() noexcept;

/// Interpolates 6 × 6 rows of 8 samples along z, between the fifth and sixth sample; the first two have weight zero.
/// `corner`: first sample. `fractions`: position in the cell, 0..1. `out`: value and gradient. `lanes`: at most
/// widest_cubic().
void cubic(const float* corner, std::size_t stride_x, std::size_t stride_y, const double* fractions, double* out,
           int lanes) noexcept;

}  // namespace typodont::haptics
