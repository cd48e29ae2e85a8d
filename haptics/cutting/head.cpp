// Cuts by heads that are not balls.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>

#include "engine/base/dispatch.h"
#include "haptics/cutting/block.h"
#include "haptics/cutting/lane_ops.h"
#include "haptics/cutting/listed.h"
#include "haptics/cutting/path.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

namespace {

/// A block with its position relative to the head.
struct HeadBlock {
  float* distance;
  const Tissue* tissue;
  std::ptrdiff_t at, stride_x, stride_y;  // `at`: index of the first sample; can be outside the array
  int from[3], to[3];                     // range of samples to process along each axis
  glm::ivec3 first;                       // first sample relative to HeadPose::base
  // Upper bound of the depths as a linear function: value at the block's first sample, and slopes. Valid because heads
  // are convex, so depth is concave.
  float bound, bound_x, bound_y, bound_z;
  const MeridianPiece* pieces;
  // Piece of the meridian that is nearest to all samples, if all lie between its ends; otherwise kManyPieces + bit mask
  // of the pieces that can be nearest.
  int kind;
  bool beside;  // true: samples may be deeper during the motion than at its end
  // voxels; the motion brings the head nearer to every sample by at least this
  float slowest;

  /// Address of a sample next to the block's centre.
  const float* middle() const { return distance + (at + stride_x + stride_y + 3); }
  /// Upper bound of the depths in the row (ix, iy), voxels.
  float deepest(int ix, int iy) const {
    return bound + static_cast<float>(ix) * bound_x + static_cast<float>(iy) * bound_y +
           std::max((kRowLength - 1) * bound_z, 0.0f);
  }
};

/// Further inputs and results of carve_head_block().
struct BlockSafeTravel {
  // input: length of the path, in voxels, for which `live` will be valid
  float ahead = 0;
  float safe_travel = kNoEnd;  // voxels of motion until a processed sample can change
  // Output (may be null): for each of the 4 × 4 rows along z (y is fastest), a bit mask of the samples that may change.
  std::uint64_t* live = nullptr;
  int shift = 0;         // position of the first sample's bit in each element of `live`
  bool emptied = false;  // true if a sample became air
};

}  // namespace

// One sample per lane. A mask is a vector of lanes, or one bit per lane where there are mask registers.
namespace eight {
namespace {

#include "haptics/cutting/cut_kernel.h"
#include "haptics/cutting/depth_kernel.h"
#include "haptics/cutting/path_kernel.h"
#include "haptics/cutting/row_kernel.h"
// Included last, because they use the four files above.
#include "haptics/cutting/head_block_kernel.h"
#include "haptics/cutting/leaf_block_kernel.h"

TYPODONT_DISPATCH("avx2", "default")
void raise_in_leaf(const HeadPose* pose, const HeadBlock* block, RaisedBlock* raised) {
  *raised = raise_leaf_block(*pose, *block);
}

TYPODONT_DISPATCH("avx2", "default")
bool dispatched(const HeadPose* pose, const HeadBlock* block, bool may_raise, PathMaxima* tops, RemovedVolume* removed,
                BlockSafeTravel* found) {
  return carve_head_block(*pose, *block, may_raise, *tops, removed, *found);
}

}  // namespace
}  // namespace eight

#ifdef TYPODONT_SIXTEEN_LANES
#pragma GCC push_options
#pragma GCC target("arch=x86-64-v4")
namespace eight_masked {
namespace {

#include "haptics/cutting/cut_kernel.h"
#include "haptics/cutting/depth_kernel.h"
#include "haptics/cutting/path_kernel.h"
#include "haptics/cutting/row_kernel.h"
// Included last, because it uses the four files above.
#include "haptics/cutting/head_block_kernel.h"

bool dispatched(const HeadPose* pose, const HeadBlock* block, bool may_raise, PathMaxima* tops, RemovedVolume* removed,
                BlockSafeTravel* found) {
  return carve_head_block(*pose, *block, may_raise, *tops, removed, *found);
}

}  // namespace
}  // namespace eight_masked

// Sixteen lanes: two neighbouring rows of a leaf.
namespace sixteen {
namespace {

#include "haptics/cutting/cut_kernel.h"
#include "haptics/cutting/depth_kernel.h"
// Included last, because it uses the two files above.
#include "haptics/cutting/leaf_block_kernel.h"

RaisedBlock raise_in_leaf(const HeadPose* pose, const HeadBlock* block) {
  return raise_leaf_block(*pose, *block);
}

}  // namespace
}  // namespace sixteen
#pragma GCC pop_options
#endif

