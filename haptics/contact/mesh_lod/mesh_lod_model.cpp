#include "haptics/contact/mesh_lod/mesh_lod_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/contact/mesh_lod/mesh_lod_method.h"
#include "haptics/contact/tool_check.h"

namespace typodont::haptics::mesh_lod {

namespace {

constexpr double kSpeedTime = 20e-3;                         // s, time constant of the filter for the hand's speed
constexpr double kSearchDistance = SurfacePoint::kFarthest;  // m, search distance around a tool without contact
// m; tissue_at() uses the nearest face up to this distance
constexpr double kNearby = 0.2e-3;
constexpr double kMinStep = 1e-9;  // m; a cut with a shorter step is not made
// weight of a new value in measured_, the running mean of (measured / estimated removed volume)
constexpr double kMeasuredShare = 0.3;
// The snapshot may lack the last cuts; its faces then overlap the bur. Limits in radii of the bur:
// kMaxOverlap: depth of a face in the bur's head. kMaxAdvance: distance that the bur may cut without a new snapshot.
constexpr double kMaxOverlap = 0.5, kMaxAdvance = 2;
constexpr double kFastestCut = 0.02;  // m/s, largest speed at which a bur sinks into tissue
// smallest and largest ratio of measured to estimated removed volume
constexpr double kMinMeasured = 0.02, kMaxMeasured = 4.0;
// m; a shorter vector offset_ (shift of the contact point after a change of level) counts as zero
constexpr double kNoOffset = 1e-12;
// smallest allowed ratio of a tissue's stiffness to ServoSettings::stiffness
constexpr double kMinStiffness = 1e-3;
constexpr double kClear = 0.3e-3;  // m; a bur farther than this from the mesh has left the hole that it cut
constexpr double kEase = 15;       // N/s, largest change of a bur's force while the hand rests

SurfaceOptions options_for(const ServoSettings& settings, const Parameters& parameters, const Tool& tool) {
  SurfaceOptions options;
  options.radius = tool.shape == HeadShape::kSphere ? tool.radius() : 0;
  options.walls = settings.boundary_walls;
  options.wall_limit = parameters.wall_limit;
  options.unit_force = settings.stiffness;
  return options;
}

Stiffness stiffness_of(const MaterialTable& materials) {
  Stiffness stiffness{};
  for (std::size_t i = 1; i < stiffness.size(); ++i) stiffness[i] = materials[i].stiffness;
  return stiffness;
}

}  // namespace

std::size_t LevelBySpeed::step(double displacement, double dt, std::size_t count) noexcept {
  const double now = displacement / dt;
  speed_ = fresh_ ? now : now + (speed_ - now) * std::exp(-dt / kSpeedTime);
  const double margin = fresh_ ? 0 : hysteresis_;
  fresh_ = false;
  const std::size_t last = std::min(count - 1, speeds_.size());
  level_ = std::min(level_, last);
  while (level_ < last && speed_ > speeds_[level_] * (1 + margin)) ++level_;
  while (level_ > 0 && speed_ < speeds_[level_ - 1] * (1 - margin)) --level_;
  return level_;
}

MeshLodModel::MeshLodModel(const ServoSettings& settings, const Parameters& parameters)
    : settings_(settings), parameters_(parameters), by_speed_(parameters.switch_speed, parameters.hysteresis) {
  refuse_tools_that_fill(tool_set(settings), kName);
  for (const Tool& tool : tool_set(settings)) {
    if (whole_head(tool)) {
      points_.push_back(std::make_unique<HeadContact>(tool));
    } else {
      points_.push_back(
          std::make_unique<SurfacePoint>(options_for(settings, parameters, tool), stiffness_of(settings.materials)));
    }
    const bool touches_at_end = tool.shape != HeadShape::kSphere && !whole_head(tool);
    ends_.push_back(touches_at_end ? dvec3(0, 0, -tool.half()) : dvec3(0));
  }
}

void MeshLodModel::adopt(Snapshot& snapshot, PerTissue& removed) noexcept {
  auto& fresh = static_cast<MeshSnapshot&>(snapshot);
  if (fresh.cut) {
    const std::uint64_t first_lacking = made_.first_after(fresh.cuts);
    if (first_lacking <= made_.last()) first_missing_cut_ = made_[first_lacking].from;
    const bool edited = fresh.edits != snapshot_.edits;
    double estimated = 0, measured = 0;
    for (std::uint64_t i = made_.first_after(snapshot_.cuts); i <= fresh.cuts; ++i) {
      estimated += total(made_[i].removed);
    }
    for (std::size_t t = 1; t < removed.size(); ++t) {
      measured += fresh.removed[t] - snapshot_.removed[t];
      // A cut of the mesh may add a little volume, but the count of removed volume may decrease only by undo.
      removed[t] = edited ? fresh.removed[t] : std::max(removed[t], fresh.removed[t]);
    }
    if (estimated > 0 && !edited) {
      const double ratio = std::clamp(measured / estimated * measured_, kMinMeasured, kMaxMeasured);
      measured_ += kMeasuredShare * (ratio - measured_);
    }
  }
  // After undo or redo, there may be tissue at the tool, so the contact starts again.
  if (fresh.edits != snapshot_.edits) placed_ = moved_freely_ = false;
  adopted_ = fresh.cut || snapshot_.cut;
  std::swap(fresh, snapshot_);
  for (const auto& contact : points_) contact->mesh_changed();
  if (snapshot_.points_of < points_.size()) points_[snapshot_.points_of]->use_prepared(snapshot_.points.get());
}

bool MeshLodModel::holds(const dvec3& p, double reach) const noexcept {
  if (!snapshot_.cut) return true;
  return glm::all(glm::lessThanEqual(snapshot_.lo, p - reach)) &&
         glm::all(glm::greaterThanEqual(snapshot_.hi, p + reach));
}

/// Returns true if a tool at pose X overlaps no face, in any level of detail that the tool can use.
bool MeshLodModel::is_free(std::uint32_t tool, const Pose& X) noexcept {
  const SurfaceContact& contact = *points_[tool];
  const dvec3 p = X * ends_[tool];
  if (!holds(p, contact.outlook())) return false;
  for (std::size_t level = 0; level < level_count(tool); ++level) {
    if (!contact.is_free(grids()[level], {p, X.R})) return false;
  }
  return true;
}

double MeshLodModel::clearance(const Pose& X) noexcept {
  const dvec3 p = X * ends_[tool_];
  if (!holds(p, point().outlook())) return 0;
  point().turn_to(X.R);
  double clearance = kSearchDistance;
  for (std::size_t level = 0; level < level_count(tool_) && clearance > 0; ++level) {
    clearance = std::min(clearance, point().clearance(grids()[level], p, kSearchDistance));
  }
  return clearance;
}

void MeshLodModel::release() noexcept {
  moved_freely_ = moved_freely_ || placed_;
  placed_ = false;
  offset_ = wall_normal_ = dvec3(0);
  wall_stiffness_ = 0;
  eases_ = false;
  by_speed_.reset();
}

void MeshLodModel::take_up(std::uint32_t tool) noexcept {
  tool_ = tool;
  placed_ = moved_freely_ = false;
}

bool MeshLodModel::choose_level(const ContactInput& in) noexcept {
  // While the tool cuts or is in its cut, or while the snapshot lacks cuts, only the finest level is valid.
  const std::size_t count = in.removal.cuts || behind() || in_own_cut_ ? 1 : level_count(tool_);
  const std::size_t next = by_speed_.step(glm::length(in.moved), in.dt, count);
  if (next == level_) return false;
  level_ = next;
  point().mesh_changed();
  return true;
}

/// Moves the contact point to the mesh of another level; `hip_`: the hand's position in the last tick. `anew`: computes
/// the contact point from the hand's position alone; otherwise the change of the force is applied gradually.
void MeshLodModel::take_over(bool anew) noexcept {
  const dvec3 before = point().place();
  if (anew) {
    point().put(grid(), hip_);
    return;
  }
  point().map_to(grid());
  point().follow(grid(), hip_, false);
  if (parameters_.ramp > 0) offset_ += before - point().place();
}

void MeshLodModel::constrain(const ContactInput& in, Contact& out) noexcept {
  out.level = static_cast<std::uint32_t>(level_);
  const dvec3 end = in.X_WT.R * ends_[tool_], goal = in.X_WT.p + end;
  // For a placed tool, X_WT is not the hand's pose.
  const dvec3 hip = in.placed ? hip_ + in.moved : goal;
  if (!holds(in.X_WG * ends_[tool_], point().reach() + kNearby)) {
    placed_ = moved_freely_ = false;
    out.p_WG = in.X_WG.p;
    out.gap.lost = true;
    return;
  }
  point().turn_to(in.X_WT.R);
  const bool was_touching = placed_ && point().touching();
  in_own_cut_ = in_own_cut_ && placed_ && (was_touching || point().clearance(grid(), point().place(), kClear) < kClear);
  const bool give = in.removal.cuts || behind() || in_own_cut_;
  const bool renewed = std::exchange(adopted_, false) && !give;
  const bool switched = choose_level(in);
  out.level = static_cast<std::uint32_t>(level_);
  // The contact starts again at the tool's current position if the tool has moved without calls of this model. Such a
  // free motion may have led through a hole of an open mesh.
  const bool fresh = !placed_;
  if (fresh) {
    const Pose X_WG{in.X_WG.p, in.X_WT.R};
    if (moved_freely_) {
      point().put_free(X_WG * ends_[tool_]);
    } else if (!point().put(grid(), X_WG * ends_[tool_])) {
      out.leading_out = true;
    }
    placed_ = true;
    moved_freely_ = false;
  } else if (was_touching && (switched || renewed)) {
    take_over(switched && !parameters_.maps);
  }
  const dvec3 before = point().place();
  point().follow(grid(), goal, give);
  out.leading_out = out.leading_out || point().leading_out();
  withdraw(in, goal);
  hip_ = hip;
  cutting_ = cutting_ && in.removal.cuts && !fresh;
  if (point().gave_way() && parameters_.ramp > 0) offset_ += before - point().place();
  fade_offset(in);
  ease(in, give && !fresh);
  out.touching = point().touching();
  out.breaking_through = !out.touching && offset_ != dvec3(0);
  out.p_WG = point().place() + offset_ - end;
  out.settled = !out.touching && offset_ == dvec3(0);
  if (out.touching) out.contact_direction = point().place() - hip;
  for (int i = 0; i < point().count(); ++i) {
    const Hold& hold = point().hold(i);
    if (!hold.wall) continue;
    wall_normal_ = hold.n;
    wall_stiffness_ = settings_.materials[static_cast<std::size_t>(hold.tissue)].stiffness / 1000.0;
  }
  out.wall.normal = wall_normal_;
  out.wall.stiffness = wall_stiffness_;
}

int MeshLodModel::near_planes(std::span<NearPlane, kMaxNearPlanes> planes) const noexcept {
  return placed_ && offset_ == dvec3(0) ? points_[tool_]->near_planes(planes) : 0;
}

/// Moves a bur that stands still in its own cut back along its path, towards `goal`.
void MeshLodModel::withdraw(const ContactInput& in, const dvec3& goal) noexcept {
  const double h = settings_.frame.voxel;
  const dvec3 c = point().place();
  if (!in_own_cut_) return path_.begin(c / h);
  path_.add(c / h);
  if (in.removal.cuts || behind() || !point().touching()) return;
  if (whole_head(tool_set(settings_)[tool_]) && RetreatPath::turned(in.X_WT.R, end_.R)) return;
  const double most = glm::length(in.moved) + kEase * in.dt / settings_.stiffness;
  point().sink_to(h * path_.withdrawn(c / h, goal / h, most / h));
}

void MeshLodModel::fade_offset(const ContactInput& in) noexcept {
  const bool at_wall =
      std::any_of(&point().hold(0), &point().hold(0) + point().count(), [](const Hold& hold) { return hold.wall; });
  const double size = glm::length(offset_);
  if (size > kNoOffset) {
    const double stiffness =
        settings_.stiffness * std::max({in.last.relative_stiffness, wall_stiffness_, kMinStiffness});
    offset_ *= std::max(0.0, 1 - parameters_.ramp * in.dt / (stiffness * size));
    if (offset_ != dvec3(0)) return;
  }
  offset_ = dvec3(0);
  if (!at_wall) wall_normal_ = dvec3(0), wall_stiffness_ = 0;
}

/// Limits how fast a bur's force changes. Otherwise the force would jump when contacts end while the hand is far from
/// the bur, or when a new snapshot shifts the contact point.
void MeshLodModel::ease(const ContactInput& in, bool give) noexcept {
  eases_ = parameters_.ramp > 0 && !in.placed && (give || (eases_ && (point().touching() || offset_ != dvec3(0))));
  const double moved = displacement_bound({in.X_WT.p - in.moved, last_R_}, in.X_WT, point().reach());
  last_R_ = in.X_WT.R;
  const double most = moved + kEase * in.dt / settings_.stiffness;
  const dvec3 lag = point().place() + offset_ - hip_, change = lag - last_lag_;
  const double size = glm::length(change);
  if (eases_ && size > most) offset_ -= (1 - most / size) * change;
  last_lag_ = point().place() + offset_ - hip_;
}

/// Returns true if the faces of the snapshot can still stop the head at `to`: no face lies too deep inside the head.
/// Without this test, a bur could pass all faces if no new snapshot arrives.
bool MeshLodModel::may_penetrate_to(const dvec3& to) noexcept {
  const double most = kMaxOverlap * point().radius(),
               advance = glm::distance(to, behind() ? first_missing_cut_ : point().place());
  if (advance <= most) return true;
  return advance <= kMaxAdvance * point().radius() && point().clearance(finest(), to, 0) >= -most;
}

bool MeshLodModel::cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept {
  if (!(in.removal.cuts && in.removal.budget > 0 && contact.touching)) return false;
  const dvec3 c = point().place(), displacement = in.X_WT.p - c;
  const double left = glm::length(displacement);
  if (!(left > 0)) return false;
  // The head moves towards the hand as far as the energy allows. A step of length s removes A s + π r s² (A: contact
  // area; r: head's radius). The second term is volume below the surface that the head newly touches.
  PerTissue area = point().engaged_area(grid(), displacement / left);
  double all = 0, work = 0;  // all: m², contact area; work: J/m, energy per metre of the step
  for (std::size_t t = 1; t < area.size(); ++t) {
    area[t] *= measured_;
    all += area[t];
    work += area[t] * settings_.materials[t].specific_energy;
  }
  // J/m³, specific cutting energy of the touched tissues
  const double u = in.removal.specific_energy > 0 ? in.removal.specific_energy : all > 0 ? work / all : 0;
  if (!(u > 0)) return false;
  if (!(work > 0)) work = 0;
  const double round = kPi * point().radius() * measured_;
  const double paid = (-work + std::sqrt(work * work + 4 * round * u * in.removal.budget)) / (2 * round * u);
  // The energy budget of a blocked bur grows. A speed limit prevents one long step, which the hand would feel.
  const double step = std::min({left, paid, kFastestCut * in.dt});
  if (!(step > kMinStep)) return false;
  const dvec3 to = c + step / left * displacement;
  if (!may_penetrate_to(to)) return false;
  PerTissue removed{};
  for (std::size_t t = 1; t < area.size(); ++t) removed[t] = area[t] * step;
  const auto under = static_cast<std::size_t>(point().hold(0).tissue);
  removed[under] += round * step * step;
  energy = work * step + round * step * step * u;
  const Pose end{to, in.X_WT.R}, from = cutting_ ? end_ : Pose{c, in.X_WT.R};
  if (!behind()) first_missing_cut_ = c;
  made_.add(made_.last() + 1, {removed, c});
  cut.X_WA = from, cut.X_WB = end;
  cut.removed = removed;
  point().sink_to(to);
  cutting_ = in_own_cut_ = true;
  end_ = end;
  contact.p_WG = to + offset_;
  last_lag_ = contact.p_WG - in.X_WT.p;
  contact.area = all;
  return true;
}

void MeshLodModel::feel(const ContactInput& in, Contact&, Felt& out) noexcept {
  const bool whole = whole_head(tool_set(settings_)[tool_]);
  const dvec3 end = in.X_WT.R * ends_[tool_];
  out.turns_tool = whole || end != dvec3(0);
  double total = 0, ground = 0;
  for (int i = 0; i < point().count(); ++i) {
    const Hold& hold = point().hold(i);
    out.count = ++out.own;
    total += hold.push;
    out.add(hold.push, whole ? hold.p - point().place() : end, hold.n, true);
    if (hold.wall) continue;
    out.tissue[static_cast<std::size_t>(hold.tissue)] += hold.push;
    ground += hold.push;
  }
  if (total > 0) out.lever /= total;
  if (ground > 0) out.average(ground, false);
}

Tissue MeshLodModel::tissue_at(const dvec3& p_W) const noexcept {
  if (snapshot_.number == 0) return Tissue::kAir;
  const TriangleGrid::Nearest near = finest().nearest(p_W, kSearchDistance);
  const bool there = near.found && (near.distance <= kNearby || finest().inside(p_W));
  return there ? finest().face(near.face).tissue : Tissue::kAir;
}

}  // namespace typodont::haptics::mesh_lod
