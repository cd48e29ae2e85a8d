// Motion of heads that are not balls. A head is convex, so the depth of a sample is a concave function of its
// position. During a short motion, a sample moves along a straight line in the head's frame. So its depth along the
// path is a concave curve with a single maximum, and a search finds this maximum. For a long motion, the search runs
// for all samples; for a short motion, only for the samples near their maximum.
#include "haptics/cutting/way.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "engine/base/dispatch.h"
#include "haptics/cutting/block.h"
#include "haptics/cutting/lane_ops.h"
#include "haptics/label.h"
#include "haptics/share.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

namespace eight {
namespace {
#include "haptics/cutting/cut_kernel.h"
#include "haptics/cutting/depth_kernel.h"
#include "haptics/cutting/row_kernel.h"
#include "haptics/cutting/way_kernel.h"
}  // namespace
}  // namespace eight

namespace {

constexpr int kSteps = 24;  // upper limit of the steps of one search; almost every search needs fewer than ten
// voxels, upper bound of the error when a block of samples is evaluated at its centre
constexpr float kBesideSlip = 0.5f;

/// Restricts the range `lowest` .. `highest` of z coordinates in a column of blocks of samples. It keeps the blocks
/// that are nearer than `far` (voxels) to the head's axis. The blocks' centres have the offset `off` (x, y) from a
/// point of the axis at the z coordinate `height`. Returns false if no block of samples remains.
bool column_beside_axis(const glm::vec2& off, const glm::vec3& axis, float far, float height, int& lowest,
                        int& highest) {
  // the condition |d|² - (d·a)² <= far² with d = (off, z) is quadratic in z
  const float along = off.x * axis.x + off.y * axis.y;
  const float a = 1 - axis.z * axis.z, b = -along * axis.z, c = glm::dot(off, off) - along * along - far * far;
  if (a < 1e-3f) return true;
  const float root2 = b * b - a * c;
  if (root2 < 0) return false;
  const float root = std::sqrt(root2);
  const int from = static_cast<int>(std::floor(height + (-b - root) / a)) - 1,
            to = static_cast<int>(std::ceil(height + (-b + root) / a)) + 1;
  lowest = std::max(lowest, from - kDeep);
  highest = std::min(highest, to);
  return lowest <= highest;
}

/// Eight points in the head's frame.
struct Points {
  F8 x, y, z;
};

TYPODONT_KERNEL Points in_head(const HeadPose& pose, const F8& x, const F8& y, const F8& z) {
  const float* const R = pose.R;
  const F8 vx = x - pose.p[0], vy = y - pose.p[1], vz = z - pose.p[2];
  return {(R[0] * vx + R[3] * vy) + R[6] * vz, (R[1] * vx + R[4] * vy) + R[7] * vz,
          (R[2] * vx + R[5] * vy) + R[8] * vz};
}

/// Depth of samples at a point of their path, and its derivative along the path.
struct Depth {
  F8 depth, slope;
};

/// Searches the largest depths of eight samples, with the tolerance kTop. The search for a sample ends when the
/// sample's depth certainly does not exceed `needed`, or when it exceeds `most`. A concave curve lies below its
/// tangents, so the intersection of the tangents on both sides of the maximum is an upper bound. The search point
/// alternates between this intersection (exact for a corner) and the maximum of a parabola.
struct Search {
  unsigned set;  // one bit for each piece of the head's meridian that can be nearest to one of the samples on this path
  Points from, way;  // `from`: start positions of the samples; `way`: vectors of their paths; both in the head's frame
  // fractions of the path, 0..1: the largest depth of the sample lies between a and b, and is now searched at s
  F8 a, b, s;
  Depth at_a, at_b;
  F8 best, top, needed;
  I8 open;

