// What a hand found with the explorer: where it touched, and where it pressed the pedal to say "here is caries".
#pragma once

#include <span>
#include <vector>

#include "engine/contract/contact.h"
#include "engine/contract/field_brick.h"
#include "engine/session/dense_field.h"

namespace typodont::session {

struct ExploreMeasures {
  int lesions = 0;      // connected pieces of caries that reach the surface
  int found = 0;        // of them marked
  int false_finds = 0;  // marks on sound tissue
  double explored = 0;  // share of the surface to be explored that the tip came near, 0..1
};

/// Feed ticks in order. A mark is the pedal going down while the tip touches.
class ExploreMeter {
 public:
  /// `region`: voxels whose surface is to be explored; empty: all of it.
  ExploreMeter(const VoxelFrame& frame, const DenseField& surface, const std::vector<Tissue>& tissue,
               const std::vector<bool>& region);
  void add(std::span<const ServoTick> ticks);
  ExploreMeasures result() const;

 private:
  VoxelFrame frame_;
  DenseField surface_;
  std::vector<int> lesion_;  // per voxel: 0 none, 1, 2 …
  std::vector<bool> to_explore_, explored_;
  std::size_t surface_count_ = 0, explored_count_ = 0;
  std::vector<bool> found_;  // per lesion
  int false_finds_ = 0;
  bool pedal_down_ = false;
  dvec3 last_{1e9, 0, 0};  // voxels, where the surface was last marked as explored
};

}  // namespace typodont::session