namespace {

constexpr int kStretch = 64;  // largest number of consecutive samples of a row that one call lists
// voxels; largest error if an arc beside a piece is treated as a line
constexpr float kBent = 0.3f;
constexpr unsigned kAllPieces = (1u << HeadField::kMaxPieces) - 1;

/// For eight block centres: distances from the head and from each piece of its meridian; outward direction.
struct Seen {
  F8 distance, to_piece[HeadField::kMaxPieces];
  // frame T: position of the block's centre, its distance rho from the axis, and the outward direction (n_rho, n_z)
  F8 x, y, z, rho, n_rho, n_z;
};

/// `R`: rotation from V to T, column by column. `center`: positions of the block centres relative to the head's centre.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void evaluate_blocks(const MeridianPiece* pieces, int count, const float* R, const F8* center, Seen* seen) {
  const F8 vx = center[0], vy = center[1], vz = center[2];
  const F8 x = R[0] * vx + R[3] * vy + R[6] * vz, y = R[1] * vx + R[4] * vy + R[7] * vz,
           z = R[2] * vx + R[5] * vy + R[8] * vz;
  F8 rho = x * x + y * y;
  take_root(rho);
  F8 best = F8{} + 1e30f, n_rho = {}, n_z = {};
  I8 outside = {};
  for (int p = 0; p < count; ++p) {
    const MeridianPiece& piece = pieces[p];
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
      const float ux = piece.ax - piece.cx, uz = piece.az - piece.cz, tx = piece.bx - piece.cx,
                  tz = piece.bz - piece.cz;
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
  // At the surface, the outward direction is undefined and not needed.
  const F8 inverse = best > 1e-3f ? 1.0f / signed_best : F8{};
  seen->distance = signed_best;
  seen->n_rho = n_rho * inverse;
  seen->n_z = n_z * inverse;
  seen->x = x, seen->y = y, seen->z = z, seen->rho = rho;
}

#ifdef TYPODONT_SIXTEEN_LANES
const bool kMasked = __builtin_cpu_supports("x86-64-v4") != 0;
#endif

bool carve_head_block(const HeadPose& pose, const HeadBlock& block, bool may_raise, PathMaxima& tops,
                      RemovedVolume* removed, BlockSafeTravel& found) {
#ifdef TYPODONT_SIXTEEN_LANES
  if (kMasked) return eight_masked::dispatched(&pose, &block, may_raise, &tops, removed, &found);
#endif
  return eight::dispatched(&pose, &block, may_raise, &tops, removed, &found);
}

/// Selects the kernel of leaf_block_kernel.h for this processor.
eight::RaisedBlock raise_in_leaf(const HeadPose& pose, const HeadBlock& block) {
  eight::RaisedBlock raised;
#ifdef TYPODONT_SIXTEEN_LANES
  if (kMasked) {
    const sixteen::RaisedBlock wide = sixteen::raise_in_leaf(&pose, &block);
    return {wide.changed, wide.emptied};
  }
#endif
  eight::raise_in_leaf(&pose, &block, &raised);
  return raised;
}

TYPODONT_DISPATCH("avx2", "default")
void fill_heights(const HeadFront* f, int from, int to) {
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7};
  for (int z = from; z < to; z += 8) {
    const F8 height = static_cast<float>(f->origin.z + z) + steps - f->pose.p[2];
    for (int i = 0; i < 3; ++i) *reinterpret_cast<F8*>(f->along[i] + z) = f->pose.R[6 + i] * height;
  }
}

float root(float v) {
  return std::sqrt(v);
}
TYPODONT_INLINE F8 root(const F8& v) {
  return eight::root(v);
}

/// Position of a point relative to a meridian piece: distances from both ends along the piece (negative beyond an end),
/// and depth below the piece. T: one or eight floats.
template <class T>
TYPODONT_INLINE void ends_of(const MeridianPiece& piece, const T& rho, const T& z, T& from_a, T& from_b, T& depth) {
  if (piece.radius == 0) {
    from_a = (z - piece.az) * piece.nax - (rho - piece.ax) * piece.naz;
    from_b = piece.length - from_a;
    depth = (piece.ax - rho) * piece.nax + (piece.az - z) * piece.naz;
  } else {
    const T x = rho - piece.cx, y = z - piece.cz;
    from_a = piece.nax * y - piece.naz * x, from_b = x * piece.nbz - y * piece.nbx;
    depth = piece.radius - root(x * x + y * y);
  }
}

