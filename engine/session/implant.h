// Implant surgery as an exercise: the plan, the phases of the procedure, and the evaluation of a hand's ticks.
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

/// Values of ServoTick::level for the contact model "implant".
namespace implant_level {
inline constexpr std::uint32_t kFree = 0, kSliding = 1, kDrilling = 2, kPerforating = 3, kScrewing = 4, kPlaced = 5;
}

/// A cylinder with flat ends: a bed, or an implant without its thread. SI units, frame W.
struct ImplantCylinder {
  dvec3 bottom_W{0}, axis_W{0, 0, -1};  // middle of the lower end; axis_W: unit, into the bone
  double length = 0, radius = 0;        // m
  /// Distance from a point to the surface, m, negative inside.
  double distance(const dvec3& p_W) const;
  /// The least distance of the points of a polyline from the surface, m. Where the result is 0.3 mm or more, it is at
  /// most 1 µm too large.
  double distance(std::span<const dvec3> path_W) const;
};

/// Planned position of an implant. SI units, frame W.
struct ImplantPlan {
  dvec3 entry_W{0};         // m, middle of the implant's platform
  dvec3 axis_W{0, 0, -1};   // unit, into the bone
  double length = 0;        // m
  double diameter = 0;      // m, diameter of the thread
  double bed_diameter = 0;  // m, diameter of the last drill
  dvec3 apex_W() const { return entry_W + length * axis_W; }
  ImplantCylinder cylinder() const { return {apex_W(), axis_W, length, diameter / 2}; }
};

/// Type of work of a phase.
enum class ImplantAction { kSmooth, kMark, kDrill, kCheck, kTap, kPlace, kClose };
std::string_view name_of(ImplantAction deed) noexcept;
std::optional<ImplantAction> implant_action_named(std::string_view name) noexcept;

/// One phase of the procedure. SI units.
struct ImplantPhase {
  TaskText name;
  ImplantAction deed = ImplantAction::kDrill;
  std::uint32_t tool = 0;  // index among the session's tools
  double depth = 0;        // m, required depth of the tool's tip below the plan's entry
  double volume = 0;       // m³, volume that must be removed, for kSmooth and kMark
  double speed = 0;        // rad/s, speed limit of the tool; 0: the tool does not turn
  bool irrigated = false;  // true if the bone is cooled with water
};

/// A neighbouring root: all points within `radius` of the line from a to b.
struct NeighbourRoot {
  dvec3 a_W{0}, b_W{0};
  double radius = 0;  // m
};

/// An implant exercise, as read from the scene.
struct ImplantTask {
  ImplantPlan plan;
  std::vector<ImplantPhase> phases;
  std::vector<double> tip;     // m, for each tool: distance from its origin to its tip
  std::vector<double> radius;  // m, for each tool: radius
  double greatest_force = 0;   // N, limit; time with a larger force counts as over-force
  double greatest_angle = 0;   // rad, limit for the angle to the plan's axis; beyond it the trainee is warned
  double depth_tolerance = 0;  // m, limit for excess depth; beyond it the trainee is warned
  double canal_clearance = 0;  // m, limit for the distance to the nerve canal; below it the trainee is warned
  std::vector<dvec3> canal_W;  // polyline; empty: no canal
  double canal_radius = 0;     // m
  std::vector<NeighbourRoot> neighbours;
};

/// Follows a hand through the phases. Pass ticks in order. add() never allocates.
class ImplantMeter {
 public:
  explicit ImplantMeter(ImplantTask task);
  void add(std::span<const ServoTick> ticks);
  ImplantMeasures result() const;

  /// Index of the present phase. After the last phase it equals the number of phases.
  std::size_t phase() const { return phase_; }
  /// The note shown to the trainee now.
  ImplantNote note() const { return note_; }
  /// Depth of the tip below the plan's entry, along the plan's axis, m.
  double depth() const { return depth_; }
  double temperature() const { return temperature_; }  // °C
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
  double removed_last_ = 0, removed_in_phase_ = 0;  // m³
  double held_ = 0;                                 // s, time for which the phase's goal has been met
  double later_tool_time_ = 0;                      // s, time of work with the tool of a later phase
  bool works_ = false;                              // true if the tool in the hand is working on the bone
  double last_depth_ = 0;                           // m
  double insertion_speed_ = 0;                      // m/s, smoothed speed along the plan's axis
  // Force curve of this phase. When the curve has no free bin, its resolution is halved.
  static constexpr std::size_t kBins = 200;
  std::vector<double> across_, along_;
  double span_ = 0.01, span_filled_ = 0, across_sum_ = 0, along_sum_ = 0;
  // Sums for the bed, from the positions of the drill.
  dvec3 axis_sum_{0}, top_W_{0}, bottom_W_{0};
  double top_ = 1e9, bottom_ = -1e9;
  double bed_radius_ = 0;
};

}  // namespace typodont::session
