// Sweeps of every head that is not a ball.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "engine/base/dispatch.h"
#include "haptics/cut_front.h"
#include "haptics/cutting/account.h"
#include "haptics/lanes.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

namespace {

constexpr int kRows = 4, kDeep = 8;  // a block of a general head's sweep: kRows × kRows rows of kDeep samples
constexpr float kHalf = 4.1f;         // from its centre to a corner, |(1.5, 1.5, 3.5)|, and a little more
constexpr float kNoEnd = 1e9f;        // a slack that never ends
constexpr float kOneSided = 1e-5f;    // share of its way by which a head may advance and yet count as receding

/// A piece of the meridian in floats: HeadField::Piece with its outward normals at either end.
struct FlatPiece {
  float ax, az, bx, bz, dx, dz, inverse2, cx, cz, radius;
  float nax, naz, nbx, nbz;
};

/// Eight blocks seen from a head: how far their centres are from it and from its pieces, and the way out.
struct Seen {
  F8 distance, to_piece[HeadField::kMaxPieces];
  F8 x, y, z, rho, n_rho, n_z;  // centre and direction in T
};

/// `R`: from V to T, by columns; centres from the head's.
TYPODONT_DISPATCH("avx2", "default")
void see_blocks(const FlatPiece* pieces, int count, const float* R, const F8* center, Seen* seen) {
  const F8 vx = center[0], vy = center[1], vz = center[2];
  const F8 x = R[0] * vx + R[3] * vy + R[6] * vz, y = R[1] * vx + R[4] * vy + R[7] * vz,
           z = R[2] * vx + R[5] * vy + R[8] * vz;
  F8 rho = x * x + y * y;
  take_root(rho);
  F8 best = F8{} + 1e30f, n_rho = {}, n_z = {};
  I8 outside = {};
  for (int p = 0; p < count; ++p) {
    const FlatPiece& piece = pieces[p];
    const F8 ex = rho - piece.ax, ez = z - piece.az;
    const I8 beyond = piece.dx * ez - piece.dz * ex < 0.0f;
    F8 d, fx, fz;
    if (piece.radius == 0.0f) {
      F8 s = (ex * piece.dx + ez * piece.dz) * piece.inverse2;
      s = s < 0.0f ? F8{} : s;
      s = s > 1.0f ? F8{} + 1.0f : s;
      fx = ex - s * piece.dx, fz = ez - s * piece.dz;
      outside |= beyond;
    } else {
      const F8 gx = rho - piece.bx, gz = z - piece.bz, wx = rho - piece.cx, wz = z - piece.cz;
      F8 length = wx * wx + wz * wz;
      length = length > 1e-12f ? length : F8{} + 1e-12f;
      take_root(length);
      const float ux = piece.ax - piece.cx, uz = piece.az - piece.cz, tx = piece.bx - piece.cx, tz = piece.bz - piece.cz;
      const I8 between = (ux * wz - uz * wx >= 0.0f) & (wx * tz - wz * tx >= 0.0f);
      const I8 first = ex * ex + ez * ez < gx * gx + gz * gz;
      const F8 off = (length - piece.radius) / length;
      fx = between ? off * wx : first ? ex : gx;
      fz = between ? off * wz : first ? ez : gz;
      outside |= beyond & (length > piece.radius);
    }
    d = fx * fx + fz * fz;
    take_root(d);
    seen->to_piece[p] = d;
    const I8 nearer = d < best;
    best = nearer ? d : best;
    n_rho = nearer ? fx : n_rho;
    n_z = nearer ? fz : n_z;
  }
  const F8 signed_best = outside ? best : -best;
  // Where the centre lies on the surface the direction is of no use, nor needed: see bound below.
  const F8 inverse = best > 1e-3f ? 1.0f / signed_best : F8{};
  seen->distance = signed_best;
  seen->n_rho = n_rho * inverse;
  seen->n_z = n_z * inverse;
  seen->x = x, seen->y = y, seen->z = z, seen->rho = rho;
}

/// A block and the head beside it.
struct HeadBlock {
  float* distance;
  const Tissue* tissue;
  std::ptrdiff_t at, stride_x, stride_y;  // of its first sample, inside the array or not
  int from[3], to[3];                     // the part of it that is meant
  float px, py, pz;                       // its first sample in T
  float ex[3], ey[3], ez[3];              // to the next sample along x, y, z, in T
  // No sample is deeper than this plane says: the distance from a convex head is convex.
  float bound, bound_x, bound_y, bound_z;
  const FlatPiece* pieces;
  int which[HeadField::kMaxPieces], count;  // those that can be the closest one to any of the samples
  bool smooth;                              // there is only one, and between its ends
};

/// Depth of eight samples of the meridian's half plane, or of points in T.
TYPODONT_KERNEL void depth_in_head(const HeadBlock& block, const F8& rho, const F8& z, F8& depth) {
  const FlatPiece& only = block.pieces[block.which[0]];
  if (block.smooth && only.radius == 0.0f) {
    depth = (only.ax - rho) * only.nax + (only.az - z) * only.naz;
    return;
  }
  if (block.smooth) {
    const F8 vx = rho - only.cx, vz = z - only.cz;
    depth = vx * vx + vz * vz;
    take_root(depth);
    depth = only.radius - depth;
    return;
  }
  F8 best = F8{} + 1e30f;
  I8 outside = {};
  for (int p = 0; p < block.count; ++p) {
    const FlatPiece& piece = block.pieces[block.which[p]];
    const float ax = piece.ax, az = piece.az, dx = piece.dx, dz = piece.dz, radius = piece.radius;
    const F8 ex = rho - ax, ez = z - az;
    const I8 beyond = dx * ez - dz * ex < 0.0f;
    if (radius == 0.0f) {
      F8 s = (ex * dx + ez * dz) * piece.inverse2;
      s = s < 0.0f ? F8{} : s;
      s = s > 1.0f ? F8{} + 1.0f : s;
      const F8 fx = ex - s * dx, fz = ez - s * dz, d2 = fx * fx + fz * fz;
      best = d2 < best ? d2 : best;
      outside |= beyond;
    } else {
      const float bx = piece.bx, bz = piece.bz, cx = piece.cx, cz = piece.cz;
      const float ux = ax - cx, uz = az - cz, wx = bx - cx, wz = bz - cz;
      const F8 gx = rho - bx, gz = z - bz, vx = rho - cx, vz = z - cz;
      F8 length = vx * vx + vz * vz;
      take_root(length);
      const F8 on = (length - radius) * (length - radius);
      const F8 e2 = ex * ex + ez * ez, g2 = gx * gx + gz * gz, ends = e2 < g2 ? e2 : g2;
      const I8 between = (ux * vz - uz * vx >= 0.0f) & (vx * wz - vz * wx >= 0.0f);
      const F8 d2 = between ? on : ends;
      best = d2 < best ? d2 : best;
      outside |= beyond & (length > radius);
    }
  }
  take_root(best);
  depth = outside ? -best : best;
}

/// What a look at a block found besides.
struct BlockSlack {
  float ahead = 0;    // given: rows with less slack than this are live
  float slack = 0;    // how far the head may come nearer before anything changes, in the part that is meant
  unsigned live = 0;  // a bit for each row, y fastest
};

/// new = max(old, min(depth, kInner)), depths below -kMargin not counted. Returns whether anything changed. `may_raise`
/// false: only looks.
TYPODONT_DISPATCH("avx2", "default")
bool raise_head_block(const HeadBlock* block_at, bool may_raise, PerTissue* removed, BlockSlack* found) {
  const HeadBlock& block = *block_at;
  const int* const from = block.from;
  const int* const to = block.to;
  const bool whole = from[2] == 0 && to[2] == kDeep;
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7};
  const F8 along_x = steps * block.ez[0], along_y = steps * block.ez[1], along_z = steps * block.ez[2];
  const F8 bound = block.bound + steps * block.bound_z;
  bool changed = false;
  Account account{removed};
  F8 least_slack = F8{} + kNoEnd;
  const float near = found->ahead;
  unsigned live = 0;
  for (int ix = from[0]; ix < to[0]; ++ix) {
    for (int iy = from[1]; iy < to[1]; ++iy) {
      const float fx = static_cast<float>(ix), fy = static_cast<float>(iy);
      float* const row = block.distance + (block.at + ix * block.stride_x + iy * block.stride_y);
      F8 old = F8{} + 1e9f;  // what lies outside the part is not raised
      if (whole) {
        old = *reinterpret_cast<const F8*>(row);
      } else {
        for (int i = from[2]; i < to[2]; ++i) old[i] = row[i];
      }
      F8 most = bound + (fx * block.bound_x + fy * block.bound_y);
      most = most > Sweep::kInner ? F8{} + Sweep::kInner : most;
      const F8 least = old > -Sweep::kMargin ? old : F8{} - Sweep::kMargin;
      const I8 full = old >= Sweep::kInner;  // nothing more can come of these
      if (!any_of(most > least)) {
        const F8 room = full ? F8{} + kNoEnd : least - most;
        least_slack = room < least_slack ? room : least_slack;
        live |= static_cast<unsigned>(any_of(room < near)) << (ix * kRows + iy);
        continue;
      }
      const F8 x = (block.px + fx * block.ex[0] + fy * block.ey[0]) + along_x;
      const F8 y = (block.py + fx * block.ex[1] + fy * block.ey[1]) + along_y;
      const F8 z = (block.pz + fx * block.ex[2] + fy * block.ey[2]) + along_z;
      F8 rho = x * x + y * y, depth;
      take_root(rho);
      depth_in_head(block, rho, z, depth);
      depth = depth > Sweep::kInner ? F8{} + Sweep::kInner : depth;
      const I8 raised = depth > least;
      F8 room = raised ? F8{} : least - depth;
      room = full | (depth >= Sweep::kInner) ? F8{} + kNoEnd : room;
      least_slack = room < least_slack ? room : least_slack;
      live |= static_cast<unsigned>(any_of(room < near)) << (ix * kRows + iy);
      if (!may_raise || !any_of(raised)) continue;
      changed = true;
      const F8 now = raised ? depth : old;
      if (whole) {
        *reinterpret_cast<F8*>(row) = now;
      } else {
        for (int i = from[2]; i < to[2]; ++i) row[i] = now[i];
      }
      F8 taken;
      share_taken(old, now, taken);
      if (!removed || !any_of(taken > 0.0f)) continue;
      const Tissue* const labels = block.tissue + (row - block.distance);
      if (whole) {
        account.add(taken, labels);
      } else {
        for (int i = from[2]; i < to[2]; ++i) {
          account.add(static_cast<double>(share_inside(old[i]) - share_inside(now[i])), labels[i]);
        }
      }
    }
  }
  if (removed) account.close();
  float least = least_slack[0];
  for (int i = 1; i < 8; ++i) least = std::min(least, least_slack[i]);
  found->slack = least;
  found->live = live;
  return changed;
}