/// Returns a bit mask. A piece's bit is set if this piece alone is nearest to all `count` samples along z while the
/// head moves by `ahead`. `first`, `last`: examined pieces. `v`: first sample relative to the head's centre, frame V.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
unsigned lone_piece(const MeridianPiece* pieces, int first, int last, const float* R, const float* v, int count,
                    float ahead) {
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7};
  I8 shared[2] = {};
  for (int i = 0; i < count; i += 8) {
    const F8 height = v[2] + static_cast<float>(i) + steps;
    const F8 x = (R[0] * v[0] + R[3] * v[1]) + R[6] * height, y = (R[1] * v[0] + R[4] * v[1]) + R[7] * height;
    const F8 z = (R[2] * v[0] + R[5] * v[1]) + R[8] * height;
    F8 rho = x * x + y * y;
    take_root(rho);
    const I8 meant = I8{0, 1, 2, 3, 4, 5, 6, 7} + i < count;
    for (int piece = first; piece <= last; ++piece) {
      F8 from_a, from_b, depth;
      ends_of(pieces[piece], rho, z, from_a, from_b, depth);
      F8 deepest = depth + ahead;
      deepest = deepest > 0.0f ? deepest : F8{};
      shared[piece - first] |=
          meant & ((from_a <= ahead + (piece > first ? kBent + deepest * pieces[piece].corner_a : F8{})) |
                   (from_b <= ahead + (piece < last ? kBent + deepest * pieces[piece].corner_b : F8{})));
    }
  }
  unsigned alone = 0;
  for (int piece = first; piece <= last; ++piece)
    alone |= static_cast<unsigned>(!any_of(shared[piece - first])) << piece;
  return alone;
}

/// Smallest and largest n·w over the samples within `reach` of `center`, where w is the motion of a sample in frame T,
/// and n any outward normal of the meridian's pieces `first` to `last`. `rho`: distance of `center` from the axis.
struct Advance {
  float slowest, fastest;
};
inline Advance advance_beside(const MeridianPiece& first, const MeridianPiece& last, const glm::vec3& center, float rho,
                              float reach, const glm::vec3& w) {
  const float across = std::sqrt(w.x * w.x + w.y * w.y);
  // Component of the motion w away from the axis: largest and smallest value over the samples within `reach`.
  float most = across, least = -across;
  if (rho > reach) {
    const float inverse = 1 / rho, ux = center.x * inverse, uy = center.y * inverse, sine = reach * inverse,
                cosine = std::sqrt(1 - sine * sine);
    const float radial = w.x * ux + w.y * uy, round = std::abs(w.x * uy - w.y * ux);
    if (!(round * cosine <= radial * sine)) most = radial * cosine + round * sine;
    if (!(round * cosine <= -radial * sine)) least = radial * cosine - round * sine;
  }
  // Largest n·w (n: normal, w: motion). Along the meridian, n turns from the normal at its start (at a tip: straight
  // down) to the normal at its end. If n passes the direction of w, the largest n·w is |w|; otherwise it is at an end.
  const bool tip = first.ax == 0.0f && rho < reach + Sweep::kMargin;
  const float first_x = tip ? 0 : first.nax, first_z = tip ? -1 : first.naz;
  const auto greatest = [&](float away, float along) {
    if (first_x * along - first_z * away >= 0 && away * last.nbz - along * last.nbx >= 0)
      return std::sqrt(away * away + along * along);
    return std::max(first_x * away + first_z * along, last.nbx * away + last.nbz * along);
  };
  return {-greatest(-least, -w.z), greatest(most, w.z)};
}

/// Examines blocks at one pose, eight at a time.
class HeadPass {
 public:
  /// Examines blocks at the start pose or at the end pose. `after`: true if the cut at the other pose was made already;
  /// `ahead`: voxels of path for which the results are valid.
  HeadPass(const Straight& back, bool after, double reach, float ahead)
      : pose_(back.from),
        back_(back),
        after_(after),
        rounding_(4e-6f * (static_cast<float>(reach) + 8)),
        ahead_(ahead) {}

  const HeadPose& pose() const { return pose_; }

  /// Adds the block whose first voxel is `block`. Returns true if there are now eight blocks; then call examine().
  bool add(const glm::ivec3& block) {
    blocks_[lanes_] = block;
    const glm::vec3 c = glm::vec3(block - pose_.base) + kMiddle;
    for (int i = 0; i < 3; ++i) center_[i][lanes_] = c[i] - pose_.p[i];
    return ++lanes_ == 8;
  }
  int lanes() const { return lanes_; }

  /// Computes the distances of the added blocks from the head and from its pieces. Call it before near() and what().
  void examine() {
    for (int lane = lanes_; lane < 8; ++lane) {
      for (int i = 0; i < 3; ++i) center_[i][lane] = center_[i][0];
    }
    evaluate_blocks(back_.pieces, back_.count, pose_.R, center_, &seen_);
    lanes_ = 0;
  }

  /// Index of the meridian's piece nearest to all samples of the group at `first_voxel`; `kind` if no piece alone is.
  int kind_of_group(const glm::ivec3& first_voxel, int kind, int count) const {
    const auto set = static_cast<unsigned>(kind - kManyPieces);
    const int first = std::countr_zero(set), last = static_cast<int>(std::bit_width(set)) - 1;
    if (last - first > 1) return kind;
    const glm::vec3 v = glm::vec3(first_voxel - pose_.base) - glm::vec3(pose_.p[0], pose_.p[1], pose_.p[2]);
    const unsigned alone = lone_piece(back_.pieces, first, last, pose_.R, &v.x, count, ahead_);
    return alone != 0 ? std::countr_zero(alone) : kind;
  }

