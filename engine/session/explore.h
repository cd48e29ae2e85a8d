// Evaluates an exploration: where the tip touched the tissue, and where the trainee marked caries with the pedal.
#pragma once

#include <span>
#include <vector>

#include "engine/contract/contact.h"
#include "engine/contract/field_brick.h"
#include "engine/session/dense_field.h"

namespace typodont::session {

struct ExploreMeasures {
  int lesions = 0;      // number of lesions; a lesion is a connected piece of caries that extends to the surface
  int found = 0;        // number of lesions that were marked
  int false_finds = 0;  // number of marks on sound tissue, which found no lesion
  double explored = 0;  // fraction of the region's surface that the tip explored, 0..1
};

/// Measures an exploration. Call add() with the ticks in order. The trainee sets a mark by pressing the pedal while the
/// tip touches the tissue.
class ExploreMeter {
 public:
  /// `region` marks the voxels whose surface the trainee must explore. If `region` is empty, the trainee must explore
  /// the whole surface.
  ExploreMeter(const VoxelFrame& frame, const DenseField& surface, const std::vector<Tissue>& tissue,
               const std::vector<bool>& region);
  void add(std::span<const ServoTick> ticks);
  ExploreMeasures result() const;

 private:
  VoxelFrame frame_;
  DenseField surface_;
  std::vector<int> lesion_;  // number 1, 2 … of each voxel's lesion; 0 if the voxel belongs to no lesion
  std::vector<bool> to_explore_, explored_;
  std::size_t surface_count_ = 0, explored_count_ = 0;
  std::vector<bool> found_;  // true for each lesion that a mark has found
  int false_finds_ = 0;
  bool pedal_down_ = false;
  dvec3 last_{1e9, 0, 0};  // voxels, position of the tip at the last update
};

}  // namespace typodont::session
