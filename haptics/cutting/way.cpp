// Long sweeps of heads that are no balls. A head is convex, so how deep a sample lies in it is a concave function of where
// it is there; and on a short turn a sample goes straight through the head, as that sees it. So how deep it ever lies is
// the one top of a curve, and is searched for, sample by sample.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "engine/base/dispatch.h"
#include "haptics/cutting/lane_ops.h"
#include "haptics/cutting/listed.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

namespace eight {
namespace {
#include "haptics/cutting/cut_kernel.h"
#include "haptics/cutting/depth_kernel.h"
#include "haptics/cutting/row_kernel.h"
}  // namespace
}  // namespace eight

namespace {

constexpr int kRows = 4, kDeep = 8;  // a block: kRows × kRows rows of kDeep samples
constexpr float kHalf = 4.1f;         // from its centre to a corner, |(1.5, 1.5, 3.5)|, and a little more
constexpr glm::vec3 kMiddle{(kRows - 1) / 2.0f, (kRows - 1) / 2.0f, (kDeep - 1) / 2.0f};
constexpr float kTop = 1e-4f;   // voxels; how far below its top a search may end
constexpr float kNear = 0.01f;  // voxels; nearer to a corner the direction from it would be rounding
constexpr int kSteps = 24;      // of a search; hardly any takes ten

/// A part of the way, on which samples go straight through the head.
struct Straight {
  HeadPose from, to;
  const MeridianPiece* pieces;
  int count;
  float on[3];   // from the second pose's base to the first's
  float slip;    // more than a tangent errs, voxels
  float bent;    // more than what is known of a block's centre errs within it
  float outside, emptied;  // where a centre is no deeper, or is deeper, all samples beside it are
};

/// Eight points in the head.
struct Points {
  F8 x, y, z;
};

TYPODONT_KERNEL Points in_head(const HeadPose& pose, const F8& x, const F8& y, const F8& z) {
  const float* const R = pose.R;
  const F8 vx = x - pose.p[0], vy = y - pose.p[1], vz = z - pose.p[2];
  return {(R[0] * vx + R[3] * vy) + R[6] * vz, (R[1] * vx + R[4] * vy) + R[7] * vz, (R[2] * vx + R[5] * vy) + R[8] * vz};
}

/// How deep samples lie at a point of their way, and how that changes along it.
struct Depth {
  F8 depth, slope;
};

/// The closest piece to some samples, as eight::NearestPiece finds it, with how they lie from it and its normal there.
struct NearestWithNormal {
  eight::NearestPiece nearest = eight::no_piece_yet();
  F8 out_rho{}, out_z{}, n_rho{}, n_z{};