  /// Returns true if the block's samples may change within the next `ahead_` voxels of travel; `block` then receives
  /// the part of the block for which `target` has samples. Otherwise sets `safe_travel`.
  bool near(int lane, const HeadTarget& target, HeadBlock& block, float& safe_travel, bool& clipped) const {
    const float d = seen_.distance[lane];
    safe_travel = d - (Sweep::kMargin + kHalf);
    const float path_length = after_ ? back_.longest : 0;
    if (safe_travel > std::max(ahead_, path_length)) return false;
    // For a motion along the axis: blocks above the rim and beside the flank do not change (Straight::still_above). z
    // and rho + z of a block's samples differ by at most kHalf and √2 kHalf from those of the block's centre.
    if (seen_.z[lane] - kHalf > back_.still_above &&
        seen_.rho[lane] + seen_.z[lane] - 1.5f * kHalf > back_.still_beyond) {
      safe_travel = 0;
      return false;
    }
    safe_travel = kNoEnd;
    // The block is deep inside the head at the other pose, so it is already empty.
    if (after_ && d < -(Sweep::kInner + kHalf + path_length)) return false;
    const glm::ivec3 inside = blocks_[lane] - target.lo;
    block.distance = target.distance, block.tissue = target.tissue;
    block.stride_x = target.stride_x, block.stride_y = target.stride_y;
    block.at = inside.x * block.stride_x + inside.y * block.stride_y + inside.z;
    const int extent[3] = {kRows, kRows, kRowLength};
    clipped = false;
    for (int i = 0; i < 3; ++i) {
      block.from[i] = std::max(-inside[i], 0);
      block.to[i] = std::min(target.size[i] - inside[i], extent[i]);
      clipped |= block.to[i] - block.from[i] != extent[i];
    }
    return true;
  }

  // kNone: the block's samples need not be read. kExamine: they are read, but not changed, because the head recedes.
  // kRaise: they are read and may change.
  enum class Work { kNone, kExamine, kRaise };
  /// Call it after near(). If no sample can change within `ahead` voxels of path, returns kNone and sets `safe_travel`.
  Work what(int lane, HeadBlock& block, float& safe_travel, bool clipped) const {
    const float d = seen_.distance[lane], path_length = after_ ? back_.longest : 0;
    // The middle sample shows whether the block can change, because values and depths change by at most one per voxel.
    if (!clipped) {
      safe_travel = *block.middle() + d - 2 * kHalf;
      if (safe_travel > 1 + path_length) return Work::kNone;
    }
    const MeridianPiece* const pieces = back_.pieces;
    unsigned set = 0;
    int first = 0, last = 0;
    for (int i = back_.count - 1; i >= 0; --i) {
      if (!(seen_.to_piece[i][lane] < std::abs(d) + 2 * (kHalf + std::max(ahead_, path_length)))) continue;
      last = set == 0 ? i : last;
      first = i;
      set |= 1u << i;
    }
    const glm::vec3 at(seen_.x[lane], seen_.y[lane], seen_.z[lane]);
    const float rho = seen_.rho[lane];
    bool recedes = false;
    block.beside = false;
    if (after_) {
      // If the head moves away from the block, no sample of the block gets deeper.
      const float* const T = back_.turn;
      const float* const shift = back_.shift;
      const glm::vec3 w(T[0] * at.x + T[3] * at.y + (T[6] * at.z + shift[0]),
                        T[1] * at.x + T[4] * at.y + (T[7] * at.z + shift[1]),
                        T[2] * at.x + T[5] * at.y + (T[8] * at.z + shift[2]));
      const Advance advance = advance_beside(pieces[first], pieces[last], at, rho, kHalf + path_length, w);
      const float turned = back_.turned * kHalf;
      recedes = advance.fastest + turned <= -rounding_;
      block.slowest = advance.slowest - turned;
      block.beside =
          !recedes && back_.longest > kSlow && back_.still_above == kNoEnd && block.slowest < -0.5f * kTop + rounding_;
    }
    block.first = blocks_[lane] - pose_.base;
    const float out = rho > 1e-6f ? seen_.n_rho[lane] / rho : 0;
    const float* const R = pose_.R;
    const glm::vec3 n_T(out * at.x, out * at.y, seen_.n_z[lane]);
    const glm::vec3 n(R[0] * n_T.x + R[1] * n_T.y + R[2] * n_T.z, R[3] * n_T.x + R[4] * n_T.y + R[5] * n_T.z,
                      // the outward direction n_T, rotated to frame V
                      R[6] * n_T.x + R[7] * n_T.y + R[8] * n_T.z);
    // If the outward direction is unknown, the bound follows from this: depth changes by at most one per voxel.
    const bool known = glm::dot(n, n) > 0.5f;
    block.bound = known ? glm::dot(n, kMiddle) - d + 1e-3f : kHalf - d;
    block.bound_x = known ? -n.x : 0, block.bound_y = known ? -n.y : 0, block.bound_z = known ? -n.z : 0;
    block.pieces = pieces;
    // One piece suffices if all samples lie between its ends and no other piece is nearer to a sample inside the head.
    int nearest = first;
    for (int i = first + 1; i <= last; ++i)
      nearest = seen_.to_piece[i][lane] < seen_.to_piece[nearest][lane] ? i : nearest;
    const MeridianPiece& only = pieces[nearest];
    float from_a, from_b, below;
    ends_of(only, rho, at.z, from_a, from_b, below);
    const float reach = kHalf + std::max(ahead_, path_length), deepest = std::max(reach - d, 0.0f);
    const bool smooth = from_a > reach + (nearest > first ? kBent + deepest * only.corner_a : 0.0f) &&
                        from_b > reach + (nearest < last ? kBent + deepest * only.corner_b : 0.0f) &&
                        nearest - first <= 1 && last - nearest <= 1;
    block.kind = smooth ? nearest : kManyPieces + static_cast<int>(set);
    block.beside &= !(smooth && rho - kHalf - path_length > smooth_from(back_, only));
    return recedes ? Work::kExamine : Work::kRaise;
  }