/// Rows in which the surface moved, and what they lost, until it is added up.
struct Moved {
  static constexpr int kRoom = 64;
  F8 taken[kRoom + kRows * kRows];
  const Tissue* labels[kRoom + kRows * kRows];
  int count = 0;
};

TYPODONT_DISPATCH("avx2", "default") void account_for(Moved* moved, PerTissue* removed) {
  Account account{removed};
  for (int m = 0; m < moved->count; ++m) account.add(moved->taken[m], moved->labels[m]);
  account.close();
  moved->count = 0;
}

enum class Nearest { kLine, kArc, kSeveral };

template <Nearest nearest>
TYPODONT_KERNEL bool raise_rows(const HeadBlock& block, unsigned rows, Moved& moved) {
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7};
  const F8 along_x = steps * block.ez[0], along_y = steps * block.ez[1], along_z = steps * block.ez[2];
  const FlatPiece only = block.pieces[block.which[0]];
  const float px = block.px, py = block.py, pz = block.pz;
  float* const first = block.distance + block.at;
  const Tissue* const labels = block.tissue + block.at;
  const std::ptrdiff_t stride_x = block.stride_x, stride_y = block.stride_y;
  int count = moved.count;
  I8 any_raised = {};
  for (; rows != 0; rows &= rows - 1) {
    const int row = std::countr_zero(rows), ix = row / kRows, iy = row % kRows;
    const float fx = static_cast<float>(ix), fy = static_cast<float>(iy);
    const std::ptrdiff_t offset = ix * stride_x + iy * stride_y;
    const F8 old = *reinterpret_cast<const F8*>(first + offset);
    const F8 x = (px + fx * block.ex[0] + fy * block.ey[0]) + along_x;
    const F8 y = (py + fx * block.ex[1] + fy * block.ey[1]) + along_y;
    const F8 z = (pz + fx * block.ex[2] + fy * block.ey[2]) + along_z;
    F8 rho = x * x + y * y, depth;
    take_root(rho);
    if constexpr (nearest == Nearest::kLine) {
      depth = (only.ax - rho) * only.nax + (only.az - z) * only.naz;
    } else if constexpr (nearest == Nearest::kArc) {
      const F8 vx = rho - only.cx, vz = z - only.cz;
      depth = vx * vx + vz * vz;
      take_root(depth);
      depth = only.radius - depth;
    } else {
      depth_in_head(block, rho, z, depth);
    }
    depth = depth > Sweep::kInner ? F8{} + Sweep::kInner : depth;
    const F8 least = old > -Sweep::kMargin ? old : F8{} - Sweep::kMargin;
    const I8 raised = depth > least;
    const F8 now = raised ? depth : old;
    *reinterpret_cast<F8*>(first + offset) = now;
    any_raised |= raised;
    F8 taken;
    share_taken(old, now, taken);
    moved.taken[count] = taken;
    moved.labels[count] = labels + offset;
    count += any_of(taken > 0.0f);
  }
  moved.count = count;
  return any_of(any_raised);
}

