// Measures of an exercise in implant surgery: plain data, for score and report.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "engine/session/strings.h"

namespace typodont::session {

/// Notes that are shown to the trainee immediately during the exercise.
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

/// Bone temperature at the drill. The model is a mass of bone around the bed: a fraction of the cutting power heats
/// this mass, and the mass cools towards body temperature. The parameters are estimates, except the threshold:
/// Eriksson & Albrektsson, J Prosthet Dent 1983;50:101-107, found bone damage from 47 °C for one minute.
struct HeatModel {
  // fraction of the cutting power that heats the bone; the chips remove the rest of the heat
  static constexpr double fraction = 0.3;
  static constexpr double shell = 1e-3;             // m, thickness of the heated bone around the bed
  static constexpr double heat_capacity = 2.5e6;    // J/(m³ K): 1.9 g/cm³ at 1.3 J/(g K)
  static constexpr double cooled_time = 8;          // s, time constant with irrigation
  static constexpr double dry_time = 30;            // s, time constant without irrigation
  static constexpr double body = 37, harmful = 47;  // °C
};

/// A force curve: mean forces over intervals of equal length, counted in time of contact during a phase.
struct ForceCurve {
  std::vector<float> across, along;  // N, perpendicular to the plan's axis and along it
  double span = 0;                   // s, length of an interval
};

struct ImplantPhaseMeasures {
  std::array<std::string, kLanguageCount> name;
  bool done = false, skipped = false;
  double began = -1, ended = -1;                  // s, times of the first contact and of the end; negative: not yet
  double force_max = 0;                           // N
  double over_force = 0;                          // s, time for which the force was above its limit
  double depth = 0;                               // m, largest depth below the plan's entry
  double hottest = HeatModel::body;               // °C, highest temperature
  std::array<double, kImplantNoteCount> noted{};  // s, display time of each note
  ForceCurve force;
};

/// The bed as drilled. SI units.
struct ImplantBedMeasures {
  bool found = false;
  double entry_error = 0, apex_error = 0;  // m, distances from the planned points
  double axis_error = 0;                   // rad, angle to the planned axis
  double depth = 0;                        // m, depth below the plan's entry
  double canal_distance = 1e9;             // m, distance from the bed's wall or bottom to the canal's wall
  double neighbour_distance = 1e9;         // m, distance from the bed's wall to the nearest root
  // The next measures are computed from the tissue, see measure_bed(); negative if unknown.
  double diameter = -1, ovality = -1;  // m
  double perforated = -1;              // fraction of the wall's upper nine tenths that has no bone behind it
};

struct ImplantMeasures {
  std::vector<ImplantPhaseMeasures> phases;
  ImplantBedMeasures bed;
  bool placed = false;
  double insertion_torque = 0;       // N·m, largest torque while the implant was inserted
  double bone_contact = -1;          // fraction of the implant's surface in contact with bone; negative if unknown
  double over_force = 0;             // s, time for which the force was above its limit
  double hottest = HeatModel::body;  // °C, highest temperature
  double phases_done() const;        // completed fraction of the phases
};

}  // namespace typodont::session
