#include "haptics/contact/proxy/head_samples.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <vector>

#include "engine/base/dispatch.h"
#include "haptics/contact/proxy/parameters.h"
#include "haptics/cutting/lanes.h"

namespace typodont::haptics {

namespace {

using P = HeadSampleParameters;
constexpr int kBatch = ApproximatePlanes::kBatch;

/// The head at one pose. Coordinates are in voxels, relative to a voxel near the head.
struct FlatHead {
  const MeridianPiece* pieces;
  int count;
  float cx, cy, cz;  // coordinates of the head's centre
  float R[9];        // rotation matrix from the tool's frame T to the voxel frame V, column by column
  float radius;      // radius of a ball; 0 for any other head
  float thickness;   // voxels, largest radius of the head
};

/// Computes the signed distance of eight points from the head, and the gradient of this distance. Points are relative
/// to the head's centre, along the axes of the voxel frame V.
TYPODONT_INLINE void distance_from_head(const FlatHead& head, const F8& x, const F8& y, const F8& z, F8& distance,
                                        F8& mx, F8& my, F8& mz) {
  if (head.radius > 0) {
    F8 length = x * x + y * y + z * z;
    length = length > 1e-12f ? length : F8{} + 1e-12f;
    take_root(length);
    const F8 inverse = 1.0f / length;
    mx = x * inverse, my = y * inverse, mz = z * inverse;
    distance = length - head.radius;
    return;
  }
  const float* R = head.R;
  const F8 tx = R[0] * x + R[1] * y + R[2] * z, ty = R[3] * x + R[4] * y + R[5] * z,
           tz = R[6] * x + R[7] * y + R[8] * z;
  F8 rho = tx * tx + ty * ty;
  rho = rho > 1e-12f ? rho : F8{} + 1e-12f;
  take_root(rho);
  F8 best2 = F8{} + 1e30f, n_rho = {}, n_z = {}, corner = {};
  I8 outside = {}, at_corner = {};
  for (int i = 0; i < head.count; ++i) {
    const MeridianPiece& piece = head.pieces[i];
    const F8 ex = rho - piece.ax, ez = tz - piece.az;
    const I8 beyond = piece.dx * ez - piece.dz * ex < 0.0f;
    F8 fx, fz, nx, nz;
    I8 between;
    if (piece.radius == 0) {
      const F8 s = (ex * piece.dx + ez * piece.dz) * piece.inverse2;
      between = (s > 0.0f) & (s < 1.0f);
      const F8 least = s < 0.0f ? F8{} : s, t = least > 1.0f ? F8{} + 1.0f : least;
      fx = ex - t * piece.dx, fz = ez - t * piece.dz;
      nx = F8{} + piece.nax, nz = F8{} + piece.naz;
      outside |= beyond;
    } else {
      const F8 vx = rho - piece.cx, vz = tz - piece.cz;
      F8 length = vx * vx + vz * vz;
      length = length > 1e-12f ? length : F8{} + 1e-12f;
      take_root(length);
      between = (piece.ux * vz - piece.uz * vx >= 0.0f) & (vx * piece.wz - vz * piece.wx >= 0.0f);
      const F8 gx = rho - piece.bx, gz = tz - piece.bz, inverse = 1.0f / length;
      const I8 first = ex * ex + ez * ez < gx * gx + gz * gz;
      nx = vx * inverse, nz = vz * inverse;
      const F8 off = length - piece.radius;
      fx = between ? off * nx : first ? ex : gx;
      fz = between ? off * nz : first ? ez : gz;
      outside |= beyond & (length > piece.radius);
    }
    const F8 f2 = fx * fx + fz * fz;
    const I8 nearer = f2 < best2;
    best2 = nearer ? f2 : best2;
    // If the nearest point is an end of a piece, the gradient points from this end to the given point. Very close to
    // the end this is inaccurate, so the piece's normal is used.
    const I8 smooth = between | (f2 < 1e-8f);
    n_rho = nearer ? (smooth ? nx : fx) : n_rho;
    n_z = nearer ? (smooth ? nz : fz) : n_z;
    corner = nearer ? (smooth ? F8{} + 1.0f : f2) : corner;
    at_corner = nearer ? ~smooth : at_corner;
  }
  take_root(best2);
  take_root(corner);
  distance = outside ? best2 : -best2;
  const F8 inverse = 1.0f / corner, scale = at_corner & ~outside ? -inverse : inverse, along = n_rho * scale / rho;
  const F8 ux = along * tx, uy = along * ty, uz = n_z * scale;
  mx = R[0] * ux + R[3] * uy + R[6] * uz;
  my = R[1] * ux + R[4] * uy + R[7] * uz;
  mz = R[2] * ux + R[5] * uy + R[8] * uz;
}

/// The distance field around the head. Coordinates are relative to the same voxel near the head as those in FlatHead.
struct FlatField {
  const float* samples;  // address of sample (0,0,0), which may lie outside the stored field
  int sx, sy;
  float lo[3], hi[3];  // voxels, bounds of the region in which the field may be sampled
  bool whole;          // the tissue patch contains all tissue; outside it is air
};

TYPODONT_INLINE void pairs_at(const float* samples, const I8& at, std::ptrdiff_t offset, F8& first, F8& second) {
  double pair[8];  // each element: two neighbouring floats, read by one load
  for (int i = 0; i < 8; ++i) std::memcpy(&pair[i], samples + at[i] + offset, sizeof(double));
  const D4 one = {pair[0], pair[1], pair[2], pair[3]}, two = {pair[4], pair[5], pair[6], pair[7]};
  const F8 low = (F8)one, high = (F8)two;
  first = __builtin_shufflevector(low, high, 0, 2, 4, 6, 8, 10, 12, 14);
  second = __builtin_shufflevector(low, high, 1, 3, 5, 7, 9, 11, 13, 15);
}

/// Interpolates the distance field trilinearly at eight points. Returns values and gradients. All coordinates must be
/// positive.
TYPODONT_INLINE void sample_eight(const FlatField& field, const F8& x, const F8& y, const F8& z, F8& value, F8& gx,
                                  F8& gy, F8& gz) {
  const I8 ix = __builtin_convertvector(x, I8), iy = __builtin_convertvector(y, I8),
           iz = __builtin_convertvector(z, I8);
  const F8 u = x - __builtin_convertvector(ix, F8), v = y - __builtin_convertvector(iy, F8),
           w = z - __builtin_convertvector(iz, F8);
  const I8 at = ix * field.sx + iy * field.sy + iz;
  F8 f0, f1, a, b, d, e;
  pairs_at(field.samples, at, 0, f0, f1);
  const F8 z00 = f1 - f0;
  a = f0 + w * z00;
  pairs_at(field.samples, at, field.sy, f0, f1);
  const F8 z01 = f1 - f0;
  b = f0 + w * z01;
  pairs_at(field.samples, at, field.sx, f0, f1);
  const F8 z10 = f1 - f0;
  d = f0 + w * z10;
  pairs_at(field.samples, at, field.sx + field.sy, f0, f1);
  const F8 z11 = f1 - f0;
  e = f0 + w * z11;
  const F8 ab = b - a, de = e - d, lo = a + v * ab, hi = d + v * de;
  const F8 gz0 = z00 + v * (z01 - z00), gz1 = z10 + v * (z11 - z10);
  gx = hi - lo;
  value = lo + u * gx;
  gy = ab + u * (de - ab);
  gz = gz0 + u * (gz1 - gz0);
}

TYPODONT_INLINE void keep_between(float lo, float hi, F8& x) {
  x = x > lo ? x : F8{} + lo;
  x = x < hi ? x : F8{} + hi;
}

/// Working data of the contact search: the samples in batches of eight, and the points that are moved from them to the
/// tissue's surface.
struct SampleBatches {
  static constexpr int kBatches = ContactSet::kMax / kBatch;
  int from[kBatches];                           // index of the first sample of the batch
  F8 qx[kBatches], qy[kBatches], qz[kBatches];  // voxels, positions of the samples on the head
  // voxels, current positions of the points, which move from the samples to the tissue's surface
  F8 x[kBatches], y[kBatches], z[kBatches];
  // value (voxels) and gradient of the distance field at the current positions
  F8 value[kBatches], gx[kBatches], gy[kBatches], gz[kBatches];
  F8 nx[kBatches], ny[kBatches], nz[kBatches];  // unit vectors in the direction of the gradients
  // steep: the gradient is long enough for a step along it; again: the point is not on the surface yet, so it moves
  // further
  I8 steep[kBatches], again[kBatches];
  F8 best[kBatches], best_x[kBatches], best_y[kBatches], best_z[kBatches];
  F8 best_mx[kBatches], best_my[kBatches], best_mz[kBatches];
};

/// Searches contacts: moves each sample of the head near tissue to the point where head and tissue are closest. All
/// batches make one step before any makes the next, because loads, roots and divisions have a long latency.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void slide_to_surface(const HeadSamples* samples, const FlatHead* head_at, const FlatField* field_at, float near,
                      ApproximatePlanes* planes, Found* found) {
  const FlatHead head = *head_at;
  const FlatField field = *field_at;
  const float* R = head.R;
  const float examined = std::max(P::examined, near + P::beyond_near);
  SampleBatches w;
  int batches = 0;
  for (int k = 0; k < ContactSet::kMax; k += kBatch) {
    F8 px, py, pz;
    std::memcpy(&px, samples->px + k, sizeof px);
    std::memcpy(&py, samples->py + k, sizeof py);
    std::memcpy(&pz, samples->pz + k, sizeof pz);
    if (head.radius == 0) {
      const F8 tx = px, ty = py, tz = pz;
      px = R[0] * tx + R[3] * ty + R[6] * tz;
      py = R[1] * tx + R[4] * ty + R[7] * tz;
      pz = R[2] * tx + R[5] * ty + R[8] * tz;
    }
    F8 qx = head.cx + px, qy = head.cy + py, qz = head.cz + pz;
    if (field.whole) {
      keep_between(field.lo[0], field.hi[0], qx);
      keep_between(field.lo[1], field.hi[1], qy);
      keep_between(field.lo[2], field.hi[2], qz);
    }
    // Skips batches that are far from tissue. A quick test reads the field at the voxel nearest to each sample; the
    // field changes by at most one per voxel.
    const I8 jx = __builtin_convertvector(qx + 0.5f, I8), jy = __builtin_convertvector(qy + 0.5f, I8),
             jz = __builtin_convertvector(qz + 0.5f, I8);
    F8 coarse;
    const I8 j = jx * field.sx + jy * field.sy + jz;
    for (int i = 0; i < 8; ++i) coarse[i] = field.samples[j[i]];
    w.from[batches] = k;
    w.qx[batches] = qx, w.qy[batches] = qy, w.qz[batches] = qz;
    batches += any_of(coarse < examined + 0.87f);
  }

  // Step 1: moves each sample onto the tissue's surface.
  for (int b = 0; b < batches; ++b)
    sample_eight(field, w.qx[b], w.qy[b], w.qz[b], w.value[b], w.gx[b], w.gy[b], w.gz[b]);
  F8 area = {}, area_x = {}, area_y = {}, area_z = {}, least = {};
  int close_batches = 0;
  for (int b = 0; b < batches; ++b) {
    const F8 qx = w.qx[b], qy = w.qy[b], qz = w.qz[b], gx = w.gx[b], gy = w.gy[b], gz = w.gz[b];
    F8 value = w.value[b];
    const I8 close = value < examined;
    F8 engaged, nx, ny, nz;
    const int k = w.from[b];
    std::memcpy(&engaged, samples->area + k, sizeof engaged);
    std::memcpy(&nx, samples->nx + k, sizeof nx);
    std::memcpy(&ny, samples->ny + k, sizeof ny);
    std::memcpy(&nz, samples->nz + k, sizeof nz);
    // `fraction`: weight of a sample's area; decreases linearly from 1 at the surface to 0 at one voxel. `half`: 0 at
    // half a voxel. Normals have the weight 2 · half − fraction, whose mean is 0, so areas without contact cancel.
    F8 fraction = 1.0f - value, half = fraction - value;
    fraction = fraction < 0.0f ? F8{} : fraction;
    fraction = fraction > 1.0f ? F8{} + 1.0f : fraction;
    half = half < 0.0f ? F8{} : half;
    half = half > 1.0f ? F8{} + 1.0f : half;
    area += engaged * fraction;
    fraction = engaged * (half + half - fraction);
    area_x += fraction * nx, area_y += fraction * ny, area_z += fraction * nz;

    F8 length2 = gx * gx + gy * gy + gz * gz;
    const I8 steep = close & (length2 > 0.01f);
    length2 = length2 > 0.01f ? length2 : F8{} + 0.01f;
    take_root(length2);
    const F8 inverse = 1.0f / length2;
    nx = gx * inverse, ny = gy * inverse, nz = gz * inverse;
    value = steep ? value : F8{};
    const int to = close_batches;
    w.qx[to] = qx, w.qy[to] = qy, w.qz[to] = qz;
    w.x[to] = qx - value * nx, w.y[to] = qy - value * ny, w.z[to] = qz - value * nz;
    w.nx[to] = nx, w.ny[to] = ny, w.nz[to] = nz;
    w.steep[to] = steep;
    // A point counts as on the surface only if it was nearly on it before this step, because a long step across a ridge
    // may end anywhere.
    w.again[to] = steep & (value < P::on_surface) & (value > -P::on_surface);
    close_batches += any_of(close);
  }

  // Step 2, made twice: moves each point along the tissue's surface towards the head while the gap decreases.
  for (int b = 0; b < close_batches; ++b) {
    F8 x = w.x[b], y = w.y[b], z = w.z[b];
    const F8 nx = w.nx[b], ny = w.ny[b], nz = w.nz[b];
    const I8 on = w.again[b];
    F8 gap, mx, my, mz;
    distance_from_head(head, x - head.cx, y - head.cy, z - head.cz, gap, mx, my, mz);
    w.best[b] = on ? gap : F8{} + 1e30f;
    w.best_x[b] = x, w.best_y[b] = y, w.best_z[b] = z;
    w.best_mx[b] = mx, w.best_my[b] = my, w.best_mz[b] = mz;

    const F8 along = mx * nx + my * ny + mz * nz;
    const F8 way = on ? gap + head.thickness : F8{};
    x -= way * (mx - along * nx), y -= way * (my - along * ny), z -= way * (mz - along * nz);
    const I8 inside = (x > field.lo[0]) & (x < field.hi[0]) & (y > field.lo[1]) & (y < field.hi[1]) &
                      (z > field.lo[2]) & (z < field.hi[2]);
    w.x[b] = inside ? x : w.qx[b], w.y[b] = inside ? y : w.qy[b], w.z[b] = inside ? z : w.qz[b];
    w.again[b] = w.steep[b] & inside;
  }
  for (int b = 0; b < close_batches; ++b)
    sample_eight(field, w.x[b], w.y[b], w.z[b], w.value[b], w.gx[b], w.gy[b], w.gz[b]);
  for (int b = 0; b < close_batches; ++b) {
    const F8 value = w.value[b], gx = w.gx[b], gy = w.gy[b], gz = w.gz[b];
    F8 length2 = gx * gx + gy * gy + gz * gz;
    w.again[b] = w.again[b] & (length2 > 0.01f) & (value < P::on_surface) & (value > -P::on_surface);
    length2 = length2 > 0.01f ? length2 : F8{} + 0.01f;
    take_root(length2);
    const F8 inverse = value / length2;
    w.x[b] -= inverse * gx, w.y[b] -= inverse * gy, w.z[b] -= inverse * gz;
  }
  int count = 0;
  for (int b = 0; b < close_batches; ++b) {
    const F8 x = w.x[b], y = w.y[b], z = w.z[b];
    F8 gap, mx, my, mz, best = w.best[b];
    distance_from_head(head, x - head.cx, y - head.cy, z - head.cz, gap, mx, my, mz);
    const I8 better = w.again[b] & (gap < best);
    best = better ? gap : best;
    const I8 kept = best < near;
    const unsigned keep = bits_of(kept);
    best = kept ? best : F8{} + 1e30f;
    least = best < least ? best : least;
    // Moves the valid lanes to the front of the vector. A branch is avoided, because it would often be mispredicted.
    const I8& order = kCompaction.order[keep];
    const auto put = [&](const F8& v, float* to) __attribute__((always_inline)) {
      F8 first;
      gather_lanes(v, order, first);
      std::memcpy(to + count, &first, sizeof first);
    };
    put((better ? x : w.best_x[b]) - head.cx, planes->x);
    put((better ? y : w.best_y[b]) - head.cy, planes->y);
    put((better ? z : w.best_z[b]) - head.cz, planes->z);
    put(-(better ? mx : w.best_mx[b]), planes->nx);
    put(-(better ? my : w.best_my[b]), planes->ny);
    put(-(better ? mz : w.best_mz[b]), planes->nz);
    put(best, planes->gap);
    count += std::popcount(keep);
  }
  found->count = count;
  found->area = sum_of(area);
  found->area_x = sum_of(area_x);
  found->area_y = sum_of(area_y);
  found->area_z = sum_of(area_z);
  float deepest = 0;
  for (int i = 0; i < 8; ++i) deepest = -least[i] > deepest ? -least[i] : deepest;
  found->deepest = deepest;
}

/// Updates the normals and gaps of the contacts of the last search. `d`: displacement of the head since then, voxels.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
float see_anew(const FlatHead* head_at, ApproximatePlanes* planes, int count, const float* d) {
  const FlatHead head = *head_at;
  F8 least = {};
  I8 at = {0, 1, 2, 3, 4, 5, 6, 7};
  for (int k = 0; k < count; k += kBatch, at += 8) {
    F8 x, y, z, gap, mx, my, mz;
    std::memcpy(&x, planes->x + k, sizeof x);
    std::memcpy(&y, planes->y + k, sizeof y);
    std::memcpy(&z, planes->z + k, sizeof z);
    distance_from_head(head, x - d[0], y - d[1], z - d[2], gap, mx, my, mz);
    mx = -mx, my = -my, mz = -mz;
    std::memcpy(planes->nx + k, &mx, sizeof mx);
    std::memcpy(planes->ny + k, &my, sizeof my);
    std::memcpy(planes->nz + k, &mz, sizeof mz);
    std::memcpy(planes->gap + k, &gap, sizeof gap);
    least = (gap < least) & (at < count) ? gap : least;
  }
  float deepest = 0;
  for (int i = 0; i < 8; ++i) deepest = -least[i] > deepest ? -least[i] : deepest;
  return deepest;
}

/// Moves surface points that are inside the head to the head's surface, so that their gap becomes 0. `d`: head's centre
/// relative to the origin of the points. `head_at`: head at its current pose; null: it has not moved.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void push_out(const FlatHead* head_at, ApproximatePlanes* planes, int count, const float* d) {
  const FlatHead head = head_at ? *head_at : FlatHead{};
  for (int k = 0; k < count; k += kBatch) {
    F8 x, y, z, gap, nx, ny, nz, off, mx, my, mz;
    std::memcpy(&gap, planes->gap + k, sizeof gap);
    std::memcpy(&x, planes->x + k, sizeof x);
    std::memcpy(&y, planes->y + k, sizeof y);
    std::memcpy(&z, planes->z + k, sizeof z);
    std::memcpy(&nx, planes->nx + k, sizeof nx);
    std::memcpy(&ny, planes->ny + k, sizeof ny);
    std::memcpy(&nz, planes->nz + k, sizeof nz);
    if (head_at) {
      distance_from_head(head, x - d[0], y - d[1], z - d[2], off, mx, my, mz);
    } else {
      off = gap, mx = -nx, my = -ny, mz = -nz;
    }
    const I8 in = off < 0.0f;
    off = in ? off : F8{};
    x -= off * mx, y -= off * my, z -= off * mz;
    nx = in ? -mx : nx, ny = in ? -my : ny, nz = in ? -mz : nz;
    gap = in ? F8{} : gap;
    std::memcpy(planes->gap + k, &gap, sizeof gap);
    std::memcpy(planes->x + k, &x, sizeof x);
    std::memcpy(planes->y + k, &y, sizeof y);
    std::memcpy(planes->z + k, &z, sizeof z);
    std::memcpy(planes->nx + k, &nx, sizeof nx);
    std::memcpy(planes->ny + k, &ny, sizeof ny);
    std::memcpy(planes->nz + k, &nz, sizeof nz);
  }
}