/// The same as raise_head_block() for some rows of a block.
TYPODONT_DISPATCH("avx2", "default") bool raise_head_rows(const HeadBlock* block, unsigned rows, Moved* moved) {
  if (!block->smooth) return raise_rows<Nearest::kSeveral>(*block, rows, *moved);
  return block->pieces[block->which[0]].radius == 0.0f ? raise_rows<Nearest::kLine>(*block, rows, *moved)
                                                       : raise_rows<Nearest::kArc>(*block, rows, *moved);
}

/// How fast, at most, the head comes nearer to any sample around a point of its half plane: the greatest n·w over the
/// normals of some neighbouring pieces, turned about the axis by as much as `kHalf` is seen from it. `w` in T.
float fastest_advance(const FlatPiece& first, const FlatPiece& last, const glm::vec3& center, float rho,
                      const glm::vec3& w) {
  const float across = std::sqrt(w.x * w.x + w.y * w.y);
  float along = across;  // the greatest part of w away from the axis
  if (rho > kHalf) {
    const float ux = center.x / rho, uy = center.y / rho, sine = kHalf / rho, cosine = std::sqrt(1 - sine * sine);
    const float radial = w.x * ux + w.y * uy, round = std::abs(w.x * uy - w.y * ux);
    if (!(radial > 0 && round * cosine <= radial * sine)) along = radial * cosine + round * sine;
  }
  // Normals turn from the first piece's to the last one's; the greatest is at w itself when that lies between.
  if (first.nax * w.z - first.naz * along >= 0 && along * last.nbz - w.z * last.nbx >= 0) {
    return std::sqrt(along * along + w.z * w.z);
  }
  return std::max(first.nax * along + first.naz * w.z, last.nbx * along + last.nbz * w.z);
}

