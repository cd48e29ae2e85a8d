// Records which surface the probe's tip touched, and where the user marked caries with the pedal.
#pragma once

#include <span>
#include <vector>

#include "engine/contract/contact.h"
#include "engine/contract/field_brick.h"
#include "engine/session/dense_field.h"

namespace typodont::session {

struct ExploreMeasures {
  int lesions = 0;      // number of connected pieces of caries that reach the surface
  int found = 0;        // number of lesions that were marked
  int false_finds = 0;  // number of marks that the user set on sound tissue
  double explored = 0;  // fraction of the region's surface that was explored, 0 to 1
};

/// Call add() with all ticks in order. Pressing the pedal while the tip touches makes a mark.
class ExploreMeter {
 public:
  /// `region`: voxels whose surface must be explored; empty: all voxels.
  ExploreMeter(const VoxelFrame& frame, const DenseField& surface, const std::vector<Tissue>& tissue,
               const std::vector<bool>& region);
  void add(std::span<const ServoTick> ticks);
  ExploreMeasures result() const;

 private:
  VoxelFrame frame_;
  DenseField surface_;
  std::vector<int> lesion_;  // number of each voxel's lesion, from 1; 0: none
  std::vector<bool> to_explore_, explored_;
  std::size_t surface_count_ = 0, explored_count_ = 0;
  std::vector<bool> found_;  // for each lesion: true if it was marked
  int false_finds_ = 0;
  bool pedal_down_ = false;
  dvec3 last_{1e9, 0, 0};  // voxels, position of the tip at the last update
};

}  // namespace typodont::session
