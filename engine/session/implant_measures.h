// What an exercise in implant surgery measures: plain data, for score and report.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "engine/session/strings.h"

namespace typodont::session {

/// What is said at once.
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

/// Bone temperature at the drill: one mass of bone around the bed, heated by a share of the cutting power, cooled
/// towards the body's. Estimates, but for the threshold: Eriksson & Albrektsson, J Prosthet Dent 1983;50:101-107, found
/// bone harmed from 47 °C for a minute on.
struct HeatModel {
  static constexpr double share = 0.3;              // of the power; the chips take the rest away
  static constexpr double shell = 1e-3;             // m of bone around the bed that warms up
  static constexpr double heat_capacity = 2.5e6;    // J/(m³ K): 1.9 g/cm³ at 1.3 J/(g K)
  static constexpr double cooled_time = 8;          // s, time constant with irrigation …
  static constexpr double dry_time = 30;            // … and without
  static constexpr double body = 37, harmful = 47;  // °C
};

/// A force curve: means over equal spans of a phase's own time in contact.
struct ForceCurve {
  std::vector<float> across, along;  // N, across and along the plan's axis
  double span = 0;                   // s
};

struct ImplantPhaseMeasures {
  std::array<std::string, kLanguageCount> name;
  bool done = false, skipped = false;
  double began = -1, ended = -1;                  // s, of the first contact and of the end; negative: none
  double force_max = 0;                           // N
  double over_force = 0;                          // s
  double depth = 0;                               // m below the plan's entry, the deepest
  double hottest = HeatModel::body;               // °C
  std::array<double, kImplantNoteCount> noted{};  // s that each note stood
  ForceCurve force;
};

/// The bed as the hand made it. SI.
struct ImplantBedMeasures {
  bool found = false;
  double entry_error = 0, apex_error = 0;  // m from the plan's
  double axis_error = 0;                   // rad
  double depth = 0;                        // m below the plan's entry
  double canal_distance = 1e9;             // m from the bed's wall, or bottom, to the canal's wall
  double neighbour_distance = 1e9;         // m from the wall to the nearest root
  // Measured in the tissue, see measure_bed(); negative where they are not known.
  double diameter = -1, ovality = -1;  // m
  double perforated = -1;              // share of the wall's upper nine tenths that has no bone behind it
};

struct ImplantMeasures {
  std::vector<ImplantPhaseMeasures> phases;
  ImplantBedMeasures bed;
  bool placed = false;
  double insertion_torque = 0;       // N·m, the greatest while the implant went in
  double bone_contact = -1;          // share of its surface that lies in bone; negative where not known
  double over_force = 0;             // s
  double hottest = HeatModel::body;  // °C
  double phases_done() const;        // share
};

}  // namespace typodont::session
