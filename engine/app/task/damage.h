// Damage to neighbouring teeth and gum, which are not in the haptic field: the rotating head is moved through their
// distance fields. A recording gives the same. Far away it costs two queries per tick.
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

/// Every tick in order, in groups of any size. One thread only.
class DamageMeter {
 public:
  /// ServoTick::tool is an index in `tools`.
  DamageMeter(SurroundingsShape shape, std::span<const haptics::Tool> tools);
  void add(std::span<const ServoTick> ticks);
  session::DamageMeasures result() const;

 private:
  struct Head {
    bool turns = false;
    double reach = 0;  // m, from the head's centre to its farthest point
    haptics::HeadField field;
  };
  void sweep(const ServoTick& tick, const Head& head);

  SurroundingsShape shape_;
  std::vector<Head> heads_;
  std::unordered_set<std::uint64_t> neighbour_, gum_;  // cells that the bur has entered
  std::optional<Pose> last_;                           // of the head, at the last evaluation
  std::uint32_t last_tool_ = 0;
  std::vector<session::DamageMeasures::Touch> touches_;
  Nanos touched_[2] = {};     // ns, last touch of neighbour and gum
  std::size_t open_[2] = {};  // index in touches_ plus 1
  double most_[2] = {};       // m³, of one tick of the open touch
};

struct Scene;
/// Empty without neighbours and gum. Throws Error.
std::optional<DamageMeter> damage_meter(const Scene& scene);

}  // namespace typodont
