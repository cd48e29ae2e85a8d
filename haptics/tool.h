// Description of a tool, used for contact, cutting and drawing; instruments of implant surgery have an ImplantTool.
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

namespace typodont::haptics {

/// Solid of revolution about z, with the shank at +z and the free end at -z. The origin of T is the centre of a ball,
/// or the middle of another head's axis. kShaft is for shanks only.
enum class HeadShape { kSphere, kCylinder, kRoundEndCylinder, kCone, kPear, kFlame, kInvertedCone, kShaft };
/// Returns the name in scenes, for example "round_end_cylinder"; that of a shaft is "cylinder".
std::string_view name_of(HeadShape shape) noexcept;

struct Tool;
class Solid;

/// Purpose of an instrument in an implant set.
enum class ImplantToolKind {
  kRound,    // round bur: cuts on all sides, moves in any direction
  kDrill,    // drill: makes an implant bed (the drilled hole), or widens or deepens it along its axis
  kGauge,    // gauge: measures the depth of an implant bed (the drilled hole), never cuts
  kTap,      // thread tap: cuts a thread; advances by rotation
  kImplant,  // implant: has a thread; remains in the bone
  kScrew,    // screw: closes an implant and stays in it
};
std::string_view name_of(ImplantToolKind kind) noexcept;

/// Value of the key "implant" in a tool's file, in SI units. Zhao 2020, "Modeling of the tools".
struct ImplantTool {
  ImplantToolKind kind = ImplantToolKind::kGauge;
  // Cutting ability, 0 to 1, of the voxels that represent the tool. It depends on their position.
  double end_ability = 0;     // cutting ability on the end face outside `centre_radius`
  double centre_ability = 0;  // cutting ability on the end face, within `centre_radius` of the axis
  double side_ability = 0;    // cutting ability on the side of the tool
  double centre_radius = 0;   // m, radius within which the end face's cutting ability is centre_ability
  double max_grey = 0;        // Hounsfield units; denser bone stops the tool
  // Alpha of eq. (2), Zhao 2020: ratio of tangential to normal force at the edge.
  double thrust_ratio = 1;
  double pitch = 0;          // m, advance of the thread per turn; 0: no thread
  double core_diameter = 0;  // m, core diameter of the thread; 0: no thread
  double bore_diameter = 0;  // m, diameter of the implant's inner thread for a screw; 0: none
  double bore_depth = 0;     // m, depth of the inner thread
  double speed = 0;          // rad/s, speed that the manufacturer states; 0: the tool does not rotate
  // Speed at full pedal with a reduction gear, rad/s; 0: speed of the motor.
  double top_speed = 0;
  bool by_hand = false;    // turned by hand (ratchet)
  bool irrigated = false;  // true: the tool needs cooling water
  double max_torque = 0;   // N·m, the manufacturer's limit; 0: not stated
  // Heights of the rings (depth marks) above the free end, m, ascending.
  std::vector<double> marks;

  bool threaded() const { return pitch > 0; }
  /// Returns true for implants and screws, which remain in the patient.
  bool stays() const { return kind == ImplantToolKind::kImplant || kind == ImplantToolKind::kScrew; }
};

/// Reads the key "implant". `diameter`, `length`: size of the head, m. Throws Error.
ImplantTool read_implant_tool(const Json& json, double diameter, double length);

/// Distance field of a head for fast queries: its meridian is a convex chain of lines and arcs in (ρ ≥ 0, z). Works in
/// any unit of length. Never allocates.
class HeadField {
 public:
  HeadField() = default;
  /// `unit`: m per unit of the results, for example the size of a voxel.
  HeadField(const Tool& tool, double unit);
  /// Field of the head and its exit path: a cylinder with the head's largest radius, from the widest point 1 m towards
  /// the shank.
  static HeadField with_exit_path(const Tool& tool, double unit);

  /// Exact signed distance of a point in frame T from the head; negative inside.
  double distance(const dvec3& p_TQ) const noexcept;
  /// Also returns the distance to each piece of the meridian. If the distance of a piece exceeds the smallest distance
  /// by more than 2 r, this piece is never the closest one within radius r of the point.
  double distance(const dvec3& p_TQ, double (&to_piece)[4]) const noexcept;
  /// Also returns the unit direction in which the distance increases, frame T.
  double distance(const dvec3& p_TQ, dvec3& n_T) const noexcept;

