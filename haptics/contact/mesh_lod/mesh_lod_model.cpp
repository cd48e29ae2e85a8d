#include "haptics/contact/mesh_lod/mesh_lod_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/base/error.h"

namespace typodont::haptics::mesh_lod {

namespace {

constexpr double kSpeedTime = 20e-3;      // s, time constant of the hand's speed
constexpr double kLook = 1.5e-3;          // m, how far a free tool looks around itself
constexpr double kNearby = 0.2e-3;        // m, within which a point belongs to the face nearest to it
constexpr double kNoOffset = 1e-12;       // m
constexpr double kLeastStiffness = 1e-3;  // over that of the settings

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

std::size_t LevelBySpeed::step(double way, double dt, std::size_t count) noexcept {
  const double now = way / dt;
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
  for (const Tool& tool : tool_set(settings)) {
    if (tool.cuts || tool.fill != Tissue::kAir) {
      throw Error(tool.name, "model", tool.cuts ? "mesh_lod with a tool that cuts" : "mesh_lod with a tool that fills",
                  "the model offset, or a tool that only touches");
    }
    points_.emplace_back(options_for(settings, parameters, tool), stiffness_of(settings.materials));
    ends_.push_back(tool.shape == HeadShape::kSphere ? dvec3(0) : dvec3(0, 0, -tool.half()));
  }
}

double MeshLodModel::travel() const noexcept {
  return std::numeric_limits<double>::infinity();
}

void MeshLodModel::adopt(Snapshot& snapshot, PerTissue&) noexcept {
  std::swap(static_cast<MeshSnapshot&>(snapshot), snapshot_);
}

double MeshLodModel::clearance(const Pose& X_WG) noexcept {
  if (snapshot_.number == 0) return 0;
  // Any level may be the next one.
  return point().clearance(snapshot_.levels->grids[0], X_WG * ends_[tool_], kLook) - snapshot_.levels->hausdorff;
}

void MeshLodModel::release() noexcept {
  placed_ = false;
  offset_ = wall_normal_ = dvec3(0);
  wall_stiffness_ = 0;
  by_speed_.reset();
}

bool MeshLodModel::may_take_up(std::uint32_t tool, const Pose& X_WG) noexcept {
  if (snapshot_.number == 0) return false;
  const auto is_free = [&](std::uint32_t t) {
    return points_[t].clearance(snapshot_.levels->grids[0], X_WG * ends_[t], kLook) > snapshot_.levels->hausdorff;
  };
  return is_free(tool_) && is_free(tool);
}

void MeshLodModel::take_up(std::uint32_t tool) noexcept {
  tool_ = tool;
  placed_ = false;
}

bool MeshLodModel::choose_level(const ContactInput& in) noexcept {
  const std::size_t next = by_speed_.step(glm::length(in.moved), in.dt, snapshot_.levels->grids.size());
  if (next == level_) return false;
  level_ = next;
  if (parameters_.maps)
    point().map_to(grid());
  else
    point().put(grid(), in.X_WT * ends_[tool_]);
  return true;
}

void MeshLodModel::constrain(const ContactInput& in, Contact& out) noexcept {
  out.level = static_cast<std::uint32_t>(level_);
  if (snapshot_.number == 0) {
    out.p_WG = in.X_WT.p;
    out.lost = true;
    out.faults |= bits(Fault::kPatchEdge);
    return;
  }
  const dvec3 hip = in.X_WT * ends_[tool_], end = in.X_WT.R * ends_[tool_];
  const bool was_touching = placed_ && point().touching();
  const dvec3 before = point().place();
  const bool switched = choose_level(in);
  out.level = static_cast<std::uint32_t>(level_);
  // The servo moves a free tool without asking, and holds a tip that has sunk in where it is.
  if (!placed_ || (!was_touching && offset_ == dvec3(0))) {
    const Pose X_WG{in.X_WG.p, in.X_WT.R};
    if (!point().put(grid(), X_WG * ends_[tool_])) {
      out.leading_out = true;
      out.faults |= bits(Fault::kDeepPenetration);
    }
    placed_ = true;
  }
  point().follow(grid(), hip);
  // The difference that another level, or a wall that gave way, makes is given to the hand at a pace.
  if (was_touching && ((switched && parameters_.maps) || point().gave_way())) {
    if (parameters_.ramp > 0) offset_ += before - point().place();
  }
  fade_offset(in);
  out.touching = point().touching();
  out.breaking_through = !out.touching && offset_ != dvec3(0);
  out.p_WG = point().place() + offset_ - end;
  out.settled = !out.touching && offset_ == dvec3(0);
  if (out.touching) out.held_off_direction = point().place() - hip;
  for (int i = 0; i < point().count(); ++i) {
    const Hold& hold = point().hold(i);
    if (!hold.wall) continue;
    wall_normal_ = hold.n;
    wall_stiffness_ = settings_.materials[static_cast<std::size_t>(hold.tissue)].stiffness / 1000.0;
  }
  out.side_normal = wall_normal_;
  out.side_stiffness = wall_stiffness_;
}

void MeshLodModel::fade_offset(const ContactInput& in) noexcept {
  const bool at_wall =
      std::any_of(&point().hold(0), &point().hold(0) + point().count(), [](const Hold& hold) { return hold.wall; });
  const double size = glm::length(offset_);
  if (size > kNoOffset) {
    const double stiffness = settings_.stiffness * std::max({in.relative_stiffness, wall_stiffness_, kLeastStiffness});
    offset_ *= std::max(0.0, 1 - parameters_.ramp * in.dt / (stiffness * size));
    if (offset_ != dvec3(0)) return;
  }
  offset_ = dvec3(0);
  if (!at_wall) wall_normal_ = dvec3(0), wall_stiffness_ = 0;
}

bool MeshLodModel::cut(const ContactInput&, Contact&, Cut&, double&) noexcept {
  return false;
}

void MeshLodModel::feel(const ContactInput& in, Contact& out) noexcept {
  const dvec3 end = in.X_WT.R * ends_[tool_];
  out.turns_tool = end != dvec3(0);
  double total = 0, ground = 0;
  for (int i = 0; i < point().count(); ++i) {
    const Hold& hold = point().hold(i);
    out.count = ++out.own;
    total += hold.push;
    out.on_head += hold.push * hold.n;
    if (out.turns_tool) {
      out.lever += hold.push * end;
      out.turn += hold.push * glm::cross(end, hold.n);
    }
    if (hold.wall) continue;
    out.tissue[static_cast<std::size_t>(hold.tissue)] += hold.push;
    ground += hold.push;
  }
  if (total > 0) out.lever /= total;
  if (ground > 0) {
    for (double& share : out.tissue) share /= ground;
    out.known_tissue = true;
  }
}

Tissue MeshLodModel::tissue_at(const dvec3& p_W) const noexcept {
  if (snapshot_.number == 0) return Tissue::kAir;
  const TriangleGrid& finest = snapshot_.levels->grids[0];
  const TriangleGrid::Nearest near = finest.nearest(p_W, kLook);
  const bool there = near.found && (near.distance <= kNearby || finest.inside(p_W));
  return there ? finest.face(near.face).tissue : Tissue::kAir;
}

}  // namespace typodont::haptics::mesh_lod
