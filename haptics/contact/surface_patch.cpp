#include "haptics/surface_patch.h"

#include <algorithm>
#include <cmath>

namespace typodont::haptics {

namespace {

struct Cell {
  int x, y, z;
  double u, v, w;  // 0..1 inside the cell
};

Cell cell_at(const SurfacePatch& patch, const dvec3& p_V) {
  const dvec3 q = p_V - dvec3(patch.lo);
  const dvec3 f = glm::floor(q);
  return {static_cast<int>(f.x), static_cast<int>(f.y), static_cast<int>(f.z), q.x - f.x, q.y - f.y, q.z - f.z};
}

/// Weights and derivative weights of the six samples i-2 .. i+3 at fraction t: the cubic B-spline convolved with its
/// local prefilter (-1, 8, -1)/6.
struct Weights {
  double value[6], slope[6];
  explicit Weights(double t) {
    const double t2 = t * t, t3 = t2 * t, s = 1 - t;
    const double b[4] = {s * s * s / 6, (3 * t3 - 6 * t2 + 4) / 6, (-3 * t3 + 3 * t2 + 3 * t + 1) / 6, t3 / 6};
    const double d[4] = {-s * s / 2, (3 * t2 - 4 * t) / 2, (-3 * t2 + 2 * t + 1) / 2, t2 / 2};
    fold(b, value);
    fold(d, slope);
  }
  static void fold(const double (&b)[4], double (&w)[6]) {
    w[0] = -b[0] / 6;
    w[1] = (8 * b[0] - b[1]) / 6;
    w[2] = (8 * b[1] - b[0] - b[2]) / 6;
    w[3] = (8 * b[2] - b[1] - b[3]) / 6;
    w[4] = (8 * b[3] - b[2]) / 6;
    w[5] = -b[3] / 6;
  }
};

}  // namespace

double sample_linear(const SurfacePatch& patch, const dvec3& p_V) noexcept {
  const Cell c = cell_at(patch, p_V);
  const float* f = patch.distance.data() + patch.at(c.x, c.y, c.z);
  const std::size_t sy = static_cast<std::size_t>(patch.n), sx = sy * sy;
  const auto along_z = [&](std::size_t o) { return f[o] + c.w * (f[o + 1] - f[o]); };
  const double a = along_z(0), b = along_z(sy), d = along_z(sx), e = along_z(sx + sy);
  const double lo = a + c.v * (b - a), hi = d + c.v * (e - d);
  return lo + c.u * (hi - lo);
}

FieldSample sample_linear_gradient(const SurfacePatch& patch, const dvec3& p_V) noexcept {
  const Cell c = cell_at(patch, p_V);
  const float* f = patch.distance.data() + patch.at(c.x, c.y, c.z);
  const std::size_t sy = static_cast<std::size_t>(patch.n), sx = sy * sy;
  const double z00 = f[1] - f[0], z01 = f[sy + 1] - f[sy], z10 = f[sx + 1] - f[sx], z11 = f[sx + sy + 1] - f[sx + sy];
  const double a = f[0] + c.w * z00, b = f[sy] + c.w * z01, d = f[sx] + c.w * z10, e = f[sx + sy] + c.w * z11;
  const double lo = a + c.v * (b - a), hi = d + c.v * (e - d);
  const double gz0 = z00 + c.v * (z01 - z00), gz1 = z10 + c.v * (z11 - z10);
  return {lo + c.u * (hi - lo), {hi - lo, (b - a) + c.u * ((e - d) - (b - a)), gz0 + c.u * (gz1 - gz0)}};
}

FieldSample sample_cubic(const SurfacePatch& patch, const dvec3& p_V) noexcept {
  const Cell c = cell_at(patch, p_V);
  const Weights wx(c.u), wy(c.v), wz(c.w);
  const std::size_t sy = static_cast<std::size_t>(patch.n), sx = sy * sy;
  const float* f = patch.distance.data() + patch.at(c.x - 2, c.y - 2, c.z - 2);
  FieldSample out;
  for (std::size_t i = 0; i < 6; ++i) {
    double value = 0, slope_y = 0, slope_z = 0;
    for (std::size_t j = 0; j < 6; ++j) {
      const float* row = f + i * sx + j * sy;
      double v = 0, s = 0;
      for (std::size_t k = 0; k < 6; ++k) {
        v += wz.value[k] * row[k];
        s += wz.slope[k] * row[k];
      }
      value += wy.value[j] * v;
      slope_y += wy.slope[j] * v;
      slope_z += wy.value[j] * s;
    }
    out.value += wx.value[i] * value;
    out.gradient.x += wx.slope[i] * value;
    out.gradient.y += wx.value[i] * slope_y;
    out.gradient.z += wx.value[i] * slope_z;
  }
  return out;
}

PerTissue sample_tissue(const SurfacePatch& patch, const dvec3& p_V) noexcept {
  const Cell c = cell_at(patch, p_V);
  PerTissue shares{};
  double total = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner >> 2, j = corner >> 1 & 1, k = corner & 1;
    const Tissue tissue = patch.tissue[patch.at(c.x + i, c.y + j, c.z + k)];
    if (tissue == Tissue::kAir) continue;
    const double weight = (i ? c.u : 1 - c.u) * (j ? c.v : 1 - c.v) * (k ? c.w : 1 - c.w);
    shares[static_cast<std::size_t>(tissue)] += weight;
    total += weight;
  }
  if (total > 0) {
    for (double& share : shares) share /= total;
  }
  return shares;
}

PerTissue carve(SurfacePatch& patch, const Sweep& sweep, bool* changed) noexcept {
  PerTissue removed{};
  if (changed) *changed = false;
  const glm::ivec3 a = glm::max(sweep.lo() - patch.lo, 0), b = glm::min(sweep.hi() - patch.lo, patch.n - 1);
  if (a.x > b.x || a.y > b.y || a.z > b.z) return removed;
  const std::size_t start = patch.at(a.x, a.y, a.z), edge = static_cast<std::size_t>(patch.n);
  if (sweep.raise(a + patch.lo, b - a + 1, patch.distance.data() + start, edge * edge, edge,
                  patch.tissue.data() + start, &removed)) {
    patch.exact_outside = false;
    if (changed) *changed = true;
  }
  removed[0] = 0;
  return removed;
}

void merge(SurfacePatch& patch, const SurfacePatch& old, const glm::ivec3& box_lo, const glm::ivec3& box_hi) noexcept {
  const glm::ivec3 lo = glm::max(box_lo, glm::max(patch.lo, old.lo));
  const glm::ivec3 hi = glm::min(box_hi, glm::min(patch.lo + patch.n, old.lo + old.n) - 1);
  for (int x = lo.x; x <= hi.x; ++x) {
    for (int y = lo.y; y <= hi.y; ++y) {
      if (lo.z > hi.z) return;
      float* to = patch.distance.data() + patch.at(x - patch.lo.x, y - patch.lo.y, lo.z - patch.lo.z);
      const float* from = old.distance.data() + old.at(x - old.lo.x, y - old.lo.y, lo.z - old.lo.z);
      for (int i = 0; i <= hi.z - lo.z; ++i) to[i] = std::max(to[i], from[i]);
    }
  }
  if (lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z) patch.exact_outside = patch.exact_outside && old.exact_outside;
}

}  // namespace typodont::haptics
