// The lists of the active front (CutFront), all that most cuts change. Private to haptics/cutting.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>

#include "engine/contract/tissue.h"
#include "haptics/cutting/cut_front.h"
#include "haptics/cutting/inside_fraction.h"
#include "haptics/cutting/meridian.h"
#include "haptics/cutting/way.h"
#include "haptics/volume/label.h"

namespace typodont::haptics {

/// Voxels from a nearby voxel: A, A to B, radius. `continues`: the last sweep ended at A.
struct Capsule {
  float ax, ay, az;
  float abx, aby, abz;
  float inverse_length2, radius;
  bool continues;
};

/// As plain data. Positions from the first voxel of the front's first block.
struct BallFront {
  Capsule c;
  // from the origin of `c`
  glm::ivec3 origin;
  float* distance;  // at the origin
  struct {          // by z
    // Capsule: voxels along z from A; if B covers all ahead of A: voxels², squared from B along z.
    float* apart;
    // voxels², along z from A × motion's z
    float* ahead;
  } heights;
  CutFront::Listed groups;
  // Ahead of the ball, beside, behind.
  struct Ranges {
    int count;
    struct {
      int from, to;
    } at[3];
  } wide, narrow;
};

/// For other heads, as plain data.
struct HeadFront {
  HeadPose pose;
  const MeridianPiece* pieces;
  glm::ivec3 origin;  // from HeadPose::base
  float* distance;
  // per z: its terms of x, y, z in T
  float* along[3];
  CutFront::Listed groups;
  const CutFront::Run* runs;
  int run_count;
  PathMaxima* tops;
};

/// At a group's start, at most `lanes`. Empty air matches all.
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

/// True: changed; volume to `removed`.
bool carve_listed_ball(const BallFront& front, bool capsule, int lanes, RemovedVolume* removed) noexcept;
bool carve_listed_head(const HeadFront& front, int lanes, RemovedVolume* removed) noexcept;

}  // namespace typodont::haptics