  TYPODONT_KERNEL Points place(const F8& share) const {
    return {from.x + share * way.x, from.y + share * way.y, from.z + share * way.z};
  }
  TYPODONT_KERNEL eight::NearestWithNormal nearest(const Straight& head, const F8& rho, const F8& z) const {
    return eight::nearest_with_normal(head.pieces, set, rho, z);
  }
  TYPODONT_KERNEL Depth at(const Straight& head, const F8& share) const {
    const Points p = place(share);
    const F8 rho = eight::root(p.x * p.x + p.y * p.y);
    const eight::NearestWithNormal found = nearest(head, rho, p.z);
    return {found.nearest.depth(), found.slope(p.x, p.y, rho, way.x, way.y, way.z)};
  }
  /// Returns the outward normal at the fraction `share` of the path, in the head's frame.
  TYPODONT_KERNEL Points normal(const Straight& head, const F8& share) const {
    const Points p = place(share);
    const F8 rho = eight::root(p.x * p.x + p.y * p.y), inverse = 1.0f / (rho + 1e-6f);
    F8 n_rho, n_z;
    nearest(head, rho, p.z).normal(n_rho, n_z);
    return {n_rho * p.x * inverse, n_rho * p.y * inverse, n_z};
  }
  /// Begins the search at the fraction `share` of the path. x, y, z: positions of the samples, in voxels relative to
  /// HeadPose::base of the path's first pose.
  TYPODONT_KERNEL void begin(const Straight& head, unsigned pieces, const F8& x, const F8& y, const F8& z,
                             const F8& least, float share, float most) {
    const float* const T = head.turn;
    set = pieces;
    from = in_head(head.from, x, y, z);
    way = {(T[0] * from.x + T[3] * from.y) + (T[6] * from.z + head.shift[0]),
           (T[1] * from.x + T[4] * from.y) + (T[7] * from.z + head.shift[1]),
           (T[2] * from.x + T[5] * from.y) + (T[8] * from.z + head.shift[2])};
    needed = least - head.slip;
    a = b = F8{} + share;
    at_a = at_b = at(head, a);
    best = at_a.depth;
    const I8 rises = at_a.slope > 0.0f;
    s = rises ? F8{} + 1.0f : F8{};
    top = best + at_a.slope * (s - a);
    open = (best < most) & (top > best + kTop) & (top > needed);
  }
  TYPODONT_KERNEL void step(const Straight& head, int number, float most) {
    const Depth now = at(head, s);
    best = open ? eight::greater(best, now.depth) : best;
    // The result for one sample does not depend on the other samples. If the curve rises towards an end, the maximum is
    // at that end.
    const I8 rises = (now.slope > 0.0f) & (s < 1.0f), before = open & (rises | (s <= 0.0f)), after = open & ~before;
    a = before ? s : a, at_a.depth = before ? now.depth : at_a.depth, at_a.slope = before ? now.slope : at_a.slope;
    b = after ? s : b, at_b.depth = after ? now.depth : at_b.depth, at_b.slope = after ? now.slope : at_b.slope;
    const I8 between = (at_a.slope > 0.0f) & (at_b.slope < 0.0f);
    const F8 rest = b - a, turn = at_a.slope - at_b.slope;
    const F8 inverse = 1.0f / eight::greater(turn, eight::all(1e-9f));
    const F8 by = eight::greater(eight::lesser((at_b.depth - at_a.depth - at_b.slope * rest) * inverse, rest), F8{});
    top = open ? between ? at_a.depth + at_a.slope * by : best : top;
    s = open & between ? a + (number % 2 == 0 ? by : at_a.slope * rest * inverse) : s;
    open &= (best < most) & (top > best + kTop) & (top > needed);
  }
};

/// The centres of eight blocks of samples, and the largest depth of each centre in the head during the motion. The
/// depth is a concave function of the position. So a linear function of the position (see n_x, n_y, n_z) is an upper
/// bound of the depth of every sample of a block of samples.
struct Centres {
  unsigned set;  // input: pieces of the head's meridian that can be nearest to any of the centres on the path
  // input, two limits of the depth: if no sample of a block of samples is deeper than `outside`, or all samples are
  // deeper than `emptied`, the block is treated as a whole
  float outside, emptied;
  F8 x, y, z;    // voxels, positions of the centres, relative to the base voxel of the first pose
  F8 best, top;  // lower and upper bound of the largest depth of each centre
  // Vector n out of the head. A sample at the offset d (voxels) from a block's centre is, up to rounding and the
  // head's rotation, at most `top` − n · d deep in the head.
  F8 n_x, n_y, n_z;
  F8 share;  // fraction of the path at which the centres are deepest
};

TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void look_at(const Straight* way_at, Centres* centres) {
  const Straight& way = *way_at;
  Search search;
  search.begin(way, centres->set, centres->x, centres->y, centres->z, eight::all(centres->outside), 0.5f,
               centres->emptied);
  for (int step = 0; step < kSteps && any_of(search.open); ++step) search.step(way, step, centres->emptied);
  // The tangents at a and at b both bound the depth from above. A weighted mean of the two tangents is also a bound.
  // The weights are chosen so that this mean is constant along the path.
  const F8 up = search.at_a.slope, down = search.at_b.slope;
  const I8 at_a = up <= 0.0f, at_b = ~at_a & (down >= 0.0f);
  const F8 part = at_a ? eight::all(1) : at_b ? F8{} : down / (down - up);
  const Points a = search.normal(way, search.a), b = search.normal(way, search.b);
  const F8 nx = b.x + part * (a.x - b.x), ny = b.y + part * (a.y - b.y), nz = b.z + part * (a.z - b.z);
  const float* const R = way.from.R;
  centres->n_x = R[0] * nx + R[1] * ny + R[2] * nz;
  centres->n_y = R[3] * nx + R[4] * ny + R[5] * nz;
  centres->n_z = R[6] * nx + R[7] * ny + R[8] * nz;
  centres->best = search.best, centres->top = search.top;
  centres->share = at_a ? search.a : at_b ? search.b : search.s;
}

/// Data of the centres at the beginning of the path: their depths in the head, and their distances from each of its
/// pieces of the head's meridian.
struct AtStart {
  F8 depth, to_piece[HeadField::kMaxPieces];
  Points at;  // positions of the centres in the head's frame
  F8 rho;     // voxels, distances of the centres from the head's axis
  // Mask of the blocks of samples from which the head recedes, at all their samples. The depth is concave along the
  // path, so each sample of such a block of samples is deepest at the beginning of the path.
  I8 recedes;

