// Tricubic, in a patch. Private to haptics/contact.
#pragma once

#include <cstddef>

namespace typodont::haptics {

/// 8, 4 or 2 doubles; same bits for each.
int widest_cubic() noexcept;

/// Over 6 × 6 rows of eight along z, the first two with weight zero; the cell is between the fifth and sixth. `corner`:
/// first row; `fractions`: 0..1 in the cell; `out`: value and gradient; `lanes`: up to widest_cubic().
void cubic(const float* corner, std::size_t stride_x, std::size_t stride_y, const double* fractions, double* out,
           int lanes) noexcept;

}  // namespace typodont::haptics
