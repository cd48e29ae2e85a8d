// Included by cubic.cpp once for each vector type `Lanes`.

/// Evaluates the polynomials with the coefficients `c` at t (t2 = t²), for the kLanes samples from index `at`.
template <std::size_t powers>
TYPODONT_INLINE Lanes at_fraction(const double (&c)[powers][8], int at, double t, double t2) {
  Lanes p = *reinterpret_cast<const Lanes*>(c[1] + at) * t;
  if constexpr (powers == 4) {
    p += (*reinterpret_cast<const Lanes*>(c[2] + at) + *reinterpret_cast<const Lanes*>(c[3] + at) * t) * t2;
  } else {
    p += *reinterpret_cast<const Lanes*>(c[2] + at) * t2;
  }
  return *reinterpret_cast<const Lanes*>(c[0] + at) + p;
}

/// Computes the weights (or their derivatives) of the 8 samples of a row for a point at the fraction t of its cell.
template <std::size_t powers>
TYPODONT_INLINE void weigh(const double (&c)[powers][8], double t, double* weights) {
  const double t2 = t * t;
  for (int at = 0; at < 8; at += kLanes) *reinterpret_cast<Lanes*>(weights + at) = at_fraction(c, at, t, t2);
}
/// Like weigh(), but the results are multiples of 2^-29: the weights add up to exactly 1, the derivatives to exactly 0.
template <std::size_t powers>
TYPODONT_INLINE void weigh_on_grid(const double (&sums)[powers][8], double t, double* weights) {
  const double t2 = t * t;
  // A weight is the sum of the weights from its sample on (`from`) minus that of all later samples (`after`). Both sums
  // contain kGrid, which rounds them; their difference does not contain it.
  Lanes after = Lanes{} + kGrid;
  for (int at = 8 - kLanes; at >= 0; at -= kLanes) {
    const Lanes from = at_fraction(sums, at, t, t2);
    *reinterpret_cast<Lanes*>(weights + at) = from - one_on(from, after);
    after = from;
  }
}

void cubic(const float* f, std::size_t stride_x, std::size_t stride_y, const double* fractions, double* out) {
  alignas(64) double x[8], x_slope[8], y[8], y_slope[8], z[8], z_slope[8];
  weigh_on_grid(kSums.value, fractions[1], y);
  weigh_on_grid(kSums.slope, fractions[1], y_slope);
  weigh(kWeights.value, fractions[0], x);
  weigh(kWeights.slope, fractions[0], x_slope);
  weigh(kWeights.value, fractions[2], z);
  weigh(kWeights.slope, fractions[2], z_slope);
  // Forces the weights into memory, so that one broadcast load copies a weight to all lanes of a vector.
  asm("" : "+m"(x), "+m"(x_slope), "+m"(y), "+m"(y_slope));
  // Sample k is added to the partial sum k mod 4, so that all vector widths add in the same order.
  alignas(64) double sums[4][4] = {};
  for (int at = 0; at < 8; at += kLanes) {
    Lanes value = {}, by_x = {}, by_y = {};
#pragma GCC unroll 6
    for (int i = 0; i < 6; ++i) {
      const float* const rows = f + static_cast<std::size_t>(i) * stride_x + at;
      Lanes sum = {}, slope = {};
#pragma GCC unroll 6
      for (int j = 0; j < 6; ++j) {
        const Lanes row = widened(rows + static_cast<std::size_t>(j) * stride_y);
        sum = exact_product_added(row, y[kLead + j], sum);
        slope = exact_product_added(row, y_slope[kLead + j], slope);
      }
      value += sum * x[kLead + i];
      by_x += sum * x_slope[kLead + i];
      by_y += slope * x[kLead + i];
    }
    const Lanes along = *reinterpret_cast<const Lanes*>(z + at),
                along_slope = *reinterpret_cast<const Lanes*>(z_slope + at);
    add_by_fours(value * along, at, sums[0]);
    add_by_fours(by_x * along, at, sums[1]);
    add_by_fours(by_y * along, at, sums[2]);
    add_by_fours(value * along_slope, at, sums[3]);
  }
  add_across(sums, out);
}