  /// Returns the pieces of the head's meridian (one bit each) that can be nearest to a sample within `reach` of the
  /// centre's initial position.
  unsigned nearest_within(float reach, int lane, int count) const {
    unsigned set = 0;
    for (int i = 0; i < count; ++i) {
      set |= static_cast<unsigned>(to_piece[i][lane] <= std::abs(depth[lane]) + 2 * reach) << i;
    }
    return set;
  }
};

TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void look_at_start(const Straight* way_at, const Centres* centres, AtStart* found) {
  const Straight& way = *way_at;
  const Points p = in_head(way.from, centres->x, centres->y, centres->z);
  const F8 rho = eight::root(p.x * p.x + p.y * p.y);
  found->depth = eight::depth_below_pieces(way.pieces, (1u << way.count) - 1, rho, p.z);
  found->at = p, found->rho = rho;
}

/// Computes AtStart::recedes for eight centres at once. The method is that of advance_beside(), but only the smallest
/// n·w is computed. `rounding`: voxels, rounding error of the component of a path along a normal.
TYPODONT_KERNEL I8 receding(const Straight& way, const AtStart& at, float rounding) {
  const float* const T = way.turn;
  const F8 x = at.at.x, y = at.at.y, z = at.at.z, none = {};
  const F8 wx = (T[0] * x + T[3] * y) + (T[6] * z + way.shift[0]),
           wy = (T[1] * x + T[4] * y) + (T[7] * z + way.shift[1]),
           wz = (T[2] * x + T[5] * y) + (T[8] * z + way.shift[2]);
  // Finds the first and the last normal of the neighbouring meridian pieces that can be nearest to a sample of the
  // block of samples.
  const F8 within = (at.depth > 0.0f ? at.depth : -at.depth) + 2 * kHalf;
  F8 first_x = none, first_z = none, last_x = none, last_z = none;
  I8 from_axis = {};
  for (int i = 0; i < way.count; ++i) {
    const MeridianPiece& piece = way.pieces[i];
    const I8 near = at.to_piece[i] <= within;
    last_x = near ? eight::all(piece.nbx) : last_x, last_z = near ? eight::all(piece.nbz) : last_z;
  }
  for (int i = way.count - 1; i >= 0; --i) {
    const MeridianPiece& piece = way.pieces[i];
    const I8 near = at.to_piece[i] <= within;
    first_x = near ? eight::all(piece.nax) : first_x, first_z = near ? eight::all(piece.naz) : first_z;
    from_axis = near ? I8{} - (piece.ax == 0.0f) : from_axis;
  }
  const I8 tip = from_axis & (at.rho < kHalf + Sweep::kMargin);
  first_x = tip ? none : first_x, first_z = tip ? eight::all(-1) : first_z;
  // Computes the smallest component of the motion w away from the axis, over all points within kHalf of the centre.
  const F8 across = eight::root(wx * wx + wy * wy), inverse = 1.0f / eight::greater(at.rho, eight::all(kHalf));
  const F8 ux = x * inverse, uy = y * inverse, sine = kHalf * inverse, radial = wx * ux + wy * uy;
  const F8 cosine = eight::root(eight::greater(1.0f - sine * sine, none)), around = wx * uy - wy * ux;
  const F8 round = around < 0.0f ? -around : around;
  const I8 beside = (at.rho > kHalf) & (round * cosine > -radial * sine);
  const F8 away = beside ? round * sine - radial * cosine : across, along = -wz;
  const I8 between = (first_x * along >= first_z * away) & (away * last_z >= along * last_x);
  const F8 ends = eight::greater(first_x * away + first_z * along, last_x * away + last_z * along);
  // the largest n·w on the path back; its negative value is the smallest n·w of the motion
  const F8 approach = between ? eight::root(away * away + along * along) : ends;
  return -approach >= way.turned * kHalf + rounding;
}

/// Computes the distance of each centre from each piece of the meridian. It is called only if a centre is not outside
/// the head, because most centres are outside.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void look_at_pieces(const Straight* way_at, AtStart* found, float rounding) {
  const Straight& way = *way_at;
  for (int i = 0; i < way.count; ++i) {
    // The kernel assigns an arc's second end to the next piece of the head's meridian, so the distance from this end is
    // computed here.
    const F8 depth = eight::depth_below_pieces(way.pieces, 1u << i, found->rho, found->at.z),
             off_rho = found->rho - way.pieces[i].bx, off_z = found->at.z - way.pieces[i].bz;
    found->to_piece[i] = eight::lesser(depth > 0.0f ? depth : -depth, eight::root(off_rho * off_rho + off_z * off_z));
  }
  found->recedes = receding(way, *found, rounding);
}

