// What a bur does to what it should not touch: the neighbouring teeth and the gum of a scene's surroundings, which are
// not in the haptic field. Found from the ticks alone, so a recording says it again: the turning head, as it is drawn,
// swept through their field. A scene without surroundings pays nothing; away from them a tick costs two distances.
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

/// Feed it every tick in order, in pieces of any size. One thread.
class DamageMeter {
 public:
  /// `tools` as ServoTick::tool counts them.
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
  std::unordered_set<std::uint64_t> neighbour_, gum_;  // cells the bur was in
  std::optional<Pose> last_;                           // where it was looked at last
  std::uint32_t last_tool_ = 0;
  double first_ = -1;
};

/// Of this scene; nothing where it has no surroundings. Throws Error.
struct Scene;
std::optional<DamageMeter> damage_meter(const Scene& scene);

}  // namespace typodont