  // Meridian from the free end to the shank end, in double precision. (Sweep uses floats.)
  static constexpr int kMaxPieces = 4;
  struct Piece {
    double ax = 0, az = 0, bx = 0, bz = 0;  // end points (ρ, z)
    double dx = 0, dz = 0, inverse2 = 0;    // vector from end a to end b; 1 / its squared length
    double cx = 0, cz = 0, radius = 0;      // centre and radius of an arc; radius 0: a line
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
  double length = 1.2e-3;    // m, length of the head along the axis; for a ball, its diameter
  bool cuts = true;          // false: probe or gauge, which touches but never cuts
  // Fraction of the normal force that cuts, at the side of the head.
  double side_efficiency = 1;
  // Fraction of the normal force that cuts, at the end of the head. Between side and end, interpolated by the squared
  // cosine of the angle to the axis.
  double end_efficiency = 1;
  // Fraction of the hand's push that scrapes, for an edge that is drawn along the path; 0: does not scrape.
  double scrapes = 0;
  double sink_yield = 0;  // N, force at which the tip sinks into softened tissue; 0: never sinks
  // μ_c: ratio of tangential to normal force (Preston, Archard), used where the tissue's EdgeLaw states none.
  double cutting_coefficient = 0.3;
  // Number of blades; 0: not stated. Blades cut by Material::blade, the grains of a diamond bur by Material::grit.
  int blades = 0;
  double grit = 0;  // m, mean size of the grains

  // Parts that never cut: the shank from the head to the handpiece, which widens from its neck; the safe end, a round
  // pin beyond the free end.
  double shank_length = 0;         // m, length that can touch tissue; 0: no shank
  double shank_diameter = 1.6e-3;  // m, full diameter; default: friction grip shank, ISO 1797 type 3
  double neck_diameter = 0;        // m, diameter of the neck
  double neck_length = 0;          // m, length from the neck to the full diameter
  double safe_length = 0;          // m, length of the safe end, a pin that never cuts; 0: no pin
  double safe_diameter = 0;        // m, diameter of the safe end

  // Tissue that is added at the free end while the pedal is pressed; kAir: none.
  Tissue fill = Tissue::kAir;
  double fill_rate = 0;   // m³/s, rate of filling at full pedal
  double fill_reach = 0;  // m, largest distance of the filling from the free end
  // Solid that limits the filling: the cavity, or the original tooth; null: no limit.
  std::shared_ptr<const Solid> fill_within;

  // Handpiece drawn with the tool: a file of assets/handpieces/, or "none"; empty: chosen by
  // engine/app/scene/handpiece_file.h.
  std::string handpiece;

  // Properties of an instrument for implant surgery; null: other tool.
  std::shared_ptr<const ImplantTool> implant;

  bool edges_known() const { return blades > 0 || grit > 0; }
  /// Returns true for a coarse diamond bur, which removes much tissue quickly (ISO 6360 code 534 or coarser).
  bool coarse() const { return grit >= 140e-6; }
  /// Returns true if the tool cuts by rotation; other tools scrape or never cut.
  bool turns() const { return cuts && scrapes == 0; }
  /// Returns true if the tool can rotate backward, because it has a thread.
  bool reverses() const { return implant && implant->threaded(); }
  /// Speed without load at full pedal, rad/s. `motor`: free speed of the motor, rad/s.
  double free_speed(double motor) const {
    if (!implant) return motor;
    return implant->by_hand ? 0 : implant->top_speed > 0 ? implant->top_speed : motor;
  }
  double radius() const { return diameter / 2; }
  /// Surface of the head, m².
  double area() const;
  /// Volume of the grains of a new diamond bur, m³: one layer on the head.
  double grain_volume() const { return grit * area(); }
  /// Distance from the head's centre to its ends along the axis, m.
  double half() const { return shape == HeadShape::kSphere ? radius() : length / 2; }
  /// Distance from the origin of T to the head's farthest point, m.
  double reach() const;
  /// Signed distance to the head's surface, m; negative inside; exact.
  double distance(const dvec3& p_TQ) const;
  /// Radius of the head at height z, m; 0 beyond the ends. For drawing and sampling.
  double profile(double z) const;
};

/// A part of the tool that never cuts. `z`: height of its centre on the axis, m.
struct NonCuttingPart {
  Tool shape;
  double z = 0;
};
/// shank_of() and safe_end_of() return nullopt if the tool has no such part.
std::optional<NonCuttingPart> shank_of(const Tool& tool);
std::optional<NonCuttingPart> safe_end_of(const Tool& tool);
/// Distance from the origin of T to the farthest point of head and safe end, m. A tissue patch reaches at least so far.
double near_reach(const Tool& tool);

/// A point on the head's surface.
struct HeadSample {
  dvec3 p_TQ;   // m, position of the sample
  dvec3 n_T;    // unit normal, pointing out of the head
  double area;  // m², area that the sample represents
};
/// Distributes points over the head almost evenly; deterministic. If the head is not a ball, the fraction `near_end` of
/// them is near the free end, which touches first.
std::vector<HeadSample> sample_head(const Tool& tool, int count, double near_end = 0);

/// Reads a tool from an inline object or a file of assets/tools/. Throws Error.
Tool read_tool(const Json& json);

}  // namespace typodont::haptics
