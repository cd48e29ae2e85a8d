#include "engine/app/recording/replay_hand.h"

#include "engine/base/error.h"
#include "haptics/devices.h"
#include "haptics/scripted_hand.h"

namespace typodont {

std::unique_ptr<haptics::HapticDevice> open_replay_hand(const session::SessionReader& session, double rate,
                                                        bool paced) {
  haptics::HandPath path;
  path.chooses_tools = true;
  for (const ServoTick& tick : session.ticks()) {
    const double t = to_seconds(tick.t);
    if (!path.rows.empty() && t <= path.rows.back().t) continue;
    path.rows.push_back({t, tick.X_WT, tick.pedal, dvec3(0), tick.tool});
  }
  if (path.rows.empty()) throw Error(session.file().string(), "", "no ticks", "a recorded session");
  return haptics::make_scripted_hand(std::move(path), rate, paced);
}

void add_replay_driver() {
  haptics::Driver driver;
  driver.scheme = "replay";
  driver.rest = "SESSION.h5";
  driver.about = "the hand of a recorded session";
  driver.hardware = false;
  driver.open = [](const std::string& rest, const haptics::HandOptions& options) {
    return open_replay_hand(session::SessionReader(rest), options.rate, options.paced);
  };
  haptics::add_driver(driver);
}

}  // namespace typodont
