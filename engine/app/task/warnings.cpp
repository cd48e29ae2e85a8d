#include "engine/app/task/warnings.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "engine/base/units.h"
#include "engine/base/voxels.h"

namespace typodont {

namespace {

// Margins are estimates: a bur moves about 1 mm/s, and a hand needs about half a second to react.
constexpr double kPulpMargin = 0.5e-3, kNeighbourMargin = 0.3e-3;  // m
constexpr double kAxisMargin = 0.5;                                // fraction of the largest angle
constexpr int kTouchPoints = 96;
constexpr double kPulpBlock = 1e-3;  // m, edge of a block

}  // namespace

std::vector<WarningRule> warning_rules(const Scene& scene) {
  if (!scene.task || !scene.warnings || scene.implant) return {};
  const session::Task& task = *scene.task;
  session::ScoreInput input;
  if (task.explore) input.explore.emplace().sites.resize(task.sites.size());
  std::vector<session::ScoreRule> all = task.score.rules;
  if (task.score.defaults) std::ranges::copy(session::default_rules(input), std::back_inserter(all));
  const auto rule = [&](const char* item) {
    const auto found = std::ranges::find(all, item, &session::ScoreRule::name);
    return found == all.end() ? nullptr : &*found;
  };
  // The item's rule if it gives points.
  const auto scored = [&](const char* item) {
    const session::ScoreRule* found = rule(item);
    return found && found->weight > 0 ? found : nullptr;
  };
  std::vector<WarningRule> rules;
  if (const auto* pulp = scored("pulp_distance_mm"); pulp && !task.explore) {
    const double target = std::isnan(pulp->target) ? *session::default_target(pulp->name) : pulp->target;
    if (target > 0) rules.push_back({Warning::kPulp, pulp->name, target * kMillimetre, kPulpMargin});
  }
  const bool monitored = scene.surroundings && scene.surroundings->monitored;
  if (const auto* neighbour = scored("neighbour_removed_mm3"); neighbour && monitored)
    rules.push_back({Warning::kNeighbour, neighbour->name, 0, kNeighbourMargin});
  if (const auto* force = scored("force_max_N"); force && force->target > 0) {
    const session::ScoreRule* mean = rule("force_mean_N");
    rules.push_back({Warning::kForce, force->name, force->target,
                     std::max(0.0, 0.5 * (force->target - (mean ? mean->target : 0)))});
  }
  for (const char* item : {"taper_deg", "floor_tilt_deg"})
    if (const auto* axis = scored(item)) {
      const double limit = axis->tolerance * kDegree;
      rules.push_back({Warning::kAxis, axis->name, limit, kAxisMargin * limit});
      break;
    }
  return rules;
}

WarningMeter::WarningMeter(const Scene& scene, const haptics::TissueVolume& start,
                           const session::WarningLevels& levels) {
  for (WarningRule& rule : warning_rules(scene)) {
    const auto level = levels.find(rule.item);
    if (level == levels.end()) continue;
    rule.margin *= level->second;
    rules_.push_back(std::move(rule));
  }
  for (const haptics::Tool& tool : haptics::tool_set(scene.servo)) {
    heads_.push_back({tool.turns(), tool.shape == haptics::HeadShape::kSphere, tool.reach(), {tool, 1}, {}});
    for (const haptics::HeadSample& sample : haptics::sample_head(tool, kTouchPoints))
      heads_.back().surface_T.push_back(sample.p_TQ);
  }
  if (scene.task) axis_W_ = scene.task->axis_W;
  const auto has = [&](Warning warning) { return std::ranges::count(rules_, warning, &WarningRule::warning) > 0; };
  if (has(Warning::kNeighbour)) around_ = monitored_shape(scene.surroundings);
  if (!has(Warning::kPulp)) return;
  if (const haptics::VoxelBox box = start.box_of(Tissue::kPulp); !box.empty())
    add_pulp(dense_copy(start, box.lo - 1, box.hi - box.lo + 3));
}

void WarningMeter::add_pulp(const DenseCopy& copy) {
  half_voxel_ = 0.5 * copy.frame.voxel;
  const auto is_pulp = [&](const glm::ivec3& v) {
    const std::size_t i = copy.field.at(v.x, v.y, v.z);
    return copy.tissue[i] == Tissue::kPulp && copy.field.distance[i] < 0;
  };
  std::map<glm::ivec3, PulpBlock, LessByAxes> blocks;
  for_each_voxel_between(glm::ivec3(1), copy.field.size - 2, [&](const glm::ivec3& v) {
    if (!is_pulp(v)) return;
    bool outermost = false;
    for (int axis = 0; axis < 3; ++axis) {
      glm::ivec3 step(0);
      step[axis] = 1;
      outermost = outermost || !is_pulp(v - step) || !is_pulp(v + step);
    }
    if (!outermost) return;
    const dvec3 p_W = copy.frame.to_world(dvec3(v));
    const dvec3 corner = glm::floor(p_W / kPulpBlock);
    PulpBlock& block = blocks[glm::ivec3(corner)];
    block.middle = (corner + 0.5) * kPulpBlock;
    block.points.push_back(p_W);
  });
  for (auto& [corner, block] : blocks) pulp_.push_back(std::move(block));
}

void WarningMeter::restart() {
  max_force_ = 0;
  current_ = Warning::kNone;
  until_ = 0;
}

void WarningMeter::add(const ServoTick& tick) {
  const bool contact = tick.depth > 0 || tick.contact_area > 0;
  if (contact && !(tick.faults & bits(Fault::kHeld))) max_force_ = std::max(max_force_, glm::length(tick.f_T_W));
}

void WarningMeter::evaluate(const ServoTick& tick, Nanos t) {
  const Head& head = heads_[std::min<std::size_t>(tick.tool, heads_.size() - 1)];
  Warning found = Warning::kNone;
  for (const WarningRule& rule : rules_)  // in order of priority
    if (found == Warning::kNone && applies(rule, tick, head)) found = rule.warning;
  max_force_ = 0;
  if (found == Warning::kNone || (found > current_ && t < until_)) {
    if (t >= until_) current_ = Warning::kNone;
    return;
  }
  current_ = found;
  until_ = t + kShown;
}

bool WarningMeter::applies(const WarningRule& rule, const ServoTick& tick, const Head& head) const {
  if (rule.warning == Warning::kForce) return max_force_ > rule.limit - rule.margin;
  if (!head.turns || !(tick.spindle > 0) || !is_finite(tick.X_WG.p)) return false;
  switch (rule.warning) {
    case Warning::kPulp:
      return pulp_within(rule.limit + rule.margin, head, tick.X_WG);
    case Warning::kNeighbour:
      return neighbour_within(rule.limit + rule.margin, head, tick.X_WG);
    case Warning::kAxis: {
      const double cosine = glm::dot(tick.X_WG.rotate({0, 0, 1}), axis_W_);
      return !head.ball && tick.contact_area > 0 && std::acos(std::clamp(cosine, -1.0, 1.0)) > rule.limit - rule.margin;
    }
    default:
      return false;
  }
}

bool WarningMeter::pulp_within(double distance, const Head& head, const Pose& X_WG) const {
  const Pose X_GW = inverse(X_WG);
  const double near = distance + half_voxel_, reach = near + head.reach + 0.5 * std::sqrt(3.0) * kPulpBlock;
  return std::ranges::any_of(pulp_, [&](const PulpBlock& block) {
    return glm::length(block.middle - X_WG.p) < reach &&
           std::ranges::any_of(block.points, [&](const dvec3& p_W) { return head.field.distance(X_GW * p_W) < near; });
  });
}

bool WarningMeter::neighbour_within(double distance, const Head& head, const Pose& X_WG) const {
  if (around_->neighbour(X_WG.p) > head.reach + distance) return false;
  return std::ranges::any_of(head.surface_T,
                             [&](const dvec3& p_T) { return around_->neighbour(X_WG * p_T) < distance; });
}

}  // namespace typodont
