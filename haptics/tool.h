// One description for contact, cutting and drawing.
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

/// Revolution about z; shank at +z, free end at -z. T's origin is a ball's centre, otherwise the axis's middle. (kShaft
/// is for shanks only.) Table in tool.cpp.
enum class HeadShape { kSphere, kCylinder, kRoundEndCylinder, kCone, kPear, kFlame, kInvertedCone, kShaft };
/// Returns all shapes that a scene can use.
std::vector<HeadShape> head_shapes();
/// In scenes, for example "round_end_cylinder"; a shaft is a cylinder.
std::string_view name_of(HeadShape shape) noexcept;

struct Tool;
class Solid;

/// For fast queries: convex chain of lines and arcs in (ρ ≥ 0, z), whose distance is the surface's. Any unit of length.
/// Never allocates.
class HeadField {
 public:
  HeadField() = default;
  /// `unit`: m per unit of the results, for example a voxel.
  HeadField(const Tool& tool, double unit);
  /// With the way out: a cylinder of the widest radius from there, 1 m towards the shank.
  static HeadField with_exit_path(const Tool& tool, double unit);

  /// Point in T; negative inside; exact.
  double distance(const dvec3& p_TQ) const noexcept;
  /// With the distance to each piece: one that exceeds the smallest by more than 2 r is nowhere closest within r.
  double distance(const dvec3& p_TQ, double (&to_piece)[4]) const noexcept;
  /// With the unit direction of increase, T.
  double distance(const dvec3& p_TQ, dvec3& n_T) const noexcept;

  // Free to shank end, double precision. (Sweep uses floats.)
  static constexpr int kMaxPieces = 4;
  struct Piece {
    double ax = 0, az = 0, bx = 0, bz = 0;  // ends, (ρ, z)
    double dx = 0, dz = 0, inverse2 = 0;    // vector b - a, and 1/|b - a|²
    double cx = 0, cz = 0, radius = 0;      // of an arc; radius 0: a line
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
  double length = 1.2e-3;    // m along the axis; ball: diameter
  bool cuts = true;          // probes and gauges touch but never remove
  // of the normal force that cuts, at the side
  double side_efficiency = 1;
  // The same at the end; in between by the squared cosine with the axis.
  double end_efficiency = 1;
  // Of the hand's push, for an edge drawn along the path; 0: none.
  double scrapes = 0;
  double sink_yield = 0;  // N, at which the tip sinks into softened tissue; 0: never
  // μ_c: tangential cutting / normal force (Preston, Archard), where the tissue's EdgeLaw states none
  double cutting_coefficient = 0.3;
  // Edges: a drill's blades cut by Material::blade, a diamond's grains by Material::grit. 0: not stated.
  int blades = 0;
  double grit = 0;  // m, mean size of the grains

  // Never cut: the shank from the head's upper end to the handpiece, widening from its neck; the safe end, a round pin
  // beyond the free end.
  double shank_length = 0;         // m that can touch; 0: none
  double shank_diameter = 1.6e-3;  // m; default: friction grip, ISO 1797 type 3
  double neck_diameter = 0;        // m, diameter of the neck
  double neck_length = 0;          // m, from neck to full diameter
  double safe_length = 0;          // m; 0: none
  double safe_diameter = 0;        // m, diameter of the safe end

  // added at the free end under the pedal; kAir: nothing
  Tissue fill = Tissue::kAir;
  double fill_rate = 0;   // m³/s, rate of filling at full pedal
  double fill_reach = 0;  // m from the free end
  // Limits filling: the cavity, or the tooth before; null: none.
  std::shared_ptr<const Solid> fill_within;

  // Drawn with the tool: a file of assets/handpieces/, or "none"; empty: by engine/app/scene/handpiece_file.h.
  std::string handpiece;

  // for implant surgery; null: not
  std::shared_ptr<const ImplantTool> implant;

  bool edges_known() const { return blades > 0 || grit > 0; }
  /// A diamond that removes the bulk, ISO 6360 code 534 or coarser.
  bool coarse() const { return grit >= 140e-6; }
  /// By rotation; others scrape or never cut.
  bool turns() const { return cuts && scrapes == 0; }
  /// It has a thread.
  bool reverses() const { return implant && implant->threaded(); }
  /// rad/s unloaded at full pedal. `motor`: rad/s of the motor.
  double free_speed(double motor) const {
    if (!implant) return motor;
    return implant->by_hand ? 0 : implant->top_speed > 0 ? implant->top_speed : motor;
  }
  double radius() const { return diameter / 2; }
  /// m, centre to ends along the axis.
  double half() const { return shape == HeadShape::kSphere ? radius() : length / 2; }
  /// m, T's origin to the head's farthest point.
  double reach() const;
  /// m, negative inside; exact.
  double distance(const dvec3& p_TQ) const;
  /// m at height z; 0 beyond the ends. For drawing and sampling.
  double profile(double z) const;
};

/// A part that never cuts. `z`: m, of its centre on the axis.
struct NonCuttingPart {
  Tool shape;
  double z = 0;
};
/// nullopt: none.
std::optional<NonCuttingPart> shank_of(const Tool& tool);
std::optional<NonCuttingPart> safe_end_of(const Tool& tool);
/// m, T's origin to the farthest point of head and safe end; a patch must contain it.
double near_reach(const Tool& tool);

/// With its area; deterministic.
struct HeadSample {
  dvec3 p_TQ;   // m, position of the sample
  dvec3 n_T;    // unit normal, pointing out of the head
  double area;  // m², area that the sample represents
};
/// Almost even; off a ball, `near_end` of them near the free end, which touches first.
std::vector<HeadSample> sample_head(const Tool& tool, int count, double near_end = 0);

/// Inline object, or file of assets/tools/. Throws Error.
Tool read_tool(const Json& json);

}  // namespace typodont::haptics
