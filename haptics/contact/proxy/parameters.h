// Constants of the contact search and the projection, each with its unit and its reason. Lengths are in voxels unless
// another unit is given, because they depend on the resolution of the field.
#pragma once

namespace typodont::haptics {

/// Conditions under which one cubic query at a ball's centre gives the only contact (ContactFinder::find_by_offset).
struct OffsetQueryParameters {
  // Voxels, tolerance of the field at the foot point. It covers the error of linear interpolation, which is this large
  // for a ball with a radius of four voxels.
  static constexpr double foot_tolerance = 0.05;
  // Tolerance of the gradient's length, which is 1 near a single smooth wall.
  static constexpr double gradient_tolerance = 2e-4;
  static constexpr double depth_below = 3;  // voxels; the tissue must be at least this deep below the surface
  // Voxels; up to this height above the ball's centre, no other wall may be nearer.
  static constexpr double height_above = 3.5;
};

/// Parameters for the direct computation of a ball's position on one smooth wall (ContactFinder::seat).
struct WallSeatParameters {
  // Voxels, largest depth of the hand below the surface on which the ball lies.
  static constexpr double hand_depth = 4;
  static constexpr double aligned = 1e-8;  // voxels², tolerance of the squared lateral error of the foot point
  static constexpr int iterations = 6;     // upper limit of the steps along the wall to the foot point
  // Tolerance of the gradient's length, which is 1 near a single smooth wall.
  static constexpr double gradient_tolerance = 1e-3;
  // Stricter tolerance of the gradient's length; within it, no other wall is near.
  static constexpr double gradient_tolerance_alone = 5e-5;
};

/// Parameters of the refinement of one contact by cubic queries (ContactFinder::refine).
struct RefineParameters {
  static constexpr int iterations = 2;  // upper limit of queries per contact and call for a head that cuts
  // Upper limit of queries per contact and call for a head that does not cut. Without cutting, the hand feels errors of
  // the force's direction.
  static constexpr int iterations_fine = 8;
  // Voxels. A contact counts as exact until the ball has moved this far after its query. The error of its gap is then
  // 2e-5 voxel.
  static constexpr double stays_exact = 0.02;
  static constexpr double stays_exact_edged =
      2e-3;  // voxels, path of a head with edges below which a contact stays exact; its gap errs by the whole path
  // Voxels, limit of the path after a query, for a head that does not cut: up to this limit, the contact counts as
  // exact.
  static constexpr double stays_exact_fine = 1e-3;
  // Voxels, convergence tolerance: the search ends when a step lowers the gap by less than this. The next step would
  // lower it by about the square.
  static constexpr double gained = 1e-4;
  // Voxels, convergence tolerance for a head that does not cut, a change of the gap per step. The direction of the
  // force depends on the sideways error of the contact, which is the square root of the gap's error; so this
  // tolerance is much smaller.
  static constexpr double gained_fine = 3e-8;
  // Upper limit of the ratio of successive steps for which the secant method is used.
  static constexpr double still_converges = 0.95;
  static constexpr double most_gain = 10;  // upper limit of the secant method's gain
};

/// A sharp rim inside the tissue. The tissue's normal is the direction out of the tissue; the normals of the rim's
/// sides are not (touch_with_rim).
struct RimParameters {
  // Limit of the cosine between the head's normal and the tissue's normal; below this limit the two normals count as
  // different.
  static constexpr double askew = 0.99999;
  // Tolerance of the gradient's length, which is 1 in smooth tissue.
  static constexpr double gradient_tolerance = 0.05;
  // lower limit of the cosine between the normals of two contacts on one wall
  static constexpr double same_wall = 0.9;
  // Voxels, limit: a contact nearer than this to the head's rim counts as a contact of the rim. Twice the depth of
  // the rim in the tissue is added to this limit.
  static constexpr double near_rim = 2;
};

/// Parameters of the head's samples (HeadSamples).
struct HeadSampleParameters {
  // voxels, limit of the distance to the surface: a nearer point counts as on the surface
  static constexpr float on_surface = 0.25f;
  // voxels, limit of the distance to the surface: a nearer sample is moved onto the surface
  static constexpr float examined = 1.5f;
  static constexpr double near_free_end = 0.5;  // fraction of the samples that lie near the head's free end
};

/// Parameters for edges, corners and grooves, which are constructed from the faces beside them (sharp_edge).
struct SharpEdgeParameters {
  // Number of directions in which faces are searched. It must be large, because some faces of a corner are found in
  // few directions.
  static constexpr int directions = 12;
  // Voxels, lateral distance from the foot point at which each search for a face starts.
  static constexpr double aside = 8;
  // Voxels; the search for a face beyond an edge starts this far beside the foot point and this far below it.
  static constexpr double down = 6.8;
  // Voxels, least distance from the foot point to a face; the stencil then ends before the edge.
  static constexpr double least_aside = 5.2;
  static constexpr int steps = 3;          // limit of steps onto a face
  static constexpr double on_face = 1e-3;  // voxels, tolerance: a point nearer than this lies on the face
  // Tolerance of the gradient's length, which is 1 near a single face.
  static constexpr double gradient_tolerance = 1e-3;
  // voxels, depth of the tissue under a face that lies far from all other faces
  static constexpr double depth_clean = 4.5;
  // voxels, lower limit of the depth of tissue under a face near a corner; with less tissue, the face is not used
  static constexpr double depth_least = 3.7;
  static constexpr double depth_tolerance = 0.05;  // voxels, tolerance of the depth of tissue
  // Lower limit of the cosine between normals of equal faces: above this limit, a face near others counts as a face
  // already found.
  static constexpr double alike = 0.98;
  // limit of 1 - cosine between normals on one plane; interpolation causes such a difference
  static constexpr double same_face = 1e-5;
  static constexpr double convex = 0.02;  // voxels, limit of the height by which a face may protrude over another face
  // Voxels, tolerance of the difference between the distance to the nearest point and the field's distance.
  static constexpr double agrees = 0.05;
  static constexpr double farther = 1.5;  // voxels, distance over which a groove's wall must continue
  static constexpr double flat = 1e-10;   // limit of 1 - cosine between the normals of two samples of a groove's wall
  // Voxels, limit of the offset between the planes of two samples of a groove's wall; rounding to floats causes an
  // offset.
  static constexpr double flat_distance = 2e-5;
  static constexpr int misses = 6;  // limit of the number of directions in which a groove shows no wall
  // Voxels per unit of difference between a groove's normals; gives the limit of the depth to which interpolation
  // fills the groove.
  static constexpr double filled = 0.15;
};

/// Parameters of shanks and safe ends, which are computed in the coarse patch (NonCuttingContacts). Lengths are in
/// coarse voxels unless another unit is given.
struct NonCuttingPartParameters {
  static constexpr double spacing = 0.25e-3;  // m, distance between samples of the coarse patch
  // Coarse voxels, largest amount by which a linearly interpolated distance can exceed the true distance.
  static constexpr double overestimate = 0.5;
  // Coarse voxels, tolerance for rounding: a distance this close to the band's limit counts as cut off at the limit.
  static constexpr double at_band = 1e-3;
  // Coarse voxels, limit: a nearest point farther than this from the surface results from an intersection of solids.
  static constexpr double edge_distance = 0.4;
  // patch voxels of free distance; with more, the shank is not searched again
  static constexpr double enough_room = 3;
  static constexpr double close_room = 0.8;  // patch voxels of free distance; with less, contacts are searched
  // Lower limit of the cosine between the normals of two contacts at one place; such contacts are merged.
  static constexpr double same_direction = 0.985;
  // Voxels of the part's patch, limit of the distance between two contacts that count as being at one place.
  static constexpr double same_place = 2;
  // Voxels of the head's patch, limit of the overlap that one search corrects; a part deeper in tissue is led out
  // gradually.
  static constexpr double led_out = 0.1;
};

}  // namespace typodont::haptics
