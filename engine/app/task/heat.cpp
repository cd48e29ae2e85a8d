#include "engine/app/task/heat.h"

#include <algorithm>
#include <cmath>

#include "engine/app/assets.h"
#include "engine/app/scene.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"

namespace typodont {

namespace {

using namespace literals;

constexpr double kStep = 0.02;    // s, time step of the heat conduction
constexpr double kCell = 0.4_mm;  // approximate edge of a cell
// Distance from the cut surface at which the temperature of bone is measured.
constexpr double kFromWall = 0.5_mm;
constexpr double kLongestTick = 0.1;  // s, longer times between two ticks count as this

/// Makes the grid of cells from every n-th sample of the tissue.
session::HeatGrid grid_of(const haptics::TissueVolume& start, const session::ThermalTable& materials) {
  const VoxelFrame& frame = start.frame();
  const int n = std::max(1, static_cast<int>(std::lround(kCell / frame.voxel)));
  glm::ivec3 lo, hi;
  start.bounds(lo, hi);
  lo = glm::ivec3(glm::floor(dvec3(lo) / double(n))), hi = glm::ivec3(glm::ceil(dvec3(hi) / double(n)));
  const glm::ivec3 size = glm::max(hi - lo + 1, glm::ivec3(1));
  const std::size_t count = voxel_count(size);
  std::vector<float> distance(count);
  std::vector<Tissue> tissue(count);
  start.copy_every(n, lo, size, distance.data(), tissue.data());
  for (std::size_t i = 0; i < count; ++i)
    if (distance[i] >= 0) tissue[i] = Tissue::kAir;
  return {{frame.to_world(dvec3(lo * n)), frame.voxel * n}, size, std::move(tissue), materials, HeatMeter::kBody};
}

}  // namespace

HeatMeter::HeatMeter(const session::HeatConstants& constants, const session::HeatSettings& settings, double flow,
                     const haptics::TissueVolume& start, std::span<const haptics::Tool> tools)
    : constants_(constants),
      dry_{constants.dry_film, kBody},
      wet_{constants.wet_film * std::sqrt(flow / constants.wet_flow), settings.coolant},
      grid_(grid_of(start, constants.tissue)) {
  for (const haptics::Tool& tool : tools) heads_.push_back({haptics::HeadField(tool, 1), tool.reach()});
  const std::size_t count = voxel_count(grid_.size());
  wall_.assign(count, 1e3f);
  for (std::size_t i = 0; i < count; ++i) {
    const Tissue tissue = grid_.tissue(i);
    if (tissue == Tissue::kPulp) pulp_cells_.push_back(i);
    measures_.bone |= tissue == Tissue::kCorticalBone || tissue == Tissue::kCancellousBone;
  }
  measures_.pulp = !pulp_cells_.empty();
}

void HeatMeter::add(std::span<const ServoTick> ticks, bool sprays) {
  for (const ServoTick& tick : ticks) {
    const double dt = last_t_ ? std::clamp(to_seconds(tick.t - *last_t_), 0.0, kLongestTick) : 0;
    last_t_ = tick.t;
    energy_ += tick.cutting_power * dt;
    since_ += dt;
    if (since_ < kStep || !is_finite(tick.X_WG.p)) continue;
    step(tick, since_, sprays && wet_.film > 0 && tick.spindle != 0);
    observe(since_);
    since_ = energy_ = 0;
  }
}

void HeatMeter::step(const ServoTick& tick, double dt, bool wet) {
  const Head& head = heads_[std::min<std::size_t>(tick.tool, heads_.size() - 1)];
  const double h = grid_.frame().voxel, near = head.reach + kFromWall + 2 * h;
  warmed_.clear();
  if (energy_ > 0) {
    const glm::dmat3 R_TW = glm::transpose(glm::dmat3(tick.X_WG.R));
    const dvec3 center = grid_.frame().to_voxels(tick.X_WG.p);
    const glm::ivec3 lo = glm::max(glm::ivec3(glm::floor(center - near / h)), glm::ivec3(0)),
                     hi = glm::min(glm::ivec3(glm::ceil(center + near / h)), grid_.size() - 1);
    for_each_voxel_between(lo, hi, [&](int x, int y, int z) {
      const std::size_t i = grid_.at(x, y, z);
      if (grid_.tissue(i) == Tissue::kAir) return;
      const dvec3 p_W = grid_.frame().to_world(dvec3(x, y, z));
      const double away = head.field.distance(R_TW * (p_W - tick.X_WG.p));
      if (away < 0) {
        grid_.remove(i);
        return;
      }
      // Only cells in front of the head, where it presses, are warmed.
      if (away < h && glm::dot(p_W - tick.X_WG.p, tick.n_C_W) <= 0) warmed_.push_back(i);
      const Tissue tissue = grid_.tissue(i);
      if (tissue != Tissue::kCorticalBone && tissue != Tissue::kCancellousBone) return;
      if (wall_[i] > 100 && away < kFromWall + h) watched_.push_back(i);
      wall_[i] = std::min(wall_[i], static_cast<float>(away));
    });
    for (const std::size_t i : warmed_)
      grid_.heat(i, constants_.fraction * energy_ / static_cast<double>(warmed_.size()));
  }
  ++steps_;
  grid_.step(dt, dry_, wet ? wet_ : dry_, tick.X_WG.p, constants_.wet_reach);
}

void HeatMeter::observe(double dt) {
  const bool second = std::floor(time_ + dt) > std::floor(time_);
  time_ += dt;
  if (measures_.pulp) {
    pulp_ = kBody;
    for (const std::size_t i : pulp_cells_) {
      if (const double t = grid_.temperature(i); std::abs(t - kBody) > std::abs(pulp_ - kBody)) pulp_ = t;
    }
    measures_.pulp_max = std::max(measures_.pulp_max, pulp_), measures_.pulp_min = std::min(measures_.pulp_min, pulp_);
    if (second) measures_.pulp_curve.push_back(static_cast<float>(pulp_));
  }
  if (measures_.bone) {
    bone_ = kBody;
    for (const std::size_t i : watched_) {
      if (wall_[i] >= kFromWall && grid_.tissue(i) != Tissue::kAir) bone_ = std::max(bone_, grid_.temperature(i));
    }
    above_ = bone_ > kBoneHarm ? above_ + dt : 0;
    measures_.bone_max = std::max(measures_.bone_max, bone_);
    measures_.bone_above = std::max(measures_.bone_above, above_);
    if (second) measures_.bone_curve.push_back(static_cast<float>(bone_));
  }
}

std::optional<HeatMeter> heat_meter(const Scene& scene, const haptics::TissueVolume& start) {
  if (!scene.heat) return std::nullopt;
  return HeatMeter(session::read_heat_constants(Json::load(assets_folder() / "materials" / "heat.json")), *scene.heat,
                   scene.spray ? scene.spray->flow : 0, start, haptics::tool_set(scene.servo));
}

}  // namespace typodont