/// Returns the smallest depth of the samples of a block of samples in the head at the beginning of the path. `first`:
/// first sample of the block, relative to the base voxel of the first pose. Depth is concave, so it is smallest at a
/// corner of the block.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
float least_depth_at_start(const Straight* way_at, const glm::ivec3* first) {
  const Straight& way = *way_at;
  constexpr float kX = kRows - 1, kZ = kDeep - 1;
  const F8 x = static_cast<float>(first->x) + F8{0, 0, 0, 0, kX, kX, kX, kX},
           y = static_cast<float>(first->y) + F8{0, 0, kX, kX, 0, 0, kX, kX},
           z = static_cast<float>(first->z) + F8{0, kZ, 0, kZ, 0, kZ, 0, kZ};
  const Points p = in_head(way.from, x, y, z);
  const F8 depth =
      eight::depth_below_pieces(way.pieces, (1u << way.count) - 1, eight::root(p.x * p.x + p.y * p.y), p.z);
  float least = depth[0];
  for (int i = 1; i < 8; ++i) least = depth[i] < least ? depth[i] : least;
  return least;
}

/// A block, the part of it that is processed, and bounds of the depth, computed at the block's centre.
struct WayBlock {
  float* distance;
  const Tissue* tissue;
  std::ptrdiff_t stride_x, stride_y;
  int from[3], to[3];
  glm::ivec3 first;  // first sample of the block of samples, relative to the base voxel of the first pose
  float top, n[3], share;
  // voxels, upper bound of the error when the depth at the centre is used for the other samples of the block of samples
  float bent;
  float* due;    // receives the path length at which the block of samples is due again; null: the value is not stored
  unsigned set;  // the pieces of the meridian that can be nearest to any sample on the path, one bit for each piece
  bool emptied;

