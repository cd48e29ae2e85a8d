#include "haptics/cutting/listed.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <type_traits>

#include "haptics/cutting/lane_ops.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

namespace {

constexpr float kTurnsBack = 1e9f;  // of a corner

}  // namespace

// Compiled for each width of lanes and chosen at run time. Every sample is computed by itself, volumes are counted in whole
// units and FMA is off for the whole program, so that every processor gives the same bits.
namespace halves {
namespace {

#include "haptics/cutting/cut_kernel.h"
#include "haptics/cutting/depth_kernel.h"
#include "haptics/cutting/listed_kernel.h"

bool ball(const BallFront* f, PerTissue* removed) { return raise_ball<false>(*f, removed); }
bool capsule(const BallFront* f, PerTissue* removed) { return raise_ball<true>(*f, removed); }
bool head(const HeadFront* f, PerTissue* removed) { return raise_head(*f, false, removed); }

}  // namespace
}  // namespace halves

#ifdef TYPODONT_SIXTEEN_LANES
namespace eight {
namespace {

#include "haptics/cutting/cut_kernel.h"
#include "haptics/cutting/depth_kernel.h"
#include "haptics/cutting/listed_kernel.h"

__attribute__((target("avx2"))) bool ball(const BallFront* f, PerTissue* removed) { return raise_ball<false>(*f, removed); }
__attribute__((target("avx2"))) bool capsule(const BallFront* f, PerTissue* removed) { return raise_ball<true>(*f, removed); }
__attribute__((target("avx2"))) bool head(const HeadFront* f, PerTissue* removed) { return raise_head(*f, false, removed); }

}  // namespace
}  // namespace eight

#pragma GCC push_options
#pragma GCC target("arch=x86-64-v4")
namespace sixteen {
namespace {

#include "haptics/cutting/cut_kernel.h"
#include "haptics/cutting/depth_kernel.h"
#include "haptics/cutting/listed_kernel.h"

bool ball(const BallFront* f, PerTissue* removed) { return raise_ball<false>(*f, removed); }
bool capsule(const BallFront* f, PerTissue* removed) { return raise_ball<true>(*f, removed); }
bool head(const HeadFront* f, PerTissue* removed) { return raise_head(*f, false, removed); }

}  // namespace
}  // namespace sixteen

namespace eight_masked {
namespace {

#include "haptics/cutting/cut_kernel.h"
#include "haptics/cutting/depth_kernel.h"
#include "haptics/cutting/listed_kernel.h"

bool head(const HeadFront* f, PerTissue* removed) { return raise_head(*f, true, removed); }

}  // namespace
}  // namespace eight_masked
#pragma GCC pop_options
#endif

void flatten(const HeadField& head, MeridianPiece* pieces) {
  for (int p = 0; p < head.count; ++p) {
    const HeadField::Piece& piece = head.pieces[p];
    const double length = std::sqrt(1 / piece.inverse2), r = piece.radius;
    const bool line = r == 0;
    const double values[] = {piece.ax, piece.az, piece.bx, piece.bz, piece.dx, piece.dz, piece.inverse2, piece.cx, piece.cz, r,
                             line ? piece.dz / length : (piece.ax - piece.cx) / r,
                             line ? -piece.dx / length : (piece.az - piece.cz) / r,
                             line ? piece.dz / length : (piece.bx - piece.cx) / r,
                             line ? -piece.dx / length : (piece.bz - piece.cz) / r, length,
                             piece.ax - piece.cx, piece.az - piece.cz, piece.bx - piece.cx, piece.bz - piece.cz, 0, 0};
    static_assert(sizeof(MeridianPiece) == std::size(values) * sizeof(float));
    float flat[std::size(values)];
    for (std::size_t i = 0; i < std::size(values); ++i) flat[i] = static_cast<float>(values[i]);
    std::memcpy(&pieces[p], flat, sizeof flat);
  }
  for (int p = 0; p + 1 < head.count; ++p) {
    const float c = std::clamp(pieces[p].nbx * pieces[p + 1].nax + pieces[p].nbz * pieces[p + 1].naz, -1.0f, 1.0f);
    pieces[p].corner_b = pieces[p + 1].corner_a = std::min(std::sqrt((1 - c) / (1 + c)), kTurnsBack);
  }
}

HeadPose head_pose(const Pose& X_VT) {
  HeadPose pose;
  pose.base = glm::ivec3(glm::floor(X_VT.p));
  const glm::vec3 p(X_VT.p - dvec3(pose.base));
  const glm::mat3 R(glm::transpose(glm::dmat3(X_VT.R)));
  for (int i = 0; i < 3; ++i) pose.p[i] = p[i];
  for (int i = 0; i < 9; ++i) pose.R[i] = R[i / 3][i % 3];
  return pose;
}

int widest_group() noexcept {
#ifdef TYPODONT_SIXTEEN_LANES
  if (__builtin_cpu_supports("x86-64-v4")) return sixteen::kLanes;
#endif
  return halves::kLanes;
}

bool raise_listed_ball(const BallFront& front, bool capsule, int lanes, PerTissue* removed) noexcept {
#ifdef TYPODONT_SIXTEEN_LANES
  if (lanes == sixteen::kLanes) return capsule ? sixteen::capsule(&front, removed) : sixteen::ball(&front, removed);
  if (__builtin_cpu_supports("avx2")) return capsule ? eight::capsule(&front, removed) : eight::ball(&front, removed);
#endif
  (void)lanes;
  return capsule ? halves::capsule(&front, removed) : halves::ball(&front, removed);
}

bool raise_listed_head(const HeadFront& front, int lanes, PerTissue* removed) noexcept {
#ifdef TYPODONT_SIXTEEN_LANES
  if (lanes == sixteen::kLanes) {
    const bool wide = sixteen::head(&front, removed), narrow = eight_masked::head(&front, removed);
    return wide || narrow;
  }
  if (__builtin_cpu_supports("avx2")) return eight::head(&front, removed);
#endif
  (void)lanes;
  return halves::head(&front, removed);
}

}  // namespace typodont::haptics
