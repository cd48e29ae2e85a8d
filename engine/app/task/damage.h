// Damage of a bur to the neighbouring teeth and the gum of a scene's surroundings, which are not in the haptic field.
// It is computed from the ticks alone, so that a recording gives the same result: the rotating head of the drawn tool
// is swept through their field. A scene without surroundings has no cost; far from them a tick costs two distance
// queries.
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

/// Needs every tick in order, in pieces of any size. One thread.
class DamageMeter {
 public:
  /// `tools`: ServoTick::tool is an index into these.
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

/// The meter for a scene; nothing if it has no surroundings. Throws Error.
struct Scene;
std::optional<DamageMeter> damage_meter(const Scene& scene);

}  // namespace typodont
