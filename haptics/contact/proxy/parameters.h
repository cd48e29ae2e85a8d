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
  static constexpr int iterations_fine = 12;
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
  static constexpr double most_gain = 10;   // largest factor by which the secant method lengthens a step
  static constexpr double shortened = 0.2;  // factor for a step after which the gap was larger
  // Difference between 1 and the gradient's length up to which the surface is smooth.
  static constexpr double smooth = 1e-3;
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
  // Voxels between samples up to which no tissue is missed between them, and between the points that cover a larger
  // head.
  static constexpr double dense = 3, cover = 8;
  static constexpr int max_cover = 8192;   // points
  static constexpr int descents = 24;      // largest number of descents from such points
  static constexpr double same_place = 1;  // voxels between two contacts below which they are the same
};

/// Parameters of the sheets that meet at a convex edge, rim or corner (crease.h). Voxels.
struct CreaseParameters {
  static constexpr int directions = 12;  // directions in which the surface beside the crease is searched
  // Distances of the search from the crease; the first one is usually enough.
  static constexpr double aside[] = {4, 6.5, 5};
  static constexpr double down = 0.8;       // times that distance: second start of the search, aside and below
  static constexpr double least_aside = 2;  // smallest distance of a place that is used
  static constexpr int steps = 4;           // largest number of steps onto the surface
  static constexpr double landed = 0.1;     // nearer than this, a point counts as on the surface
  // A sheet is fitted at the place found or so much farther from the crease, and above the sheet.
  static constexpr double farther[] = {0, 1.5, 3, 4.5}, height = 0.7;
  static constexpr double clear = 0.4;  // smallest distance between the samples of a fit and those of other sheets
  static constexpr double gradient_tolerance = 5e-3;  // difference between 1 and the gradient's length
  static constexpr double max_curvature = 0.4;        // 1/voxel
  // Largest third or fourth difference of the samples; the second term covers curved sheets.
  static constexpr double rough = 0.03, rough_curved = 4;
  static constexpr double same_normal =
      0.7;  // cosine between the normals of a sheet and of the place where it is fitted
  // Two fits belong to one sheet up to this distance and cosine between their normals.
  static constexpr double same_sheet = 0.3, same_sheet_normal = 0.98;
  static constexpr double convex = 0.2;  // a fit lies at least so far below the other sheets
  // A place so far below two sheets belongs to a third one, or with this cosine between its normal and their line.
  static constexpr double missed_below = 0.6, along_line = 0.3;
  static constexpr double converged = 1e-9;
  static constexpr double least_angle = 1e-4;  // determinant of normals below which sheets do not meet
  static constexpr int newton_steps = 8;
};

/// Descent along the interpolated surface to the point nearest to the head (ContactFinder::descend). Voxels.
struct DescentParameters {
  static constexpr int steps = 14, surface_steps = 10;
  static constexpr double shortest = 0.2;  // a shorter step along the surface ends the descent
  static constexpr double flat = 0.2;      // length of the gradient below which it has no direction
  static constexpr double on_surface = 0.1, near_surface = 0.3;
};

/// Contact of a head with a crease (ContactFinder::touch_crease). Voxels.
struct CreaseContactParameters {
  static constexpr int steps = 8;
  static constexpr double aligned = 1e-9;  // derivative of the gap along the crease
  static constexpr double slid = 1e-14;    // voxels², square of a step along a sheet
  static constexpr double longest = 4;     // longest step along the crease
  static constexpr double inside_cone = 1e-9, feasible = 1e-7;
  // The exact crease may be so much farther from the head and nearer to it than the interpolated one.
  static constexpr double farther = 0.5, nearer = 1.5;
  static constexpr double depth = 1.5, agrees = 0.1;  // depth of the sample compared with the sheets, and tolerance
};

/// Parameters of grooves and inner corners between flat walls (groove.h). Voxels.
struct GrooveParameters {
  static constexpr int directions = 12;       // directions in which walls are searched
  static constexpr double aside = 8;          // distance of the search from the bottom of the groove
  static constexpr double least_aside = 5.2;  // of a nearer point, the stencil would include samples of another wall
  static constexpr int steps = 3;             // largest number of steps onto a wall
  static constexpr double on_face = 1e-3;     // at most; a nearer point counts as on the wall
  static constexpr double gradient_tolerance = 1e-3;  // difference between 1 and the gradient's length
  // The tissue below a wall must be at least so deep, with this error of the interpolated depth.
  static constexpr double depth = 3.7, depth_tolerance = 0.05;
  static constexpr double same_face = 1e-5;  // 1 - cosine between the normals of two places of one wall
  static constexpr double concave = 0.02;    // a wall may lie so far below the planes of the others
  static constexpr double agrees = 0.05;     // difference between the field and the distance from the walls
  static constexpr double farther = 1.5;     // distance of a second point that shows whether the wall is flat
  // Limits for this point: 1 - cosine between the normals, and the distance, which allows for rounding to floats.
  static constexpr double flat = 1e-10, flat_distance = 2e-5;
  static constexpr int misses = 6;  // after so many directions without a wall, the search fails
  // Interpolation fills the bottom of a groove up to this depth times |n1 - n2|, with the normals of the walls.
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