void flatten(const HeadField& head, FlatPiece* pieces) {
  for (int p = 0; p < head.count; ++p) {
    const HeadField::Piece& piece = head.pieces[p];
    const double length = std::sqrt(1 / piece.inverse2), r = piece.radius;
    const bool line = r == 0;
    const double values[] = {piece.ax, piece.az, piece.bx, piece.bz, piece.dx, piece.dz, piece.inverse2, piece.cx, piece.cz, r,
                             line ? piece.dz / length : (piece.ax - piece.cx) / r,
                             line ? -piece.dx / length : (piece.az - piece.cz) / r,
                             line ? piece.dz / length : (piece.bx - piece.cx) / r,
                             line ? -piece.dx / length : (piece.bz - piece.cz) / r};
    static_assert(sizeof(FlatPiece) == std::size(values) * sizeof(float));
    float flat[std::size(values)];
    for (std::size_t i = 0; i < std::size(values); ++i) flat[i] = static_cast<float>(values[i]);
    std::memcpy(&pieces[p], flat, sizeof flat);
  }
}

/// A box of samples that a head is cut out of.
struct HeadTarget {
  glm::ivec3 lo, size;
  float* distance;
  std::ptrdiff_t stride_x, stride_y;
  const Tissue* tissue;
};

/// One pose of a sweep, and the blocks beside it, eight by eight. Blocks are aligned to the voxel grid, so that a sample's
/// depth does not depend on how the work was cut up.
class HeadPass {
 public:
  /// `after`: the head was cut out at `before`, `travel` voxels from here.
  HeadPass(const FlatPiece* pieces, int count, const Pose& X_VT, const Pose& before, bool after, double travel)
      : pieces_(pieces), count_(count), base_(glm::floor(X_VT.p)), p_(X_VT.p - dvec3(base_)), after_(after),
        travel_(static_cast<float>(travel)) {
    const glm::dmat3 R_TV = glm::transpose(glm::dmat3(X_VT.R));
    R_ = glm::mat3(R_TV);
    // A point's way in T since the pose before: where the head recedes from all of a block nothing is left to cut.
    const glm::dmat3 R_TA = glm::transpose(glm::dmat3(before.R));
    turned_ = glm::mat3(R_TA - R_TV);
    shifted_ = glm::vec3(R_TA * (X_VT.p - before.p));
    for (int c = 0; c < 3; ++c) turn_ += glm::length(turned_[c]) * kHalf;
  }