 private:
  const HeadPose& pose_;
  const Straight& back_;
  bool after_;
  float rounding_, ahead_;
  glm::ivec3 blocks_[8];
  F8 center_[3];  // voxels, block centres relative to the head's centre
  Seen seen_;
  int lanes_ = 0;
};

/// examine(), choose() and carve() are called in turn (Sweep::carve_due_blocks()), so that one batch is loaded while
/// another is computed.
class HeadBatch {
 public:
  explicit HeadBatch(const HeadPass& none) : pass_(none) {}

  /// Adds a block. `due`: receives the path length of its next examination. Returns true if the batch is full.
  bool add(const glm::ivec3& block, float* due) {
    due_[pass_.lanes()] = due;
    return pass_.add(block);
  }
  void examine(const HeadTarget& target) {
    lanes_ = pass_.lanes();
    if (lanes_ == 0) return;
    pass_.examine();
    for (int lane = 0; lane < lanes_; ++lane) {
      near_[lane] = pass_.near(lane, target, block_[lane], safe_travel_[lane], clipped_[lane]);
      if (near_[lane] && !clipped_[lane]) __builtin_prefetch(block_[lane].middle());
    }
  }
  void choose() {
    for (int lane = 0; lane < lanes_; ++lane) {
      HeadBlock& block = block_[lane];
      work_[lane] = near_[lane] ? pass_.what(lane, block, safe_travel_[lane], clipped_[lane]) : HeadPass::Work::kNone;
      if (work_[lane] == HeadPass::Work::kNone) continue;
      for (int ix = block.from[0]; ix < block.to[0]; ++ix) {
        for (int iy = block.from[1]; iy < block.to[1]; ++iy) {
          if (block.deepest(ix, iy) < -Sweep::kMargin) continue;
          __builtin_prefetch(block.distance + (block.at + ix * block.stride_x + iy * block.stride_y), 1);
        }
      }
    }
  }
  /// Cuts the batch. Sets the path length at which each block is examined next. `again`: examine all in the next cut.
  bool carve(PathMaxima& tops, float slip, float path_length, bool again) {
    bool changed = false;
    for (int lane = 0; lane < lanes_; ++lane) {
      if (work_[lane] != HeadPass::Work::kNone) {
        BlockSafeTravel found{.ahead = slip};
        changed |= carve_head_block(pass_.pose(), block_[lane], work_[lane] == HeadPass::Work::kRaise, tops,
                                    tops.removed, found);
        // A block partly outside the tissue patch has safe travel 0: it is examined again in the next cut.
        safe_travel_[lane] = clipped_[lane] ? 0 : found.safe_travel;
      }
      *due_[lane] = again ? path_length : path_length + (safe_travel_[lane] - slip);
    }
    lanes_ = 0;
    return changed;
  }

 private:
  HeadPass pass_;
  int lanes_ = 0;
  float* due_[8];
  HeadBlock block_[8];
  float safe_travel_[8];
  bool near_[8], clipped_[8];
  HeadPass::Work work_[8];
};

/// Returns the kind (HeadBlock::kind) of a group that extends over two blocks with the kinds `a` and `b`.
int kind_of(int a, int b) {
  if (a == b) return a;
  const auto set = [](int kind) { return kind < kManyPieces ? 1u << kind : static_cast<unsigned>(kind - kManyPieces); };
  return kManyPieces + static_cast<int>(set(a) | set(b));
}

}  // namespace

