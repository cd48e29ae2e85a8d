// Measures of an exercise in implant surgery, for the score and the report.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "engine/session/strings.h"

namespace typodont::session {

/// Notes that the trainee sees during the exercise as soon as their reason occurs.
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

/// Model of the temperature of the bone at the drill. The bone near the bed (drilled hole) is one mass with one
/// temperature. A fraction of the cutting power heats this mass, and it cools towards body temperature. The parameters
/// are estimates, except the temperature `harmful`: Eriksson & Albrektsson, J Prosthet Dent 1983;50:101-107, found bone
/// damage at 47 °C for one minute.
struct HeatModel {
  // Fraction of the cutting power that heats the bone. The chips remove the rest of the heat.
  static constexpr double fraction = 0.3;
  static constexpr double shell = 1e-3;             // m, thickness of the heated bone around the bed (drilled hole)
  static constexpr double heat_capacity = 2.5e6;    // J/(m³ K), from a density of 1.9 g/cm³ and 1.3 J/(g K)
  static constexpr double cooled_time = 8;          // s, time constant of cooling with irrigation
  static constexpr double dry_time = 30;            // s, time constant of cooling without irrigation
  static constexpr double body = 37, harmful = 47;  // °C, body temperature and temperature that damages bone
};

/// A force curve: the mean force in each interval of contact time in a phase. All intervals have the same length, and
/// the time without contact is not counted.
struct ForceCurve {
  std::vector<float> across, along;  // N, mean force perpendicular to the planned axis and along it, for each interval
  double span = 0;                   // s, length of an interval of contact time
};

struct ImplantPhaseMeasures {
  std::array<std::string, kLanguageCount> name;
  bool done = false, skipped = false;
  // s, times of the first contact and of the phase's end; negative if this has not yet happened
  double began = -1, ended = -1;
  double force_max = 0;                           // N, largest force in the phase
  double over_force = 0;                          // s, time for which the force was above its limit
  double depth = 0;                               // m, largest depth below the planned entry point
  double hottest = HeatModel::body;               // °C, highest temperature of the bone
  std::array<double, kImplantNoteCount> noted{};  // s, time for which each note was shown
  ForceCurve force;
};

/// Measures of the bed (drilled hole), in SI units.
struct ImplantBedMeasures {
  bool found = false;
  double entry_error = 0, apex_error = 0;  // m, distances of entry and apex (deepest point) from the planned points
  double axis_error = 0;                   // rad, angle between the axis of the bed (drilled hole) and the planned axis
  double depth = 0;                        // m, depth of the bed (drilled hole) below the planned entry point
  double canal_distance = 1e9;             // m, distance from the drilled hole's wall to the wall of the nerve canal
  double neighbour_distance = 1e9;         // m, distance from the drilled hole's wall to the nearest neighbouring root
  // `diameter`, `ovality` and `perforated` are computed from the tissue (measure_bed()). Negative: unknown. `diameter`:
  // m, mean diameter of the bed (drilled hole); `ovality`: m, largest diameter minus smallest diameter
  double diameter = -1, ovality = -1;
  double perforated = -1;  // fraction of the upper nine tenths of the drilled hole's wall that has no bone behind it
};

struct ImplantMeasures {
  std::vector<ImplantPhaseMeasures> phases;
  ImplantBedMeasures bed;
  bool placed = false;
  double insertion_torque = 0;       // N·m, largest torque during the insertion of the implant
  double bone_contact = -1;          // fraction of the implant's surface that touches bone; negative if unknown
  double over_force = 0;             // s, time for which the force was above its limit
  double hottest = HeatModel::body;  // °C, highest temperature of the bone
  double phases_done() const;        // returns the fraction of the phases that are complete, 0..1
};

}  // namespace typodont::session
