// Constants of the contact search and the projection, each with its unit and its reason. Lengths are in voxels unless
// another unit is given, because they depend on the resolution of the field.
#pragma once

namespace typodont::haptics {

/// Conditions under which one cubic interpolation at a ball's centre finds its only contact (find_by_offset()).
struct OffsetQueryParameters {
  // Voxels; largest difference between the field and its expected value: 0 at the foot point (nearest surface point),
  // -d at the depth d below it. Equals the error of linear interpolation at a ball with a radius of 4 voxels.
  static constexpr double foot_tolerance = 0.05;
  // Largest allowed difference between 1 and the length of the field's gradient at the ball's centre. Near a single
  // smooth wall, this length is 1.
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
  static constexpr double min_height = 0.5;  // voxels, smallest height of the hand above a crease
  // Voxels. For a ball on a crease: a contact whose gap is below `near` is other tissue if it is farther than
  // `off_crease` from the smooth surfaces that form the crease. A search up to `ahead` more shows how far the ball may
  // move before it touches other tissue.
  static constexpr double near = 0.05, ahead = 2, off_crease = 0.7;
  // The next search begins when this fraction of that room is used, so that it seldom falls in the tick of a new fit of
  // the crease. Voxels per tick: a contact that moves faster than `fast` is searched only if all room is used.
  static constexpr double used = 0.7, fast = 0.3;
  // voxels²; the iteration ends if the hand's squared distance from the wall's normal line at the contact is below this
  static constexpr double aligned = 1e-8;
  static constexpr int iterations = 6;  // largest number of steps along the wall to the contact point
  // Largest allowed difference between 1 and the length of the field's gradient at the contact point. The length is 1
  // near a single smooth wall.
  static constexpr double gradient_tolerance = 1e-3;
  // If the length of the field's gradient differs from 1 by less than this, no other wall is near the ball.
  static constexpr double gradient_tolerance_alone = 5e-5;
};

/// Refinement of one contact by queries (cubic interpolations) of the field (ContactFinder::refine).
struct RefineParameters {
  static constexpr int iterations = 2;  // largest number of queries in one call of refine() for a head that cuts
  // Largest number of queries per contact and call for a head that does not cut. Without cutting, the hand feels errors
  // of the force's direction.
  static constexpr int iterations_fine = 12;
  // Voxels. If a ball has moved by less than this since the last query, the contact's plane counts as exact. The error
  // of its gap is at most 2e-5 voxels.
  static constexpr double stays_exact = 0.02;
  // Voxels. If a head with edges has moved by less than this since the last query, its contact's plane counts as exact.
  // The limit is smaller than that of a ball, because the error of the gap is as large as the motion.
  static constexpr double stays_exact_edged = 2e-3;
  // Voxels. If a head that does not cut has moved by less than this since the last query, its contact's plane counts
  // as exact. The limit is small, because without cutting the hand feels errors of the force's direction.
  static constexpr double stays_exact_fine = 1e-3;
  // Voxels. The refinement ends when a step reduces the gap by less than this; the next step would reduce it by about
  // the square of this.
  static constexpr double gained = 1e-4;
  // Voxels. For a head that does not cut, the refinement ends when a step reduces the gap by less than this. The limit
  // is small, because the contact's lateral error, which turns the force, is the square root of the gap's error.
  static constexpr double gained_fine = 3e-8;
  // The secant method is used only if a step is shorter than this factor times the previous step.
  static constexpr double still_converges = 0.95;
  static constexpr double max_gain = 10;    // largest factor by which the secant method lengthens a step
  static constexpr double shortened = 0.2;  // factor for the step length after a step that increased the gap
  // The tissue's surface is smooth if the length of the field's gradient differs from 1 by less than this.
  static constexpr double smooth = 1e-3;
};

/// A sharp rim of the head inside the tissue (ContactFinder::touch_with_rim). The head must leave along the tissue's
/// normal, not along the normal of one side of the rim.
struct RimParameters {
  // If the cosine between the head's and the tissue's normal is larger than this, the normals count as equal, and the
  // rim is not examined.
  static constexpr double askew = 0.99999;
  // Largest difference between 1 and the length of the field's gradient in smooth tissue.
  static constexpr double gradient_tolerance = 0.05;
  // A contact and the rim belong to the same wall if the cosine between the tissue's normals at both is above this.
  static constexpr double same_wall = 0.9;
  // Voxels. A contact belongs to the rim if its distance from the rim is at most this length + twice the rim's depth.
  static constexpr double near_rim = 2;
  // The head has a rim or tip at a point of its outline if the cosine between the outline's directions before and after
  // this point is below `sharp`. If the cosine is above `blunt`, near_blunt (voxels) is used in place of near_rim.
  static constexpr double sharp = 0.98, blunt = 0.3, near_blunt = 0.5;
  // spacing: voxels between the points of a rim at which the field is read. max_points: largest number of these points.
  static constexpr double spacing = 1;
  static constexpr int max_points = 128;
  static constexpr int steps = 6;            // largest number of steps along the rim
  static constexpr double converged = 1e-3;  // voxels; a shorter step along the rim ends the search
};

/// Parameters of the samples on the head's surface (HeadSamples).
struct HeadSampleParameters {
  // voxels; a point nearer than this to the tissue's surface counts as on the surface
  static constexpr float on_surface = 0.25f;
  // Voxels. Samples of the head nearer to the tissue's surface than `examined` are moved onto the surface. A search for
  // contacts with larger gaps examines samples up to `beyond_near` beyond these gaps.
  static constexpr float examined = 1.5f, beyond_near = 0.5f;
  static constexpr double near_free_end = 0.5;  // fraction of the samples near the head's free end, which cuts most
  // Voxels. Samples at most `dense` apart miss no tissue. A head whose samples are farther apart gets additional points
  // with the spacing `cover`.
  static constexpr double dense = 3, cover = 8;
  static constexpr int max_cover = 8192;   // largest number of additional points (see `cover`)
  static constexpr int descents = 24;      // largest number of searches (descend()) that start at additional points
  static constexpr double same_place = 1;  // voxels; contacts nearer to each other count as one
};

/// Parameters of the smooth surfaces (sheets) that meet at a convex edge, rim or corner (crease.h). Voxels.
struct CreaseParameters {
  // An edge is sharp if the samples' second difference there exceeds that beside the edge by more than this.
  static constexpr double sharp = 0.2;
  static constexpr int directions = 24;  // number of directions in which the surface beside the crease is searched
  // Voxels, distances from the crease at which the surface is searched, in this order; usually the first suffices.
  static constexpr double aside[] = {4, 6.5, 5};
  static constexpr double down = 0.8;     // second start of a search: down × aside beside the crease, and as far below
  static constexpr double min_aside = 2;  // surface points nearer to the crease than this are not used
  static constexpr int steps = 4;         // largest number of steps onto the surface
  static constexpr double landed = 0.1;   // a point nearer to the surface than this counts as on the surface
  // Start points of a fit: `farther` from the surface point, along the surface, and at `height` above the surface.
  static constexpr double farther[] = {0, 1.5, 3, 4.5}, height = 0.7;
  static constexpr int away_steps = 5;  // largest number of steps along a narrow surface, away from the other surfaces
  static constexpr double away_step = 3;
  // The samples to which a smooth surface is fitted must be at least this far from samples of the other surfaces.
  static constexpr double clear = 0.4;
  static constexpr double gradient_tolerance = 5e-3;  // largest difference between 1 and the gradient's length
  static constexpr double max_curvature = 0.4;        // 1/voxel, largest principal curvature of a smooth surface
  // Limit of the third and fourth differences of a fit's samples: rough + curved_roughness × the fit's curvature².
  static constexpr double rough = 0.03, curved_roughness = 4;
  // If the curvature (1/voxel) is above `curved`, samples two voxels from a fit's centre must fit within `residual`.
  static constexpr double curved = 0.05, residual = 0.1;
  static constexpr double same_normal =
      0.7;  // smallest cosine between the normals of a fitted surface and of the tissue at the fitted place
  // Two fits are one surface if their distance is below same_sheet and their normals' cosine above same_sheet_normal.
  static constexpr double same_sheet = 0.3, same_sheet_normal = 0.98;
  // A point is beside a crease only if at least two smooth surfaces are nearer to it than this.
  static constexpr double near_sheet = 3;
  // Each surface's fitted point must lie at least this deep below the other surfaces: then the crease is convex.
  static constexpr double convex = 0.2;
  static constexpr double shallow = 0.966;  // an edge between normals with a larger cosine is flat, so no crease
  // Samples within ±`around` of a crease, at -deepest to shallowest, must agree with its surfaces to around_agrees.
  static constexpr double around = 2, shallowest = -0.2, deepest = 1.5, around_agrees = 0.15;
  // A surface point belongs to a third smooth surface if it lies missed_below under the first two, or if the cosine
  // between its normal and the first two surfaces' common line exceeds along_line.
  static constexpr double missed_below = 0.6, along_line = 0.3;
  // If a sample below the surface differs by more than this from the fitted surfaces, there is another surface.
  static constexpr double missed_by = 0.3;
  // Up to the distance `reused` from the point where a crease was fitted, the crease is used unchanged. Up to the
  // distance `followed`, its smooth surfaces are fitted again, without a new search for the crease.
  static constexpr double reused = 1, followed = 3;
  // A search that found no crease is not repeated within `none_within`, if the cosine between both directions of search
  // is above `none_along`.
  static constexpr double none_within = 0.25, none_along = 0.9;
  // `ahead` along the line where two surfaces meet, the sample at the depth `below` must fit them within line_agrees.
  static constexpr double ahead = 4, below = 1.5, line_agrees = 0.1;
  static constexpr double aside_followed[] = {3.5, 4.5, 6};  // distances from a known crease for fits of the surfaces
  static constexpr double converged = 1e-9;
  // The search for the line where two surfaces meet ends after a step that began at a distance below this from both
  // surfaces. As Newton's method converges quadratically, the error is then about 1e-3 voxels.
  static constexpr double last_step = 0.1;
  // smooth surfaces count as parallel if the determinant of their unit normals is smaller than this
  static constexpr double min_angle = 1e-4;
  static constexpr int newton_steps = 8;
};

/// Descent along the interpolated surface to the point nearest to the head (ContactFinder::descend). Voxels.
struct DescentParameters {
  static constexpr int steps = 14, surface_steps = 10;
  static constexpr double shortest = 0.2;  // a shorter step along the surface ends the descent
  static constexpr double flat = 0.2;      // a shorter gradient has no clear direction
  static constexpr double on_surface = 0.1, near_surface = 0.3;
};

/// Contact of a head with a crease (ContactFinder::touch_crease). Voxels.
struct CreaseContactParameters {
  static constexpr int steps = 8;
  // voxels²; for a ball, the search along the line of a crease ends when a step's squared length is below this. As
  // Newton's method converges quadratically, the error is then about 1e-5 voxels.
  static constexpr double last_step = 1e-4;
  // voxels²; a smaller squared step ends a search along a surface, or along a crease's line if the head is no ball
  static constexpr double slid = 1e-14;
  static constexpr double longest = 4;  // longest step along the crease
  static constexpr double inside_cone = 1e-9, feasible = 1e-7;
  // The exact contact with a crease may be farther from the head than the interpolated contact by at most `farther`, or
  // nearer by at most `nearer`.
  static constexpr double farther = 0.1, nearer = 1.5;
  // The sample at this `depth` below the contact must differ by less than `agrees` from the crease's fitted surfaces.
  static constexpr double depth = 1.5, agrees = 0.1;
};

/// Grooves and inner corners between flat walls (groove.h). Voxels.
struct GrooveParameters {
  static constexpr int directions = 12;     // directions in which walls are searched
  static constexpr double aside = 8;        // walls are searched at this distance from the bottom of the groove
  static constexpr double min_aside = 5.2;  // smallest distance of a wall point from the bottom of the groove
                                            // (nearer, the interpolation would read samples of another wall)
  static constexpr int steps = 3;           // largest number of steps onto a wall
  static constexpr double on_face = 1e-3;   // a point nearer to the wall than this counts as on the wall
  static constexpr double gradient_tolerance = 1e-3;  // largest difference between 1 and the gradient's length
  // At this `depth` below a wall, the field's value must be -depth, with an error of at most depth_tolerance.
  static constexpr double depth = 3.7, depth_tolerance = 0.05;
  static constexpr double same_face = 1e-5;  // largest 1 - cosine between normals of one wall
  static constexpr double concave = 0.02;    // largest depth of a point of one wall below the plane of another
  static constexpr double agrees = 0.05;     // largest difference between the field and the distance from the walls
  static constexpr double farther = 1.5;     // distance of the second point, which tests whether a wall is flat
  // Limits for a second point of a flat wall: 1 - cosine between both normals; distance from the first point's plane.
  static constexpr double flat = 1e-10, flat_distance = 2e-5;
  static constexpr int misses = 6;  // after so many directions without a wall, the search fails
  // Interpolation fills a groove up to this depth × |n1 - n2|, where n1 and n2 are the normals of its walls.
  static constexpr double filled = 0.15;
};

/// Shanks and safe ends (pins at the tip), see NonCuttingContacts. The tissue patch around the shank has coarse voxels.
/// Lengths are in coarse voxels unless another unit is given.
struct NonCuttingPartParameters {
  static constexpr double spacing = 0.25e-3;  // m, sample spacing of the coarse tissue patch
  // Coarse voxels; linear interpolation gives distances that are too large by at most this.
  static constexpr double overestimate = 0.5;
  // Coarse voxels. A distance counts as equal to the largest stored one (the band) if they differ by less than this.
  static constexpr double at_band = 1e-3;
  // Coarse voxels. If the computed surface point is farther than this from the surface, the field is not a true
  // distance there, as at an intersection of solids.
  static constexpr double edge_distance = 0.4;
  // Voxels of the head's tissue patch. While the shank's free distance is larger than this, it is not computed again.
  static constexpr double enough_room = 3;
  // voxels of the head's tissue patch; if the shank's free distance is smaller, it is always computed again
  static constexpr double close_room = 0.8;
  // Contacts of non-cutting parts at the same position are merged if the cosine between their normals is above this.
  static constexpr double same_direction = 0.985;
  // Voxels (for the shank: coarse voxels). Contacts nearer to each other than this count as at the same position.
  static constexpr double same_place = 2;
  // Largest overlap that one search corrects, in voxels of the head's tissue patch. A deeper part is moved out slowly.
  static constexpr double led_out = 0.1;
};

}  // namespace typodont::haptics