bool Sweep::carve_head(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                       std::size_t stride_y, const Tissue* tissue, RemovedVolume* removed) const noexcept {
  bool changed = false;
  const HeadTarget target{
      lo, size, distance, static_cast<std::ptrdiff_t>(stride_x), static_cast<std::ptrdiff_t>(stride_y), tissue};
  const auto down = [](int v, int step) { return v - (v % step + step) % step; };
  const glm::ivec3 first(down(lo.x, kRows), down(lo.y, kRows), down(lo.z, kRowLength)), last = lo + size - 1;
  for (int k = continues_ ? 1 : 0; k <= 1; ++k) {
    PathMaxima tops(k == 0 ? straight_path(X_VA_, X_VA_, pieces_, back_.count, reach_) : path_back(), removed);
    HeadPass pass(tops.back, k > 0, reach_, 0);
    const auto carve = [&] {
      const int lanes = pass.lanes();
      pass.examine();
      for (int lane = 0; lane < lanes; ++lane) {
        HeadBlock block;
        float safe_travel;
        bool clipped;
        BlockSafeTravel found;
        if (pass.near(lane, target, block, safe_travel, clipped) &&
            pass.what(lane, block, safe_travel, clipped) == HeadPass::Work::kRaise)
          changed |= carve_head_block(pass.pose(), block, true, tops, removed, found);
      }
    };
    for (int x0 = first.x; x0 <= last.x; x0 += kRows) {
      for (int y0 = first.y; y0 <= last.y; y0 += kRows) {
        for (int z0 = first.z; z0 <= last.z; z0 += kRowLength) {
          if (pass.add({x0, y0, z0})) carve();
        }
      }
    }
    if (pass.lanes() > 0) carve();
    tops.carve();
    changed |= tops.changed;
  }
  return changed;
}

void Sweep::carve_head_leaves(std::span<Leaf> leaves, float path) const noexcept {
  static_assert(Leaf::kBlocks * kRows * kRows == kLeaf * kLeaf && kRowLength == kLeaf);
  const float slip = rounding_of_depth();
  for (int k = continues_ ? 1 : 0; k <= 1; ++k) {
    PathMaxima tops(k == 0 ? straight_path(X_VA_, X_VA_, pieces_, back_.count, reach_) : path_back(), nullptr);
    HeadPass pass(tops.back, k > 0, reach_, 0);
    struct {
      Leaf* leaf;
      float* due;
    } added[8];
    /// Cuts a block and returns how far the head may move before a sample can change, voxels.
    const auto carve_block = [&](int lane, Leaf& leaf) {
      HeadBlock block;
      float safe_travel;
      bool clipped;
      if (!pass.near(lane, {leaf.lo, glm::ivec3(kLeaf), leaf.distance, kLeaf * kLeaf, kLeaf, nullptr}, block,
                     safe_travel, clipped))
        return safe_travel;
      const HeadPass::Work work = pass.what(lane, block, safe_travel, clipped);
      if (work == HeadPass::Work::kNone) return safe_travel;
      bool raise = work == HeadPass::Work::kRaise;
      if (raise && !block.beside && tops.back.still_above == kNoEnd) {
        const eight::RaisedBlock raised = raise_in_leaf(pass.pose(), block);
        leaf.changed |= raised.changed, leaf.emptied |= raised.emptied;
        if (raised.changed) return 0.0f;  // the changed samples are at the surface now, so any motion may change them
        raise = false;
      }
      BlockSafeTravel found;
      leaf.changed |= carve_head_block(pass.pose(), block, raise, tops, nullptr, found);
      leaf.emptied |= found.emptied;
      if (tops.count > 0) tops.carve();
      leaf.changed |= tops.changed, leaf.emptied |= tops.changed;
      tops.changed = false;
      return found.safe_travel;
    };
    const auto carve = [&] {
      const int lanes = pass.lanes();
      pass.examine();
      for (int lane = 0; lane < lanes; ++lane) {
        const float safe_travel = carve_block(lane, *added[lane].leaf);
        // At pose A (k = 0), no path length is stored, because pose B must examine all blocks again.
        if (k > 0) *added[lane].due = path + (safe_travel - slip);
      }
    };
    for (Leaf& leaf : leaves) {
      for (int i = 0; i < Leaf::kBlocks; ++i) {
        if (leaf.due[i] > path) continue;
        added[pass.lanes()] = {&leaf, leaf.due + i};
        constexpr int kAcross = kLeaf / kRows;
        if (pass.add(leaf.lo + glm::ivec3(i / kAcross, i % kAcross, 0) * kRows)) carve();
      }
    }
    if (pass.lanes() > 0) carve();
  }
}