  TYPODONT_KERNEL void take(const F8& before, const F8& f_rho, const F8& f_z, const F8& m_rho, const F8& m_z) {
    const I8 nearer = nearest.square < before;
    out_rho = nearer ? f_rho : out_rho, out_z = nearer ? f_z : out_z;
    n_rho = nearer ? m_rho : n_rho, n_z = nearer ? m_z : n_z;
  }
  TYPODONT_KERNEL void meet_line(const MeridianPiece& piece, const F8& rho, const F8& z) {
    const F8 before = nearest.square;
    nearest.meet_line(piece, rho, z);
    const F8 in = piece.ax - rho, down = piece.az - z, below = in * piece.nax + down * piece.naz;
    const F8 along = in * piece.naz - down * piece.nax;
    const F8 over = along - eight::greater(eight::lesser(along, eight::all(piece.length)), F8{});
    take(before, F8{} - (below * piece.nax + over * piece.naz), over * piece.nax - below * piece.naz, eight::all(piece.nax),
         eight::all(piece.naz));
  }
  TYPODONT_KERNEL void meet_arc(const MeridianPiece& piece, const F8& rho, const F8& z) {
    const F8 before = nearest.square;
    nearest.meet_arc(piece, rho, z);
    const F8 vx = rho - piece.cx, vz = z - piece.cz, inverse = 1.0f / (eight::root(vx * vx + vz * vz) + 1e-6f);
    const I8 between = (piece.ux * vz - piece.uz * vx >= 0.0f) & (vx * piece.wz - vz * piece.wx >= 0.0f);
    const F8 off = 1.0f - piece.radius * inverse;
    take(before, between ? vx * off : rho - piece.ax, between ? vz * off : z - piece.az, between ? vx * inverse : eight::all(piece.nax),
         between ? vz * inverse : eight::all(piece.naz));
  }
  /// The way out; at a corner any normal there will do.
  TYPODONT_KERNEL void normal(F8& rho, F8& z) const {
    const F8 away = eight::root(nearest.square), inverse = 1.0f / eight::greater(away, eight::all(kNear));
    const I8 beside = nearest.outside & (away > kNear);
    rho = beside ? out_rho * inverse : n_rho, z = beside ? out_z * inverse : n_z;
  }
};

/// How deep eight samples ever lie in the head, to kTop; of those that come no deeper than `needed`, or deeper than `most`,
/// only that. No curve lies above its tangents, so where those on either side of its top meet is how high it can be. It is looked for
/// there, where a corner would have it, and by turns where a round curve would be level.
struct Search {
  Points from, way;  // in the head
  F8 a, b, s;        // shares of the way: the top lies between a and b, and is looked for at s
  Depth at_a, at_b;
  F8 best, top, needed;
  I8 open;

