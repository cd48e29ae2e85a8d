// Implant surgery: plan, phases, and measures computed from the ticks.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/contract/contact.h"
#include "engine/session/implant_measures.h"
#include "engine/session/task.h"

namespace typodont::session {

/// Values of ServoTick::level with the contact model "implant".
namespace implant_level {
inline constexpr std::uint32_t kFree = 0, kSliding = 1, kDrilling = 2, kPerforating = 3, kScrewing = 4, kPlaced = 5;
}

/// The cylinder of a drilled hole (bed), or of an implant without its thread. SI units, frame W.
struct ImplantCylinder {
  dvec3 bottom_W{0}, axis_W{0, 0, -1};  // bottom_W: middle of the lower end, m; axis_W: unit vector into the bone
  double length = 0, radius = 0;        // m, length and radius of the cylinder
  /// Signed distance from the cylinder's surface, m; negative inside.
  double distance(const dvec3& p_W) const;
  /// Smallest distance of a polyline from the surface, m. Distances above 0.3 mm may be up to 1 µm too large.
  double distance(std::span<const dvec3> path_W) const;
};

/// Planned position of the implant. SI units, frame W.
struct ImplantPlan {
  dvec3 entry_W{0};         // m, middle of the implant's platform
  dvec3 axis_W{0, 0, -1};   // unit vector into the bone
  double length = 0;        // m, length of the implant
  double diameter = 0;      // m, outer diameter of the implant's thread
  double bed_diameter = 0;  // m, diameter of the last drill
  dvec3 apex_W() const { return entry_W + length * axis_W; }
  ImplantCylinder cylinder() const { return {apex_W(), axis_W, length, diameter / 2}; }
};

/// The kinds of work that a phase can consist of.
enum class ImplantAction { kSmooth, kMark, kDrill, kCheck, kTap, kPlace, kClose };
inline constexpr std::array<std::string_view, 7> kImplantActions = {"smooth", "mark",  "drill", "check",
                                                                    "tap",    "place", "close"};

/// One phase of the implant surgery. SI units.
struct ImplantPhase {
  TaskText name;
  ImplantAction deed = ImplantAction::kDrill;
  std::uint32_t tool = 0;  // index in the session's list of tools
  double depth = 0;        // m, required depth of the tip below the entry
  double volume = 0;       // m³ to remove in the phases kSmooth and kMark
  double speed = 0;        // rad/s, largest spindle speed; 0: the tool does not turn
  bool irrigated = false;  // true if the bone is cooled with water
};

/// A neighbouring tooth's root: all points closer than `radius` to the line from a to b.
struct NeighbourRoot {
  dvec3 a_W{0}, b_W{0};
  double radius = 0;  // m, radius of the root
};

/// An implant exercise as described by the scene.
struct ImplantTask {
  ImplantPlan plan;
  std::vector<ImplantPhase> phases;
  std::vector<double> tip;     // m, for each tool: distance from the tool's origin to its tip
  std::vector<double> radius;  // m, radius of each tool
  double max_force = 0;        // N; a larger force counts as over-force
  double max_angle = 0;        // rad, largest angle between tool and planned axis without a warning
  // m, largest depth below the planned depth without a warning
  double depth_tolerance = 0;
  double canal_clearance = 0;  // m; a smaller distance from the nerve canal causes a warning
  std::vector<dvec3> canal_W;  // the canal's centre line as a polyline; empty: no canal
  double canal_radius = 0;     // m, radius of the nerve canal
  std::vector<NeighbourRoot> neighbours;
};

/// Measures an implant exercise. Call add() with all ticks in order; it never allocates.
class ImplantMeter {
 public:
  explicit ImplantMeter(ImplantTask task);
  void add(std::span<const ServoTick> ticks);
  ImplantMeasures result() const;

  /// Index of the current phase. When all phases are finished: the number of phases.
  std::size_t phase() const { return phase_; }
  /// The warning that the trainee sees now.
  ImplantNote note() const { return note_; }
  /// The tip's depth below the planned entry, along the axis, m.
  double depth() const { return depth_; }
  double temperature() const { return temperature_; }  // °C, temperature of the bone at the drill
  const ImplantTask& task() const { return task_; }

 private:
  void follow(const ServoTick& tick, double dt);
  void heat(const ServoTick& tick, double dt, bool irrigated);
  ImplantNote note_of(const ServoTick& tick, const dvec3& tip_W, const dvec3& axis_W, bool touches) const;
  bool is_done(const ImplantPhase& phase, const ServoTick& tick, bool touches, double dt);
  void record(const ServoTick& tick, double dt);
  void finish_phase(const ServoTick& tick);

  ImplantTask task_;
  ImplantMeasures measures_;
  std::size_t phase_ = 0;
  ImplantNote note_ = ImplantNote::kNone;
  double depth_ = 0, temperature_ = HeatModel::body;
  bool started_ = false;
  Nanos last_t_ = 0;
  double removed_last_ = 0, removed_in_phase_ = 0;  // m³, removed volume at the last tick; volume removed in this phase
  double held_ = 0;                                 // s, time for which the phase's goal has been met
  double later_tool_time_ = 0;                      // s, time of work with a later phase's tool
  bool works_ = false;                              // true while the tool cuts or moves deeper
  double last_depth_ = 0;                           // m, depth of the tip in the last tick
  double insertion_speed_ = 0;                      // m/s along the axis, low-pass filtered
  // Mean forces. Each bin covers an interval of contact time. When there are 2 · kBins bins, neighbours are joined, so
  // that each covers twice the time.
  static constexpr std::size_t kBins = 200;
  std::vector<double> across_, along_;
  double span_ = 0.01, span_filled_ = 0, across_sum_ = 0, along_sum_ = 0;
  // Sums and extreme values over the drill's positions, for the geometry of the drilled hole.
  dvec3 axis_sum_{0}, top_W_{0}, bottom_W_{0};
  double top_ = 1e9, bottom_ = -1e9;
  double bed_radius_ = 0;
};

}  // namespace typodont::session
