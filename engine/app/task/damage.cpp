#include "engine/app/task/damage.h"

#include <algorithm>
#include <cmath>

#include "engine/app/scene.h"
#include "engine/base/voxels.h"
#include "engine/session/defect.h"

namespace typodont {

namespace {

constexpr double kDamageCell = 0.1e-3;  // m, size of the cells in which the damaged volume is measured
constexpr double kVolume = kDamageCell * kDamageCell * kDamageCell;
// Motion of the tool's head between two evaluations of the damage, m.
constexpr double kMoved = 0.01e-3;
// Cuts of a neighbour or the gum that are less deep than this do not count as damage, m.
constexpr double kDamageTolerance = 0.01e-3;

std::uint64_t cell_of(const dvec3& p_W) {
  constexpr double kHalf = 1 << 20;
  const auto at = [](double v) {
    return static_cast<std::uint64_t>(std::clamp(std::floor(v / kDamageCell) + kHalf, 0.0, 2 * kHalf - 1));
  };
  return at(p_W.x) << 42 | at(p_W.y) << 21 | at(p_W.z);
}

}  // namespace

DamageMeter::DamageMeter(SurroundingsShape shape, std::span<const haptics::Tool> tools) : shape_(std::move(shape)) {
  for (const haptics::Tool& tool : tools) heads_.push_back({tool.turns(), tool.reach(), haptics::HeadField(tool, 1)});
}

void DamageMeter::add(std::span<const ServoTick> ticks) {
  for (const ServoTick& tick : ticks) {
    const Head& head = heads_[std::min<std::size_t>(tick.tool, heads_.size() - 1)];
    if (!head.turns || !(tick.spindle > 0) || !is_finite(tick.X_WG.p)) continue;
    const double near = head.reach + kDamageCell;
    if (shape_.neighbour(tick.X_WG.p) > near && shape_.gum(tick.X_WG.p) > near) continue;
    if (last_ && last_tool_ == tick.tool && displacement_bound(*last_, tick.X_WG, head.reach) < kMoved) continue;
    last_ = tick.X_WG;
    last_tool_ = tick.tool;
    sweep(tick, head);
  }
}

void DamageMeter::sweep(const ServoTick& tick, const Head& head) {
  const std::size_t before[2] = {neighbour_.size(), gum_.size()};
  dvec3 place_W[2];
  const glm::dmat3 R_TW = glm::transpose(glm::dmat3(tick.X_WG.R));
  const glm::ivec3 lo(glm::floor((tick.X_WG.p - head.reach) / kDamageCell)),
      hi(glm::floor((tick.X_WG.p + head.reach) / kDamageCell));
  for_each_voxel_between(lo, hi, [&](int x, int y, int z) {
    const dvec3 p_W = (dvec3(x, y, z) + 0.5) * kDamageCell;
    if (head.field.distance(R_TW * (p_W - tick.X_WG.p)) > 0) return;
    if (shape_.neighbour(p_W) < -kDamageTolerance) {
      if (neighbour_.insert(cell_of(p_W)).second) place_W[0] = p_W;
      // The gum overlaps the tooth, so a point inside the tooth is no damage to the gum.
    } else if (shape_.gum(p_W) < -kDamageTolerance && shape_.tooth(p_W) > kDamageTolerance) {
      if (gum_.insert(cell_of(p_W)).second) place_W[1] = p_W;
    }
  });
  for (const bool gum : {false, true}) {
    const std::size_t cells = (gum ? gum_ : neighbour_).size() - before[gum];
    if (cells == 0) continue;
    const double volume = static_cast<double>(cells) * kVolume;
    if (open_[gum] == 0 || to_seconds(tick.t - touched_[gum]) > session::kStrokePause ||
        touches_[open_[gum] - 1].tool != tick.tool) {
      touches_.push_back({gum, tick.index, 0, 0, tick.tool, 0, {}});
      open_[gum] = touches_.size();
      most_[gum] = 0;
    }
    touched_[gum] = tick.t;
    session::DamageMeasures::Touch& touch = touches_[open_[gum] - 1];
    touch.last = tick.index;
    touch.volume += volume;
    if (volume > most_[gum]) most_[gum] = volume, touch.worst = tick.index, touch.p_W = place_W[gum];
  }
}

session::DamageMeasures DamageMeter::result() const {
  return {shape_.has_neighbours(), shape_.has_gum(), static_cast<double>(neighbour_.size()) * kVolume,
          static_cast<double>(gum_.size()) * kVolume, touches_};
}

std::optional<DamageMeter> damage_meter(const Scene& scene) {
  auto shape = monitored_shape(scene.surroundings);
  if (!shape) return std::nullopt;
  return DamageMeter(std::move(*shape), haptics::tool_set(scene.servo));
}

}  // namespace typodont