  /// A plane bounds the depth in each row of the block of samples. Returns the bound of the row through the centre
  /// minus the bound of row (ix, iy).
  float off(int ix, int iy) const {
    return n[0] * (static_cast<float>(ix) - kMiddle.x) + n[1] * (static_cast<float>(iy) - kMiddle.y);
  }
  /// Returns the plane's upper bound of all depths in the row through the block's centre.
  float most() const { return top + bent + std::abs(n[2]) * kMiddle.z; }
  /// Returns the distance (voxels) by which the upper bound of the depths in a row is below -kMargin, the smallest
  /// value of any sample. If the result is not negative, the row cannot change.
  float unread(int ix, int iy) const { return emptied ? -1.0f : -Sweep::kMargin - (most() - off(ix, iy)); }
  /// Returns the plane's upper bound of all depths in the block of samples.
  float most_of_all() const { return most() + std::abs(n[0]) * kMiddle.x + std::abs(n[1]) * kMiddle.y; }
  bool may_change() const { return emptied || most_of_all() > -Sweep::kMargin; }
};

/// Prefetches those rows of a block of samples that carve_way_block will read.
void fetch(const WayBlock& block) {
  for (int ix = block.from[0]; ix < block.to[0]; ++ix) {
    for (int iy = block.from[1]; iy < block.to[1]; ++iy) {
      if (block.unread(ix, iy) < 0) {
        __builtin_prefetch(block.distance + ix * block.stride_x + iy * block.stride_y, 1);
      }
    }
  }
}

/// Sets each sample to max(sample, min(depth, kInner)); depths below -kMargin are ignored. Returns true if any sample
/// changed. `slack`: distance in voxels that the head may still move before any sample of these rows can change.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
bool carve_way_block(const Straight* way_at, const WayBlock* block_at, RemovedVolume* removed, float* slack) {
  const Straight& way = *way_at;
  const WayBlock& block = *block_at;
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7}, bound = block.top + block.bent - block.n[2] * (steps - kMiddle.z);
  const F8 z = static_cast<float>(block.first.z) + steps;
  // All rows are processed step by step together, so that the processor need not wait for the result of each step.
  constexpr int kAll = kRows * kRows;
  const bool whole = block.from[2] == 0 && block.to[2] == kDeep;
  Search searches[kAll];
  std::ptrdiff_t at[kAll];
  int rows = 0, open = 0, still_open[kAll];
  float unread = kNoEnd;    // voxels, smallest slack (motion until a sample can change) of the rows that are not read
  F8 read = F8{} + kNoEnd;  // voxels, smallest slack of the rows that are read but cannot change in this motion
  for (int ix = block.from[0]; ix < block.to[0]; ++ix) {
    for (int iy = block.from[1]; iy < block.to[1]; ++iy) {
      if (const float room = block.unread(ix, iy); room >= 0) {
        unread = std::min(unread, room);
        continue;
      }
      at[rows] = ix * block.stride_x + iy * block.stride_y;
      const F8 old = eight::Row{block.distance + at[rows], block.from[2], block.to[2], whole}.read();
      const I8 full = old >= Sweep::kInner;  // samples that already have the largest value that a cut writes
      const float off = block.off(ix, iy);
      const F8 least = full ? F8{} + kNoEnd : eight::greater(old, F8{} - Sweep::kMargin);
      if (!any_of(block.emptied ? ~full : bound - off > least)) {
        read = eight::lesser(read, least - (bound - off));
        continue;
      }
      Search& search = searches[rows];
      if (block.emptied) {
        search.best = F8{} + Sweep::kInner;
      } else {
        search.begin(way, block.set, eight::all(static_cast<float>(block.first.x + ix)),
                     eight::all(static_cast<float>(block.first.y + iy)), z, least, block.share, Sweep::kInner);
        still_open[open] = rows;
        open += any_of(search.open);
      }
      ++rows;
    }
  }
  *slack = unread;
  for (int i = 0; i < 8; ++i) *slack = std::min(*slack, read[i]);
  if (rows > 0) *slack = block.emptied ? kNoEnd : 0;
  for (int step = 0; step < kSteps && open > 0; ++step) {
    int left = 0;
    for (int i = 0; i < open; ++i) {
      Search& search = searches[still_open[i]];
      search.step(way, step, Sweep::kInner);
      still_open[left] = still_open[i];
      left += any_of(search.open);
    }
    open = left;
  }
  bool changed = false;
  eight::Taken taken{removed};
  for (int row = 0; row < rows; ++row) {
    const eight::Row samples{block.distance + at[row], block.from[2], block.to[2], whole};
    const F8 old = samples.read(), depth = eight::lesser(searches[row].best, F8{} + Sweep::kInner);
    const I8 raised = depth > eight::greater(old, F8{} - Sweep::kMargin);
    if (!any_of(raised)) continue;
    changed = true;
    samples.write(old, raised ? depth : old, removed ? block.tissue + at[row] : nullptr, taken);
  }
  if (removed) taken.close();
  return changed;
}

