// Adds filling to eight samples at once.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "engine/base/dispatch.h"
#include "haptics/cutting/inside_fraction.h"
#include "haptics/cutting/lane_ops.h"
#include "haptics/cutting/meridian.h"
#include "haptics/fill.h"
#include "haptics/volume/label.h"

namespace typodont::haptics {

namespace eight {
namespace {
#include "haptics/cutting/cut_kernel.h"
#include "haptics/cutting/depth_kernel.h"
}  // namespace
}  // namespace eight

namespace {

constexpr int kLanes = 8;
// voxels; air nearer than this to the filling gets the filling's label, for queries at the surface
constexpr float kLabelled = 1;
constexpr float kSlip = 1e-3f;  // voxels, added to the ball's reach because of rounding errors

/// A ball of filling as plain data. Positions in voxels, relative to a base voxel near the head.
struct FillBall {
  HeadPose head;
  // meridian of the head; no filling may enter the head, or the path on which the head can be withdrawn
  MeridianPiece pieces[HeadField::kMaxPieces];
  // bit mask of all pieces of the meridian
  unsigned all_pieces;
  float x, y, z, radius;
  Tissue label;
  const Fill* filling;  // gives the solid that limits the filling
};

/// The samples that lower_rows() processes.
struct FillBlock {
  // `first`: position relative to the base voxel; `size`: number of samples along each axis
  glm::ivec3 first, size;
  float* distance;
  Tissue* tissue;
  std::ptrdiff_t stride_x, stride_y;
};

/// Eight samples of a row. Lanes outside the block get values that no filling changes.
struct Lanes {
  float* at;
  int from, to;  // first lane inside the block, and one after the last

