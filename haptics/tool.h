// The tool in the hand. The same description of its head is used for contact, cutting and drawing.
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

/// Shape of a head. A head is a surface of revolution about the tool's z axis. The shank is on the side of +z, the free
/// end on the side of -z. The origin of the tool's frame T is the head's centre: the centre of a ball; for other
/// shapes, the middle of the axis. (kShaft is the shape of shanks; scenes cannot use it.) A table in tool.cpp describes
/// every shape.
enum class HeadShape { kSphere, kCylinder, kRoundEndCylinder, kCone, kPear, kFlame, kInvertedCone, kShaft };
/// Returns all shapes that a scene can use.
std::vector<HeadShape> head_shapes();
/// Returns the shape's name in scenes, for example "round_end_cylinder"; a shaft has the name of a cylinder.
std::string_view name_of(HeadShape shape) noexcept;

struct Tool;
class Solid;

/// The meridian of a head, prepared for fast distance queries. It is a convex chain of lines and arcs in the half plane
/// (ρ ≥ 0, z). The distance to it in this plane equals the distance to the surface of revolution. All lengths have the
/// same, arbitrary unit. Never allocates.
class HeadField {
 public:
  HeadField() = default;
  /// `unit`: length in m of the unit in which the results are given, for example the voxel size.
  HeadField(const Tool& tool, double unit);
  /// Returns the head together with its exit path along the axis: from the widest place of the head, a cylinder of the
  /// same radius continues for 1 m towards the shank.
  static HeadField with_exit_path(const Tool& tool, double unit);

  /// Returns the signed distance from a point in frame T of the tool to the surface, negative inside; exact for every
  /// shape.
  double distance(const dvec3& p_TQ) const noexcept;
  /// Returns the signed distance from a point in frame T of the tool to the surface. `to_piece` receives the distance
  /// from the point to each piece of the meridian. With these distances, far pieces can be excluded: if the distance to
  /// a piece exceeds the smallest one by more than 2 r, this piece is not the closest one for any point within the
  /// distance r.
  double distance(const dvec3& p_TQ, double (&to_piece)[4]) const noexcept;
  /// Returns the signed distance from a point in frame T of the tool to the surface. `n_T` receives the unit direction
  /// in frame T in which the distance increases.
  double distance(const dvec3& p_TQ, dvec3& n_T) const noexcept;

  // Pieces of the meridian from the free end to the shank end, in double precision. (The class Sweep uses floats.)
  static constexpr int kMaxPieces = 4;
  struct Piece {
    double ax = 0, az = 0, bx = 0, bz = 0;  // end points a and b of the piece, (ρ, z)
    double dx = 0, dz = 0, inverse2 = 0;    // vector b - a, and 1/|b - a|²
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
  double diameter = 1.2e-3;  // m, largest diameter of the head
  double length = 1.2e-3;    // m, length of the head along the axis; for a ball its diameter
  bool cuts = true;          // false for probes and gauges, which touch tissue but never remove it
  // fraction of the normal force that contributes to cutting, if the side of the head has contact
  double side_efficiency = 1;
  // Fraction of the normal force that contributes to cutting, for a contact at the end of the head. Between side and
  // end, the fraction is interpolated by the squared cosine of the angle to the axis.
  double end_efficiency = 1;
  // Fraction of the hand's push that contributes to cutting, for a cutting edge that does not rotate but is drawn along
  // the hand's path; 0: the tool has no such edge.
  double scrapes = 0;
  double sink_yield = 0;  // N, force at which the tip sinks into softened tissue; 0: it never sinks
  // coefficient μ_c: ratio of the tangential cutting force to the normal force (Preston, Archard)
  double cutting_coefficient = 0.3;
  // Ratio of the specific cutting energy with this tool to the specific energy of the material. A coarse diamond breaks
  // larger chips, which need less energy per volume.
  double energy_ratio = 1;