/// Converts the head at one pose to the form that the SIMD functions use. `c`: the head's centre in voxels, relative to
/// a voxel near it.
FlatHead flat_head(const HeadSamples& samples, const dquat& R, const glm::vec3& c) {
  FlatHead head{samples.pieces, samples.piece_count, c.x, c.y, c.z, {}, samples.ball_radius, samples.thickness};
  const glm::mat3 columns{glm::dmat3(R)};
  for (int i = 0; i < 9; ++i) head.R[i] = columns[i / 3][i % 3];
  return head;
}

}  // namespace

HeadSamples::HeadSamples(const Tool& tool, const HeadField& head, double voxel)
    : piece_count(head.count),
      ball_radius(tool.shape == HeadShape::kSphere ? static_cast<float>(tool.radius() / voxel) : 0.0f),
      thickness(static_cast<float>(tool.radius() / voxel)),
      reach(static_cast<float>(tool.reach() / voxel)) {
  std::vector<HeadSample> list = sample_head(tool, ContactSet::kMax, P::near_free_end);
  // Puts neighbouring samples into the same batch: splits the set along its longest side until eight samples are left.
  const auto halve = [&](auto&& self, std::size_t from, std::size_t count) -> void {
    if (count <= kBatch) return;
    dvec3 lo(1e300), hi(-1e300);
    for (std::size_t i = from; i < from + count; ++i) lo = glm::min(lo, list[i].p_TQ), hi = glm::max(hi, list[i].p_TQ);
    const dvec3 side = hi - lo;
    const int axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
    const auto first = list.begin() + static_cast<std::ptrdiff_t>(from);
    std::stable_sort(first, first + static_cast<std::ptrdiff_t>(count),
                     [&](const HeadSample& a, const HeadSample& b) { return a.p_TQ[axis] < b.p_TQ[axis]; });
    self(self, from, count / 2);
    self(self, from + count / 2, count / 2);
  };
  halve(halve, 0, list.size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    const glm::vec3 p(list[i].p_TQ / voxel), n(list[i].n_T);
    px[i] = p.x, py[i] = p.y, pz[i] = p.z;
    nx[i] = n.x, ny[i] = n.y, nz[i] = n.z;
    area[i] = static_cast<float>(list[i].area / (voxel * voxel));
  }
  double surface = 0;
  for (const HeadSample& sample : list) surface += sample.area;
  surface /= voxel * voxel;
  if (surface > ContactSet::kMax * P::dense * P::dense) {
    const double spacing = P::cover * P::cover;
    const std::vector<HeadSample> points =
        sample_head(tool, std::clamp(static_cast<int>(surface / spacing), ContactSet::kMax, P::max_cover));
    double largest = 0;
    for (const HeadSample& point : points) {
      cover.emplace_back(point.p_TQ / voxel);
      largest = std::max(largest, point.area);
    }
    cover_radius = static_cast<float>(std::sqrt(largest) / voxel);
  }
  flatten(head, pieces);
}

