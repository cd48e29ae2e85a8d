#include "engine/app/session_start.h"

#include "engine/app/recording/replay_hand.h"
#include "engine/app/recording/resume.h"
#include "haptics/scripted_hand.h"

namespace typodont {

std::unique_ptr<haptics::HapticDevice> open_unpaced_hand(const Scene& scene, const std::string& address, double rate) {
  if (address.starts_with("replay:"))
    return open_replay_hand(session::SessionReader(address.substr(7)), rate, /*paced=*/false);
  const std::string file = address.starts_with("script:") ? address.substr(7) : address;
  return haptics::open_scripted_hand(file, rate, /*paced=*/false, tool_names(scene));
}

SteppedSession start_session(const Scene& scene, const haptics::DeviceInfo& hand) {
  return SteppedSession(scene, load_tissue(scene), hand);
}

}  // namespace typodont
