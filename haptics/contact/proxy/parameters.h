// The numbers of contact search and projection, each with its unit and its reason. Lengths in voxels unless a unit is
// given: they are limits of what the field can tell, which grows with the voxel.
#pragma once

namespace typodont::haptics {

/// One cubic query at a ball's centre (ContactFinder::find_by_offset): when its answer is the only contact.
struct OffsetQueryParameters {
  static constexpr double foot_tolerance = 0.05;  // error of a linear look; a ball of four voxels' radius has as much
  static constexpr double gradient_tolerance = 2e-4;  // deviation of the gradient's length from one, of a single wall …
  static constexpr double depth_below = 3;            // … with this much tissue under its surface …
  static constexpr double height_above = 3.5;         // … and this much air before another wall is nearer
};

/// Where a ball rests on one smooth wall (ContactFinder::seat).
struct WallSeatParameters {
  static constexpr double hand_depth = 4;  // greatest depth of the hand under the surface on which its ball lies
  static constexpr double aligned = 1e-8;  // voxels², squared offset from straight above the wall that counts as none
  static constexpr int iterations = 6;     // limit of steps along the wall to get there
  static constexpr double gradient_tolerance = 1e-3;  // deviation of the gradient's length from one on the way, …
  static constexpr double gradient_tolerance_alone = 5e-5;  // … and where nothing else may be near
};

/// Making one contact exact by cubic queries (ContactFinder::refine).
struct RefineParameters {
  static constexpr int iterations = 2;         // limit of queries per contact and call while the head cuts, …
  static constexpr int iterations_fine = 8;    // … and while it only touches: then the force's direction counts
  static constexpr double stays_exact = 0.02;  // path of a ball for which a contact stays exact: 2e-5 of gap
  static constexpr double stays_exact_edged =
      2e-3;                                         // the same of a head with edges: its gap changes by the path itself
  static constexpr double stays_exact_fine = 1e-3;  // the same of a head that only touches
  // The search ends when a step lowers the gap by less than this: the next step would lower it by about its square.
  static constexpr double gained = 1e-4;
  // The same of a head that only touches. Its force's direction depends on the sideways error of the contact, which is
  // the square root of the gap's error: so this limit is much smaller.
  static constexpr double gained_fine = 3e-8;
  static constexpr double still_converges = 0.95;  // ratio of successive steps up to which the secant method is used
  static constexpr double most_gain = 10;          // limit of its gain
};

/// A rim that lies in the tissue: its sides are no guide to the way out, the tissue's normal is (touch_with_rim).
struct RimParameters {
  static constexpr double askew = 0.99999;            // cosine of head's and tissue's normal below which they differ
  static constexpr double gradient_tolerance = 0.05;  // deviation of the gradient's length from one, of smooth tissue
  static constexpr double same_wall = 0.9;            // cosine of normals of one wall
  static constexpr double near_rim = 2;  // distance from the rim, and from its sunk part, that belongs to it
};

/// Samples of the head (HeadSamples).
struct HeadSampleParameters {
  static constexpr float on_surface = 0.25f;    // a point nearer to the surface than this lies on it
  static constexpr float examined = 1.5f;       // a sample nearer to the surface than this is slid onto it
  static constexpr double near_free_end = 0.5;  // fraction of the samples that lie near the head's free end
};

/// Edges, corners and grooves made of the faces beside them (sharp_edge).
struct SharpEdgeParameters {
  static constexpr int directions = 12;       // in which faces are looked for: those of a corner may be met in few
  static constexpr double aside = 8;          // distance from the foot at which they are looked for, …
  static constexpr double down = 6.8;         // … and that aside and down, beyond an edge
  static constexpr double least_aside = 5.2;  // least distance of a face found: the stencil then ends before the edge
  static constexpr int steps = 3;             // limit of steps onto a face
  static constexpr double on_face = 1e-3;     // distance that counts as on it
  static constexpr double gradient_tolerance = 1e-3;  // deviation of the gradient's length from one, of a single face
  static constexpr double depth_clean = 4.5;          // tissue under a face that is far from any other, …
  static constexpr double depth_least = 3.7;          // … and at a corner, where nothing better may be found …
  static constexpr double depth_tolerance = 0.05;     // … and the error allowed in it
  static constexpr double alike = 0.98;               // cosine above which a clean face and another may be the same
  static constexpr double same_face = 1e-5;           // 1 - cosine, of one plane: what interpolation leaves
  static constexpr double convex = 0.02;              // height by which a face may stand out over another
  static constexpr double agrees = 0.05;              // between the nearest point's distance and the field's
  static constexpr double farther = 1.5;              // distance by which a groove's wall must go on …
  static constexpr double flat = 1e-10;               // … with the same normal, 1 - cosine, …
  static constexpr double flat_distance = 2e-5;       // … in the same plane: what floats leave of it
  static constexpr int misses = 6;                    // limit of directions in which a groove shows no wall
  static constexpr double filled = 0.15;  // most that interpolation fills a groove, for each unit its normals differ
};

/// Shanks and safe ends, felt in the coarse patch (SmoothContacts). Lengths in coarse voxels, if not said otherwise.
struct SmoothPartParameters {
  static constexpr double spacing = 0.25e-3;    // m between samples of the coarse patch
  static constexpr double overestimate = 0.5;   // most that a linear look overestimates a distance
  static constexpr double at_band = 1e-3;       // rounding: distances this near the band's end are cut off there
  static constexpr double edge_distance = 0.4;  // a nearest point farther from the surface was made by intersection
  static constexpr double enough_room =
      3;  // patch voxels of room for which a part is not examined again, nor while half …
  static constexpr double close_room = 0.8;  // … of it is left, but for this much, at which contacts are looked for
  static constexpr double same_direction = 0.985;  // cosine: contacts that push alike, and lie closer together than …
  static constexpr double same_place = 2;          // … this many patch voxels, are one
  static constexpr double led_out = 0.1;           // per look: a part found deeper in tissue is led out at this pace
};

}  // namespace typodont::haptics
