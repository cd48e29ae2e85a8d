// Parameters of the model "offset", with unit and reason. Most lengths are in voxels, because the resolution of the
// field determines them.
#pragma once

#include <cstddef>
#include <cstdint>

namespace typodont::haptics::offset {

/// Iteration that computes the proxy: find contacts, project, move, until the proxy no longer moves (proxy.cpp).
struct SearchParameters {
  // voxels; tissue whose distance from the head is below this is a contact
  static constexpr double contact_range = 0.8;
  // voxels, largest step of the proxy per iteration with several contacts; below contact_range, to miss no contact
  static constexpr double contact_step = 0.6;
  // voxels, largest step per iteration with at most one contact. Tissue thicker than this cannot be skipped.
  static constexpr double free_step = 1.5;
  // voxels that the head moves before contacts are searched again
  static constexpr double reuse_distance = 0.3;
  // voxels; with one contact, a step of the proxy shorter than this ends the search
  static constexpr double converged = 1e-6;
  // voxels; with one contact, the search ends if the sum of all further steps (geometric series) is smaller than this
  static constexpr double foreseen = 1e-7;
  // voxels; with several contacts, a step of the proxy shorter than this ends the search
  static constexpr double settled = 2e-5;
  // voxels; like `settled` (with several contacts, a shorter step ends the search), but while cutting. The remaining
  // error is about the square of this, because the search converges quadratically.
  static constexpr double settled_cutting = 0.03;
  // largest number of iterations per tick
  static constexpr int iterations = 48;
  // Largest number of iterations per tick in contact: without cutting, and while cutting.
  static constexpr int settling_iterations = 8, settling_iterations_cutting = 5;
  // Largest number of long steps opposite to the step before; with more, the search ends, as it does not converge.
  static constexpr int reversals = 2;
  // Voxels. If the last step is longer than `unsettled`, the search has not converged (hand deeper than the surface's
  // radius of curvature). Then the position with the smallest distance to the hand + overlap_weight × overlap is used.
  static constexpr double unsettled = 0.02, overlap_weight = 4;
  // voxels; the nearest contact plane is computed exactly if its gap at the head's next position is below this
  static constexpr double may_block = 0.4;
  // Without cutting: how often an iteration may compute the exact planes of the contacts that stop the head.
  static constexpr int refining_rounds = 6;
  // The secant method lengthens a step of the proxy only if its ratio to the previous step is below this.
  static constexpr double still_converges = 0.95;
  // for a head with one contact: largest factor by which the secant method lengthens a step of the proxy
  static constexpr double max_gain = 10;
  // for a head with several contacts: largest factor by which the secant method lengthens a step of the proxy
  static constexpr double max_gain_of_many = 2;
  // voxels; a place that the servo has computed is not taken if a contact overlaps by more than this
  static constexpr float placed_overlap = 0.25f;
  // voxels, largest depth per tick that a cutting head sinks into tissue; contact planes are not valid deeper
  static constexpr double max_allowed_depth = 1;
  // voxels; overlap of head and tissue up to this comes from cutting or rounding. A deeper head is moved out slowly.
  static constexpr double deep = 0.6;
  // voxels; a head deep in tissue is moved out along the field's gradients until its overlap with tissue is below this
  static constexpr double led_out = 0.1;
};

/// Limits within which the position of a ball on one smooth wall is computed directly (ContactFinder::seat). Otherwise
/// the search iterates.
struct WallPlacementParameters {
  // voxels, largest allowed overlap of the placed ball-shaped head with an approximate contact plane
  static constexpr double overlap = 0.1;
  // voxels, largest allowed overlap of a ball-shaped head, placed directly on one wall, with any other wall
  static constexpr double other_wall = 4e-3;
  // two contact planes belong to the same wall if the cosine between their normals is above this
  static constexpr double same_wall = 0.9;
  // voxels, largest allowed overlap of a ball-shaped head with other contact planes of the wall on which it is placed
  static constexpr double same_wall_overlap = 0.02;
  // voxels; the position of a placed ball-shaped head is accepted if one search iteration moves it by less than this
  static constexpr double alone = 2e-4;
};

/// Limits the change of the force while cutting to at most 0.02 N per tick, by limiting the proxy's speed relative to
/// the hand.
struct StepLimitParameters {
  static constexpr double cut_slew = 6;  // N/s, limit of the force's rate in contact
  // N/s, limit of the force's rate when the head breaks through
  static constexpr double free_slew = 14;
  // N/s, limit of the force's rate for a head that slips without cutting, for example off a ridge
  static constexpr double slip_slew = 60;
  static constexpr double tolerance = 1.02;  // factor by which the limit of the force's rate may be exceeded
  static constexpr int rounds = 4;           // largest number of iterations that enforce the limit of the force's rate
  // s; energy that cuts used beyond the motor's work, divided by the motor's power. Above this, the bur is slowed down.
  static constexpr double free_deficit = 3e-3;
  static constexpr double standing_deficit = 12e-3;  // s; like `free_deficit`, but above this, the bur stops
};

/// Fall: the tissue that supported the bur is gone, and the pressing hand accelerates until the next contact. The bur's
/// speed is limited, so that it does not hit tissue hard (follow_fall).
struct FallParameters {
  // s, time constant of the filter for the hand's current velocity
  static constexpr double rough_time = 2e-3;
  // s, time constant of the filter for the hand's mean velocity
  static constexpr double speed_time = 0.1;
  // s, time constant of the filter for the mean contact force, which keeps its direction when the support is lost
  static constexpr double push_time = 0.05;
  // N/s; the bur has lost its support only if (current - mean velocity of the hand) × stiffness is larger than this
  static constexpr double gain = 5;
  // Support is lost only if the cosine of mean contact force and (mean - current velocity of the hand) is above this.
  static constexpr double along = 0.3;
  // N/s; this value divided by the stiffness is a speed that a bur without support may always have
  static constexpr double landing_slew = 12;
  // no unit; after the tissue below the bur has gone, the bur may move at `growth` × the hand's mean speed
  static constexpr double growth = 1.2;
  // N/s; a bur that lost its support is slower than the hand by at most this value divided by the stiffness
  static constexpr double brake = 12;
};

/// Walls: borders to harder tissue that stop a head which comes from softer tissue (Wang 2009, "boundary walls").
struct WallParameters {
  // m, depth in harder tissue up to which its border still stops the head
  static constexpr double felt_depth = 0.1e-3;
  // voxels; a sample nearer than this to a border between two tissues may have the label of either tissue
  static constexpr double border = 0.5;
  // smallest fraction of its power with which a bur cuts at a wall of harder tissue
  static constexpr double min_power = 0.1;
  // A border is a wall if the ratio of the softer tissue's specific energy to that of the harder one is below this.
  static constexpr double from_ratio = 0.2;
  // Largest number of rounds per iteration. A round reduces the allowed overlap at walls, and moves the proxy again.
  static constexpr int rounds = 4;
};

/// Recovery of a head inside tissue, and after a missing tissue patch.
struct RecoveryParameters {
  // s, time constant with which the tolerated overlap of head and tissue decreases
  static constexpr double recovery_time = 6e-3;
  static constexpr double min_overlap = 0.01;  // voxels; a smaller overlap counts as none
  // s, duration of the proxy's smooth return to the surface after a plane has replaced a missing tissue patch
  static constexpr double rejoin_time = 0.3;
};

/// Cutting of the coarse patch, the tissue around the shank.
struct CoarseParameters {
  // coarse voxels that the head must move before the coarse patch is cut
  static constexpr double cut_step = 0.2;
  // largest number of ticks that a cut of the coarse patch may wait
  static constexpr int max_waits = 4;
};

/// Placing of filling by a filling instrument (filling.cpp).
struct FillingParameters {
  // s; if there is no room for the filling, only what the instrument delivers in this time is kept for later
  static constexpr double waits = 0.05;
  // Length of the distance field's gradient above which only one surface is near. The length is about 1 near one
  // surface, and smaller midway between two surfaces.
  static constexpr double one_surface = 0.5;
  // voxels between the examined points in front of the instrument
  static constexpr double search_step = 0.25;
  static constexpr double step = 0.25;   // voxels; each tick may enlarge the radius of the ball of filling by this
  static constexpr double max_step = 1;  // voxels, largest growth per tick of the radius of the ball of filling
  // s; per tick, the ball of filling gains at most the waiting material plus the material delivered in this time
  static constexpr double ahead = 0.01;
  static constexpr double min_step = 1e-3;
  // the ball of filling material grows only if more than this fraction of the ball's surface is in air
  static constexpr double buried = 0.01;
  // voxels; a place with room for filling is at least this far from tissue, head and border of Tool::fill_within
  static constexpr double open = 0.5;
  // largest distance at which free space is searched, from the centre of the first ball of filling, / Tool::fill_reach
  static constexpr double flows_on = 3;
  static constexpr double flow_step = 0.5;  // voxels, distance between two samples along a search ray
  // Largest number of consecutive tissue samples, apart from filling, that a search ray may pass.
  static constexpr int thin = 3;
  // ns, approximate time for the search per tick
  static constexpr int search_cost = 60000;
  // ns, approximate times: to skip a ray, to read a sample, to test whether a place has room for filling
  static constexpr int skip_cost = 1, sample_cost = 5, room_cost = 60;
  static constexpr std::size_t directions = 2048;  // number of search rays
};

}  // namespace typodont::haptics::offset