/// Cuts the blocks in one part of the active front that must be examined now, and sets the path length of their next
/// examination. Lists groups of samples that may change within the next `ahead` voxels of path.
bool Sweep::carve_due_head(CutFront& front, int part, float ahead, PathMaxima& tops, const glm::ivec3& patch_lo, int n,
                           float* distance, const Tissue* tissue, int& listed) const noexcept {
  CutFront::Groups& groups = front.parts_[static_cast<std::size_t>(part)];
  const Straight& back = tops.back;
  const unsigned all = (1u << back.count) - 1;
  const HeadTarget target{patch_lo, glm::ivec3(n), distance, n * n, n, tissue};
  const float path_length = static_cast<float>(front.path_length_), slip = rounding_of_depth();
  const glm::ivec3 step(kRows, kRows, kRowLength), held = patch_lo - front.first_ * step;
  const std::ptrdiff_t origin = -((static_cast<std::ptrdiff_t>(held.x) * n + held.y) * n + held.z);
  const auto [first, last] = front.reached(lo_, hi_);
  bool changed = false;
  for (int k = continues_ ? 1 : 0; k <= 1; ++k) {
    const Straight path_here = k == 0 ? straight_path(X_VA_, X_VA_, back.pieces, back.count, reach_) : back;
    HeadPass pass(path_here, k > 0, reach_, ahead + slip);
    const float due_by =
        k == 0 ? front.path_length_before(travel_) : path_length + ahead;  // blocks that are due later are skipped
    for (int x = first.x; x <= last.x; ++x) {
      if (front.part_of(x) != part) continue;
      for (int y = first.y; y <= last.y; ++y) {
        float* const row = front.due(front.first_ + glm::ivec3(x, y, 0));
        for (int z0 = first.z; z0 <= last.z; z0 += 8) {  // processes one interval of the row after another
          int lanes = 0, which[8];
          for (int z = z0; z <= std::min(last.z, z0 + 7); ++z) {
            if (row[z] >= due_by) continue;
            which[lanes++] = z;
            pass.add((front.first_ + glm::ivec3(x, y, z)) * step);
          }
          if (lanes == 0) continue;
          std::uint64_t live[kRows * kRows] = {};
          int kinds[8];
          std::fill_n(kinds, 8, kManyPieces + static_cast<int>(all));
          pass.examine();
          for (int lane = 0; lane < lanes; ++lane) {
            HeadBlock block;
            float safe_travel;
            bool clipped;
            const int z = which[lane];
            const HeadPass::Work work = pass.near(lane, target, block, safe_travel, clipped)
                                            ? pass.what(lane, block, safe_travel, clipped)
                                            : HeadPass::Work::kNone;
            if (work != HeadPass::Work::kNone) {
              BlockSafeTravel found{.ahead = ahead + slip, .live = live, .shift = (z - z0) * kRowLength};
              changed |=
                  carve_head_block(pass.pose(), block, work == HeadPass::Work::kRaise, tops, tops.removed, found);
              // A block for which `target` lacks samples has safe travel 0: it is examined again in the next cut.
              safe_travel = clipped ? 0 : found.safe_travel;
              kinds[z - z0] = block.kind;
            }
            // After pose A (k = 0), all blocks are marked as due, because they must be examined at pose B as well.
            row[z] = k == 0 ? -CutFront::kNever : path_length + (safe_travel - slip);
          }
          if (k == 0) continue;
          for (int r = 0; r < kRows * kRows; ++r) {
            for (std::uint64_t rest = live[r]; rest != 0;) {
              const int z = std::countr_zero(rest);
              const int gx = x * kRows + r / kRows, gy = y * kRows + r % kRows, gz = z0 * kRowLength + z;
              const int at = (gx * n + gy) * n + gz;
              std::uint8_t label;
              const int end = std::min(
                  z + with_one_label(tissue + origin + at, distance + origin + at, front.lanes_, label), kStretch);
              const std::uint64_t these = end < kStretch ? rest & ((std::uint64_t{1} << end) - 1) : rest;
              rest &= ~these;
              const int last_live = static_cast<int>(std::bit_width(these)) - 1;
              int kind = kinds[z / kRowLength];
              for (int block = z / kRowLength + 1; block <= last_live / kRowLength; ++block)
                kind = kind_of(kind, kinds[block]);
              const int live_lanes = last_live - z + 1;
              if (kind >= kManyPieces)
                kind = pass.kind_of_group(front.first_ * step + glm::ivec3(gx, gy, gz), kind, live_lanes);
              const bool narrow = live_lanes <= CutFront::kNarrowest && front.lanes_ > CutFront::kNarrowest;
              groups.found[static_cast<std::size_t>(std::min(listed++, groups.capacity()))] = {
                  static_cast<float>(gx),
                  static_cast<float>(gy),
                  gz,
                  at,
                  kind,
                  0,
                  narrow,
                  static_cast<std::uint8_t>(live_lanes),
                  label};
            }
          }
        }
      }
    }
  }
  return changed;
}