  /// Takes in a block by its first voxel; true when there are eight.
  bool add(const glm::ivec3& block) {
    blocks_[lanes_] = block;
    const glm::vec3 c = glm::vec3(block - base_) + kMiddle - p_;
    for (int i = 0; i < 3; ++i) center_[i][lanes_] = c[i];
    return ++lanes_ == 8;
  }
  int lanes() const { return lanes_; }

  /// Looks at those taken in: what() then says what is to be done about each.
  void look() {
    for (int lane = lanes_; lane < 8; ++lane) {
      for (int i = 0; i < 3; ++i) center_[i][lane] = center_[i][0];
    }
    see_blocks(pieces_, count_, &R_[0].x, center_, &seen_);
    lanes_ = 0;
  }

  enum class Work { kNone, kLook, kRaise };  // of kLook it is known that the head recedes from all of it
  /// `block` is filled unless nothing is to be done; `slack`: how far the head may come nearer before there is, clipped or
  /// not; if that is less than `ahead` it is looked at. `listed`: it is known that something is to be done sooner or later.
  Work what(int lane, const HeadTarget& target, bool listed, float ahead, HeadBlock& block, float& slack,
            bool& clipped) const {
    const float d = seen_.distance[lane];
    slack = d - (Sweep::kMargin + kHalf);
    if (slack > ahead) return Work::kNone;
    // Deep in the head at the pose before too: empty since then.
    slack = kNoEnd;
    if (after_ && d < -(Sweep::kInner + kHalf + travel_)) return Work::kNone;
    const glm::ivec3 inside = blocks_[lane] - target.lo;
    block.stride_x = target.stride_x, block.stride_y = target.stride_y;
    block.at = inside.x * block.stride_x + inside.y * block.stride_y + inside.z;
    clipped = false;
    if (!listed) {
      const int extent[3] = {kRows, kRows, kDeep};
      for (int i = 0; i < 3; ++i) {
        block.from[i] = std::max(-inside[i], 0);
        block.to[i] = std::min(target.size[i] - inside[i], extent[i]);
        clipped |= block.to[i] - block.from[i] != extent[i];
      }
      // Far out in the air: field and depth change by at most one per voxel each.
      if (!clipped) {
        slack = target.distance[block.at + block.stride_x + block.stride_y + 3] + d - 2 * kHalf;
        if (slack > 1) return Work::kNone;
      }
    }
    block.count = 0;
    for (int i = 0; i < count_; ++i) {
      if (seen_.to_piece[i][lane] < std::abs(d) + 2 * kHalf) block.which[block.count++] = i;
    }
    const glm::vec3 from_head(center_[0][lane], center_[1][lane], center_[2][lane]);
    const glm::vec3 at(seen_.x[lane], seen_.y[lane], seen_.z[lane]);
    const float rho = seen_.rho[lane];
    bool recedes = false;
    if (after_) {
      const glm::vec3 w = turned_ * from_head + shifted_;
      const float fastest = fastest_advance(pieces_[block.which[0]], pieces_[block.which[block.count - 1]], at, rho, w);
      recedes = fastest + turn_ <= kOneSided * glm::length(w);
      if (recedes && listed) return Work::kNone;
    }
    block.distance = target.distance, block.tissue = target.tissue;
    const glm::vec3 q = R_ * (from_head - kMiddle);
    block.px = q.x, block.py = q.y, block.pz = q.z;
    for (int i = 0; i < 3; ++i) block.ex[i] = R_[0][i], block.ey[i] = R_[1][i], block.ez[i] = R_[2][i];
    if (!listed) {
      const float out = rho > 1e-6f ? seen_.n_rho[lane] / rho : 0;
      const glm::vec3 n = glm::vec3(out * at.x, out * at.y, seen_.n_z[lane]) * R_;  // in V
      // Without a direction only the change by one per voxel is known.
      const bool known = glm::dot(n, n) > 0.5f;
      block.bound = known ? glm::dot(n, kMiddle) - d + 1e-3f : kHalf - d;
      block.bound_x = known ? -n.x : 0, block.bound_y = known ? -n.y : 0, block.bound_z = known ? -n.z : 0;
    }
    block.pieces = pieces_;
    const FlatPiece& only = pieces_[block.which[0]];
    block.smooth = false;
    if (block.count == 1 && only.radius == 0) {
      const float s = ((rho - only.ax) * only.dx + (at.z - only.az) * only.dz) * only.inverse2;
      const float reach = kHalf * std::sqrt(only.inverse2);
      block.smooth = s > reach && s < 1 - reach;
    } else if (block.count == 1) {
      const float vx = rho - only.cx, vz = at.z - only.cz;
      block.smooth = only.nax * vz - only.naz * vx > kHalf && vx * only.nbz - vz * only.nbx > kHalf;
    }
    return recedes ? Work::kLook : Work::kRaise;
  }

