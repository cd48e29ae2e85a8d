// Damage that a bur does to the neighbouring teeth and the gum. These are not in the haptic field, so the damage is
// computed from the ticks alone: the rotating head of the drawn tool is swept through the fields of the surroundings.
// So a recording gives the same result. For a scene without surroundings there is no cost; far from the surroundings,
// a tick costs two distance queries.
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

/// Computes the damage from the ticks. Must get every tick in order, in pieces of any size. One thread.
class DamageMeter {
 public:
  /// `tools`: the tools of the session; ServoTick::tool is an index into them.
  DamageMeter(SurroundingsShape shape, std::span<const haptics::Tool> tools);
  void add(std::span<const ServoTick> ticks);
  session::DamageMeasures result() const;

 private:
  struct Head {
    bool turns = false;
    double reach = 0;  // m
    haptics::HeadField field;
  };
  void sweep(const ServoTick& tick, const Head& head);

  SurroundingsShape shape_;
  std::vector<Head> heads_;
  std::unordered_set<std::uint64_t> neighbour_, gum_;  // cells that the bur entered
  std::optional<Pose> last_;                           // pose at the last evaluation
  std::uint32_t last_tool_ = 0;
  double first_ = -1;
};

struct Scene;
/// The damage meter of a scene; empty if the scene has no neighbouring teeth or gum. Throws Error.
std::optional<DamageMeter> damage_meter(const Scene& scene);

}  // namespace typodont