/// Cuts without lists of samples, because a fast head would soon make them invalid. For the caches, blocks are
/// processed in batches of eight: prefetch one sample per block; choose blocks and prefetch their rows; cut them.
bool Sweep::carve_due_blocks(CutFront& front, unsigned parts, PathMaxima& tops,
                             const HeadTarget& target) const noexcept {
  const float path_length = static_cast<float>(front.path_length_), slip = rounding_of_depth();
  const glm::ivec3 step(kRows, kRows, kRowLength);
  const auto [first, last] = front.reached(lo_, hi_);
  bool changed = false;
  for (int k = continues_ ? 1 : 0; k <= 1; ++k) {
    const Straight path_here =
        k == 0 ? straight_path(X_VA_, X_VA_, tops.back.pieces, tops.back.count, reach_) : tops.back;
    const HeadPass none(path_here, k > 0, reach_, slip);
    const float due_by =
        k == 0 ? front.path_length_before(travel_) : path_length;  // blocks with a larger due path length are skipped
    HeadBatch batches[3] = {HeadBatch(none), HeadBatch(none), HeadBatch(none)};
    int newest = 0;
    const auto advance = [&] {
      batches[newest].examine(target);
      batches[(newest + 2) % 3].choose();
      HeadBatch& oldest = batches[(newest + 1) % 3];
      changed |= oldest.carve(tops, slip, k == 0 ? -CutFront::kNever : path_length, k == 0);
      newest = (newest + 1) % 3;
    };
    for (int x = first.x; x <= last.x; ++x) {
      if (!(parts >> front.part_of(x) & 1)) continue;
      for (int y = first.y; y <= last.y; ++y) {
        float* const row = front.due(front.first_ + glm::ivec3(x, y, 0));
        for (int z = first.z; z <= last.z; ++z) {
          if (row[z] >= due_by) continue;
          if (batches[newest].add((front.first_ + glm::ivec3(x, y, z)) * step, row + z)) advance();
        }
      }
    }
    for (int i = 0; i < 3; ++i) advance();
  }
  return changed;
}

bool Sweep::carve_head(CutFront& front, const glm::ivec3& patch_lo, int n, float* distance, const Tissue* tissue,
                       RemovedVolume* removed) const noexcept {
  static_assert(kRows == CutFront::kRows && kRowLength == CutFront::kRowLength && kStretch == 8 * kRowLength);
  static_assert(CutFront::kKinds > kManyPieces + static_cast<int>(kAllPieces));
  const glm::ivec3 step(kRows, kRows, kRowLength), from = front.first_ * step, held = patch_lo - from;
  const std::ptrdiff_t origin = -((static_cast<std::ptrdiff_t>(held.x) * n + held.y) * n + held.z);
  front.keep_listed(patch_lo, n, continues_ && holds_listed(patch_lo, n));
  if (!continues_) front.drop_listed();

  PathMaxima tops(path_back(), removed);
  HeadFront f{.pose = tops.back.from,
              .pieces = pieces_,
              .origin = from - tops.back.from.base,
              .distance = distance + origin,
              .along = {front.heights(0), front.heights(1), front.heights(2)},
              .groups = {},
              .runs = nullptr,
              .run_count = 0,
              .tops = &tops};
  if (front.outdated() < front.parts()) {
    // The tables extend beyond the sweep's box, because groups end at block borders, and lists are used for a voxel
    // more. In a motion along the axis, the box contains only the head's end, and earlier lists extend farther.
    const int beyond = along_axis_ ? 64 : 16;
    const int lo = std::max(((lo_.z - from.z) & ~7) - beyond, 0),
              hi = std::min(((hi_.z - from.z) | 7) + beyond, front.size_.z * kRowLength - 1);
    fill_heights(&f, lo, hi + 16);
  }
  CutFront::Renewal renewal(front, front.reached(lo_, hi_), travel_, CutFront::kListedOfHead);
  bool changed = false;
  unsigned unlisted = 0;  // bit mask of the parts that have no list
  for (int part = 0; part < front.parts(); ++part) {
    CutFront::Groups& groups = front.parts_[static_cast<std::size_t>(part)];
    if (renewal.keeps(part)) {
      f.groups = groups.listed();
      f.runs = groups.runs.data(), f.run_count = groups.run_count;
      changed |= carve_listed_head(f, front.lanes_, removed);
      continue;
    }
    groups.until = -1;
    groups.count = 0;
    const double lasts = renewal.lasts(part);
    if (!(lasts > 0)) {
      unlisted |= 1u << part;
      continue;
    }
    int listed = 0;
    changed |= carve_due_head(front, part, static_cast<float>(lasts), tops, patch_lo, n, distance, tissue, listed);
    groups.renew(listed, front.path_length_, lasts);
  }
  if (unlisted != 0) {
    changed |= carve_due_blocks(front, unlisted, tops, {patch_lo, glm::ivec3(n), distance, n * n, n, tissue});
  }
  tops.carve();
  return changed || tops.changed;
}

}  // namespace typodont::haptics