  TYPODONT_KERNEL Points place(const F8& share) const { return {from.x + share * way.x, from.y + share * way.y, from.z + share * way.z}; }
  TYPODONT_KERNEL NearestWithNormal nearest(const Straight& head, const F8& rho, const F8& z) const {
    NearestWithNormal found;
    for (int i = 0; i < head.count; ++i) {
      const MeridianPiece& piece = head.pieces[i];
      piece.radius == 0.0f ? found.meet_line(piece, rho, z) : found.meet_arc(piece, rho, z);
    }
    return found;
  }
  TYPODONT_KERNEL Depth at(const Straight& head, const F8& share) const {
    const Points p = place(share);
    const F8 rho = eight::root(p.x * p.x + p.y * p.y);
    const NearestWithNormal found = nearest(head, rho, p.z);
    F8 n_rho, n_z;
    found.normal(n_rho, n_z);
    return {found.nearest.depth(), F8{} - (n_rho * ((p.x * way.x + p.y * way.y) / (rho + 1e-6f)) + n_z * way.z)};
  }
  /// The way out there, in the head.
  TYPODONT_KERNEL Points normal(const Straight& head, const F8& share) const {
    const Points p = place(share);
    const F8 rho = eight::root(p.x * p.x + p.y * p.y), inverse = 1.0f / (rho + 1e-6f);
    F8 n_rho, n_z;
    nearest(head, rho, p.z).normal(n_rho, n_z);
    return {n_rho * p.x * inverse, n_rho * p.y * inverse, n_z};
  }
  /// Begins at that share of the way. Positions count from the first pose's base.
  TYPODONT_KERNEL void begin(const Straight& head, const F8& x, const F8& y, const F8& z, const F8& least, float share, float most) {
    from = in_head(head.from, x, y, z);
    const Points to = in_head(head.to, x + head.on[0], y + head.on[1], z + head.on[2]);
    way = {to.x - from.x, to.y - from.y, to.z - from.z};
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
    // What has been found of one does not depend on what the others need; an end towards which the curve rises is its top.
    const I8 rises = (now.slope > 0.0f) & (s < 1.0f), before = open & (rises | (s <= 0.0f)), after = open & ~before;
    a = before ? s : a, at_a.depth = before ? now.depth : at_a.depth, at_a.slope = before ? now.slope : at_a.slope;
    b = after ? s : b, at_b.depth = after ? now.depth : at_b.depth, at_b.slope = after ? now.slope : at_b.slope;
    const I8 between = (at_a.slope > 0.0f) & (at_b.slope < 0.0f);
    const F8 rest = b - a, turn = at_a.slope - at_b.slope;
    const F8 inverse = 1.0f / eight::greater(turn, eight::all(1e-9f));
    const F8 by = eight::greater(eight::lesser((at_b.depth - at_a.depth - at_b.slope * rest) * inverse, rest), F8{});
    top = open ? between ? at_a.depth + at_a.slope * by : best : top;
    s = open & between ? a + (number % 2 == 0 ? at_a.slope * rest * inverse : by) : s;
    open &= (best < most) & (top > best + kTop) & (top > needed);
  }
};
/// Centres of eight blocks, and how deep they ever lie in the head. That is concave in space, too: no sample lies deeper than
/// the plane says.
struct Centres {
  F8 x, y, z;  // from the first pose's base
  F8 best, top;         // as deep at least, and at most
  F8 n_x, n_y, n_z;     // of the plane, out of the head
  F8 share;             // of the way, where they lie deepest
};

TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void look_at(const Straight* way_at, Centres* centres) {
  const Straight& way = *way_at;
  Search search;
  search.begin(way, centres->x, centres->y, centres->z, eight::all(way.outside), 0.5f, way.emptied);
  for (int step = 0; step < kSteps && any_of(search.open); ++step) search.step(way, step, way.emptied);
  // The tangents that hold the curve down, as much of each as makes a level one.
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

/// A block, the part of it that is meant, and what is known by its centre.
struct WayBlock {
  float* distance;
  const Tissue* tissue;
  std::ptrdiff_t stride_x, stride_y;
  int from[3], to[3];
  glm::ivec3 first;  // from the first pose's base
  float top, n[3], share;
  bool emptied;
};

/// new = max(old, min(depth, kInner)), depths below -kMargin not counted. Returns whether anything changed.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
bool raise_way_block(const Straight* way_at, const WayBlock* block_at, PerTissue* removed) {
  const Straight& way = *way_at;
  const WayBlock& block = *block_at;
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7}, bound = block.top + way.bent - block.n[2] * (steps - kMiddle.z);
  const F8 z = static_cast<float>(block.first.z) + steps;
  // Step by step all rows together, so that what one waits for the others can fill.
  constexpr int kAll = kRows * kRows;
  const bool whole = block.from[2] == 0 && block.to[2] == kDeep;
  Search searches[kAll];
  std::ptrdiff_t at[kAll];
  int rows = 0, open = 0, still_open[kAll];
  for (int ix = block.from[0]; ix < block.to[0]; ++ix) {
    for (int iy = block.from[1]; iy < block.to[1]; ++iy) {
      at[rows] = ix * block.stride_x + iy * block.stride_y;
      const F8 old = eight::Row{block.distance + at[rows], block.from[2], block.to[2], whole}.read();
      const I8 full = old >= Sweep::kInner;  // nothing more can come of these
      const float off = block.n[0] * (static_cast<float>(ix) - kMiddle.x) + block.n[1] * (static_cast<float>(iy) - kMiddle.y);
      const F8 least = full ? F8{} + kNoEnd : eight::greater(old, F8{} - Sweep::kMargin);
      if (!any_of(block.emptied ? ~full : bound - off > least)) continue;
      Search& search = searches[rows];
      if (block.emptied) {
        search.best = F8{} + Sweep::kInner;
      } else {
        search.begin(way, eight::all(static_cast<float>(block.first.x + ix)), eight::all(static_cast<float>(block.first.y + iy)), z, least,
                     block.share, Sweep::kInner);
        still_open[open] = rows;
        open += any_of(search.open);
      }
      ++rows;
    }
  }
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

}  // namespace

bool Sweep::raise_way(const HeadTarget& target, PerTissue* removed) const noexcept {
  MeridianPiece pieces[HeadField::kMaxPieces];
  flatten(head_, pieces);
  const auto down = [](int v, int step) { return v - (v % step + step) % step; };
  // A tangent errs by rounding; near a corner by twice the distance to it, or all along the way by what rounding turns it.
  const float slip = 1e-3f + 4e-6f * static_cast<float>(reach_ + travel_) + 2 * kNear + 1e-3f * static_cast<float>(travel_);
  const float turned = static_cast<float>(turn_ / straights_) * kHalf;
  const dvec3 around(reach_ + static_cast<double>(kMargin) + 1);
  const auto block_at = [&](const glm::ivec3& first) {
    WayBlock block;
    const glm::ivec3 inside = first - target.lo;
    const std::ptrdiff_t at = inside.x * target.stride_x + inside.y * target.stride_y + inside.z;
    block.distance = target.distance + at, block.tissue = target.tissue ? target.tissue + at : nullptr;
    block.stride_x = target.stride_x, block.stride_y = target.stride_y;
    const int extent[3] = {kRows, kRows, kDeep};
    for (int i = 0; i < 3; ++i) {
      block.from[i] = std::max(-inside[i], 0);
      block.to[i] = std::min(target.size[i] - inside[i], extent[i]);
    }
    block.first = first;
    return block;
  };
  bool changed = false;
  Pose X_VB = X_VA_;
  for (int k = 1; k <= straights_; ++k) {
    const Pose X_VA = X_VB;
    X_VB = k == straights_ ? X_VB_ : interpolate(X_VA_, X_VB_, static_cast<double>(k) / straights_);
    Straight way{.from = head_pose(X_VA), .to = head_pose(X_VB), .pieces = pieces, .count = head_.count, .on = {}, .slip = slip,
                 .bent = slip + kTop + turned, .outside = -(kMargin + kHalf + kTop + slip),
                 .emptied = kInner + kHalf + slip};
    for (int i = 0; i < 3; ++i) way.on[i] = static_cast<float>(way.from.base[i] - way.to.base[i]);
    const glm::ivec3 lo = glm::max(target.lo, glm::ivec3(glm::ceil(glm::min(X_VA.p, X_VB.p) - around)));
    const glm::ivec3 last = glm::min(target.lo + target.size - 1, glm::ivec3(glm::floor(glm::max(X_VA.p, X_VB.p) + around)));
    const glm::ivec3 first(down(lo.x, kRows), down(lo.y, kRows), down(lo.z, kDeep));
    Centres centres;
    glm::ivec3 blocks[8];
    int lanes = 0;
    const auto raise = [&] {
      for (int lane = lanes; lane < 8; ++lane) {
        centres.x[lane] = centres.x[0], centres.y[lane] = centres.y[0], centres.z[lane] = centres.z[0];
      }
      look_at(&way, &centres);
      for (int lane = 0; lane < lanes; ++lane) {
        if (centres.top[lane] <= way.outside) continue;
        WayBlock block = block_at(blocks[lane]);
        block.first -= way.from.base;
        block.top = centres.top[lane], block.share = centres.share[lane], block.emptied = centres.best[lane] >= way.emptied;
        block.n[0] = centres.n_x[lane], block.n[1] = centres.n_y[lane], block.n[2] = centres.n_z[lane];
        changed |= raise_way_block(&way, &block, removed);
      }
      lanes = 0;
    };
    for (int x0 = first.x; x0 <= last.x; x0 += kRows) {
      for (int y0 = first.y; y0 <= last.y; y0 += kRows) {
        for (int z0 = first.z; z0 <= last.z; z0 += kDeep) {
          blocks[lanes] = {x0, y0, z0};
          const glm::vec3 c = glm::vec3(blocks[lanes] - way.from.base) + kMiddle;
          centres.x[lanes] = c.x, centres.y[lanes] = c.y, centres.z[lanes] = c.z;
          if (++lanes == 8) raise();
        }
      }
    }
    if (lanes > 0) raise();
  }
  return changed;
}

}  // namespace typodont::haptics