Found HeadSamples::search_around(const TissuePatch& patch, const Pose& X_VT, float near,
                                 ApproximatePlanes& planes) const noexcept {
  // Coordinates are relative to a voxel near the head, because floats represent small numbers more precisely.
  const glm::ivec3 base = glm::ivec3(X_VT.p) - (static_cast<int>(reach) + 8), from = base - patch.lo;
  const FlatHead head = flat_head(*this, X_VT.R, glm::vec3(X_VT.p - dvec3(base)));
  const std::ptrdiff_t sy = patch.n, sx = sy * sy;
  FlatField field{patch.distance.data() + (from.x * sx + from.y * sy + from.z),
                  static_cast<int>(sx),
                  static_cast<int>(sy),
                  {},
                  {},
                  patch.whole};
  for (int i = 0; i < 3; ++i) {
    field.lo[i] = static_cast<float>(std::max(3 - from[i], 0));
    field.hi[i] = static_cast<float>(patch.n - 4 - from[i]);
  }
  Found found{};
  // A head completely outside a patch that contains all tissue has no contacts. It is skipped: indices could overflow.
  const int edge = 2 * (static_cast<int>(reach) + 8);
  if (patch.whole && (std::min({from.x, from.y, from.z}) < -edge || std::max({from.x, from.y, from.z}) > patch.n))
    return found;
  slide_to_surface(this, &head, &field, near, &planes, &found);
  return found;
}

float HeadSamples::update_planes(const dquat& R, const glm::vec3& moved, ApproximatePlanes& planes,
                                 int count) const noexcept {
  const FlatHead head = flat_head(*this, R, glm::vec3(0));
  return see_anew(&head, &planes, count, &moved.x);
}

void HeadSamples::push_out_here(ApproximatePlanes& planes, int count) const noexcept {
  push_out(nullptr, &planes, count, nullptr);
}

void HeadSamples::push_out_at(const dquat& R, const glm::vec3& c, ApproximatePlanes& planes, int count) const noexcept {
  const FlatHead head = flat_head(*this, R, glm::vec3(0));
  push_out(&head, &planes, count, &c.x);
}

}  // namespace typodont::haptics
