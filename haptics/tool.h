// The tool in the hand: one description of its head for contact, cutting and drawing.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/json.h"
#include "engine/base/pose.h"
#include "engine/contract/tissue.h"
#include "haptics/implant_tool.h"

namespace typodont::haptics {

/// A head is a surface of revolution about the tool's z axis; the shank is on the side of +z, the free end on the side
/// of -z. The origin of T is the head's centre: for a ball its centre, for other shapes the middle of their axis.
/// (Shanks have the shape kShaft; scenes cannot name it.) A table in tool.cpp describes every shape.
enum class HeadShape { kSphere, kCylinder, kRoundEndCylinder, kCone, kPear, kFlame, kInvertedCone, kShaft };
/// Every shape that a scene can name.
std::vector<HeadShape> head_shapes();
/// The name in scenes, e.g. "round_end_cylinder"; a shaft counts as a cylinder.
std::string_view name_of(HeadShape shape) noexcept;

struct Tool;
class Solid;

/// The head's meridian, prepared for fast distances: a convex chain of lines and arcs in the half plane (ρ ≥ 0, z).
/// The distance to the chain in this plane is the distance to the surface of revolution. All lengths have the same,
/// arbitrary unit. Never allocates.
class HeadField {
 public:
  HeadField() = default;
  /// `unit`: m, length unit of the result, e.g. a voxel.
  HeadField(const Tool& tool, double unit);
  /// The head and the volume that it sweeps when it is withdrawn along its axis: a cylinder with the head's largest
  /// radius continues for one unit of length.
  static HeadField with_exit_path(const Tool& tool, double unit);

  /// Signed distance from a point in T, negative inside; exact for every shape.
  double distance(const dvec3& p_TQ) const noexcept;
  /// Signed distance from a point in T; also returns the distance to each piece. A piece whose distance exceeds the
  /// smallest one by more than 2 r cannot be the closest piece of any point within r.
  double distance(const dvec3& p_TQ, double (&to_piece)[4]) const noexcept;
  /// Signed distance from a point in T; also returns the unit direction, in T, in which the distance grows.
  double distance(const dvec3& p_TQ, dvec3& n_T) const noexcept;

  // The pieces of the meridian, from the free end to the shank end, in double precision; sweeps use floats.
  static constexpr int kMaxPieces = 4;
  struct Piece {
    double ax = 0, az = 0, bx = 0, bz = 0;  // end points (ρ, z)
    double dx = 0, dz = 0, inverse2 = 0;    // b - a, 1/|b - a|²
    double cx = 0, cz = 0, radius = 0;      // centre and radius of an arc; radius 0: a straight line
  };
  Piece pieces[kMaxPieces];
  int count = 0;

 private:
  double nearest(double rho, double z, double& n_rho, double& n_z) const noexcept;
};

struct Tool {
  std::string name;
  std::string iso_code;  // ISO 6360 code, if the tool has one
  HeadShape shape = HeadShape::kSphere;
  double diameter = 1.2e-3;    // m, largest diameter
  double length = 1.2e-3;      // m, length along the axis; for a ball its diameter
  bool cuts = true;            // false for probes and gauges, which touch but never remove tissue
  double side_efficiency = 1;  // fraction of the normal force that cuts, for a contact on the flank
  // Fraction of the normal force that cuts, for a contact at the end; between flank and end, the fraction is
  // interpolated by the squared cosine
  double end_efficiency = 1;
  // Fraction of the push along the hand's path that cuts, for an edge that does not turn; 0: the tool has no such
  // edge
  double scrapes = 0;
  double sink_yield = 0;             // N, force at which the tip sinks into softened tissue; 0: never
  double cutting_coefficient = 0.3;  // μ_c: tangential cutting force / normal force (Preston, Archard)

  // Parts that never cut: the shank, from the head's upper end to the handpiece, which widens from its neck; and the
  // safe end, a round-ended pin beyond the free end.
  double shank_length = 0;         // m, length of the shank that has contact; 0: no contact
  double shank_diameter = 1.6e-3;  // m, diameter of the shank; default: friction grip, ISO 1797 type 3
  double neck_diameter = 0;        // m
  double neck_length = 0;          // m, length of the taper
  double safe_length = 0;          // m, length of the safe end; 0: no safe end
  double safe_diameter = 0;        // m

  Tissue fill = Tissue::kAir;  // tissue that the instrument adds at its free end while the pedal is pressed; kAir: none
  double fill_rate = 0;        // m³/s at full pedal
  double fill_reach = 0;       // m, largest distance from the free end to the tissue that receives the filling
  // The filling stays inside this solid: the cavity, or the former tooth; null: no limit
  std::shared_ptr<const Solid> fill_within;

  // Instrument that holds the tool in pictures: a file in assets/handpieces/, or "none". If empty, the rule in
  // engine/app/handpiece_file.h selects the instrument. Contact and cutting ignore it.
  std::string handpiece;

  std::shared_ptr<const ImplantTool> implant;  // properties of an instrument for implant surgery; null: another tool

  /// True for a tool that cuts by rotation of the spindle; other tools scrape or never cut.
  bool turns() const { return cuts && scrapes == 0; }
  /// True if the pedal can turn the tool backwards, because it has a thread.
  bool reverses() const { return implant && implant->threaded(); }
  /// Speed of the unloaded tool at full pedal, rad/s; `motor`: rad/s, speed of the motor there.
  double free_speed(double motor) const {
    if (!implant) return motor;
    return implant->by_hand ? 0 : implant->top_speed > 0 ? implant->top_speed : motor;
  }
  double radius() const { return diameter / 2; }
  /// Distance from the head's centre to its ends on the axis, m.
  double half() const { return shape == HeadShape::kSphere ? radius() : length / 2; }
  /// Distance from T's origin to the farthest point of the head, m.
  double reach() const;
  /// Signed distance from a point to the head's surface, m, negative inside; exact for every shape.
  double distance(const dvec3& p_TQ) const;
  /// Radius of the head at height z on its axis, m; 0 beyond the ends. For drawing and sampling.
  double profile(double z) const;
};

/// A part that never cuts, described as a tool of its own. `z`: m, position of the part's centre on the tool's axis.
struct NonCuttingPart {
  Tool shape;
  double z = 0;
};
/// Shank and safe end; nullopt if the tool has none.
std::optional<NonCuttingPart> shank_of(const Tool& tool);
std::optional<NonCuttingPart> safe_end_of(const Tool& tool);
/// Distance from T's origin to the farthest point of head and safe end, m: the range that the patch must contain.
double near_reach(const Tool& tool);

/// Sample points on the head, each with its part of the surface area; deterministic.
struct HeadSample {
  dvec3 p_TQ;   // m
  dvec3 n_T;    // unit normal, pointing out of the head
  double area;  // m²
};
/// Samples the head's surface nearly evenly. For heads other than a ball, the fraction `near_end` of the samples lies
/// near the free end, which touches first and often alone.
std::vector<HeadSample> sample_head(const Tool& tool, int count, double near_end = 0);

/// Reads a scene's inline object or a file of assets/tools/. Throws Error.
Tool read_tool(const Json& json);

}  // namespace typodont::haptics
