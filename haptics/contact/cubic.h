// The tricubic interpolation of a patch. Private to haptics/contact.
#pragma once

#include <cstddef>

namespace typodont::haptics {

/// How many doubles side by side this processor does it by: 8, 4 or 2. All give the same bits.
int widest_cubic() noexcept;

/// The weighted sum over 6 × 6 rows of eight samples, of which the first two weigh nothing. `corner`: the first row;
/// `fractions`: of the point between the fifth and the sixth sample of its row, and so across. `out`: value, gradient.
/// `lanes`: 8, 4 or 2, and no more than the processor has.
void cubic(const float* corner, std::size_t stride_x, std::size_t stride_y, const double* fractions, double* out,
           int lanes) noexcept;

}  // namespace typodont::haptics
