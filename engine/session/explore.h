// Evaluates an exploration: the places that the tip touched, and the places that the trainee marked as caries with the
// pedal.
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
  int false_finds = 0;  // number of marks on sound tissue
  double explored = 0;  // fraction of the region's surface that the tip explored, 0..1
};

/// Measures an exploration. Pass ticks in order. The trainee sets a mark by pressing the pedal while the tip touches
/// the tissue.
class ExploreMeter {
 public:
  /// `region`: voxels whose surface must be explored; empty: the whole surface.
  ExploreMeter(const VoxelFrame& frame, const DenseField& surface, const std::vector<Tissue>& tissue,
               const std::vector<bool>& region);
  void add(std::span<const ServoTick> ticks);
  ExploreMeasures result() const;

 private:
  VoxelFrame frame_;
  DenseField surface_;
  std::vector<int> lesion_;  // for each voxel: number of its lesion 1, 2 …; 0: no lesion
  std::vector<bool> to_explore_, explored_;
  std::size_t surface_count_ = 0, explored_count_ = 0;
  std::vector<bool> found_;  // for each lesion: true if a mark found it
  int false_finds_ = 0;
  bool pedal_down_ = false;
  dvec3 last_{1e9, 0, 0};  // voxels, position of the last update
};

}  // namespace typodont::session
