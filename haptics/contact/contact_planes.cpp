#include "haptics/contact/contact_planes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <vector>

#include "engine/base/dispatch.h"
#include "engine/base/units.h"
#include "haptics/contact/sharp_edge.h"
#include "haptics/lanes.h"

namespace typodont::haptics {

namespace {

constexpr double kFootOff = 0.05;     // voxels; of a ball of four voxels' radius the linear look alone is off by as much
constexpr double kUnbent = 2e-4;      // a gradient whose length is off by less, over a surface …
constexpr double kBelow = 3;          // … that lies so many voxels of tissue away from any edge …
constexpr double kAbove = 3.5;        // … and so many of air from where another wall is nearer, is that of one wall
constexpr double kMostBehind = 4;     // voxels that a hand may be under the surface which its ball lies on
constexpr double kStraight = 1e-8;    // voxels², how far aside from straight above a point of the wall …
constexpr int kMostSteps = 6;         // … after so many steps along it at most …
constexpr double kUneven = 1e-3;      // … while the field's gradient is no longer or shorter than one by more than this,
constexpr double kEven = 5e-5;        // … and than this where nothing else is near
constexpr float kOnSurface = 0.25f;   // voxels
constexpr float kNear = 1.5f;         // voxels: samples closer than this to the surface are looked at
constexpr int kExactSteps = 4;        // cubic queries a contact may take on its way to the closest point
constexpr double kStaysExact = 0.02;  // voxels a ball may move before a contact is made exact again: 2e-5 voxels of gap,
constexpr double kStaysExactEdged = 2e-3;  // … and a head with edges, where the gap may change by as much as the way
constexpr double kGained = 1e-4;      // voxels: the next step would gain the square of that
// While nothing is cut the force's direction counts, and sideways a contact is off by the root of what a step still gains.
constexpr int kFineSteps = 8;
constexpr double kFineStays = 1e-3, kFineGained = 3e-8;
constexpr double kStillConverges = 0.95, kMostGain = 10;
// A rim that lies in the tissue: what its sides say about the way out is wrong, the tissue's normal is right …
constexpr double kAskew = 0.99999;    // … where these differ, by their cosine, …
constexpr double kSmooth = 0.05;      // … the tissue is smooth, its gradient no shorter than this from one, …
constexpr double kSameWall = 0.9;     // … and the same around, by the cosine of its normals, …
constexpr double kNearRim = 2;        // … as far as this many voxels from the rim, and from what of it is sunk
constexpr int kBatch = RoughPlanes::kBatch;

/// A piece of the head's meridian in floats; see HeadField::Piece.
struct FlatPiece {
  float ax, az, bx, bz, dx, dz, inverse2;
  float cx, cz, radius;
  float ux, uz, wx, wz;  // from an arc's centre to its ends
  float nx, nz;          // outward normal of a line
};

/// The head where it is looked at, from some voxel near it.
struct FlatHead {
  const FlatPiece* pieces;
  int count;
  float cx, cy, cz;     // its centre
  float R[9];           // from T to V, by columns
  float radius;         // of a ball; else 0
  float thickness;      // half its width
};

}  // namespace

/// The samples side by side, in clusters of eight neighbours: what one of a batch is near to, most of it are.
struct HeadSamples {
  alignas(32) float px[ContactSet::kMax], py[ContactSet::kMax], pz[ContactSet::kMax];
  alignas(32) float nx[ContactSet::kMax], ny[ContactSet::kMax], nz[ContactSet::kMax], area[ContactSet::kMax];
  FlatPiece pieces[HeadField::kMaxPieces];
};

namespace {

/// Signed distance of points from the head, with the direction in which it grows; points from the head's centre, in V.
TYPODONT_KERNEL void distance_from_head(const FlatHead& head, const F8& x, const F8& y, const F8& z, F8& distance, F8& mx,
                                        F8& my, F8& mz) {
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
  const F8 tx = R[0] * x + R[1] * y + R[2] * z, ty = R[3] * x + R[4] * y + R[5] * z, tz = R[6] * x + R[7] * y + R[8] * z;
  F8 rho = tx * tx + ty * ty;
  rho = rho > 1e-12f ? rho : F8{} + 1e-12f;
  take_root(rho);
  F8 best2 = F8{} + 1e30f, n_rho = {}, n_z = {}, corner = {};
  I8 outside = {}, at_corner = {};
  for (int i = 0; i < head.count; ++i) {
    const FlatPiece& piece = head.pieces[i];
    const F8 ex = rho - piece.ax, ez = tz - piece.az;
    const I8 beyond = piece.dx * ez - piece.dz * ex < 0.0f;
    F8 fx, fz, nx, nz;
    I8 between;
    if (piece.radius == 0) {
      const F8 s = (ex * piece.dx + ez * piece.dz) * piece.inverse2;
      between = (s > 0.0f) & (s < 1.0f);
      const F8 least = s < 0.0f ? F8{} : s, t = least > 1.0f ? F8{} + 1.0f : least;
      fx = ex - t * piece.dx, fz = ez - t * piece.dz;
      nx = F8{} + piece.nx, nz = F8{} + piece.nz;
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
    // Beside an end the direction is that to the end, where it is far enough away to have one.
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

/// The field around the head, from the same voxel as the head.
struct FlatField {
  const float* samples;  // at that voxel, which need not be one of the patch
  int sx, sy;
  float lo[3], hi[3];  // between these a point may be sampled
};

TYPODONT_KERNEL void pairs_at(const float* samples, const I8& at, std::ptrdiff_t offset, F8& first, F8& second) {
  double pair[8];  // two floats move as one double
  for (int i = 0; i < 8; ++i) std::memcpy(&pair[i], samples + at[i] + offset, sizeof(double));
  const D4 one = {pair[0], pair[1], pair[2], pair[3]}, two = {pair[4], pair[5], pair[6], pair[7]};
  const F8 low = (F8)one, high = (F8)two;
  first = __builtin_shufflevector(low, high, 0, 2, 4, 6, 8, 10, 12, 14);
  second = __builtin_shufflevector(low, high, 1, 3, 5, 7, 9, 11, 13, 15);
}

/// Trilinear value with its own gradient at eight points, all positive.
TYPODONT_KERNEL void sample_eight(const FlatField& field, const F8& x, const F8& y, const F8& z, F8& value, F8& gx,
                                  F8& gy, F8& gz) {
  const I8 ix = __builtin_convertvector(x, I8), iy = __builtin_convertvector(y, I8), iz = __builtin_convertvector(z, I8);
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

struct Found {
  int count;
  float deepest;
  float area, area_x, area_y, area_z;
};

/// Batches of samples on their way to the surface.
struct OnTheWay {
  static constexpr int kBatches = ContactSet::kMax / kBatch;
  int from[kBatches];                              // of the head's samples
  F8 qx[kBatches], qy[kBatches], qz[kBatches];     // those
  F8 x[kBatches], y[kBatches], z[kBatches];        // where they have come to
  F8 nx[kBatches], ny[kBatches], nz[kBatches];     // the field's direction there
  I8 steep[kBatches], again[kBatches];             // it has one
  F8 best[kBatches], best_x[kBatches], best_y[kBatches], best_z[kBatches];
  F8 best_mx[kBatches], best_my[kBatches], best_mz[kBatches];
};

/// Looks around with the samples of the head: those that are near tissue are slid to where head and surface are closest.
/// Each step waits long for its roots and quotients, so every one is taken by all batches before the next.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void look_around(const HeadSamples* samples, const FlatHead* head_at, const FlatField* field_at, float near,
                 RoughPlanes* planes, Found* found) {
  const FlatHead head = *head_at;
  const FlatField field = *field_at;
  const float* R = head.R;
  OnTheWay w;
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
    const F8 qx = head.cx + px, qy = head.cy + py, qz = head.cz + pz;
    // A coarse look at the nearest voxel: the field grows by at most one per voxel.
    const I8 jx = __builtin_convertvector(qx + 0.5f, I8), jy = __builtin_convertvector(qy + 0.5f, I8),
             jz = __builtin_convertvector(qz + 0.5f, I8);
    F8 coarse;
    const I8 j = jx * field.sx + jy * field.sy + jz;
    for (int i = 0; i < 8; ++i) coarse[i] = field.samples[j[i]];
    w.from[batches] = k;
    w.qx[batches] = qx, w.qy[batches] = qy, w.qz[batches] = qz;
    batches += any_of(coarse < kNear + 0.87f);
  }

  // Onto the surface …
  F8 area = {}, area_x = {}, area_y = {}, area_z = {}, least = {};
  int close_batches = 0;
  for (int b = 0; b < batches; ++b) {
    const F8 qx = w.qx[b], qy = w.qy[b], qz = w.qz[b];
    F8 value, gx, gy, gz;
    sample_eight(field, qx, qy, qz, value, gx, gy, gz);
    const I8 close = value < kNear;
    F8 engaged, nx, ny, nz;  // fades over one voxel, so that area changes smoothly
    const int k = w.from[b];
    std::memcpy(&engaged, samples->area + k, sizeof engaged);
    std::memcpy(&nx, samples->nx + k, sizeof nx);
    std::memcpy(&ny, samples->ny + k, sizeof ny);
    std::memcpy(&nz, samples->nz + k, sizeof nz);
    F8 share = 1.0f - value;
    share = share < 0.0f ? F8{} : share;
    share = share > 1.0f ? F8{} + 1.0f : share;
    engaged *= share;
    area += engaged, area_x += engaged * nx, area_y += engaged * ny, area_z += engaged * nz;

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
    // Only a point that was already nearly on the surface counts: across a ridge the step may end anywhere.
    w.again[to] = steep & (value < kOnSurface) & (value > -kOnSurface);
    close_batches += any_of(close);
  }

  // … then along it toward the head, as long as that brings them closer: twice.
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
  for (int b = 0; b < close_batches; ++b) {
    F8 value, gx, gy, gz;
    sample_eight(field, w.x[b], w.y[b], w.z[b], value, gx, gy, gz);
    F8 length2 = gx * gx + gy * gy + gz * gz;
    w.again[b] = w.again[b] & (length2 > 0.01f) & (value < kOnSurface) & (value > -kOnSurface);
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
    // Without a branch: which are kept is not foreseeable.
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

/// New normals and gaps of known points. `d`: how far the head has moved since they were found.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
float look_again(const FlatHead* head_at, RoughPlanes* planes, int count, const float* d) {
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

/// Points that lie in the head come out of it, and touch it if it is still there. `d`: where it is, from where they are counted.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void come_out(const FlatHead* head_at, RoughPlanes* planes, int count, const float* d) {
  const FlatHead head = *head_at;
  for (int k = 0; k < count; k += kBatch) {
    F8 x, y, z, gap, nx, ny, nz, off, mx, my, mz;
    std::memcpy(&gap, planes->gap + k, sizeof gap);
    std::memcpy(&x, planes->x + k, sizeof x);
    std::memcpy(&y, planes->y + k, sizeof y);
    std::memcpy(&z, planes->z + k, sizeof z);
    std::memcpy(&nx, planes->nx + k, sizeof nx);
    std::memcpy(&ny, planes->ny + k, sizeof ny);
    std::memcpy(&nz, planes->nz + k, sizeof nz);
    distance_from_head(head, x - d[0], y - d[1], z - d[2], off, mx, my, mz);
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

}  // namespace

ContactFinder::ContactFinder(const Tool& tool, double voxel)
    : head_(tool, voxel),
      sphere_(tool.shape == HeadShape::kSphere),
      radius_(tool.radius() / voxel),
      reach_(tool.reach() / voxel),
      samples_(std::make_unique<HeadSamples>()) {
  std::vector<HeadSample> list = sample_head(tool, ContactSet::kMax);
  // Neighbours into one batch: halved across the longest side until eight are left.
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
    samples_->px[i] = p.x, samples_->py[i] = p.y, samples_->pz[i] = p.z;
    samples_->nx[i] = n.x, samples_->ny[i] = n.y, samples_->nz[i] = n.z;
    samples_->area[i] = static_cast<float>(list[i].area / (voxel * voxel));
  }
  for (int i = 0; i < head_.count; ++i) {
    const HeadField::Piece& piece = head_.pieces[i];
    const double length = std::sqrt(1 / piece.inverse2);
    const double values[] = {piece.ax,           piece.az,           piece.bx,           piece.bz,
                             piece.dx,           piece.dz,           piece.inverse2,     piece.cx,
                             piece.cz,           piece.radius,       piece.ax - piece.cx, piece.az - piece.cz,
                             piece.bx - piece.cx, piece.bz - piece.cz, piece.dz / length,   -piece.dx / length};
    static_assert(sizeof(FlatPiece) == std::size(values) * sizeof(float));
    float flat[std::size(values)];
    for (std::size_t k = 0; k < std::size(values); ++k) flat[k] = static_cast<float>(values[k]);
    std::memcpy(&samples_->pieces[i], flat, sizeof flat);
  }
}

ContactFinder::~ContactFinder() = default;
ContactFinder::ContactFinder(ContactFinder&&) noexcept = default;
ContactFinder& ContactFinder::operator=(ContactFinder&&) noexcept = default;

ContactPlane ContactSet::plane(int i) const noexcept {
  for (int k = 0; k < exact_count_; ++k) {
    if (exact_[static_cast<std::size_t>(k)].index == i) return exact_[static_cast<std::size_t>(k)].plane;
  }
  return {origin_ + dvec3(rough_.x[i], rough_.y[i], rough_.z[i]), dvec3(rough_.nx[i], rough_.ny[i], rough_.nz[i]),
          static_cast<double>(rough_.gap[i]), static_cast<double>(rough_.yields[i])};
}

ContactSet::Exact* ContactSet::exact(int i) noexcept {
  for (int k = 0; k < exact_count_; ++k) {
    if (exact_[static_cast<std::size_t>(k)].index == i) return &exact_[static_cast<std::size_t>(k)];
  }
  return nullptr;
}

void ContactSet::set_yields(int i, double yields) noexcept {
  rough_.yields[i] = static_cast<float>(yields);
  if (Exact* known = exact(i)) known->plane.yields = yields;
}

/// Keeps a contact that was made exact; where there is no more room, in place of the first.
void ContactSet::put(int i, const dvec3& c, const ContactPlane& plane) noexcept {
  Exact* slot = exact(i);
  if (!slot) {
    if (exact_count_ == kExact) std::move(exact_.begin() + 1, exact_.end(), exact_.begin()), --exact_count_;
    slot = &exact_[static_cast<std::size_t>(exact_count_++)];
  }
  *slot = {i, c, plane};
  const glm::vec3 x(plane.x - origin_), n(plane.n);
  rough_.x[i] = x.x, rough_.y[i] = x.y, rough_.z[i] = x.z;
  rough_.nx[i] = n.x, rough_.ny[i] = n.y, rough_.nz[i] = n.z;
  rough_.gap[i] = static_cast<float>(plane.gap);
  rough_.yields[i] = static_cast<float>(plane.yields);
}

/// What was found roughly around a rim says the same as the rim.
void ContactSet::put_beside(const ContactPlane& rim) noexcept {
  const glm::vec3 x(rim.x - origin_), n(rim.n);
  const auto near = static_cast<float>(kNearRim + 2 * std::abs(rim.gap));
  for (int i = 0; i < own(); ++i) {
    if (glm::length(glm::vec3(rough_.x[i], rough_.y[i], rough_.z[i]) - x) > near) continue;
    rough_.x[i] = x.x, rough_.y[i] = x.y, rough_.z[i] = x.z;
    rough_.nx[i] = n.x, rough_.ny[i] = n.y, rough_.nz[i] = n.z;
    rough_.gap[i] = static_cast<float>(rim.gap);
  }
}

bool ContactSet::add(const ContactPlane& plane) noexcept {
  if (count_ == RoughPlanes::kRoom) return false;
  const glm::vec3 x(plane.x - origin_), n(plane.n);
  rough_.x[count_] = x.x, rough_.y[count_] = x.y, rough_.z[count_] = x.z;
  rough_.nx[count_] = n.x, rough_.ny[count_] = n.y, rough_.nz[count_] = n.z;
  rough_.gap[count_] = static_cast<float>(plane.gap);
  rough_.yields[count_] = 0;
  ++count_, ++added_;
  return true;
}

void ContactSet::clear() noexcept {
  count_ = exact_count_ = added_ = 0;
  sunk_ = flat_ = forgiving_ = false;
  engaged_area_ = deepest_ = 0;
  engaged_normal_ = dvec3(0);
}

double ContactFinder::head_distance(const Pose& X_VT, const dvec3& x, dvec3& n) const noexcept {
  if (sphere_) {
    const dvec3 d = x - X_VT.p;
    const double length = glm::length(d);
    n = length > 1e-9 ? d / length : dvec3(0, 0, -1);
    return length - radius_;
  }
  dvec3 n_T;
  const double distance = head_.distance(glm::conjugate(X_VT.R) * (x - X_VT.p), n_T);
  n = X_VT.R * n_T;
  return distance;
}

/// Offset surface (Kim & Park 2006, sec. 3.2): one query at the sphere's centre. Exact where the field outside the tissue is
/// smooth, and nowhere more than the true distance; that it is no less shows in its foot, which lies on the surface. What the
/// stencil must not see shows on the line through both: near an edge the tissue below the foot is less deep (then the edge is
/// made of its faces), and near a medial axis the air above less wide.
bool ContactFinder::find_by_offset(const SurfacePatch& patch, const dvec3& c, ContactSet& set) const noexcept {
  const FieldSample at = sample_cubic(patch, c);
  const double length = glm::length(at.gradient);
  if (at.value < 0.5 || length < 0.5) return false;  // the centre is inside: the field there is not what the offset needs
  dvec3 n = at.gradient / length;
  double distance = at.value;
  const dvec3 below = c - (distance + kBelow) * n;
  const dvec3 above = c + kAbove * n;
  if (!patch.holds(above, 0) || sample_linear(patch, above) < std::min(distance + kAbove, patch.band) - kFootOff) return false;
  if (std::abs(length - 1) > kUnbent || !patch.holds(below, 0) || std::abs(sample_linear(patch, below) + kBelow) > kFootOff) {
    dvec3 foot = c - distance * n;
    if (nearest_on_edge(patch, c, foot, distance, foot)) {
      distance = glm::length(c - foot);
      n = (c - foot) / distance;
    } else {
      // Bent, or its foot in the air: a mixture of two walls'.
      if (std::abs(length - 1) > kUnbent || !patch.holds(foot, 0)) return false;
      if (std::abs(sample_linear(patch, foot)) > kFootOff) return false;
    }
  }
  set.origin_ = c;
  set.put(0, c, {c - distance * n, n, distance - radius_, 1});
  set.count_ = 1;
  set.deepest_ = std::max(0.0, radius_ - distance);
  return true;
}

/// Between flat walls every contact is known as it is, however near the crease.
bool ContactFinder::find_in_crease(const SurfacePatch& patch, const dvec3& c, double near, ContactSet& set) const noexcept {
  const FieldSample at = sample_cubic(patch, c);
  FlatWalls walls;
  if (at.value < 0.5 || glm::length(at.gradient) < 0.1 || !walls_of_crease(patch, c, at, walls)) return false;
  set.origin_ = c;
  for (int i = 0; i < walls.count; ++i) {
    const double gap = walls.height[i] - radius_;
    if (gap >= near) continue;
    set.put(set.count_++, c, {c - walls.height[i] * walls.n[i], walls.n[i], gap, 1, true});
    set.deepest_ = std::max(set.deepest_, -gap);
  }
  set.flat_ = true;
  return true;
}

bool ContactFinder::seat(const SurfacePatch& patch, const dvec3& target, const dvec3& c, dvec3& seated, ContactSet& set,
                         bool& alone) const noexcept {
  if (!sphere_ || !patch.holds(target, kBelow + kMostBehind)) return false;
  FieldSample at = sample_cubic(patch, target);
  double slope = glm::length(at.gradient);
  if (at.value < -kMostBehind || at.value > radius_ || slope < 0.5 || !is_true_around(patch, target, std::abs(at.value))) return false;
  // From the hand onto the wall, and along it to where the hand is straight above or below.
  dvec3 x = target, n;
  double height = 0, uneven = 0;
  for (int step = 0;; ++step) {
    n = at.gradient / slope;
    x -= at.value * n;
    if (!patch.holds(x, 0)) return false;
    height = glm::dot(target - x, n);
    const dvec3 aside = target - x - height * n;
    if (step > 0 && glm::dot(aside, aside) < kStraight) break;
    if (step == kMostSteps) return false;
    x += aside;
    at = sample_cubic(patch, x);
    slope = glm::length(at.gradient);
    uneven = std::abs(slope - 1);
    if (uneven > kUneven) return false;
  }
  const double deep = std::max(kBelow, 1 - height);
  const dvec3 below = x - deep * n, on = target + (radius_ - height) * n;
  if (std::abs(sample_linear(patch, below) + deep) > kFootOff) return false;
  if (height > radius_ || glm::length(on - c) > kMostSeated || !patch.holds(on, 0)) return false;
  seated = on;
  const dvec3 above = on + kAbove * n;
  alone = uneven < kEven && patch.holds(above, 0) && sample_linear(patch, above) >= std::min(radius_ + kAbove, patch.band) - kFootOff;
  if (!alone) return true;
  set.clear();
  set.origin_ = on;
  set.put(0, on, {on - radius_ * n, n, 0, 1});
  set.count_ = 1;
  return true;
}

namespace {

FlatHead flat_head(const FlatPiece* pieces, int count, bool sphere, double radius, const dquat& R, const dvec3& c) {
  FlatHead head{pieces, count, static_cast<float>(c.x), static_cast<float>(c.y), static_cast<float>(c.z), {},
                sphere ? static_cast<float>(radius) : 0.0f, static_cast<float>(radius)};
  const glm::mat3 columns{glm::dmat3(R)};
  for (int i = 0; i < 9; ++i) head.R[i] = columns[i / 3][i % 3];
  return head;
}

}  // namespace

void ContactFinder::find(const SurfacePatch& patch, const Pose& X_VT, double near, ContactSet& set) const noexcept {
  set.clear();
  const bool uncut = patch.cut_lo.x > patch.cut_hi.x ? patch.exact_outside
                                                     : is_true_around(patch, X_VT.p, sample_linear(patch, X_VT.p));
  if (sphere_ && uncut && (find_by_offset(patch, X_VT.p, set) || find_in_crease(patch, X_VT.p, near, set))) return;

  // Floats keep their digits when counted from a voxel nearby.
  const glm::ivec3 base = glm::ivec3(X_VT.p) - (static_cast<int>(reach_) + 8), from = base - patch.lo;
  const FlatHead head =
      flat_head(samples_->pieces, head_.count, sphere_, radius_, X_VT.R, X_VT.p - dvec3(base));
  const std::ptrdiff_t sy = patch.n, sx = sy * sy;
  FlatField field{patch.distance.data() + (from.x * sx + from.y * sy + from.z), static_cast<int>(sx), static_cast<int>(sy), {}, {}};
  for (int i = 0; i < 3; ++i) {
    field.lo[i] = static_cast<float>(std::max(3 - from[i], 0));
    field.hi[i] = static_cast<float>(patch.n - 4 - from[i]);
  }
  Found found{};
  look_around(samples_.get(), &head, &field, static_cast<float>(near), &set.rough_, &found);
  set.origin_ = X_VT.p;
  set.count_ = found.count;
  set.deepest_ = static_cast<double>(found.deepest);
  set.engaged_area_ = static_cast<double>(found.area);
  const dvec3 out(found.area_x, found.area_y, found.area_z);
  set.engaged_normal_ = sphere_ ? -out : -(X_VT.R * out);
  std::fill_n(set.rough_.yields, found.count, 1.0f);
}

void ContactFinder::forgive(const Pose& X_VE, const Pose& X_VT, ContactSet& set) const noexcept {
  if (set.sunk_ || set.exact_count_ > 0) return;  // what is exact already was found where nothing was cut
  set.forgiving_ = true;
  set.emptied_ = X_VE;
  const FlatHead head = flat_head(samples_->pieces, head_.count, sphere_, radius_, X_VE.R, dvec3(0));
  const glm::vec3 from(X_VE.p - set.origin_);
  come_out(&head, &set.rough_, set.count_, &from.x);
  if (same(X_VE, X_VT)) set.deepest_ = 0;
  else relinearize(X_VT, set);
}

void ContactFinder::find_way_out(const SurfacePatch& patch, const Pose& X_VT, ContactSet& set) const noexcept {
  set.count_ = set.exact_count_ = set.added_ = 0;
  set.deepest_ = 0;
  set.origin_ = X_VT.p;
  set.sunk_ = true;
  RoughPlanes& planes = set.rough_;
  const auto add = [&](const dvec3& p, double beyond) {
    const FieldSample at = sample_linear_gradient(patch, X_VT.p + p);
    const double slope = glm::length(at.gradient), gap = at.value - beyond;
    if (gap >= 0 || slope < 0.5 || set.count_ == ContactSet::kMax) return;
    const glm::vec3 n(at.gradient / slope), x(p - at.value * dvec3(n));
    const int i = set.count_++;
    planes.x[i] = x.x, planes.y[i] = x.y, planes.z[i] = x.z;
    planes.nx[i] = n.x, planes.ny[i] = n.y, planes.nz[i] = n.z;
    planes.gap[i] = static_cast<float>(gap), planes.yields[i] = 1;
    set.deepest_ = std::max(set.deepest_, -gap);
  };
  if (sample_linear(patch, X_VT.p) < 0) add(dvec3(0), sphere_ ? radius_ : 0);
  for (int i = 0; i < ContactSet::kMax; ++i) add(X_VT.R * dvec3(samples_->px[i], samples_->py[i], samples_->pz[i]), 0);
}

void ContactFinder::relinearize(const Pose& X_VT, ContactSet& set) const noexcept {
  const FlatHead head = flat_head(samples_->pieces, head_.count, sphere_, radius_, X_VT.R, dvec3(0));
  const glm::vec3 moved(X_VT.p - set.origin_);
  set.deepest_ = static_cast<double>(look_again(&head, &set.rough_, set.count_, &moved.x));
  for (int k = 0; k < set.exact_count_; ++k) {
    see_again(X_VT, set.exact_[static_cast<std::size_t>(k)].plane);
  }
}

void ContactFinder::see_again(const Pose& X_VT, ContactPlane& plane) const noexcept {
  if (plane.rim) {
    plane.gap = glm::dot(plane.n, farthest(X_VT, -plane.n) - plane.x);
    return;
  }
  plane.gap = head_distance(X_VT, plane.x, plane.n);
  plane.n = -plane.n;
}

bool ContactFinder::refine(const SurfacePatch& patch, const Pose& X_VT, ContactSet& set, int i, bool fine) const noexcept {
  if (set.sunk_ || set.flat_ || i >= set.own()) return false;
  const ContactSet::Exact* known = set.exact(i);
  const double stays = fine ? kFineStays : sphere_ ? kStaysExact : kStaysExactEdged;
  if (known && glm::length(known->c - X_VT.p) < stays) return false;
  const ContactPlane rough = set.plane(i);
  if (!patch.holds(rough.x, 0)) return false;
  // From a point near the surface: onto it, then along it toward the head, as long as that brings them closer.
  // Each slide is the same share of the one before on a surface that bends evenly: a fine one goes all the way (secant method).
  ContactPlane best;
  best.gap = 1e300;
  dvec3 x = rough.x, last_slide(0);
  double gain = 1;
  for (int step = 0; step < (fine ? kFineSteps : kExactSteps); ++step) {
    if (step > 0 && !patch.holds(x, 0)) break;
    const FieldSample field = sample_cubic(patch, x);
    const double length = glm::length(field.gradient);
    if (length < 0.1) break;
    const dvec3 n = field.gradient / length;
    x -= field.value * n;
    if (std::abs(field.value) > static_cast<double>(kOnSurface)) continue;
    dvec3 m;
    const double gap = head_distance(X_VT, x, m), gained = best.gap - gap;
    if (!(gained > 0)) break;
    best = {x, -m, gap, rough.yields};
    if (gained < (fine ? kFineGained : kGained)) break;
    const dvec3 slide = -(radius_ + gap) * (m - glm::dot(m, n) * n);
    if (fine) {
      const double before2 = glm::dot(last_slide, last_slide);
      const double share = before2 > 0 ? glm::dot(slide, last_slide) / before2 : 0;
      gain = share != 0 && std::abs(share) < kStillConverges ? std::min(gain / (1 - share), kMostGain) : 1;
      last_slide = slide;
    }
    x += gain * slide;
  }
  if (best.gap >= rough.gap + 0.5) best = rough;
  if (set.forgiving_ && best.gap < 0) {
    dvec3 n;
    const double off = head_distance(set.emptied_, best.x, n);
    if (off < 0) {
      best.x -= off * n;
      see_again(X_VT, best);
    }
  }
  const bool rim = fine && touch_with_rim(patch, X_VT, best);
  set.put(i, X_VT.p, best);
  if (rim) set.put_beside(best);
  return true;
}

/// The point of the head that lies farthest along a unit direction: on the rim of one of its pieces, or on an arc.
dvec3 ContactFinder::farthest(const Pose& X_VT, const dvec3& along) const noexcept {
  const dvec3 d = glm::conjugate(X_VT.R) * along;
  const double out = std::hypot(d.x, d.y);
  glm::dvec2 best(0);
  double most = -1e300;
  const auto try_point = [&](double rho, double z) {
    if (const double reach = out * rho + d.z * z; reach > most) most = reach, best = {rho, z};
  };
  for (int i = 0; i < head_.count; ++i) {
    const HeadField::Piece& piece = head_.pieces[i];
    try_point(piece.ax, piece.az);
    try_point(piece.bx, piece.bz);
    if (piece.radius == 0) continue;
    const double ux = piece.ax - piece.cx, uz = piece.az - piece.cz, wx = piece.bx - piece.cx, wz = piece.bz - piece.cz;
    if (ux * d.z - uz * out >= 0 && out * wz - d.z * wx >= 0) try_point(piece.cx + piece.radius * out, piece.cz + piece.radius * d.z);
  }
  const dvec3 side = out > 1e-12 ? dvec3(d.x, d.y, 0) / out : dvec3(1, 0, 0);
  return X_VT.p + X_VT.R * (best.x * side + dvec3(0, 0, best.y));
}

/// Where a sharp rim has sunk into smooth tissue the two sides of the rim each push their own way, and between them aside.
/// The way out is the tissue's normal at the rim's deepest point.
bool ContactFinder::touch_with_rim(const SurfacePatch& patch, const Pose& X_VT, ContactPlane& plane) const noexcept {
  if (sphere_ || !patch.holds(plane.x, 0)) return false;
  FieldSample field = sample_cubic(patch, plane.x);
  double slope = glm::length(field.gradient);
  if (std::abs(slope - 1) > kSmooth) return false;
  const dvec3 wall = field.gradient / slope;
  if (glm::dot(plane.n, wall) > kAskew) return false;
  dvec3 n = wall, q;
  for (int step = 0; step < 2; ++step) {
    q = farthest(X_VT, -n);
    if (!patch.holds(q, 0)) return false;
    field = sample_cubic(patch, q);
    slope = glm::length(field.gradient);
    if (std::abs(slope - 1) > kSmooth) return false;
    n = field.gradient / slope;
  }
  const double gap = field.value / slope;
  if (glm::dot(n, wall) < kSameWall || glm::length(q - plane.x) > kNearRim + 2 * std::abs(gap)) return false;
  plane = {q - gap * n, n, gap, plane.yields, true};
  return true;
}

}  // namespace typodont::haptics