  TYPODONT_INLINE bool whole() const { return from == 0 && to == kLanes; }
  TYPODONT_INLINE F8 load() const {
    if (whole()) return *reinterpret_cast<const F8*>(at);
    F8 v = F8{} - Sweep::kInner;
    for (int i = from; i < to; ++i) v[i] = at[i];
    return v;
  }
  TYPODONT_INLINE void store(const F8& v) const {
    if (whole()) {
      *reinterpret_cast<F8*>(at) = v;
    } else {
      for (int i = from; i < to; ++i) at[i] = v[i];
    }
  }
};

/// Increases the distances of the samples selected by `meant`, so that the filling stays inside the limiting solid. The
/// eight samples are aligned to the volume's blocks, so the result does not depend on the processed box.
void keep_within(const Fill& filling, const glm::ivec3& first, const I8& meant, F8& d) {
  constexpr double kHalf = (kLanes - 1) / 2.0;
  const double middle = filling.beyond_limit(dvec3(first) + dvec3(0, 0, kHalf));
  if (middle < -kHalf - static_cast<double>(Sweep::kInner)) return;
  for (int i = 0; i < kLanes; ++i) {
    if (!meant[i]) continue;
    const double limit = middle > kHalf + static_cast<double>(Sweep::kMargin)
                             ? middle
                             : filling.beyond_limit(dvec3(first + glm::ivec3(0, 0, i)));
    d[i] = std::max(d[i], static_cast<float>(limit));
  }
}

// FMA is off and samples are independent: the result is bit-identical on every processor and for any block.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
bool lower_rows(const FillBall* ball_at, const FillBlock* block_at, PerTissue* added, FreshLabels* fresh) {
  const FillBall& ball = *ball_at;
  const FillBlock& block = *block_at;
  const float* const R = ball.head.R;
  const float reach = ball.radius + Sweep::kMargin + kSlip;
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7}, inner = F8{} - Sweep::kInner;
  I8 any_lowered = {};
  // volume that the reverse change would remove, which is the added volume
  RemovedVolume reverse;
  eight::Taken taken_in{&reverse};
  for (int x = 0; x < block.size.x; ++x) {
    const float vx = static_cast<float>(block.first.x + x), px = vx - ball.x;
    for (int y = 0; y < block.size.y; ++y) {
      const float vy = static_cast<float>(block.first.y + y), py = vy - ball.y, row2 = px * px + py * py;
      if (!(row2 < reach * reach)) continue;
      const float chord = std::sqrt(reach * reach - row2), middle = ball.z - static_cast<float>(block.first.z);
      const int from = std::max(static_cast<int>(middle - chord), 0);
      const int to = std::min(static_cast<int>(middle + chord) + 2, block.size.z);
      const std::ptrdiff_t row = x * block.stride_x + y * block.stride_y;
      const float ux = vx - ball.head.p[0], uy = vy - ball.head.p[1];
      const float row_x = R[0] * ux + R[3] * uy, row_y = R[1] * ux + R[4] * uy, row_z = R[2] * ux + R[5] * uy;
      for (int z = from - ((ball.head.base.z + block.first.z + from) & (kLanes - 1)); z < to; z += kLanes) {
        const Lanes lanes{block.distance + row + z, std::max(-z, 0), std::min(block.size.z - z, kLanes)};
        const F8 old = lanes.load();
        if (!any_of(old > inner)) continue;
        const F8 vz = static_cast<float>(block.first.z + z) + steps, pz = vz - ball.z;
        F8 d = row2 + pz * pz;
        take_root(d);
        d = d - ball.radius;
        d = d > inner ? d : inner;
        I8 lowered = (d < old) & (d < Sweep::kMargin);
        if (!any_of(lowered)) continue;
        if (ball.filling->is_limited())
          keep_within(*ball.filling, ball.head.base + block.first + glm::ivec3(x, y, z), lowered, d);
        const F8 uz = vz - ball.head.p[2], tx = row_x + R[6] * uz, ty = row_y + R[7] * uz, tz = row_z + R[8] * uz;
        F8 rho = tx * tx + ty * ty;
        take_root(rho);
        const F8 kept_out = Fill::kClear + eight::depth_below_pieces(ball.pieces, ball.all_pieces, rho, tz);
        d = kept_out > d ? kept_out : d;
        lowered &= (d < old) & (d < Sweep::kMargin);
        if (!any_of(lowered)) continue;
        const F8 now = lowered ? d : old;
        lanes.store(now);
        any_lowered |= lowered;
        // volume that the reverse change would remove, which is the added volume
        const I8 filled = eight::share_taken(now, old);
        if (added && any_of(filled > 0)) taken_in.add(filled, static_cast<std::uint8_t>(ball.label), lanes.at);
        for (unsigned labelled = bits_of(lowered & (old > 0.0f) & (now < kLabelled)); labelled != 0;
             labelled &= labelled - 1) {
          const int i = std::countr_zero(labelled);
          Tissue& label = block.tissue[row + z + i];
          const Tissue other = haptics::filled(label, ball.label);
          if (label == other) continue;
          label = other;
          if (fresh && now[i] > 0) fresh->add(row + z + i);
        }
      }
    }
  }
  taken_in.close();
  for (std::size_t t = 0; added && t < added->size(); ++t) (*added)[t] += reverse.volume[t];
  return any_of(any_lowered);
}

}  // namespace

bool Fill::lower(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue, std::size_t stride_x,
                 std::size_t stride_y, PerTissue* added, FreshLabels* fresh) const noexcept {
  FillBall ball;
  ball.head = head_pose(X_VT_);
  flatten(head_, ball.pieces);
  ball.all_pieces = (1u << head_.count) - 1;
  const glm::vec3 center(center_ - dvec3(ball.head.base));
  ball.x = center.x, ball.y = center.y, ball.z = center.z;
  ball.radius = static_cast<float>(radius_);
  ball.label = label_;
  ball.filling = this;
  const FillBlock block{lo - ball.head.base,
                        size,
                        distance,
                        tissue,
                        static_cast<std::ptrdiff_t>(stride_x),
                        static_cast<std::ptrdiff_t>(stride_y)};
  return lower_rows(&ball, &block, added, fresh);
}

}  // namespace typodont::haptics
