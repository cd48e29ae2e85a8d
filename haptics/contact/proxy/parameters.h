// Constants of the contact search and the projection, each with its unit and its reason. Lengths are in voxels unless
// another unit is given, because they depend on the resolution of the field.
#pragma once

namespace typodont::haptics {

/// Conditions under which one cubic query at a ball's centre gives the only contact (ContactFinder::find_by_offset).
struct OffsetQueryParameters {
  // Voxels; largest allowed difference between the field and its expected value at a test point. The expected value is
  // 0 at the foot point (nearest point of the surface), and the negative depth at a point below it. The tolerance
  // equals the error of linear interpolation for a ball with a radius of four voxels.
  static constexpr double foot_tolerance = 0.05;
  // Largest allowed difference between 1 and the length of the field's gradient at the ball's centre. The length is 1
  // near a single smooth wall.
  static constexpr double gradient_tolerance = 2e-4;
  static constexpr double depth_below = 3;  // voxels, smallest thickness of the tissue below the contact point
  // Voxels; at this height above the ball's centre, the wall of the contact must still be the nearest wall.
  static constexpr double height_above = 3.5;
};

/// Parameters for the direct computation of a ball's position on one smooth wall (ContactFinder::seat).
struct WallSeatParameters {
  // Voxels; the ball's position is computed directly only if the hand is at most this deep below the surface that stops
  // the ball.
  static constexpr double hand_depth = 4;
  // voxels²; the iteration ends if the squared distance of the hand from the line along the wall's normal through the
  // contact point is less than this
  static constexpr double aligned = 1e-8;
  static constexpr int iterations = 6;  // largest number of steps along the wall to the ball's position
  // Largest allowed difference between 1 and the length of the field's gradient at the contact point. The length is 1
  // near a single smooth wall.
  static constexpr double gradient_tolerance = 1e-3;
  // Stricter limit of the same kind as gradient_tolerance: if the difference between 1 and the length of the field's
  // gradient is smaller than this, no other wall is near the ball.
  static constexpr double gradient_tolerance_alone = 5e-5;
};

/// Parameters of the refinement of one contact by cubic queries (ContactFinder::refine).
struct RefineParameters {
  static constexpr int iterations = 2;  // largest number of queries in one call of refine() for a head that cuts
  // Largest number of queries per contact and call for a head that does not cut. Without cutting, the hand feels errors
  // of the force's direction.
  static constexpr int iterations_fine = 8;
  // Voxels. A contact counts as exact until the ball has moved this far after its query. The error of its gap is then
  // 2e-5 voxel.
  static constexpr double stays_exact = 0.02;
  // Voxels. A contact of a head with edges counts as exact until the head has moved this far. The limit is smaller than
  // for a ball, because the error of the gap is as large as the distance moved.
  static constexpr double stays_exact_edged = 2e-3;
  // Voxels. A contact of a head that does not cut counts as exact until the head has moved this far. The limit is
  // smaller than for a cutting head, because the hand then feels errors of the force's direction.
  static constexpr double stays_exact_fine = 1e-3;
  // Voxels, convergence tolerance of the gap: the refinement ends when a step reduces the gap by less than this. The
  // next step would reduce the gap only by about the square of this.
  static constexpr double gained = 1e-4;
  // Voxels, convergence tolerance of the gap for a head that does not cut. The force direction depends on the lateral
  // error of the contact, which is the square root of the gap's error. So this tolerance is much smaller than that of a
  // cutting head.
  static constexpr double gained_fine = 3e-8;
  // The secant method is used only if the length of a step, divided by the length of the previous step, is less than
  // this.
  static constexpr double still_converges = 0.95;
  static constexpr double most_gain = 10;  // largest factor by which the secant method lengthens a step
};

/// Parameters for a sharp rim of the head that is inside the tissue (ContactFinder::touch_with_rim). The head must
/// leave the tissue along the tissue's normal, and not along a normal of the rim's sides.
struct RimParameters {
  // If the cosine between the head's normal and the tissue's normal at a contact is larger than this, the two normals
  // count as equal. The rim is then not examined.
  static constexpr double askew = 0.99999;
  // Largest allowed difference between 1 and the length of the field's gradient. The length is 1 in smooth tissue.
  static constexpr double gradient_tolerance = 0.05;
  // If the cosine between the tissue's normals at a contact and at the head's rim is larger than this, both points
  // belong to the same wall.
  static constexpr double same_wall = 0.9;
  // Voxels. A contact counts as a contact of the head's rim if its distance from the rim is at most (this length +
  // twice the depth of the rim in the tissue).
  static constexpr double near_rim = 2;
};

/// Parameters of the samples on the head's surface (HeadSamples).
struct HeadSampleParameters {
  // voxels; a point nearer than this to the tissue's surface counts as on the surface
  static constexpr float on_surface = 0.25f;
  // voxels; a sample of the head nearer than this to the tissue's surface is moved onto the surface
  static constexpr float examined = 1.5f;
  static constexpr double near_free_end = 0.5;  // fraction of the samples that lie near the head's free end
};

/// Parameters for edges, corners and grooves, which are computed from the adjacent faces (sharp_edge.h).
struct SharpEdgeParameters {
  // Number of directions in which faces are searched. It is large, because some faces of a corner are visible in few
  // directions.
  static constexpr int directions = 12;
  // Voxels. The search for a face starts at this lateral distance from the foot point (the surface point nearest to the
  // head's centre).
  static constexpr double aside = 8;
  // Voxels. If an edge of the surface lies between the foot point (the surface point nearest to the head's centre) and
  // the searched face, the search starts at this lateral distance from the foot point, and as far below the foot point.
  static constexpr double down = 6.8;
  // Voxels, smallest distance from the foot point (see `aside`) to the point that is used on a face. At a smaller
  // distance, the interpolation stencil would include samples of the other face of the edge.
  static constexpr double least_aside = 5.2;
  static constexpr int steps = 3;  // largest number of steps that move a point onto a face
  // voxels, tolerance: a point that is nearer than this to the face counts as on the face
  static constexpr double on_face = 1e-3;
  // Largest allowed difference between 1 and the length of the field's gradient at a point of a face. The length is 1
  // near a single face.
  static constexpr double gradient_tolerance = 1e-3;
  // voxels; a face counts as far from other faces if the tissue below it is at least this deep
  static constexpr double depth_clean = 4.5;
  // voxels; a face is used only if the tissue below it is at least this deep
  static constexpr double depth_least = 3.7;
  // voxels; largest allowed difference between the depth that the field gives at a point below a face, and the depth of
  // this point below the face
  static constexpr double depth_tolerance = 0.05;
  // If the cosine between the normals of two faces is larger than this, and the second face is near other faces (see
  // depth_clean), the second face counts as a duplicate of the first and is not stored.
  static constexpr double alike = 0.98;
  // Two faces can be the same plane only if (1 - cosine between their normals) is less than this; the limit covers the
  // interpolation error.
  static constexpr double same_face = 1e-5;
  // Voxels. Faces enclose a convex solid if the measured point of each face is at most this far above the planes of the
  // other faces. They form a concave crease if this point is at most this far below the planes of the other faces.
  static constexpr double convex = 0.02;
  // Voxels; largest allowed difference, at the head's centre, between the field and the distance that is computed from
  // the faces.
  static constexpr double agrees = 0.05;
  // voxels; the wall of a groove is measured at a second point, which is farther from the groove's bottom by this
  // distance
  static constexpr double farther = 1.5;
  // a groove's wall is flat if (1 - cosine between its normals at the two measured points) is less than this
  static constexpr double flat = 1e-10;
  // voxels; a groove's wall is flat if its second measured point, which lies in the tangent plane at the first one, is
  // nearer than this to the surface. The limit allows for the rounding of the distances to floats.
  static constexpr double flat_distance = 2e-5;
  // if a groove's wall is missing in more than this number of directions, the search fails
  static constexpr int misses = 6;
  // Voxels. Interpolation fills the bottom of a groove. The largest depth of the filled part is this length times |n1 -
  // n2|, where n1 and n2 are the normals of the walls.
  static constexpr double filled = 0.15;
};

/// Parameters of shanks and safe ends (smooth pins at the tip), see NonCuttingContacts. Shank contacts are computed in
/// the coarse patch (field around the shank). Lengths are in coarse voxels unless another unit is given.
struct NonCuttingPartParameters {
  static constexpr double spacing = 0.25e-3;  // m, sample spacing of the coarse patch (field around the shank)
  // Coarse voxels, upper bound of the error by which linear interpolation overestimates the distance.
  static constexpr double overestimate = 0.5;
  // Coarse voxels. The patch stores no distance larger than a limit (the band), and rounds distances. So a stored
  // distance that differs from the limit by at most this counts as equal to it.
  static constexpr double at_band = 1e-3;
  // Coarse voxels. The nearest surface point is computed from value and gradient of the field. If the computed point is
  // farther than this from the surface, the field there is not a true distance (as for an intersection of solids).
  static constexpr double edge_distance = 0.4;
  // Voxels of the fine patch (field around the head). While the shank can certainly move farther than this without
  // contact, its contacts are not searched again.
  static constexpr double enough_room = 3;
  // voxels of the fine patch (around the head); if the shank cannot move this far freely, its contacts are searched
  static constexpr double close_room = 0.8;
  // If the cosine between two contact normals at the same place is larger than this, the contacts are merged.
  static constexpr double same_direction = 0.985;
  // Voxels (coarse for the shank). Two contacts that are nearer to each other than this count as at the same place.
  static constexpr double same_place = 2;
  // Voxels of the fine patch (field around the head), largest overlap that one search corrects. A part that is deeper
  // in tissue is moved out gradually.
  static constexpr double led_out = 0.1;
};

}  // namespace typodont::haptics
