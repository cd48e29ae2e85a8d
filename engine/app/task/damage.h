// Measures damage to neighbouring teeth and gum, which the hand does not feel: the volume that the rotating head
// enters. A replay gives the same result. Far from teeth and gum, a tick costs two distance queries.
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

/// Call add() with all ticks in order, in any number of calls. One thread only.
class DamageMeter {
 public:
  /// `tools`: the session's tools; ServoTick::tool is an index into them.
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
  std::unordered_set<std::uint64_t> neighbour_, gum_;  // cells that the bur has entered
  std::optional<Pose> last_;                           // pose of the head at the last evaluation
  std::uint32_t last_tool_ = 0;
  std::vector<session::DamageMeasures::Touch> touches_;
  Nanos touched_[2] = {};     // ns, times of the last touches of neighbours and gum
  std::size_t open_[2] = {};  // index of the current touch in touches_ plus 1; 0: no touch
  double most_[2] = {};       // m³, largest volume damaged in one tick of the current touch
};

struct Scene;
/// The meter of a scene; empty if it has neither neighbours nor gum. Throws Error.
std::optional<DamageMeter> damage_meter(const Scene& scene);

}  // namespace typodont
