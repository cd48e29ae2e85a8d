#include "engine/app/review/soft_gum_player.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace typodont {

namespace {

// N/m, stiffness of the tool in a replay. The recorded poses of the tool already contain its displacement by the gum.
// With this large stiffness, the gum does not displace the tool a second time.
constexpr double kRigid = 1e6;
constexpr std::uint64_t kBlock = 4096;  // number of ticks that are read from the file at a time

}  // namespace

SoftGumPlayer::SoftGumPlayer(const SessionPlayer& player, std::shared_ptr<const haptics::SoftSurface> surface,
                             const Surroundings& around)
    : player_(player), surface_(std::move(surface)), view_(surface_, around) {}

void SoftGumPlayer::follow() {
  const session::SessionReader& session = player_.session();
  const Nanos t = player_.tick().t;
  if (!tissue_ || t < last_t_) {
    tissue_.emplace(surface_, haptics::tool_set(player_.scene().servo), kRigid);
    view_.reset();
    next_ = 0;
  }
  for (bool more = true; more && next_ < session.tick_count();) {
    for (const ServoTick& tick : session.ticks(next_, std::min(kBlock, session.tick_count() - next_))) {
      if (tick.t > t) {
        more = false;
        break;
      }
      press(tick);
      ++next_;
    }
  }
  last_t_ = t;
  view_.take(*tissue_);
  view_.follow(t);
}

void SoftGumPlayer::press(const ServoTick& tick) {
  const auto tools = haptics::tool_set(player_.scene().servo);
  if (tick.tool >= tools.size() || !is_finite(tick.X_WG.p) || tissue_->at_rest(tick.X_WG, tick.tool)) return;
  const haptics::Tool& tool = tools[tick.tool];
  const double cutting = tool.turns() ? tool.cutting_coefficient * std::abs(tick.spindle) * tool.radius() : 0.0;
  tissue_->tick({tick.t, 1 / player_.session().header().servo_rate, tick.X_WG, tick.tool, cutting});
}

}  // namespace typodont
