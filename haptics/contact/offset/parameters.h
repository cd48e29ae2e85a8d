// The constants of the offset method, each with its unit and its reason. Lengths are in voxels unless a unit is given:
// the resolution of the field, which grows with the voxel, determines them.
#pragma once

#include <cstddef>

namespace typodont::haptics::offset {

/// Search for the proxy's position: iterations of "find contacts, project, move" (proxy.cpp).
struct SearchParameters {
  static constexpr double contact_range = 0.8;  // voxels, largest gap of a contact that the search considers
  // Voxels, longest step of the proxy in one iteration while it has several contacts; less than contact_range, so that
  // no contact is missed.
  static constexpr double contact_step = 0.6;
  // Voxels, longest step of the proxy in one iteration while it has at most one contact; a step passes through no
  // tissue that is thicker than this.
  static constexpr double free_step = 1.5;
  static constexpr double reuse_distance = 0.3;  // voxels, path length after which contacts are searched again
  static constexpr double converged = 1e-6;      // voxels, threshold: a shorter step ends the search on one smooth wall
  // Voxels; the search ends when the remaining path, extrapolated as a geometric series, is shorter than this.
  static constexpr double foreseen = 1e-7;
  static constexpr double settled = 2e-5;  // voxels, threshold: with several contacts, a shorter step ends the search
  // Voxels, threshold: with several contacts, a shorter step ends the search of a cutting tool. The error of the
  // position is then about the square of this step.
  static constexpr double settled_cutting = 0.03;
  static constexpr int iterations = 48;  // limit of iterations per tick, free motion included
  // Upper limits of the iterations in contact per tick.
  static constexpr int settling_iterations = 8, settling_iterations_cutting = 5;
  // limit of long steps that reverse the previous long step; a search with more reversals does not converge
  static constexpr int reversals = 2;
  // Upper limit of the rounds of exact queries for the planes that hold a head which does not cut.
  static constexpr int refining_rounds = 6;
  // Ratio of successive steps up to which the secant method is used.
  static constexpr double still_converges = 0.95;
  static constexpr double most_gain = 10;         // upper limit of the secant method's gain with one contact
  static constexpr double most_gain_of_many = 2;  // upper limit of the secant method's gain with several contacts
  // Voxels, upper limit of the depth that one tick may cut; the contact planes do not describe a deeper surface.
  static constexpr double most_slack = 1;
  // Voxels, largest overlap that errors of cutting or rounding cause; with a larger overlap the head is moved out of
  // the tissue slowly.
  static constexpr double deep = 0.6;
};

/// Limits for a ball that slides along one smooth wall. Its position follows from the wall alone (ContactFinder::seat),
/// and the search is skipped.
struct WallPlacementParameters {
  // voxels, overlap of the placed ball with an approximate contact plane above which the search is used instead
  static constexpr double overlap = 0.1;
  // voxels, overlap of the placed ball with the exact plane of another wall above which the search is used instead
  static constexpr double other_wall = 4e-3;
  static constexpr double same_wall = 0.9;  // cosine between normals above which two planes count as one wall
  // voxels, overlap with the same wall, beside the contact point, above which the search is used instead
  static constexpr double same_wall_overlap = 0.02;
  static constexpr double alone = 2e-4;  // voxels, step below which the ball with one exact contact has converged
};

/// Limits of the proxy's speed relative to the hand while a bur cuts, so that the force changes by at most 0.02 N per
/// tick.
struct PaceParameters {
  static constexpr double cut_slew = 6;  // N/s, limit of the change of a cutting contact's force by the proxy
  // N/s, limit of the change of a force that ends because the bur broke through
  static constexpr double free_slew = 14;
  static constexpr double grip_slew = 9;      // N/s, limit of the force's rise when the teeth catch
  static constexpr double tooth_grip = 0.15;  // friction coefficient of engaged teeth: lateral force divided by push
  static constexpr double tolerance = 1.02;   // ratio of speed to speed limit up to which the limit counts as observed
  static constexpr int rounds = 4;            // limit of iterations toward the speed limit
  // A bur is in debt if it has removed tissue before the motor's work has paid for it. The debt is given in s, the time
  // in which the motor does this work. A bur with a larger debt than this is slowed down.
  static constexpr double free_debt = 3e-3;
  static constexpr double standing_debt = 12e-3;  // s, debt at which a bur stops
};

/// Parameters for a hand that falls because the tissue under the bur was removed. They limit the landing speed, which
/// is the speed at which the bur then meets the tissue (follow_fall).
struct FallParameters {
  static constexpr double rough_time = 2e-3;  // s, time constant of the hand's short-term mean velocity
  static constexpr double speed_time = 0.1;   // s, time constant of the hand's long-term mean velocity
  static constexpr double push_time = 0.05;   // s, time constant of the mean push that held the hand up
  static constexpr double gain = 5;     // N/s, increase of the hand's speed × stiffness above which a motion is a fall
  static constexpr double along = 0.3;  // least cosine between the mean push and the direction against the fall
  static constexpr double landing_slew = 12;  // N/s, landing speed × stiffness that is always allowed
  // A landing speed of up to this factor times the hand's long-term mean speed is always allowed.
  static constexpr double growth = 1.2;
  // N/s, limit of the required braking: the difference between the hand's speed and the landing speed, × stiffness
  static constexpr double brake = 12;
};

/// One-sided walls from soft to hard tissue (Wang 2009, "boundary walls").
struct WallParameters {
  static constexpr double felt_depth = 0.1e-3;  // m, depth in harder tissue up to which the wall still acts on a head
  static constexpr double border = 0.5;         // voxels on each side of a border whose samples may show either tissue
  static constexpr double least_power = 0.1;    // lower limit of the fraction of the power at a wall
  // ratio of the softer to the harder tissue's specific energy below which a border is a wall
  static constexpr double from_ratio = 0.2;
  static constexpr int rounds = 4;  // limit of projections after each of which planes at walls are made less yielding
};

/// Recovery of a tool inside tissue, and of a tool outside its patch.
struct RecoveryParameters {
  static constexpr double recovery_time = 6e-3;  // s, time constant with which the tool is led out of tissue
  static constexpr double least_overlap = 0.01;  // voxels, overlap below which the tool counts as outside
  static constexpr double patch_wait =
      0.01;  // s, time that the tool may wait at the border of its patch before the patch counts as late
  // m, distance from the patch's border up to which the last contact's plane has its full force
  static constexpr double bridge_reach = 5e-3;
  // N, amount by which the force of a plane that replaces a late patch may exceed the last contact's force.
  static constexpr double bridge_yield = 0.5;
  // s, longest use of a plane that replaces a missing patch; only with version 1 of the force laws
  static constexpr double bridge_time_of_laws_1 = 0.5;
  static constexpr double rejoin_time = 0.3;  // s, duration of the return from a bridging plane to the surface
};

/// Conditions for the retreat: if the hand has moved away from a proxy that its contacts hold, the proxy is led back
/// along its path.
struct RetreatParameters {
  static constexpr double far = 2e-3;      // m, distance from proxy to hand above which the hand may have moved away
  static constexpr double still = 0.3e-3;  // m, motion below which the proxy counts as held
  // m, distance from proxy to hand above which the hand has certainly moved away: nobody presses so far at 1 N/mm
  static constexpr double too_far = 5e-3;
  static constexpr double patience = 0.3;  // s, time that the proxy must be held before it is led back
  static constexpr double report_after =
      1;  // s, time that the proxy must be held before a fault reports that no path back was found
  // m, a point of the path must be nearer to the hand than the proxy by this distance
  static constexpr double gain = 0.1e-3;
  static constexpr double slew = 14;       // N/s, limit of the force's change while the proxy is led back
  static constexpr double outside = 1e-3;  // m, distance between head and tissue above which a new path begins
  static constexpr double look_step = 1;   // voxels, distance between two samples along the line to the hand
};

/// Updates of the coarse patch, which the shank touches.
struct CoarseParameters {
  static constexpr double cut_step = 0.2;  // coarse voxels, motion of the head between two cuts in the coarse patch
};

/// Limits for a filling instrument (filling.cpp).
struct FillingParameters {
  // s; filling that cannot be placed yet waits. At most the volume that the instrument gives in this time can wait; the
  // rest is lost.
  static constexpr double waits = 0.05;
  static constexpr double one_surface = 0.5;  // slope of the field below which a point lies midway between surfaces
  // voxels, distance between two samples in the search for tissue to fill on
  static constexpr double look_step = 0.25;
  static constexpr double step = 0.25;    // voxels, growth of a dome per tick that is always allowed
  static constexpr double most_step = 1;  // voxels, upper limit of a small dome's growth per tick
  static constexpr double ahead = 0.01;   // s; a dome may grow in one tick by the volume given in this time
  static constexpr double least_step = 1e-3;
  static constexpr double buried = 0.01;  // fraction of the dome's surface that must be free for it to grow on
  // Voxels; a position is free for filling if tissue, head and the limit of the search are at least this far away.
  static constexpr double open = 0.5;
  static constexpr double flows_on = 3;     // ratio of the search distance through filling to the instrument's reach
  static constexpr double flow_step = 0.5;  // voxels, distance between two samples along a ray
  // limit of consecutive samples inside tissue on a ray, because the voxels at a filled wall contain both tissue and
  // filling
  static constexpr int thin = 3;
  // Limit per tick of the cost of the search for a free position, in units of about 1 ns.
  static constexpr int search_cost = 60000;
  // Costs, in units of about 1 ns, of a skipped ray, of a sample, and of a test whether filling fits at a sample.
  static constexpr int skip_cost = 1, sample_cost = 5, room_cost = 60;
  static constexpr std::size_t directions = 2048;  // number of rays along which a free position for filling is searched
};

}  // namespace typodont::haptics::offset
