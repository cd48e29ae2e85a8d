// Cuts the groups of samples that the active front of a tool (CutFront) lists. Most cuts change only listed samples.
// Private to haptics/cutting.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>

#include "engine/contract/tissue.h"
#include "haptics/cutting/cut_front.h"
#include "haptics/cutting/inside_fraction.h"
#include "haptics/cutting/meridian.h"
#include "haptics/cutting/path.h"
#include "haptics/volume/label.h"

namespace typodont::haptics {

/// A ball that moves from A to B, in voxels relative to a nearby voxel: point A, vector from A to B, radius.
/// `continues`: the last sweep ended at A.
struct Capsule {
  float ax, ay, az;
  float abx, aby, abz;
  float inverse_length2, radius;
  bool continues;
};

/// The lists of groups that a ball may change, as plain data. Positions: relative to the first voxel of the CutFront.
struct BallFront {
  Capsule c;
  // first voxel of the CutFront, relative to the voxel to which the positions in `c` refer
  glm::ivec3 origin;
  float* distance;  // pointer to the sample (signed distance) of the first voxel
  struct {          // tables, one value for each z
    // capsule: height of a sample above A, voxels; ball at B: squared height difference of a sample from B, voxels²
    float* apart;
    // voxels², height of a sample above the motion's start A, multiplied by the motion's z component
    float* ahead;
  } heights;
  CutFront::Listed groups;
  // Ranges of sample groups, as indices in `groups`: those ahead of, beside and behind the ball.
  struct Ranges {
    int count;
    struct {
      int from, to;
    } at[3];
  } wide, narrow;
};

/// Lists for a head that is not a ball: the groups of samples that the head may change, as plain data.
struct HeadFront {
  HeadPose pose;
  const MeridianPiece* pieces;
  glm::ivec3 origin;  // first voxel of the CutFront, relative to HeadPose::base
  float* distance;
  // tables, one value for each z: contributions of z to the coordinates x, y, z in frame T
  float* along[3];
  CutFront::Listed groups;
  const CutFront::Run* runs;
  int run_count;
  PathMaxima* tops;
};

/// Returns how many samples at the start of a group have one label, at most `lanes`. Air counts as any label.
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

/// Cuts the groups of samples in the front's lists. Returns true if a sample changed. Adds the cut volume to `removed`.
bool carve_listed_ball(const BallFront& front, bool capsule, int lanes, RemovedVolume* removed) noexcept;
bool carve_listed_head(const HeadFront& front, int lanes, RemovedVolume* removed) noexcept;

}  // namespace typodont::haptics