 private:
  static constexpr glm::vec3 kMiddle{(kRows - 1) / 2.0f, (kRows - 1) / 2.0f, (kDeep - 1) / 2.0f};

  const FlatPiece* pieces_;
  int count_;
  glm::mat3 R_;       // from V to T
  glm::ivec3 base_;
  glm::vec3 p_;       // the head from there
  bool after_;
  float travel_;
  glm::mat3 turned_;
  glm::vec3 shifted_;
  float turn_ = 0;    // of a block's corner about its centre
  glm::ivec3 blocks_[8];
  F8 center_[3];      // from the head
  Seen seen_;
  int lanes_ = 0;
};

}  // namespace

bool Sweep::raise_head(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                       std::size_t stride_y, const Tissue* tissue, PerTissue* removed) const noexcept {
  bool changed = false;
  FlatPiece pieces[HeadField::kMaxPieces];
  flatten(head_, pieces);
  const HeadTarget target{lo, size, distance, static_cast<std::ptrdiff_t>(stride_x), static_cast<std::ptrdiff_t>(stride_y),
                          tissue};
  const auto down = [](int v, int step) { return v - (v % step + step) % step; };
  const glm::ivec3 first(down(lo.x, kRows), down(lo.y, kRows), down(lo.z, kDeep)), last = lo + size - 1;
  for (int k = continues_ ? 1 : 0; k <= poses_; ++k) {
    const Pose X_VT = k == 0 ? X_VA_ : k == poses_ ? X_VB_ : pose(k);
    HeadPass pass(pieces, head_.count, X_VT, k == 1 ? X_VA_ : k > 1 ? pose(k - 1) : X_VT, k > 0, travel_);
    const auto raise = [&] {
      const int lanes = pass.lanes();
      pass.look();
      for (int lane = 0; lane < lanes; ++lane) {
        HeadBlock block;
        float slack;
        bool clipped;
        BlockSlack found;
        if (pass.what(lane, target, false, 0, block, slack, clipped) != HeadPass::Work::kRaise) continue;
        changed |= raise_head_block(&block, true, removed, &found);
      }
    };
    for (int x0 = first.x; x0 <= last.x; x0 += kRows) {
      for (int y0 = first.y; y0 <= last.y; y0 += kRows) {
        for (int z0 = first.z; z0 <= last.z; z0 += kDeep) {
          if (pass.add({x0, y0, z0})) raise();
        }
      }
    }
    if (pass.lanes() > 0) raise();
  }
  return changed;
}

