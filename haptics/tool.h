// The tool in the hand: a head that touches and cuts, described once and used by contact, cutting and drawing.
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

/// A head is a surface of revolution about the tool's z axis; the shank leaves along +z, the free end points along -z.
/// (A shaft is what shanks are made of; no scene names it.) The origin of T is the head's centre: of the sphere; half
/// way along the axis of every other shape. What a shape is stands in one table in tool.cpp.
enum class HeadShape { kSphere, kCylinder, kRoundEndCylinder, kCone, kPear, kFlame, kInvertedCone, kShaft };
/// Every shape that a scene may name.
std::vector<HeadShape> head_shapes();
/// As scenes call it, e.g. "round_end_cylinder"; a shaft counts as a cylinder.
std::string_view name_of(HeadShape shape) noexcept;

struct Tool;
class Solid;

/// The head's meridian, prepared for fast distances: a convex chain of lines and arcs in the half plane (ρ ≥ 0, z). The
/// distance to it there is the distance to the surface of revolution. Lengths in any one unit. Never allocates.
class HeadField {
 public:
  HeadField() = default;
  /// In units of `unit` metres, e.g. a voxel.
  HeadField(const Tool& tool, double unit);
  /// The head and all that it sweeps when it is drawn out along its axis: from where it is widest a cylinder goes on,
  /// for a metre.
  static HeadField with_way_out(const Tool& tool, double unit);

  /// Signed distance from a point in T, negative inside; exact for every shape.
  double distance(const dvec3& p_TQ) const noexcept;
  /// The same, with how far each piece is: what lies farther than that by 2 r is not the closest within r of the point.
  double distance(const dvec3& p_TQ, double (&to_piece)[4]) const noexcept;
  /// The same with the unit direction, in T, in which the distance grows.
  double distance(const dvec3& p_TQ, dvec3& n_T) const noexcept;

  // The chain, from the free end to the shank end. Single precision beside double: sweeps run on floats.
  static constexpr int kMaxPieces = 4;
  struct Piece {
    double ax = 0, az = 0, bx = 0, bz = 0;  // end points (ρ, z)
    double dx = 0, dz = 0, inverse2 = 0;    // b - a, 1/|b - a|²
    double cx = 0, cz = 0, radius = 0;      // of an arc; radius 0: a straight line
  };
  Piece pieces[kMaxPieces];
  int count = 0;

 private:
  double nearest(double rho, double z, double& n_rho, double& n_z) const noexcept;
};

struct Tool {
  std::string name;
  std::string iso_code;  // ISO 6360, where the tool has one
  HeadShape shape = HeadShape::kSphere;
  double diameter = 1.2e-3;    // m, the largest
  double length = 1.2e-3;      // m, along the axis; of a sphere its diameter
  bool cuts = true;            // false: probes and gauges touch, but never remove
  double side_efficiency = 1;  // share of the normal force that cuts when the contact is on the flank …
  double end_efficiency = 1;   // … and on the end; in between by the square of the cosine
  double scrapes = 0;          // share of the push that cuts along the way of the hand: an edge that does not turn
  double sink_yield = 0;       // N that softened tissue bears before this tip sinks into it; 0: it never does
  double cutting_coefficient = 0.3;  // μ_c: tangential cutting force / normal force (Preston, Archard)

  // What of it never cuts: a shank, from the head's upper end to where the handpiece begins, widening from its neck;
  // and a round-ended pin beyond the free end.
  double shank_length = 0;         // m; 0: none is felt
  double shank_diameter = 1.6e-3;  // m; friction grip, ISO 1797 type 3
  double neck_diameter = 0;        // m
  double neck_length = 0;          // m, of the taper
  double safe_length = 0;          // m; 0: none
  double safe_diameter = 0;        // m

  Tissue fill = Tissue::kAir;  // what this instrument puts down at its free end while the pedal is pressed …
  double fill_rate = 0;        // … in m³/s at full pedal …
  double fill_reach = 0;       // … on tissue no farther than this from that end, m …
  std::shared_ptr<const Solid> fill_within;  // … and inside this, where it is given: the cavity, or the tooth as it was

  std::shared_ptr<const ImplantTool> implant;  // of an instrument for implant surgery; null: of another tool

  /// Cuts while the spindle turns; other tools never do, or as the hand draws them.
  bool turns() const { return cuts && scrapes == 0; }
  /// The pedal may turn it backwards: it has a thread.
  bool reverses() const { return implant && implant->threaded(); }
  /// rad/s at full pedal, with a motor that reaches `motor` there.
  double free_speed(double motor) const {
    if (!implant) return motor;
    return implant->by_hand ? 0 : implant->top_speed > 0 ? implant->top_speed : motor;
  }
  double radius() const { return diameter / 2; }
  /// Height of the head's ends on its axis, m.
  double half() const { return shape == HeadShape::kSphere ? radius() : length / 2; }
  /// Distance from T's origin to the farthest point of the head, m.
  double reach() const;
  /// Signed distance from a point to the head's surface, m, negative inside; exact for every shape.
  double distance(const dvec3& p_TQ) const;
  /// Radius of the head at height z on its axis, m; 0 outside its length. For drawing and sampling.
  double profile(double z) const;
};

/// A part that never cuts as a head of its own, with its middle at `z` on the tool's axis, m.
struct SmoothPart {
  Tool shape;
  double z = 0;
};
/// nullopt where the tool has none.
std::optional<SmoothPart> shank_of(const Tool& tool);
std::optional<SmoothPart> safe_end_of(const Tool& tool);
/// Distance from T's origin to the farthest point of head and safe end, m: what lies in the patch with the head.
double near_reach(const Tool& tool);

/// Sample points on the head with the area that each stands for, deterministic.
struct HeadSample {
  dvec3 p_TQ;   // m
  dvec3 n_T;    // unit, out of the head
  double area;  // m²
};
/// Nearly even, but for a share of them that lies near the free end of heads other than a ball: it touches first, and
/// often alone.
std::vector<HeadSample> sample_head(const Tool& tool, int count, double near_end = 0);

/// From a scene's inline object or a file of assets/tools/. Throws Error.
Tool read_tool(const Json& json);

}  // namespace typodont::haptics
