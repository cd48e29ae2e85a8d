// Implant surgery as an exercise: the plan, the phases of the procedure, and the evaluation of the ticks.
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

/// The values of ServoTick::level in the contact model "implant".
namespace implant_level {
inline constexpr std::uint32_t kFree = 0, kSliding = 1, kDrilling = 2, kPerforating = 3, kScrewing = 4, kPlaced = 5;
}

/// A cylinder with flat ends. It represents a bed (drilled hole), or an implant without its thread. SI units, frame W.
struct ImplantCylinder {
  dvec3 bottom_W{0}, axis_W{0, 0, -1};  // bottom_W: middle of the lower end, m; axis_W: unit vector into the bone
  double length = 0, radius = 0;        // m, length and radius of the cylinder
  /// Returns the distance from a point to the surface of the cylinder in m, negative inside.
  double distance(const dvec3& p_W) const;
  /// Returns the smallest distance in m from the points of a polyline to the cylinder's surface. If the result is 0.3
  /// mm or more, it exceeds the exact distance by at most 1 µm.
  double distance(std::span<const dvec3> path_W) const;
};

/// The planned position of an implant. SI units, frame W.
struct ImplantPlan {
  dvec3 entry_W{0};         // m, middle of the implant's platform
  dvec3 axis_W{0, 0, -1};   // unit vector along the implant's axis, into the bone
  double length = 0;        // m, length of the implant
  double diameter = 0;      // m, outer diameter of the implant's thread
  double bed_diameter = 0;  // m, diameter of the last drill for the bed (hole)
  dvec3 apex_W() const { return entry_W + length * axis_W; }
  ImplantCylinder cylinder() const { return {apex_W(), axis_W, length, diameter / 2}; }
};

/// The kinds of work that a phase can consist of.
enum class ImplantAction { kSmooth, kMark, kDrill, kCheck, kTap, kPlace, kClose };
std::string_view name_of(ImplantAction deed) noexcept;
std::optional<ImplantAction> implant_action_named(std::string_view name) noexcept;

/// One phase of the implant procedure. SI units.
struct ImplantPhase {
  TaskText name;
  ImplantAction deed = ImplantAction::kDrill;
  std::uint32_t tool = 0;  // tool of the phase, as an index in the session's list of tools
  double depth = 0;        // m, required depth of the tool's tip below the planned entry
  double volume = 0;       // m³, volume that must be removed, for kSmooth and kMark
  double speed = 0;        // rad/s, highest speed of the tool; 0: the tool does not turn
  bool irrigated = false;  // true if the bone is cooled with water
};

/// The root of a neighbouring tooth: all points within `radius` of the line from a to b.
struct NeighbourRoot {
  dvec3 a_W{0}, b_W{0};
  double radius = 0;  // m, radius of the root
};

/// An implant exercise as the scene states it.
struct ImplantTask {
  ImplantPlan plan;
  std::vector<ImplantPhase> phases;
  std::vector<double> tip;     // for each tool: distance in m from the tool's origin to its tip
  std::vector<double> radius;  // for each tool: its radius in m
  double greatest_force = 0;   // N, largest allowed force; the time with a larger force counts as over-force
  double greatest_angle = 0;   // rad, if the angle to the planned axis is larger than this, the trainee is warned
  // m, if the tool is deeper than the planned depth by more than this, the trainee is warned
  double depth_tolerance = 0;
  double canal_clearance = 0;  // m; if the distance to the nerve canal is smaller than this, the trainee is warned
  std::vector<dvec3> canal_W;  // the nerve canal as a polyline; empty if there is no canal
  double canal_radius = 0;     // m, radius of the nerve canal
  std::vector<NeighbourRoot> neighbours;
};

/// Finds the present phase and measures the trainee's work. Call add() with the ticks in order. add() never allocates.
class ImplantMeter {
 public:
  explicit ImplantMeter(ImplantTask task);
  void add(std::span<const ServoTick> ticks);
  ImplantMeasures result() const;

  /// Returns the index of the present phase. After the last phase it equals the number of phases.
  std::size_t phase() const { return phase_; }
  /// Returns the note that the trainee sees now.
  ImplantNote note() const { return note_; }
  /// Returns the depth, in m, of the tool's tip below the planned entry point, along the planned axis.
  double depth() const { return depth_; }
  double temperature() const { return temperature_; }  // returns the temperature (°C) of the bone at the drill
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
  double removed_last_ = 0, removed_in_phase_ = 0;  // m³, volumes removed up to the last tick, and in the present phase
  double held_ = 0;                                 // s, time for which the goal of the phase has been met so far
  double later_tool_time_ = 0;                      // s, time for which the tool of a later phase has worked so far
  bool works_ = false;                              // true while the tool in the hand works on the bone
  double last_depth_ = 0;                           // m, depth of the tool's tip in the last tick
  double insertion_speed_ = 0;                      // m/s, low-pass filtered speed of the tool along the planned axis
  // Data of the force curve of the present phase: the mean force in each interval (bin) of contact time. When there are
  // 2 · kBins bins, neighbouring bins are joined in pairs. Each bin then covers twice the time.
  static constexpr std::size_t kBins = 200;
  std::vector<double> across_, along_;
  double span_ = 0.01, span_filled_ = 0, across_sum_ = 0, along_sum_ = 0;
  // Sums over the positions of the drill in the bed (drilled hole), from which the bed's geometry is computed.
  dvec3 axis_sum_{0}, top_W_{0}, bottom_W_{0};
  double top_ = 1e9, bottom_ = -1e9;
  double bed_radius_ = 0;
};

}  // namespace typodont::session