bool Sweep::raise_head(CutFront& front, const glm::ivec3& patch_lo, int n, float* distance, const Tissue* tissue,
                       PerTissue* removed) const noexcept {
  static_assert(kRows == CutFront::kRows && kDeep == CutFront::kDeep);
  CutFront::Blocks& list = front.blocks_;
  bool changed = false;
  FlatPiece pieces[HeadField::kMaxPieces];
  flatten(head_, pieces);
  const HeadTarget target{patch_lo, glm::ivec3(n), distance, n * n, n, tissue};
  const glm::ivec3 step(kRows, kRows, kDeep);
  Moved moved;

  if (continues_ && front.way_ <= list.until && list.patch_lo == patch_lo) {
    HeadPass pass(pieces, head_.count, X_VB_, X_VA_, true, travel_);
    for (int i = 0; i < list.count; i += 8) {
      const int lanes = std::min(list.count - i, 8);
      for (int lane = 0; lane < lanes; ++lane) pass.add(list.first[static_cast<std::size_t>(i + lane)]);
      pass.look();
      for (int lane = 0; lane < lanes; ++lane) {
        HeadBlock block;
        float slack;
        bool clipped;
        if (pass.what(lane, target, true, 0, block, slack, clipped) != HeadPass::Work::kRaise) continue;
        changed |= raise_head_rows(&block, list.rows[static_cast<std::size_t>(i + lane)], &moved);
        if (moved.count >= Moved::kRoom) account_for(&moved, removed);
      }
    }
    if (moved.count > 0) account_for(&moved, removed);
    return changed;
  }

  const float ahead = travel_ > CutFront::kMostListed ? 0.0f : static_cast<float>(CutFront::kListed);
  const float way = static_cast<float>(front.way_), slip = 1e-3f + 2e-6f * static_cast<float>(reach_);
  const glm::ivec3 first = (lo_ - 1 - front.first_ * step) / step, last = (hi_ + 1 - front.first_ * step) / step;
  list.count = 0;
  for (int k = continues_ ? 1 : 0; k <= 1; ++k) {
    HeadPass pass(pieces, head_.count, k == 0 ? X_VA_ : X_VB_, X_VA_, k > 0, travel_);
    float* due[8];
    glm::ivec3 blocks[8];
    const auto raise = [&] {
      const int lanes = pass.lanes();
      pass.look();
      for (int lane = 0; lane < lanes; ++lane) {
        HeadBlock block;
        float slack;
        bool clipped;
        const HeadPass::Work work = pass.what(lane, target, false, ahead + slip, block, slack, clipped);
        BlockSlack found{.ahead = ahead + slip};
        if (work != HeadPass::Work::kNone) {
          changed |= raise_head_block(&block, work == HeadPass::Work::kRaise, removed, &found);
          slack = clipped ? 0 : found.slack;  // of the rest of it nothing is known
        }
        // What the head at A leaves is looked at again at B.
        *due[lane] = k == 0 ? -CutFront::kNever : way + (slack - slip);
        if (k == 1 && found.live != 0 && ahead > 0) {
          const auto at = static_cast<std::size_t>(std::min(list.count++, list.room()));
          list.first[at] = blocks[lane], list.rows[at] = found.live;
        }
      }
    };
    for (int x = first.x; x <= last.x; ++x) {
      for (int y = first.y; y <= last.y; ++y) {
        float* const row = front.due(front.first_ + glm::ivec3(x, y, 0));
        for (int z = first.z; z <= last.z; ++z) {
          if (row[z] >= way + ahead) continue;
          const glm::ivec3 block = (front.first_ + glm::ivec3(x, y, z)) * step;
          due[pass.lanes()] = row + z;
          blocks[pass.lanes()] = block;
          if (pass.add(block)) raise();
        }
      }
    }
    if (pass.lanes() > 0) raise();
  }
  list.until = ahead > 0 && list.count <= list.room() ? front.way_ + static_cast<double>(ahead) : -1;
  list.patch_lo = patch_lo;
  return changed;
}

}  // namespace typodont::haptics
