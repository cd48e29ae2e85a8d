// Constants of the contact model "offset", each with its unit and its reason. Lengths are in voxels unless a unit is
// given, because the resolution of the distance field determines them.
#pragma once

#include <cstddef>
#include <cstdint>

namespace typodont::haptics::offset {

/// Search for the proxy's position. Each iteration finds contacts, projects the target onto the allowed region, and
/// moves the proxy (proxy.cpp).
struct SearchParameters {
  // voxels; the search uses only contacts whose gap between head and tissue is at most this
  static constexpr double contact_range = 0.8;
  // Voxels, longest step of one iteration with several contacts. It is shorter than contact_range, so that no contact
  // is missed.
  static constexpr double contact_step = 0.6;
  // Voxels, longest step of one iteration with at most one contact. A step cannot pass through tissue that is thicker
  // than the step is long.
  static constexpr double free_step = 1.5;
  // voxels; until the head has moved this far, the contacts of the last search are reused; then contacts are searched
  // again
  static constexpr double reuse_distance = 0.3;
  // voxels, convergence tolerance with one contact: a step shorter than this ends the search
  static constexpr double converged = 1e-6;
  // Voxels, second convergence criterion with one contact: the search also ends if the sum of all remaining steps is
  // smaller than this. The sum is estimated as a geometric series.
  static constexpr double foreseen = 1e-7;
  // voxels, convergence tolerance with several contacts: a step shorter than this ends the search
  static constexpr double settled = 2e-5;
  // Voxels, convergence tolerance with several contacts for a cutting tool: a step shorter than this ends the search.
  // The remaining error of the position is about the square of the last step, because the steps converge quadratically.
  static constexpr double settled_cutting = 0.03;
  // largest number of iterations per tick, including iterations without contact
  static constexpr int iterations = 48;
  // Largest number of iterations in contact per tick. settling_iterations: for a tool that does not cut;
  // settling_iterations_cutting: for a cutting tool.
  static constexpr int settling_iterations = 8, settling_iterations_cutting = 5;
  // A reversal is a long step that is opposite to the previous long step. After more reversals than this, the search
  // ends, because it would not converge.
  static constexpr int reversals = 2;
  // Largest number of refinement rounds per iteration for a tool that does not cut. Each round computes the
  // exact planes of the contacts that block the head.
  static constexpr int refining_rounds = 6;
  // The secant method is used only if the length of a step, divided by the length of the previous step, is at most
  // this.
  static constexpr double still_converges = 0.95;
  // largest factor by which the secant method lengthens a step, if there is only one contact
  static constexpr double most_gain = 10;
  // largest factor by which the secant method lengthens a step, if only one of several contacts blocks the head
  static constexpr double most_gain_of_many = 2;
  // Voxels, largest depth that one tick may cut. The contact planes describe the surface only up to this
  // depth.
  static constexpr double most_slack = 1;
  // Voxels, largest overlap that cutting or rounding can cause. A larger overlap means that the tool is inside tissue;
  // the tool is then moved out slowly.
  static constexpr double deep = 0.6;
};

/// Limits for a ball that slides on one smooth wall. Its position is computed directly from this wall
/// (ContactFinder::seat). If a limit is exceeded, the iterative search is used instead.
struct WallPlacementParameters {
  // voxels, largest allowed overlap of the placed ball with an approximate contact plane
  static constexpr double overlap = 0.1;
  // voxels, largest allowed overlap of the placed ball with the exact plane of another wall
  static constexpr double other_wall = 4e-3;
  // if the cosine between the normals of two planes is above this limit, both planes belong to the same wall
  static constexpr double same_wall = 0.9;
  // voxels, largest allowed overlap of the placed ball with another plane of the same wall
  static constexpr double same_wall_overlap = 0.02;
  // Voxels. The position of a ball with only one contact is computed directly from its wall, and then checked by one
  // iteration of the search. If this iteration would move the ball farther than this, the iterative search is used.
  static constexpr double alone = 2e-4;
};

/// Limits of the proxy's speed relative to the hand while a bur cuts. With these limits the force changes by at most
/// 0.02 N per tick.
struct PaceParameters {
  static constexpr double cut_slew = 6;  // N/s, largest rate of change of the force while a cutting tool is in contact
  // N/s, largest rate of change of the force when the bur breaks through and loses contact
  static constexpr double free_slew = 14;
  // N/s, largest rate at which the force rises when the bur's cutting edges catch in the tissue
  static constexpr double grip_slew = 9;
  // friction coefficient of the bur's cutting edges: lateral force divided by the force that presses the bur
  static constexpr double tooth_grip = 0.15;
  static constexpr double tolerance = 1.02;  // tolerance: the proxy's speed may exceed the speed limit by this factor
  static constexpr int rounds = 4;  // largest number of iterations in which the speed limit of the proxy is enforced
  // s. A bur is in debt if its cuts needed more energy than its motor has delivered so far. The debt is given as the
  // time in which the motor delivers the missing energy. If the debt is larger than this, the bur is slowed down.
  static constexpr double free_debt = 3e-3;
  static constexpr double standing_debt = 12e-3;  // s; a bur with this energy debt (see free_debt) stops completely
};

/// Parameters of a fall: the tissue under the bur was removed, so the hand accelerates until the bur meets tissue
/// again. The parameters limit the speed at which the bur meets it (follow_fall).
struct FallParameters {
  // s, time constant of the low-pass filter that gives the hand's present velocity
  static constexpr double rough_time = 2e-3;
  // s, time constant of the low-pass filter that gives the hand's mean velocity
  static constexpr double speed_time = 0.1;
  // s, time constant of the low-pass filter for the force with which the tissue pushes the bur. The filtered force
  // shows the direction of the push before the tissue under the bur was removed.
  static constexpr double push_time = 0.05;
  // N/s. The hand may be in a fall (the tissue under the bur was removed) if (present velocity of the hand - its mean
  // velocity) × stiffness exceeds this limit.
  static constexpr double gain = 5;
  // Second condition for a fall (the hand accelerates because the tissue under the bur was removed): the hand must
  // accelerate against the tissue's mean push. The cosine between this push and the direction opposite to the hand's
  // gain of velocity must be at least this.
  static constexpr double along = 0.3;
  // N/s, limit for the landing (the bur meets tissue again after the tissue under it was removed). The bur may always
  // land at a speed for which (speed × stiffness of the coupling) is at most this limit.
  static constexpr double landing_slew = 12;
  // Factor for the landing of the bur, that is, for its next contact after the tissue under it was removed. The bur may
  // always land at a speed of up to this factor times the hand's mean speed.
  static constexpr double growth = 1.2;
  // N/s. While the hand falls (the tissue under the bur was removed), the bur may be slower than the hand. The force
  // then grows at the rate (speed of the hand - speed of the bur) × stiffness. This is the limit of that rate.
  static constexpr double brake = 12;
};

/// Walls at borders from soft to hard tissue. They stop only a head that comes from the softer tissue (Wang 2009,
/// "boundary walls").
struct WallParameters {
  // m; a wall acts on a head until the head is this deep in the harder tissue
  static constexpr double felt_depth = 0.1e-3;
  // voxels; within this distance of a border between tissues, a sample may show either of the two tissues
  static constexpr double border = 0.5;
  // smallest fraction of a bur's power with which it cuts at a wall of harder tissue
  static constexpr double least_power = 0.1;
  // A border is a wall if the ratio of the softer to the harder tissue's specific energy is below this limit.
  static constexpr double from_ratio = 0.2;
  // Largest number of rounds per iteration. In each round, the depth of the cut at wall planes is reduced, and the head
  // is projected again.
  static constexpr int rounds = 4;
};

/// Recovery of a tool that is inside tissue, or outside its patch (copy of the field around it).
struct RecoveryParameters {
  // s, time constant with which the overlap decays while the tool is led out of tissue
  static constexpr double recovery_time = 6e-3;
  static constexpr double least_overlap = 0.01;  // voxels; with a smaller overlap the tool counts as outside the tissue
  // s; if the tool has been outside its patch (field around it) for longer than this, the new patch counts as late
  static constexpr double patch_wait = 0.01;
  // m; a hand can be faster than the patches that follow it. While the proxy advances towards such a hand and is nearer
  // to it than this, the patch does not count as late. If the hand is farther away, it has jumped.
  static constexpr double longest_lag = 20e-3;
  // m. While the tool is outside the patch (copy of the field), a plane replaces the tissue. After a new patch has
  // become late, the force of the plane decreases if the head has moved farther than this since then.
  static constexpr double bridge_reach = 5e-3;
  // N; the plane that replaces a late patch (copy of the field) yields if the force exceeds the force of the last
  // contact by more than this.
  static constexpr double bridge_yield = 0.5;
  // s, time in which the proxy returns smoothly to the tissue's surface after a plane replaced late tissue data
  static constexpr double rejoin_time = 0.3;
};

/// Conditions for the retreat. If the hand has moved away but contacts hold the proxy, the proxy is led back along its
/// path.
struct RetreatParameters {
  // m; if the distance between hand and proxy exceeds this limit, the hand may have moved away
  static constexpr double far = 2e-3;
  static constexpr double still = 0.3e-3;  // m; the proxy counts as held by contacts while it moves less than this
  // m; if the distance between hand and proxy exceeds this limit, the hand has certainly moved away, because at 1 N/mm
  // nobody presses so hard
  static constexpr double too_far = 5e-3;
  static constexpr double patience = 0.3;    // s, time for which contacts must hold the proxy before it is led back
  static constexpr double report_after = 1;  // s, hold time after which a fault reports that no path back was found
  // m; a point of the recorded path is used only if it is nearer to the hand than the proxy is, by at least this
  // distance
  static constexpr double gain = 0.1e-3;
  static constexpr double slew = 14;  // N/s, largest rate of change of the force while the proxy retraces its path
  // m; if the distance between head and tissue exceeds this limit, the recorded path starts again
  static constexpr double outside = 1e-3;
  // voxels, distance between two samples on the line from the proxy to the hand
  static constexpr double look_step = 1;
};

/// Updates of the coarse patch, which represents the tissue around the shank.
struct CoarseParameters {
  // coarse voxels; the coarse patch (field around the shank) is cut each time the head has moved this far
  static constexpr double cut_step = 0.2;
  // ticks; a cut of the coarse patch (field around the shank) waits at most this time for a tick with less work
  static constexpr int most_waits = 4;
};

/// Limits for a filling instrument (filling.cpp).
struct FillingParameters {
  // s. Filling that cannot be added to the tissue at once is kept for later ticks: at most the volume that the
  // instrument delivers in this time. The remaining volume is lost.
  static constexpr double waits = 0.05;
  // Smallest length of the field's gradient at which a point counts as near a single surface. Near a single surface the
  // length is about 1; midway between two surfaces it is smaller.
  static constexpr double one_surface = 0.5;
  // voxels, distance between two samples when the instrument searches for tissue in front of it
  static constexpr double look_step = 0.25;
  static constexpr double step = 0.25;    // voxels; a dome of filling may always grow by this much (radius) in one tick
  static constexpr double most_step = 1;  // voxels, largest growth of the radius of a dome of filling in one tick
  // s; limit of the growth per tick: a dome may grow by the filling that waits, plus the amount delivered in this time
  static constexpr double ahead = 0.01;
  static constexpr double least_step = 1e-3;
  // if the free fraction of the surface of a dome of filling is at most this, the dome stops growing
  static constexpr double buried = 0.01;
  // Voxels. A place is open for filling if its distances from tissue, from the head and from the solid that
  // limits the filling are all at least this.
  static constexpr double open = 0.5;
  // largest search distance for a place that is open for filling, as a ratio to the instrument's reach
  static constexpr double flows_on = 3;
  static constexpr double flow_step = 0.5;  // voxels, distance between two samples along a ray
  // Largest allowed number of consecutive samples inside tissue on a ray. The voxels at a filled wall contain tissue
  // and filling, so a few such samples do not end the ray.
  static constexpr int thin = 3;
  // Largest cost of one tick's search for a place that is open for filling, in units of about 1 ns.
  static constexpr int search_cost = 60000;
  // Costs in the search for a place that is open for filling, in units of about 1 ns: of a skipped ray, of a sample,
  // and of the test whether filling fits at a sample.
  static constexpr int skip_cost = 1, sample_cost = 5, room_cost = 60;
  static constexpr std::size_t directions = 2048;  // number of rays along which places open for filling are searched
};

}  // namespace typodont::haptics::offset
