// The groups of samples that are listed before a head (CutFront), raised: most cuts are just this. Private to
// haptics/cutting.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>

#include "engine/contract/tissue.h"
#include "haptics/cut_front.h"
#include "haptics/cutting/meridian.h"
#include "haptics/cutting/way.h"
#include "haptics/label.h"
#include "haptics/share.h"

namespace typodont::haptics {

/// A ball on its way, plain. Voxels, from some voxel nearby.
struct Capsule {
  float ax, ay, az;
  float abx, aby, abz;
  float inverse_length2, radius;
  bool continues;
};

/// A cut before which stands a front, plain. Positions count from the first voxel of the front's first block.
struct BallFront {
  Capsule c;
  glm::ivec3 origin;  // of those positions, from the base of c
  float* distance;    // at the origin
  struct {            // of each height …
    float* apart;     // … from A, or, where the ball at B is all, its square from B,
    float* ahead;     // … and × way
  } heights;
  CutFront::Listed groups;
  struct Ranges {  // of the groups that may have changed by now: ahead of the ball, beside it, behind it
    int count;
    struct {
      int from, to;
    } at[3];
  } wide, narrow;
};

/// The same before a head that is no ball.
struct HeadFront {
  HeadPose pose;
  const MeridianPiece* pieces;
  glm::ivec3 origin;  // from the pose's base
  float* distance;
  float* along[3];  // of each height: along x, y, z in T
  CutFront::Listed groups;
  const CutFront::Run* runs;
  int run_count;
  Tops* tops;
};

/// How many of the samples of a group, `lanes` at most, have one label. Where no surface can ever be, any label will
/// do.
inline int with_one_label(const Tissue* labels, const float* distance, int lanes, std::uint8_t& label) {
  label = static_cast<std::uint8_t>(shown(labels[0]));
  std::uint64_t differ = 0, part;
  for (int i = 0; i < lanes; i += 8) {
    std::memcpy(&part, labels + i, sizeof part);
    part &= kShown * 0x0101010101010101u;
    differ |= part ^ label * 0x0101010101010101u;
  }
  if (!differ) return lanes;
  for (int i = 0; i < lanes; ++i) {
    const auto other = static_cast<std::uint8_t>(shown(labels[i]));
    if (other == label || (other == static_cast<std::uint8_t>(Tissue::kAir) && distance[i] >= 0.5f)) continue;
    if (label != static_cast<std::uint8_t>(Tissue::kAir) ||
        !std::all_of(distance, distance + i, [](float d) { return d >= 0.5f; }))
      return i;
    label = other;
  }
  return lanes;
}

/// Return whether anything changed; volume taken is added to `removed`.
bool carve_listed_ball(const BallFront& front, bool capsule, int lanes, PerTissue* removed) noexcept;
bool carve_listed_head(const HeadFront& front, int lanes, PerTissue* removed) noexcept;

}  // namespace typodont::haptics
