// Parameters of the model "offset", with unit and reason. Most lengths are in voxels, because the resolution of the
// field determines them.
#pragma once

#include <cstddef>
#include <cstdint>

namespace typodont::haptics::offset {

/// Contact search, projection and motion, repeated until the proxy no longer moves (proxy.cpp).
struct SearchParameters {
  // voxels, largest gap between head and tissue in a contact
  static constexpr double contact_range = 0.8;
  // voxels, largest step per iteration with several contacts. Below contact_range, so that no contact is missed.
  static constexpr double contact_step = 0.6;
  // voxels, largest step per iteration with at most one contact. The head cannot pass through thicker tissue.
  static constexpr double free_step = 1.5;
  // voxels of motion before contacts are searched again
  static constexpr double reuse_distance = 0.3;
  // voxels, one contact: the search ends after a shorter step
  static constexpr double converged = 1e-6;
  // voxels, one contact: the search ends if the sum of all further steps (geometric series) is smaller
  static constexpr double foreseen = 1e-7;
  // voxels, several contacts: the search ends after a shorter step
  static constexpr double settled = 2e-5;
  // voxels, several contacts while cutting. The error is about the square of this, because the search converges
  // quadratically.
  static constexpr double settled_cutting = 0.03;
  // largest number of iterations per tick
  static constexpr int iterations = 48;
  // Largest numbers of iterations in contact, without and with cutting.
  static constexpr int settling_iterations = 8, settling_iterations_cutting = 5;
  // Largest number of long steps opposite to the previous long step; more of them would not converge.
  static constexpr int reversals = 2;
  // Largest number of refinements per iteration without cutting, which compute exact planes of the blocking contacts.
  static constexpr int refining_rounds = 6;
  // The secant method is used while a step / the previous step is at most this.
  static constexpr double still_converges = 0.95;
  // largest lengthening factor of a step, with one contact
  static constexpr double max_gain = 10;
  // largest lengthening factor if one of several contacts blocks it
  static constexpr double max_gain_of_many = 2;
  // voxels, largest sinking depth per tick; the contact planes are not valid deeper
  static constexpr double max_slack = 1;
  // voxels; overlap up to this comes from cutting or rounding. A deeper head is inside tissue, and is moved out slowly.
  static constexpr double deep = 0.6;
  // voxels of overlap; down to this, a head that is led out of deep tissue follows the field's gradients
  static constexpr double led_out = 0.1;
};

/// Limits within which a ball on one smooth wall is placed directly (ContactFinder::seat). Otherwise the search
/// iterates.
struct WallPlacementParameters {
  // voxels, largest overlap with an approximate plane
  static constexpr double overlap = 0.1;
  // voxels, largest overlap with the exact plane of another wall
  static constexpr double other_wall = 4e-3;
  // cosine between normals above which planes are the same wall
  static constexpr double same_wall = 0.9;
  // voxels, largest overlap with another plane of the same wall
  static constexpr double same_wall_overlap = 0.02;
  // voxels, largest displacement by an iteration that checks the result
  static constexpr double alone = 2e-4;
};

/// Limits of the force's change while cutting, at most 0.02 N per tick. Implemented as a speed limit of the proxy
/// relative to the hand.
struct PaceParameters {
  static constexpr double cut_slew = 6;  // N/s, limit in contact
  // N/s, limit when the head breaks through
  static constexpr double free_slew = 14;
  // N/s, limit when the cutting edges catch
  static constexpr double grip_slew = 9;
  // largest lateral force of the cutting edges / pressing force
  static constexpr double tooth_grip = 0.15;
  static constexpr double tolerance = 1.02;  // factor by which the limit may be exceeded
  static constexpr int rounds = 4;           // largest number of iterations that enforce the limit
  // s of motor power that past cuts have consumed too much; above this, the bur is slowed down
  static constexpr double free_debt = 3e-3;
  static constexpr double standing_debt = 12e-3;  // s of missing motor power at which the bur stops
};

/// A fall: tissue under the bur is gone, and the hand accelerates. The speed at the next contact is limited
/// (follow_fall).
struct FallParameters {
  // s, time constant of the filter for the current velocity
  static constexpr double rough_time = 2e-3;
  // s, time constant of the filter for the mean velocity
  static constexpr double speed_time = 0.1;
  // s, time constant of the filter for the push, whose direction before the fall is used
  static constexpr double push_time = 0.05;
  // N/s; a fall needs more (current - mean velocity) × stiffness
  static constexpr double gain = 5;
  // A fall also needs a larger cosine between the mean push and the opposite of the gained velocity.
  static constexpr double along = 0.3;
  // N/s of speed × stiffness, always allowed at landing
  static constexpr double landing_slew = 12;
  // factor on the hand's mean speed, always allowed at landing
  static constexpr double growth = 1.2;
  // N/s, (hand's - bur's speed) × stiffness during a fall
  static constexpr double brake = 12;
};

/// Walls of harder tissue that stop a head which comes from softer tissue (Wang 2009, "boundary walls").
struct WallParameters {
  // m in harder tissue up to which its wall acts
  static constexpr double felt_depth = 0.1e-3;
  // voxels from a border where samples may have either tissue
  static constexpr double border = 0.5;
  // smallest fraction of a bur's power at a harder wall
  static constexpr double min_power = 0.1;
  // A border is a wall below this softer / harder energy.
  static constexpr double from_ratio = 0.2;
  // Largest number of rounds per iteration that reduce the depth at walls and project again.
  static constexpr int rounds = 4;
};

/// Recovery of a head inside tissue or outside the patch.
struct RecoveryParameters {
  // s, time constant of the decay of the overlap
  static constexpr double recovery_time = 6e-3;
  static constexpr double min_overlap = 0.01;  // voxels; a smaller overlap counts as outside the tissue
  // s outside the patch until the new one is late
  static constexpr double patch_wait = 0.01;
  // m; if a fast hand is less than this ahead of a moving proxy, its patch is not late. Farther away, the hand has
  // jumped.
  static constexpr double longest_lag = 20e-3;
  // m that the head has moved since the patch became late; beyond this, the plane's force decreases
  static constexpr double bridge_reach = 5e-3;
  // N above the last contact force where the plane yields
  static constexpr double bridge_yield = 0.5;
  // s, duration of the smooth return after a plane replaced the tissue
  static constexpr double rejoin_time = 0.3;
};

/// If the hand has moved away but contacts hold the proxy, it is led back along its path.
struct RetreatParameters {
  // m from hand to proxy; beyond, the hand has left
  static constexpr double far = 2e-3;
  static constexpr double still = 0.3e-3;  // m; a proxy that moves less counts as held
  // m from hand to proxy; beyond this, the hand has moved away. At 1 N/mm, nobody presses so hard.
  static constexpr double too_far = 5e-3;
  static constexpr double patience = 0.3;    // s for which the proxy is held before it is led back
  static constexpr double report_after = 1;  // s for which the proxy must be held without a way back before a fault is
                                             // reported
  // m by which a point of the path must be nearer to the hand than the proxy is
  static constexpr double gain = 0.1e-3;
  static constexpr double slew = 14;  // N/s, rate of force while the proxy is led back
  // 1 - |cos(half the turn since the cut)|; a head that is not a ball may turn so far in its own path
  static constexpr double same_turn = 1e-4;
  // m from tissue; beyond this, the recorded path starts again
  static constexpr double outside = 1e-3;
  // voxels between samples on the line from proxy to hand
  static constexpr double look_step = 1;
};

/// Cutting of the coarse patch, the tissue around the shank.
struct CoarseParameters {
  // coarse voxels that the head moves per coarse cut
  static constexpr double cut_step = 0.2;
  // largest number of ticks that a coarse cut may wait
  static constexpr int max_waits = 4;
};

/// Placing of filling by a filling instrument (filling.cpp).
struct FillingParameters {
  // s of delivery that wait for room; more is lost
  static constexpr double waits = 0.05;
  // Length of the field's gradient above which one surface is nearest. It is about 1 there, and smaller midway between
  // two surfaces.
  static constexpr double one_surface = 0.5;
  // voxels between samples in front of the instrument
  static constexpr double look_step = 0.25;
  static constexpr double step = 0.25;   // voxels by which the radius may always grow per tick
  static constexpr double max_step = 1;  // voxels, largest growth of the radius per tick
  // s of delivery placed per tick beyond what still waits
  static constexpr double ahead = 0.01;
  static constexpr double min_step = 1e-3;
  // free fraction of its surface where a dome stops growing
  static constexpr double buried = 0.01;
  // voxels; an open place is at least this far from tissue, head and limiting solid
  static constexpr double open = 0.5;
  // range of the search in multiples of the instrument's reach
  static constexpr double flows_on = 3;
  static constexpr double flow_step = 0.5;  // voxels, distance between two samples along a ray
  // Number of consecutive samples in tissue that do not end a ray: filled walls consist of both tissue and filling.
  static constexpr int thin = 3;
  // ns, approximate time for the search per tick
  static constexpr int search_cost = 60000;
  // ns, approximate time of a skipped ray, a sample, a test for room
  static constexpr int skip_cost = 1, sample_cost = 5, room_cost = 60;
  static constexpr std::size_t directions = 2048;  // number of search rays
};

}  // namespace typodont::haptics::offset
