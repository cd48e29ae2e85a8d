// Interpolation of distances and labels in a tissue patch (tissue_patch.h).
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "engine/base/dispatch.h"
#include "haptics/contact/cubic.h"
#include "haptics/contact/tissue_patch.h"
#include "haptics/sweep.h"
#include "haptics/work.h"

namespace typodont::haptics {

namespace {

// initial-exec: with the default TLS model, each access from a shared library (libtypodont.so) calls a function.
[[gnu::tls_model("initial-exec")]] constinit thread_local std::uint64_t t_queries = 0;
const int kCubicLanes = widest_cubic();

struct Cell {
  int x, y, z;
  double u, v, w;  // position in the cell between eight samples, 0..1
};

Cell cell_at(const TissuePatch& patch, const dvec3& p_V) {
  // voxels, position relative to the first sample of the tissue patch
  const dvec3 q = p_V - dvec3(patch.lo);
  const int x = static_cast<int>(q.x), y = static_cast<int>(q.y), z = static_cast<int>(q.z);
  return {x, y, z, q.x - x, q.y - y, q.z - z};
}

}  // namespace

std::uint64_t queries_of_this_thread() noexcept {
  return t_queries;
}

void count_queries(std::uint64_t count) noexcept {
  t_queries += count;
}

double sample_linear(const TissuePatch& patch, const dvec3& p_V) noexcept {
  if (patch.whole) {
    const dvec3 held = patch.nearest_held(p_V);
    if (held != p_V) return std::hypot(glm::length(p_V - held), std::max(sample_linear(patch, held), 0.0));
  }
  ++t_queries;
  const Cell c = cell_at(patch, p_V);
  const float* f = patch.distance.data() + patch.at(c.x, c.y, c.z);
  const std::size_t sy = static_cast<std::size_t>(patch.n), sx = sy * sy;
  const auto along_z = [&](std::size_t o) { return f[o] + c.w * (f[o + 1] - f[o]); };
  const double a = along_z(0), b = along_z(sy), d = along_z(sx), e = along_z(sx + sy);
  const double lo = a + c.v * (b - a), hi = d + c.v * (e - d);
  return lo + c.u * (hi - lo);
}

FieldSample sample_linear_gradient(const TissuePatch& patch, const dvec3& p_V) noexcept {
  ++t_queries;
  const Cell c = cell_at(patch, patch.whole ? patch.nearest_held(p_V) : p_V);
  const float* f = patch.distance.data() + patch.at(c.x, c.y, c.z);
  const std::size_t sy = static_cast<std::size_t>(patch.n), sx = sy * sy;
  const double z00 = f[1] - f[0], z01 = f[sy + 1] - f[sy], z10 = f[sx + 1] - f[sx], z11 = f[sx + sy + 1] - f[sx + sy];
  const double a = f[0] + c.w * z00, b = f[sy] + c.w * z01, d = f[sx] + c.w * z10, e = f[sx + sy] + c.w * z11;
  const double lo = a + c.v * (b - a), hi = d + c.v * (e - d);
  const double gz0 = z00 + c.v * (z01 - z00), gz1 = z10 + c.v * (z11 - z10);
  return {lo + c.u * (hi - lo), {hi - lo, (b - a) + c.u * ((e - d) - (b - a)), gz0 + c.u * (gz1 - gz0)}};
}

FieldSample sample_cubic(const TissuePatch& patch, const dvec3& p_V) noexcept {
  ++t_queries;
  const Cell c = cell_at(patch, p_V);
  const std::size_t sy = static_cast<std::size_t>(patch.n), sx = sy * sy;
  const double fractions[3] = {c.u, c.v, c.w};
  double out[4];
  cubic(patch.distance.data() + patch.at(c.x - 2, c.y - 2, c.z - 4), sx, sy, fractions, out, kCubicLanes);
  return {out[0], {out[1], out[2], out[3]}};
}

Tissue sole_tissue(const TissuePatch& patch, const dvec3& p_V) noexcept {
  const Cell c = cell_at(patch, p_V);
  const std::size_t sy = static_cast<std::size_t>(patch.n), sx = sy * sy, first = patch.at(c.x, c.y, c.z);
  // the labels of two neighbouring samples along z
  const auto pair = [&](std::size_t at) {
    std::uint16_t two;
    std::memcpy(&two, patch.tissue.data() + at, sizeof two);
    return two;
  };
  const Tissue label = patch.tissue[first];
  const auto all = static_cast<std::uint16_t>(0x101 * static_cast<unsigned>(label));
  return ((pair(first) ^ all) | (pair(first + sy) ^ all) | (pair(first + sx) ^ all) | (pair(first + sx + sy) ^ all))
             ? Tissue::kAir
             : shown(label);
}

/// For each tissue: mean of value(index of a sample) over the eight samples around p_V, with trilinear weights; samples
/// of other tissues count as 0, and samples of air do not count.
template <class Value>
static PerTissue weigh_tissues(const TissuePatch& patch, const dvec3& p_V, const Value& value) noexcept {
  const Cell c = cell_at(patch, p_V);
  PerTissue sums{};
  double total = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner >> 2, j = corner >> 1 & 1, k = corner & 1;
    const std::size_t at = patch.at(c.x + i, c.y + j, c.z + k);
    const Tissue tissue = shown(patch.tissue[at]);
    if (tissue == Tissue::kAir) continue;
    const double weight = (i ? c.u : 1 - c.u) * (j ? c.v : 1 - c.v) * (k ? c.w : 1 - c.w);
    sums[static_cast<std::size_t>(tissue)] += weight * value(at);
    total += weight;
  }
  if (total > 0) {
    for (double& sum : sums) sum /= total;
  }
  return sums;
}

PerTissue sample_tissue(const TissuePatch& patch, const dvec3& p_V) noexcept {
  return weigh_tissues(patch, p_V, [](std::size_t) { return 1.0; });
}

double min_distance(const TissuePatch& patch, const dvec3& p_V) noexcept {
  const double value = sample_linear(patch, p_V);
  if (patch.filled_lo.x > patch.filled_hi.x) return value;
  // A filling lowers only samples within kMargin of its surface, which is at most a voxel outside the box of fillings.
  constexpr double kCorner = 1.74, kLowered = static_cast<double>(Sweep::kMargin) - kCorner;
  const double outside = distance_to_box(patch.filled_lo, patch.filled_hi, p_V);
  return std::min(value, std::max(kLowered, outside - kCorner));
}

PerTissue sample_hardness(const TissuePatch& patch, const dvec3& p_V) noexcept {
  if (patch.hardness.empty()) return sample_tissue(patch, p_V);
  return weigh_tissues(patch, p_V, [&](std::size_t at) { return hardness_fraction(felt_hardness(patch, at)); });
}

}  // namespace typodont::haptics
