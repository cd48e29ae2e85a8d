// Implant surgery's measures, for score and report.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "engine/session/strings.h"

namespace typodont::session {

/// Shown as soon as their reason occurs.
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

/// Bone near the bed as one mass, heated by a fraction of the cutting power, cooling towards the body. Parameters are
/// estimates, except `harmful`: damage at 47 °C for a minute (Eriksson & Albrektsson, J Prosthet Dent 1983;50:101-107).
struct HeatModel {
  // Of the cutting power; chips take the rest.
  static constexpr double fraction = 0.3;
  static constexpr double shell = 1e-3;             // m, of heated bone around the bed
  static constexpr double heat_capacity = 2.5e6;    // J/(m³ K), from 1.9 g/cm³ and 1.3 J/(g K)
  static constexpr double cooled_time = 8;          // s, time constant of cooling with irrigation
  static constexpr double dry_time = 30;            // s, time constant of cooling without irrigation
  static constexpr double body = 37, harmful = 47;  // °C, body temperature and temperature that damages bone
};

/// Mean force per equal interval of contact time.
struct ForceCurve {
  std::vector<float> across, along;  // N, per interval
  double span = 0;                   // s, length of an interval of contact time
};

struct ImplantPhaseMeasures {
  std::array<std::string, kLanguageCount> name;
  bool done = false, skipped = false;
  // s, first contact and end; negative: not yet
  double began = -1, ended = -1;
  double force_max = 0;                           // N, largest force in the phase
  double over_force = 0;                          // s above the force's limit
  double depth = 0;                               // m, largest depth below the planned entry point
  double hottest = HeatModel::body;               // °C, highest temperature of the bone
  std::array<double, kImplantNoteCount> noted{};  // s, time for which each note was shown
  ForceCurve force;
};

/// SI.
struct ImplantBedMeasures {
  bool found = false;
  double entry_error = 0, apex_error = 0;  // m, entry and apex from the plan
  double axis_error = 0;                   // rad from the planned axis
  double depth = 0;                        // m below the planned entry
  double canal_distance = 1e9;             // m, wall to wall
  double neighbour_distance = 1e9;         // m, wall to nearest root
  // from the tissue (measure_bed()), negative: unknown; m: mean, and largest minus smallest
  double diameter = -1, ovality = -1;
  double perforated = -1;  // of the wall's upper nine tenths, without bone behind
};

struct ImplantMeasures {
  std::vector<ImplantPhaseMeasures> phases;
  ImplantBedMeasures bed;
  bool placed = false;
  double insertion_torque = 0;       // N·m, largest during insertion
  double bone_contact = -1;          // of the implant's surface; negative: unknown
  double over_force = 0;             // s above the force's limit
  double hottest = HeatModel::body;  // °C, highest temperature of the bone
  double phases_done() const;        // 0..1
};

}  // namespace typodont::session
