// The numbers of the offset method, each with its unit and its reason. Lengths in voxels unless a unit is given: they
// are limits of what the field can tell, which grows with the voxel.
#pragma once

#include <cstddef>

namespace typodont::haptics::offset {

/// The search for the proxy's place: iterations of "find contacts, project, move" (proxy.cpp).
struct SearchParameters {
  static constexpr double contact_range =
      0.8;  // a contact with a larger gap cannot matter before the next iteration, …
  static constexpr double contact_step = 0.6;    // … because a step among several contacts is no longer than this
  static constexpr double free_step = 1.5;       // longest step with one contact: the search skips nothing thicker
  static constexpr double reuse_distance = 0.3;  // path length for which the contacts found still serve
  static constexpr double converged = 1e-6;      // a step this short ends the search on one smooth wall
  static constexpr double foreseen = 1e-7;  // so does a remaining path this short, extrapolated as a geometric series
  static constexpr double settled = 2e-5;   // a step this short ends the search among several contacts, …
  static constexpr double settled_cutting = 0.03;  // … and while they are cut: the error is the square of it
  static constexpr int iterations = 48;            // limit per tick, free path included
  static constexpr int settling_iterations = 8, settling_iterations_cutting = 5;  // limits in contact
  static constexpr int reversals = 2;              // limit of long steps against the one before: more do not converge
  static constexpr int refining_rounds = 6;        // exact queries of the planes that hold a head which does not cut
  static constexpr double still_converges = 0.95;  // ratio of successive steps up to which the secant method is used
  static constexpr double most_gain = 10;          // limit of its gain on one contact, …
  static constexpr double most_gain_of_many = 2;   // … and among several
  static constexpr double most_slack = 1;  // a cut deeper than this in one tick says nothing about the next surface
  static constexpr double deep = 0.6;      // overlap that neither cutting nor rounding leaves: it is led out slowly
};

/// When a ball that slides along one smooth wall needs no search: the wall says where it lies (ContactFinder::seat).
struct SeatParameters {
  static constexpr double overlap = 0.1;      // a rough overlap above this refuses the seat
  static constexpr double other_wall = 4e-3;  // overlap with another wall that refuses it, …
  static constexpr double same_wall = 0.9;  // … where walls count as the same if their normals' cosine is above this
  static constexpr double same_wall_overlap = 0.02;  // overlap with the same wall beside the seat that refuses it
  static constexpr double alone = 2e-4;              // step by which one exact contact may still move the ball
};

/// How fast the proxy may move relative to the hand while a bur cuts: the hand must feel no step above 0.02 N a tick.
struct PaceParameters {
  static constexpr double cut_slew = 6;       // N/s, change of a cutting contact's force by the proxy
  static constexpr double free_slew = 14;     // N/s, of a force that ends because the bur broke through
  static constexpr double grip_slew = 9;      // N/s, rise of the force when the teeth catch
  static constexpr double tooth_grip = 0.15;  // engaged teeth resist being led sideways up to this fraction of the push
  static constexpr double tolerance = 1.02;   // ratio to the limit at which the pace counts as kept, …
  static constexpr int rounds = 4;            // … or this many steps toward it
  static constexpr double free_debt =
      3e-3;  // s of the motor's work that a bur may remove in advance; beyond, it slows …
  static constexpr double standing_debt = 12e-3;  // … and stands at this
};

/// When a hand falls because the tissue gives way, it may land no faster than it would feel (follow_fall).
struct FallParameters {
  static constexpr double rough_time = 2e-3;  // s, mean of the hand's velocity now, …
  static constexpr double speed_time = 0.1;   // s, … of its velocity of late, …
  static constexpr double push_time = 0.05;   // s, … and of the push that held it up
  static constexpr double gain = 5;           // N/s, gained speed × stiffness that makes a fall
  static constexpr double along = 0.3;        // cosine to the mean push above which a fall is one
  static constexpr double landing_slew = 12;  // N/s at which a bur may land anyway, …
  static constexpr double growth = 1.2;       // … or this ratio to the hand's speed of late, …
  static constexpr double brake = 12;         // N/s … or slower than it falls by this much
};

/// One-sided walls from soft to hard tissue (Wang 2009, "boundary walls").
struct WallParameters {
  static constexpr double felt_depth = 0.1e-3;  // m that a head may have got into harder tissue and still meet the wall
  static constexpr double border = 0.5;         // voxels on each side of a border that show either tissue
  static constexpr double least_power = 0.1;    // fraction of the power that a wall always leaves
  static constexpr double from_ratio = 0.2;     // softer over harder specific energy below which a border is a wall
  static constexpr int rounds = 4;              // projections in which planes may take the place of such as give way
};

/// A tool inside tissue, and a tool without a snapshot.
struct RecoveryParameters {
  static constexpr double recovery_time = 6e-3;  // s, time constant of leading the tool out of tissue
  static constexpr double least_overlap = 0.01;  // voxels that count as out
  static constexpr double patch_wait =
      0.01;  // s that the tool waits where its patch ends before the patch counts as late
  static constexpr double bridge_reach = 5e-3;  // m from there that the last contact's plane stands in for a late patch
  static constexpr double bridge_yield = 0.5;   // N beyond the push of that contact, at which the plane gives way
  static constexpr double bridge_time_of_laws_1 =
      0.5;                                    // s for which the plane stood in for the snapshot, by the first laws
  static constexpr double rejoin_time = 0.3;  // s for finding back from there to the surface without a step
};

/// When a proxy that its contacts hold is led back the way it came, because the hand has left.
struct RetreatParameters {
  static constexpr double far = 2e-3;      // m from the proxy to a hand that may have left
  static constexpr double still = 0.3e-3;  // m that a proxy may move which counts as held
  static constexpr double too_far = 5e-3;  // m: nobody presses so far into tissue, at 1 N/mm
  static constexpr double patience = 0.3;  // s that it must be held before it is led back, …
  static constexpr double told = 1;        // s … and before the user is told that no way back is known
  static constexpr double gain = 0.1e-3;   // m by which a place on the way back must be nearer to the hand
  static constexpr double slew = 14;       // N/s, change of the force by being led
  static constexpr double outside = 1e-3;  // m between head and tissue from which on the head is outside
  static constexpr double look_step = 1;   // voxels between two looks along the way to the hand
};

/// Upkeep of the coarse patch in which shanks are felt.
struct CoarseParameters {
  static constexpr double cut_step = 0.2;  // coarse samples that a head moves between two cuts in that patch
};

/// What a filling instrument puts down (filling.cpp).
struct FillingParameters {
  static constexpr double waits = 0.05;       // s of filling that may wait for room
  static constexpr double one_surface = 0.5;  // slope of the field below which a point lies midway between surfaces
  static constexpr double look_step = 0.25;   // between two looks for something to fill on
  static constexpr double step = 0.25;        // growth of a dome in a tick, whatever part of its surface is free, …
  static constexpr double most_step = 1;      // … limit of a small dome's growth, …
  static constexpr double ahead = 0.01;       // s of filling … that set this growth
  static constexpr double least_step = 1e-3;
  static constexpr double buried = 0.01;    // fraction of its surface that a dome must have free to go on
  static constexpr double open = 0.5;       // of air, beyond what the instrument keeps free, that count as room
  static constexpr double flows_on = 3;     // ratio to the reach: as far does filling flow through filling
  static constexpr double flow_step = 0.5;  // between two looks along a way
  static constexpr int thin = 3;  // looks into tissue that do not part two places: a filled wall shares voxels
  static constexpr int looking_cost =
      60000;  // limit per tick of the search for room, in units of about 1 ns; the cost of …
  static constexpr int skip_cost = 1, look_cost = 5,
                       room_cost = 60;             // … a skipped way, a look, a test of the room there
  static constexpr std::size_t directions = 2048;  // of the ways along which filling looks for room
};

}  // namespace typodont::haptics::offset