/// Searches the largest depths of eight listed samples on their paths, and raises the samples to these depths.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
bool carve_tops(PathMaxima* tops_at, int first) {
  PathMaxima& tops = *tops_at;
  const int count = std::min(tops.count - first, 8);
  F8 x, y, z, old;
  for (int i = 0; i < 8; ++i) {
    const int lane = first + std::min(i, count - 1);
    x[i] = tops.x[lane], y[i] = tops.y[lane], z[i] = tops.z[lane], old[i] = *tops.at[lane];
  }
  Search search;
  const F8 least = eight::greater(old, F8{} - Sweep::kMargin);
  search.begin(tops.back, (1u << tops.back.count) - 1, x, y, z, least, 0, Sweep::kInner);
  // The first step of the search evaluates the other end of the path. If the maximum is there, the sample was already
  // cut there, with the same bits.
  search.step(tops.back, 0, Sweep::kInner);
  const F8 at_ends = search.best;
  for (int step = 1; step < kSteps && any_of(search.open); ++step) search.step(tops.back, step, Sweep::kInner);
  const F8 depth = eight::lesser(search.best, F8{} + Sweep::kInner);
  const unsigned raised = bits_of((depth > least) & (search.best > at_ends + kTop));
  for (int i = 0; i < count; ++i) {
    if (!(raised >> i & 1)) continue;
    *tops.at[first + i] = depth[i];
    if (tops.removed)
      tops.removed->add(inside_units(old[i]) - inside_units(depth[i]), static_cast<Tissue>(tops.label[first + i]),
                        tops.at[first + i]);
  }
  return raised & ((1u << count) - 1);
}

}  // namespace

void PathMaxima::carve() noexcept {
  for (int first = 0; first < count; first += 8) changed |= carve_tops(this, first);
  count = 0;
}

Straight straight_way(const Pose& X_VA, const Pose& X_VB, const MeridianPiece* pieces, int count, double reach) {
  const glm::dmat3 R_AV = glm::transpose(glm::dmat3(X_VA.R)), R_BV = glm::transpose(glm::dmat3(X_VB.R));
  const dvec3 moved = R_BV * (X_VA.p - X_VB.p);
  // Computes the rotation matrix minus the identity matrix, without loss of digits by cancellation.
  const glm::dmat3 turn = (R_BV - R_AV) * glm::transpose(R_AV);
  Straight way{.from = head_pose(X_VA),
               .shift = {},
               .turn = {},
               .pieces = pieces,
               .count = count,
               .turned = 0,
               .longest = 0,
               .slip = 0};
  double turned = 0;
  for (int i = 0; i < 3; ++i) {
    way.shift[i] = static_cast<float>(moved[i]);
    for (int j = 0; j < 3; ++j) way.turn[3 * i + j] = static_cast<float>(turn[i][j]), turned += turn[i][j] * turn[i][j];
  }
  // `turn` is a rotation matrix minus the identity matrix. Half of the sum of its squared elements is the squared chord
  // of the rotation angle.
  const double beyond = static_cast<double>(Sweep::kMargin) + 1;
  way.turned = static_cast<float>(std::sqrt(turned / 2));
  way.longest = static_cast<float>(glm::length(moved) + std::sqrt(turned / 2) * (reach + beyond)) + 1e-5f;
  // Upper bound of the error of a tangent. It has three parts: rounding; near a corner, twice the distance to the
  // corner; and the rounding of the path's direction.
  way.slip = 1e-3f + 4e-6f * static_cast<float>(reach) + 2 * kNear + 1e-3f * way.longest;
  return way;
}