  // The following members describe the parts of the tool that never cut. The shank extends from the upper end of the
  // head to the handpiece and widens from its neck. The safe end is a round-ended pin beyond the free end.
  double shank_length = 0;         // m, length of the part of the shank that can have contact; 0: none
  double shank_diameter = 1.6e-3;  // m, diameter of the shank; default: friction grip, ISO 1797 type 3
  double neck_diameter = 0;        // m, diameter of the neck
  double neck_length = 0;          // m, length of the taper from the neck to the shank's full diameter
  double safe_length = 0;          // m, length of the safe end; 0: no safe end
  double safe_diameter = 0;        // m, diameter of the safe end

  // tissue that a filling instrument adds at its free end while the pedal is pressed; kAir: the tool adds nothing
  Tissue fill = Tissue::kAir;
  double fill_rate = 0;   // m³/s, rate of filling at full pedal
  double fill_reach = 0;  // m, largest distance from the free end at which tissue receives filling
  // Solid to which the filling is limited: the cavity, or the tooth before the preparation; null: no limit.
  std::shared_ptr<const Solid> fill_within;

  // Handpiece that the renderer shows with the tool: a file in assets/handpieces/, or "none". Empty: the rule in
  // engine/app/handpiece_file.h selects the handpiece. Contact and cutting do not use it.
  std::string handpiece;

  // properties of an instrument for implant surgery; null: the tool is not such an instrument
  std::shared_ptr<const ImplantTool> implant;

  /// Returns true if the tool cuts by rotation of the spindle. Other tools scrape, or never cut.
  bool turns() const { return cuts && scrapes == 0; }
  /// Returns true if the pedal can rotate the tool backward, because it has a thread.
  bool reverses() const { return implant && implant->threaded(); }
  /// Returns the speed of the unloaded tool at full pedal, rad/s. `motor`: speed of the motor at full pedal, rad/s.
  double free_speed(double motor) const {
    if (!implant) return motor;
    return implant->by_hand ? 0 : implant->top_speed > 0 ? implant->top_speed : motor;
  }
  double radius() const { return diameter / 2; }
  /// Returns the distance from the head's centre to its ends along the axis, m.
  double half() const { return shape == HeadShape::kSphere ? radius() : length / 2; }
  /// Returns the distance from the origin of the tool's frame T to the farthest point of the head, m.
  double reach() const;
  /// Returns the signed distance from a point to the head's surface, m, negative inside; exact for every shape.
  double distance(const dvec3& p_TQ) const;
  /// Returns the radius of the head at the height z on its axis, m; 0 beyond the ends. For drawing and sampling.
  double profile(double z) const;
};

/// A part of a tool that never cuts. Its shape is described by a Tool. `z`: position of the part's centre on the tool's
/// axis, m.
struct NonCuttingPart {
  Tool shape;
  double z = 0;
};
/// Returns the shank or the safe end; nullopt if the tool has none.
std::optional<NonCuttingPart> shank_of(const Tool& tool);
std::optional<NonCuttingPart> safe_end_of(const Tool& tool);
/// Returns the distance from the origin of the tool's frame T to the farthest point of the head and the safe end, m. A
/// patch (copy of the tissue around the tool) must contain this range.
double near_reach(const Tool& tool);

/// A sample point on the head's surface, with the surface area that it represents; deterministic.
struct HeadSample {
  dvec3 p_TQ;   // m, position of the sample
  dvec3 n_T;    // unit normal, pointing out of the head
  double area;  // m², area that the sample represents
};
/// Samples the head's surface almost evenly. For a head that is not a ball, the fraction `near_end` of the samples lies
/// near the free end, because the free end touches first and is often the only contact.
std::vector<HeadSample> sample_head(const Tool& tool, int count, double near_end = 0);

/// Reads a tool from a scene's inline object or from a file of assets/tools/. Throws Error.
Tool read_tool(const Json& json);

}  // namespace typodont::haptics
