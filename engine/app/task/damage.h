// Measures the damage that a bur does to the neighbouring teeth and the gum, which are not part of the haptic field.
// The damage is computed from the ticks: the head of the drawn tool, if it rotates, is moved through the distance
// fields of the surroundings. A recording gives the same result. If a scene has no surroundings, this takes no time. If
// the tool is far from them, it takes two distance queries per tick.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <unordered_set>
#include <vector>

#include "engine/app/surroundings/surroundings.h"
#include "engine/contract/contact.h"
#include "engine/session/score.h"
#include "haptics/tool.h"

namespace typodont {

/// Computes the damage from the ticks. It must receive every tick in order, in groups of any size. For one thread only.
class DamageMeter {
 public:
  /// `tools`: the tools of the session; ServoTick::tool is an index in this list.
  DamageMeter(SurroundingsShape shape, std::span<const haptics::Tool> tools);
  void add(std::span<const ServoTick> ticks);
  session::DamageMeasures result() const;

 private:
  struct Head {
    bool turns = false;
    double reach = 0;  // m, distance from the head's centre to its farthest point
    haptics::HeadField field;
  };
  void sweep(const ServoTick& tick, const Head& head);

  SurroundingsShape shape_;
  std::vector<Head> heads_;
  std::unordered_set<std::uint64_t> neighbour_, gum_;  // keys of the cells that the bur has entered
  std::optional<Pose> last_;                           // pose of the tool's head at the last evaluation
  std::uint32_t last_tool_ = 0;
  double first_ = -1;
};

struct Scene;
/// Makes the damage meter of a scene. Empty if the scene has neither neighbouring teeth nor gum. Throws Error.
std::optional<DamageMeter> damage_meter(const Scene& scene);

}  // namespace typodont
