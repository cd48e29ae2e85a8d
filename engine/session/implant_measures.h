// Measures of implant surgery, for score and report.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "engine/session/strings.h"

namespace typodont::session {

/// Warnings to the trainee, shown as soon as they apply.
enum class ImplantNote {
  kNone,
  kWrongTool,
  kOverSpeed,
  kTooDeep,
  kOffAxis,
  kNearCanal,
  kHeat,
  kOverForce,
};
inline constexpr std::size_t kImplantNoteCount = 8;
std::string_view name_of(ImplantNote note) noexcept;

/// Temperature of the bone near the drilled hole, modelled as one mass: a fraction of the cutting power heats it, and
/// the body cools it. All parameters are estimates except `harmful`: bone is damaged after a minute at 47 °C (Eriksson
/// & Albrektsson, J Prosthet Dent 1983;50:101-107).
struct HeatModel {
  // Fraction of cutting power into the bone; chips take the rest.
  static constexpr double fraction = 0.3;
  static constexpr double shell = 1e-3;             // m, thickness of heated bone around the drilled hole
  static constexpr double heat_capacity = 2.5e6;    // J/(m³ K), from 1.9 g/cm³ and 1.3 J/(g K)
  static constexpr double cooled_time = 8;          // s, time constant of cooling with irrigation
  static constexpr double dry_time = 30;            // s, time constant of cooling without irrigation
  static constexpr double body = 37, harmful = 47;  // °C, body temperature and temperature that damages bone
};

/// Mean forces for equal intervals of contact time.
struct ForceCurve {
  std::vector<float> across, along;  // N, mean force in each interval: perpendicular to the axis; along it
  double span = 0;                   // s, length of an interval of contact time
};

struct ImplantPhaseMeasures {
  std::array<std::string, kLanguageCount> name;
  bool done = false, skipped = false;
  // Time of first contact and of phase end, s; negative: not yet.
  double began = -1, ended = -1;
  double force_max = 0;                           // N, largest force in the phase
  double over_force = 0;                          // s, time with a force above the limit
  double depth = 0;                               // m, largest depth below the planned entry point
  double hottest = HeatModel::body;               // °C, highest temperature of the bone
  std::array<double, kImplantNoteCount> noted{};  // s, time for which each warning was shown
  ForceCurve force;
};

/// Measures of the drilled hole (bed). SI units.
struct ImplantBedMeasures {
  bool found = false;
  double entry_error = 0, apex_error = 0;  // m, distance of entry and apex from the plan
  double axis_error = 0;                   // rad, angle of the drilled hole's axis to the planned axis
  double depth = 0;                        // m, depth of the drilled hole below the planned entry
  double canal_distance = 1e9;             // m, distance from the drilled hole's wall to the canal's wall
  double neighbour_distance = 1e9;         // m, distance from the drilled hole's wall to the nearest root
  // From the tissue (measure_bed()): mean diameter, and largest minus smallest diameter, m. Negative: unknown.
  double diameter = -1, ovality = -1;
  double perforated = -1;  // fraction of the wall below 1.5 mm depth without bone behind it; negative: unknown
};

struct ImplantMeasures {
  std::vector<ImplantPhaseMeasures> phases;
  ImplantBedMeasures bed;
  bool placed = false;
  double insertion_torque = 0;       // N·m, largest torque during insertion
  double bone_contact = -1;          // fraction of the implant's surface that touches bone; negative: unknown
  double over_force = 0;             // s, time with a force above the limit
  double hottest = HeatModel::body;  // °C, highest temperature of the bone
  double phases_done() const;        // fraction of the phases that are done, 0 to 1
};

}  // namespace typodont::session
