// With unit and reason. Voxels unless stated: the field's resolution decides.
#pragma once

#include <cstddef>
#include <cstdint>

namespace typodont::haptics::offset {

/// Contacts, projection, motion, again (proxy.cpp).
struct SearchParameters {
  // voxels of gap between head and tissue
  static constexpr double contact_range = 0.8;
  // voxels per iteration with several contacts; below contact_range, so none is missed
  static constexpr double contact_step = 0.6;
  // voxels with at most one; thicker tissue is not passed
  static constexpr double free_step = 1.5;
  // voxels over which contacts hold
  static constexpr double reuse_distance = 0.3;
  // voxels, one contact: shorter steps end it
  static constexpr double converged = 1e-6;
  // voxels, one contact: sum of the rest, as a geometric series
  static constexpr double foreseen = 1e-7;
  // voxels, several contacts
  static constexpr double settled = 2e-5;
  // voxels, several, cutting; converges quadratically: the error is about this squared
  static constexpr double settled_cutting = 0.03;
  // per tick, also without contact
  static constexpr int iterations = 48;
  // In contact, per tick: not cutting, cutting.
  static constexpr int settling_iterations = 8, settling_iterations_cutting = 5;
  // Long steps against the last long one; with more it would not converge.
  static constexpr int reversals = 2;
  // Refinements per iteration, not cutting: exact planes of what blocks.
  static constexpr int refining_rounds = 6;
  // step / last step, up to which the secant is used
  static constexpr double still_converges = 0.95;
  // on a step, one contact
  static constexpr double most_gain = 10;
  // on a step, one of several blocks
  static constexpr double most_gain_of_many = 2;
  // voxels per tick; the planes hold no deeper
  static constexpr double most_slack = 1;
  // voxels by cutting or rounding; more is inside, led out slowly
  static constexpr double deep = 0.6;
  // voxels; until then, a head led out of deep tissue follows the field's gradients
  static constexpr double led_out = 0.1;
};

/// A ball on one smooth wall is placed directly (ContactFinder::seat), within these; otherwise iterated.
struct WallPlacementParameters {
  // voxels, with an approximate plane
  static constexpr double overlap = 0.1;
  // voxels, with another wall's exact plane
  static constexpr double other_wall = 4e-3;
  // cosine of one wall's planes
  static constexpr double same_wall = 0.9;
  // voxels, with another plane of the wall
  static constexpr double same_wall_overlap = 0.02;
  // voxels by which a checking iteration may move it
  static constexpr double alone = 2e-4;
};

/// Proxy against hand, while cutting: at most 0.02 N per tick.
struct PaceParameters {
  static constexpr double cut_slew = 6;  // N/s in contact
  // N/s at break-through
  static constexpr double free_slew = 14;
  // N/s when edges catch
  static constexpr double grip_slew = 9;
  // lateral / pressing force of the edges
  static constexpr double tooth_grip = 0.15;
  static constexpr double tolerance = 1.02;  // of the limit
  static constexpr int rounds = 4;           // iterations that enforce it
  // s of motor work missing for past cuts, from which a bur is slowed
  static constexpr double free_debt = 3e-3;
  static constexpr double standing_debt = 12e-3;  // s, at which it stops
};

/// Tissue under the bur went, the hand accelerates: limits the landing (follow_fall).
struct FallParameters {
  // s, low-pass for the present velocity
  static constexpr double rough_time = 2e-3;
  // s, for the mean velocity
  static constexpr double speed_time = 0.1;
  // s, for the push, whose direction from before counts
  static constexpr double push_time = 0.05;
  // N/s of (present - mean velocity) × stiffness, for a fall
  static constexpr double gain = 5;
  // cosine of mean push and against the gain of velocity, also for a fall
  static constexpr double along = 0.3;
  // N/s of speed × stiffness, always allowed at landing
  static constexpr double landing_slew = 12;
  // on the hand's mean speed, always allowed at landing
  static constexpr double growth = 1.2;
  // N/s of (hand's - bur's speed) × stiffness while falling
  static constexpr double brake = 12;
};

/// Soft to hard, against heads from the soft side (Wang 2009, "boundary walls").
struct WallParameters {
  // m in the harder tissue, until which it acts
  static constexpr double felt_depth = 0.1e-3;
  // voxels from a border, where a sample may be either
  static constexpr double border = 0.5;
  // of a bur's power, at a harder wall
  static constexpr double least_power = 0.1;
  // softer / harder specific energy, below which it is a wall
  static constexpr double from_ratio = 0.2;
  // rounds per iteration: less depth at walls, projected again
  static constexpr int rounds = 4;
};

/// Inside tissue, or outside the patch.
struct RecoveryParameters {
  // s, decay of the overlap
  static constexpr double recovery_time = 6e-3;
  static constexpr double least_overlap = 0.01;  // voxels; less is outside
  // s outside the patch, from which the new one is late
  static constexpr double patch_wait = 0.01;
  // m to a fast hand, within which an advancing proxy's patch is not late; farther, the hand jumped
  static constexpr double longest_lag = 20e-3;
  // m of the head since, from which the plane's force falls
  static constexpr double bridge_reach = 5e-3;
  // N above the last contact, at which the plane yields
  static constexpr double bridge_yield = 0.5;
  // s of smooth return after a plane
  static constexpr double rejoin_time = 0.3;
};

/// The hand is away, contacts hold: back along the path.
struct RetreatParameters {
  // m, hand to proxy: perhaps away
  static constexpr double far = 2e-3;
  static constexpr double still = 0.3e-3;  // m; less motion is held
  // m: certainly away; at 1 N/mm nobody presses so hard
  static constexpr double too_far = 5e-3;
  static constexpr double patience = 0.3;    // s held, before the way back
  static constexpr double report_after = 1;  // s held, before a fault: no way back
  // m that a path point must be nearer to the hand
  static constexpr double gain = 0.1e-3;
  static constexpr double slew = 14;  // N/s on the way back
  // m from tissue, where the path starts again
  static constexpr double outside = 1e-3;
  // voxels between samples, proxy to hand
  static constexpr double look_step = 1;
};

/// Tissue around the shank.
struct CoarseParameters {
  // coarse voxels of the head per coarse cut
  static constexpr double cut_step = 0.2;
  // ticks that a coarse cut may wait
  static constexpr int most_waits = 4;
};

/// Limits for a filling instrument (filling.cpp).
struct FillingParameters {
  // s of delivery that are kept when they do not fit; the rest is lost
  static constexpr double waits = 0.05;
  // gradient near one surface; about 1 there, less midway between two
  static constexpr double one_surface = 0.5;
  // voxels between samples in front
  static constexpr double look_step = 0.25;
  static constexpr double step = 0.25;    // voxels of radius, always allowed per tick
  static constexpr double most_step = 1;  // voxels of radius per tick
  // s of delivery, beyond what waits, per tick
  static constexpr double ahead = 0.01;
  static constexpr double least_step = 1e-3;
  // free fraction, at which a dome stops
  static constexpr double buried = 0.01;
  // voxels from tissue, head and limiting solid, to be open
  static constexpr double open = 0.5;
  // in the instrument's reach
  static constexpr double flows_on = 3;
  static constexpr double flow_step = 0.5;  // voxels, distance between two samples along a ray
  // samples inside in a row; filled walls hold both, so a few do not end a ray
  static constexpr int thin = 3;
  // ns per tick, about
  static constexpr int search_cost = 60000;
  // ns, about: skipped ray, sample, test for room
  static constexpr int skip_cost = 1, sample_cost = 5, room_cost = 60;
  static constexpr std::size_t directions = 2048;  // rays of the search
};

}  // namespace typodont::haptics::offset