float* DueBlocks::row(const glm::ivec3& voxel, int last_z) const noexcept {
  const glm::ivec3 step(kRows, kRows, kDeep), i = voxel / step - first;
  if (i.x < 0 || i.y < 0 || i.z < 0 || i.x >= size.x || i.y >= size.y) return nullptr;
  if (i.z + (last_z - voxel.z) / kDeep >= size.z) return nullptr;
  return due + (i.x * size.y + i.y) * size.z + i.z;
}

bool Sweep::carve_way(const HeadTarget& target, RemovedVolume* removed, const DueBlocks* known) const noexcept {
  const auto down = [](int v, int step) { return v - (v % step + step) % step; };
  const float turned = static_cast<float>(turn_ / straights_) * kHalf;
  const double radius = static_cast<double>(radius_);
  const float rounding = 4e-6f * (static_cast<float>(reach_) + 8);
  const auto axis_of = [](const Pose& X) { return X.R * dvec3(0, 0, 1); };
  // voxels, distance around the head that the cut can reach, including one voxel for the error of a straight path
  const double beside = static_cast<double>(kMargin) + 1;
  const auto extent = [&](const Pose& X) {
    const dvec3 axis = axis_of(X), across = glm::sqrt(glm::max(dvec3(1) - axis * axis, dvec3(0)));
    return half_length_ * glm::abs(axis) + radius * across + beside;
  };
  const auto block_at = [&](const glm::ivec3& first) {
    WayBlock block;
    const glm::ivec3 inside = first - target.lo;
    const std::ptrdiff_t at = inside.x * target.stride_x + inside.y * target.stride_y + inside.z;
    block.distance = target.distance + at, block.tissue = target.tissue ? target.tissue + at : nullptr;
    block.stride_x = target.stride_x, block.stride_y = target.stride_y;
    const int size[3] = {kRows, kRows, kDeep};
    for (int i = 0; i < 3; ++i) {
      block.from[i] = std::max(-inside[i], 0);
      block.to[i] = std::min(target.size[i] - inside[i], size[i]);
    }
    block.first = first;
    return block;
  };
  const auto is_whole = [&](const glm::ivec3& first) {
    return glm::all(glm::lessThanEqual(target.lo, first)) &&
           glm::all(glm::lessThanEqual(first + glm::ivec3(kRows, kRows, kDeep), target.lo + target.size));
  };
  bool changed = false;
  Pose X_VB = X_VA_;
  for (int k = 1; k <= straights_; ++k) {
    const Pose X_VA = X_VB;
    X_VB = k == straights_ ? X_VB_ : interpolate(X_VA_, X_VB_, static_cast<double>(k) / straights_);
    const Straight way = straight_way(X_VA, X_VB, pieces_, back_.count, reach_);
    const dvec3 extent_a = extent(X_VA), extent_b = extent(X_VB);
    const glm::ivec3 lo = glm::max(target.lo, glm::ivec3(glm::ceil(glm::min(X_VA.p - extent_a, X_VB.p - extent_b))));
    const glm::ivec3 last =
        glm::min(target.lo + target.size - 1, glm::ivec3(glm::floor(glm::max(X_VA.p + extent_a, X_VB.p + extent_b))));
    // Blocks with a distance of more than `far` from the head's axis at A (the start of the sweep) stay outside the
    // head on the whole path.
    const glm::vec3 axis(axis_of(X_VA)), center(X_VA.p - dvec3(way.from.base));
    const float far = static_cast<float>(radius + beside) + kHalf + way.longest;
    const glm::ivec3 first(down(lo.x, kRows), down(lo.y, kRows), down(lo.z, kDeep));
    Centres centres, starts;
    centres.outside = -(kMargin + kHalf + kTop + way.slip), centres.emptied = kInner + kHalf + way.slip;
    WayBlock blocks[8];
    glm::ivec3 begun[8];
    // for each block of samples: pointer to the stored path length at which it must be examined again; null: the value
    // is not stored
    float* due[8];
    const auto note = [&](float* at, float slack) {
      // Only the last segment of the path determines the path length at which a block of samples must be examined
      // again.
      if (at && k == straights_) *at = known->way + (slack - known->slip);
    };
    int lanes = 0, started = 0;
    const auto put = [](Centres& to, int lane, const glm::vec3& c) {
      to.x[lane] = c.x, to.y[lane] = c.y, to.z[lane] = c.z;
    };
    const auto fill_up = [](Centres& to, int from) {
      for (int lane = from; lane < 8; ++lane) to.x[lane] = to.x[0], to.y[lane] = to.y[0], to.z[lane] = to.z[0];
    };
    const auto carve = [&] {
      fill_up(centres, lanes);
      centres.set = 0;
      for (int lane = 0; lane < lanes; ++lane) centres.set |= blocks[lane].set;
      look_at(&way, &centres);
      int kept[8], keep = 0;
      for (int lane = 0; lane < lanes; ++lane) {
        WayBlock& block = blocks[lane];
        if (centres.top[lane] <= centres.outside) {
          note(block.due, centres.outside - centres.top[lane]);
          continue;
        }
        block.first -= way.from.base;
        block.top = centres.top[lane], block.share = centres.share[lane],
        block.emptied = centres.best[lane] >= centres.emptied;
        block.bent = way.slip + kTop + turned;
        block.n[0] = centres.n_x[lane], block.n[1] = centres.n_y[lane], block.n[2] = centres.n_z[lane];
        if (!block.may_change()) {
          note(block.due, -kMargin - block.most_of_all());
          continue;
        }
        fetch(block);
        kept[keep++] = lane;
      }
      for (int i = 0; i < keep; ++i) {
        float slack;
        changed |= carve_way_block(&way, &blocks[kept[i]], removed, &slack);
        note(blocks[kept[i]].due, slack);
      }
      lanes = 0;
    };
    // Omits blocks of samples that are too far from the head on the whole path. If the tissue inside the head was
    // removed at the beginning of the path, also omits empty blocks and blocks from which the head recedes.
    const bool cut_before = continues_ || k > 1;
    const auto choose = [&] {
      fill_up(starts, started);
      AtStart at;
      look_at_start(&way, &starts, &at);
      bool pieces_seen = false;
      for (int lane = 0; lane < started; ++lane) {
        if (const float top = at.depth[lane] + way.longest + kBesideSlip; top < centres.outside) {
          note(due[lane], centres.outside - top);
          continue;
        }
        if (cut_before && at.depth[lane] > kInner + way.slip) {
          const glm::ivec3 in_base = begun[lane] - way.from.base;
          if (at.depth[lane] > centres.emptied || least_depth_at_start(&way, &in_base) > kInner + way.slip) {
            note(due[lane], kNoEnd);
            continue;
          }
        }
        if (!pieces_seen) look_at_pieces(&way, &at, rounding);
        pieces_seen = true;
        if (cut_before && laws_ >= 5 && at.recedes[lane]) continue;
        blocks[lanes] = block_at(begun[lane]);
        blocks[lanes].due = due[lane];
        blocks[lanes].set = at.nearest_within(kHalf + way.longest + kBesideSlip, lane, way.count);
        put(centres, lanes, {starts.x[lane], starts.y[lane], starts.z[lane]});
        if (++lanes == 8) carve();
      }
      started = 0;
    };
    for (int x0 = first.x; x0 <= last.x; x0 += kRows) {
      for (int y0 = first.y; y0 <= last.y; y0 += kRows) {
        int lowest = first.z, highest = last.z;
        if (!column_beside_axis(
                glm::vec2(x0 - way.from.base.x, y0 - way.from.base.y) + glm::vec2(kMiddle) - glm::vec2(center), axis,
                far, static_cast<float>(way.from.base.z) + center.z - kMiddle.z, lowest, highest))
          continue;
        const int lowest_first = first.z + down(lowest - first.z, kDeep);
        float* const row = known ? known->row({x0, y0, lowest_first}, highest) : nullptr;
        for (int z0 = lowest_first; z0 <= highest; z0 += kDeep) {
          const glm::ivec3 from(x0, y0, z0);
          float* const noted = row ? row + (z0 - lowest_first) / kDeep : nullptr;
          if (noted && *noted > known->way) continue;
          begun[started] = from;
          due[started] = noted && is_whole(from) ? noted : nullptr;
          put(starts, started, glm::vec3(from - way.from.base) + kMiddle);
          if (++started == 8) choose();
        }
      }
    }
    if (started > 0) choose();
    if (lanes > 0) carve();
  }
  return changed;
}

}  // namespace typodont::haptics
