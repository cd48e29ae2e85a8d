// Constants of contact search and projection, each with its unit and its reason. Lengths are in voxels unless a unit is
// given: the resolution of the field, which grows with the voxel, determines them.
#pragma once

namespace typodont::haptics {

/// Conditions under which one cubic query at a ball's centre yields the only contact (ContactFinder::find_by_offset).
struct OffsetQueryParameters {
  // Voxels, error of linear interpolation; for a ball of four voxels' radius the error is as large.
  static constexpr double foot_tolerance = 0.05;
  // Tolerance of the gradient's length, which is 1 near a single wall.
  static constexpr double gradient_tolerance = 2e-4;
  static constexpr double depth_below = 3;  // voxels of tissue that must lie under the surface
  // Voxels, height above the ball's centre up to which no other wall may be nearer.
  static constexpr double height_above = 3.5;
};

/// The position of a ball on one smooth wall (ContactFinder::seat).
struct WallSeatParameters {
  // Voxels, greatest depth of the hand under the surface on which the ball lies.
  static constexpr double hand_depth = 4;
  static constexpr double aligned = 1e-8;  // voxels², limit of the squared sideways error of the foot point
  static constexpr int iterations = 6;     // limit of steps along the wall to the foot point
  // Tolerance of the gradient's length, which is 1 near a single wall.
  static constexpr double gradient_tolerance = 1e-3;
  // Tolerance of the gradient's length where no other wall is near.
  static constexpr double gradient_tolerance_alone = 5e-5;
};

/// Refinement of one contact by cubic queries (ContactFinder::refine).
struct RefineParameters {
  static constexpr int iterations = 2;  // limit of queries per contact and call while the head cuts
  // Limit of queries per contact and call while the head touches without cutting; the hand then feels errors of the
  // force's direction.
  static constexpr int iterations_fine = 8;
  // Voxels, path of a ball below which a contact stays exact; its gap errs by 2e-5 voxel.
  static constexpr double stays_exact = 0.02;
  static constexpr double stays_exact_edged =
      2e-3;  // voxels, path of a head with edges below which a contact stays exact; its gap errs by the whole path
  // Voxels, path of a head that does not cut, below which a contact stays exact.
  static constexpr double stays_exact_fine = 1e-3;
  // Voxels; the search ends when a step lowers the gap by less than this. The next step would lower it by about the
  // square.
  static constexpr double gained = 1e-4;
  // Voxels, least reduction of the gap in a step of a head that does not cut. The direction of its force depends on the
  // sideways error of the contact, which is the square root of the gap's error. So this limit is much smaller.
  static constexpr double gained_fine = 3e-8;
  // Largest ratio of successive steps for which the secant method is used.
  static constexpr double still_converges = 0.95;
  static constexpr double most_gain = 10;  // upper limit of the secant method's gain
};

/// A sharp rim inside the tissue. The tissue's normal is the direction out of the tissue; the normals of the rim's
/// sides are not (touch_with_rim).
struct RimParameters {
  // Cosine between the head's normal and the tissue's normal; below it the two normals differ.
  static constexpr double askew = 0.99999;
  // Tolerance of the gradient's length, which is 1 in smooth tissue.
  static constexpr double gradient_tolerance = 0.05;
  static constexpr double same_wall = 0.9;  // cosine between normals above which two contacts lie on one wall
  // Voxels; a contact nearer than this to the head's rim counts as a contact of the rim. Twice the depth of the rim in
  // the tissue is added to this limit.
  static constexpr double near_rim = 2;
};

/// Samples of the head (HeadSamples).
struct HeadSampleParameters {
  static constexpr float on_surface = 0.25f;    // voxels from the surface; a nearer point lies on the surface
  static constexpr float examined = 1.5f;       // voxels from the surface; a nearer sample is moved onto the surface
  static constexpr double near_free_end = 0.5;  // fraction of the samples that lie near the head's free end
};

/// Edges, corners and grooves, constructed from the faces beside them (sharp_edge).
struct SharpEdgeParameters {
  // Number of directions in which faces are searched; a corner shows some of its faces in few of them.
  static constexpr int directions = 12;
  static constexpr double aside = 8;  // voxels, sideways distance from the foot point at which a face is searched
  // Voxels, sideways and downward distance at which a face beyond an edge is searched.
  static constexpr double down = 6.8;
  // Voxels, least distance from the foot point to a face; the stencil then ends before the edge.
  static constexpr double least_aside = 5.2;
  static constexpr int steps = 3;          // limit of steps onto a face
  static constexpr double on_face = 1e-3;  // voxels; a point nearer than this lies on the face
  // Tolerance of the gradient's length, which is 1 near a single face.
  static constexpr double gradient_tolerance = 1e-3;
  static constexpr double depth_clean = 4.5;       // voxels of tissue under a face that lies far from all other faces
  static constexpr double depth_least = 3.7;       // voxels of tissue that must lie under a face near a corner
  static constexpr double depth_tolerance = 0.05;  // voxels, tolerance of the depth of tissue
  // Cosine between normals; above it, a face that lies near others counts as a face already found.
  static constexpr double alike = 0.98;
  // limit of 1 - cosine between normals of one plane; interpolation causes such a difference
  static constexpr double same_face = 1e-5;
  static constexpr double convex = 0.02;  // voxels, height by which a face may stand out over another one
  // Voxels, tolerance between the distance of the nearest point and the field's distance.
  static constexpr double agrees = 0.05;
  static constexpr double farther = 1.5;  // voxels over which a groove's wall must continue
  static constexpr double flat = 1e-10;   // limit of 1 - cosine between the normals of two samples of a groove's wall
  // Voxels, limit of the offset between the planes of two samples of a groove's wall; rounding to floats causes an
  // offset.
  static constexpr double flat_distance = 2e-5;
  static constexpr int misses = 6;  // limit of directions in which a groove shows no wall
  // Voxels per unit of difference between a groove's normals: limit of the depth by which interpolation fills the
  // groove.
  static constexpr double filled = 0.15;
};

/// Shanks and safe ends, computed in the coarse patch (NonCuttingContacts). Lengths are in coarse voxels unless a unit
/// is given.
struct NonCuttingPartParameters {
  static constexpr double spacing = 0.25e-3;  // m between samples of the coarse patch
  // In coarse voxels: the most by which a linearly interpolated distance can exceed the true distance.
  static constexpr double overestimate = 0.5;
  // In coarse voxels, rounding error: distances this close to the band's limit are cut off at the limit.
  static constexpr double at_band = 1e-3;
  // Coarse voxels; a nearest point farther than this from the surface results from an intersection of solids.
  static constexpr double edge_distance = 0.4;
  static constexpr double enough_room = 3;  // patch voxels of free distance above which the shank is not searched again
  static constexpr double close_room = 0.8;  // patch voxels of free distance below which contacts are searched
  // Cosine between normals above which two contacts at one place are merged.
  static constexpr double same_direction = 0.985;
  // Voxels of the part's patch; two contacts nearer to each other than this lie at one place.
  static constexpr double same_place = 2;
  // Voxels of the head's patch, overlap that is corrected per search; a part deeper in tissue is led out at this pace.
  static constexpr double led_out = 0.1;
};

}  // namespace typodont::haptics
