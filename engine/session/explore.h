// Where the tip touched, and where the pedal marked caries.
#pragma once

#include <span>
#include <vector>

#include "engine/contract/contact.h"
#include "engine/contract/field_brick.h"
#include "engine/session/dense_field.h"

namespace typodont::session {

struct ExploreMeasures {
  int lesions = 0;      // connected caries that reaches the surface
  int found = 0;        // number of lesions that were marked
  int false_finds = 0;  // marks on sound tissue
  double explored = 0;  // of the region's surface, 0..1
};

/// add() in order. A mark: pedal pressed in contact.
class ExploreMeter {
 public:
  /// `region`: voxels whose surface is to be explored; empty: all.
  ExploreMeter(const VoxelFrame& frame, const DenseField& surface, const std::vector<Tissue>& tissue,
               const std::vector<bool>& region);
  void add(std::span<const ServoTick> ticks);
  ExploreMeasures result() const;

 private:
  VoxelFrame frame_;
  DenseField surface_;
  std::vector<int> lesion_;  // 1, 2 … per voxel; 0: none
  std::vector<bool> to_explore_, explored_;
  std::size_t surface_count_ = 0, explored_count_ = 0;
  std::vector<bool> found_;  // by a mark, per lesion
  int false_finds_ = 0;
  bool pedal_down_ = false;
  dvec3 last_{1e9, 0, 0};  // voxels, of the tip at the last update
};

}  // namespace typodont::session
