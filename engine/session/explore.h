// Records which surface the probe's tip touched, and where the user marked caries or read a pocket's depth with the
// pedal.
#pragma once

#include <span>
#include <vector>

#include "engine/contract/contact.h"
#include "engine/contract/field_brick.h"
#include "engine/session/dense_field.h"

namespace typodont::session {

/// A site at which the depth of a pocket is measured.
struct ProbeSite {
  dvec3 margin_W{0}, floor_W{0};  // m, middle of the pocket at the gum's margin and at its floor
};

/// What the user read at a site.
struct SiteReading {
  double depth = 0;     // m, true depth below the margin, along the tooth's axis
  double reading = -1;  // m, last reading; negative: none
  double force = 0;     // N, force along the tooth's axis at the last reading
};

struct ExploreMeasures {
  int lesions = 0;                   // number of connected pieces of caries that reach the surface
  int found = 0;                     // number of lesions that were marked
  int false_finds = 0;               // number of marks that the user set on sound tissue
  double explored = 0;               // fraction of the region's surface that was explored, 0 to 1
  std::vector<SiteReading> sites{};  // of a task that measures pockets; empty: the task is to find lesions
  double probing_force = 0;          // N, largest force along the tooth's axis in a pocket

  int sites_read() const;
  /// Number of sites whose reading differs from the depth by at most `tolerance` (m).
  int sites_within(double tolerance) const;
};

/// Call add() with all ticks in order. Pressing the pedal while the tip touches makes a mark.
class ExploreMeter {
 public:
  /// `region`: voxels whose surface must be explored; empty: all voxels.
  ExploreMeter(const VoxelFrame& frame, const DenseField& surface, const std::vector<Tissue>& tissue,
               const std::vector<bool>& region);
  /// Measures pockets. `axis_W`: unit vector out of the tooth's crown. `tip`: m, radius of the probe's ball.
  ExploreMeter(std::vector<ProbeSite> sites, const dvec3& axis_W, double tip);
  void add(std::span<const ServoTick> ticks);
  ExploreMeasures result() const;

 private:
  void probe(const ServoTick& tick, bool pressed);

  std::vector<ProbeSite> sites_;
  std::vector<SiteReading> readings_;
  dvec3 axis_W_{0, 0, 1};
  double tip_ = 0, probing_force_ = 0;
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
