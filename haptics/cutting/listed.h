// Cuts the groups of samples in the lists of the active front (CutFront). Most cuts change only these samples. Private
// to haptics/cutting.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>

#include "engine/contract/tissue.h"
#include "haptics/cut_front.h"
#include "haptics/cutting/meridian.h"
#include "haptics/cutting/way.h"
#include "haptics/inside_fraction.h"
#include "haptics/label.h"

namespace typodont::haptics {

/// A moving ball as plain data, in voxels relative to a nearby voxel: its start A, its motion from A to B, and its
/// radius. `continues`: true if the previous sweep ended at A.
struct Capsule {
  float ax, ay, az;
  float abx, aby, abz;
  float inverse_length2, radius;
  bool continues;
};

/// A cut by a ball, and the active front of its patch (samples that cuts can change, CutFront), as plain data.
/// Positions are relative to the first voxel of the front's first block of samples.
struct BallFront {
  Capsule c;
  // position of the first block's first voxel, relative to the voxel that is the origin of the positions in `c`
  glm::ivec3 origin;
  float* distance;  // pointer to the distance of the sample at the origin
  struct {          // tables of terms that depend only on the z coordinate of a sample; this coordinate is the index
    // If the sweep is a capsule: voxels, distance of the sample from A (the start of the sweep) along z. Otherwise, if
    // the ball at B (the end) covers everything ahead of A: voxels², squared distance from B along z.
    float* apart;
    // voxels², distance from A (the start of the sweep) along z, multiplied by the z component of the motion
    float* ahead;
  } heights;
  CutFront::Listed groups;
  // Ranges of the groups that may change in this cut. There are three ranges: groups ahead of the ball, beside it, and
  // behind it.
  struct Ranges {
    int count;
    struct {
      int from, to;
    } at[3];
  } wide, narrow;
};

/// A cut by a head that is not a ball, and the active front of its patch (samples that cuts can change), as plain data.
struct HeadFront {
  HeadPose pose;
  const MeridianPiece* pieces;
  glm::ivec3 origin;  // origin of the positions of the groups of samples, relative to the voxel HeadPose::base
  float* distance;
  // for each z coordinate of a sample: the z-dependent terms of the sample's coordinates x, y, z in the head's frame T
  float* along[3];
  CutFront::Listed groups;
  const CutFront::Run* runs;
  int run_count;
  PathMaxima* tops;
};

/// Returns how many samples at the start of a group have the same label (at most `lanes`). Air samples whose voxels
/// contain no tissue match every label.
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

/// These functions cut the listed groups of samples. They return true if a sample changed, and add the removed volume
/// to `removed`.
bool carve_listed_ball(const BallFront& front, bool capsule, int lanes, RemovedVolume* removed) noexcept;
bool carve_listed_head(const HeadFront& front, int lanes, RemovedVolume* removed) noexcept;

}  // namespace typodont::haptics
