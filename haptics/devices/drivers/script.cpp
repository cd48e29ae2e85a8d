// Driver for the addresses script:HAND.csv and script:HAND.json (haptics/scripted_hand.h).
#include "engine/base/error.h"
#include "haptics/devices.h"
#include "haptics/scripted_hand.h"

namespace typodont::haptics {

extern const Driver script_driver;
const Driver script_driver{
    .scheme = "script",
    .rest = "HAND.csv or HAND.json",
    .about = "a recorded or simulated hand from a file, in the workbench frame",
    .hardware = false,
    .open =
        [](const std::string& rest, const HandOptions& options) {
          if (rest.empty()) throw Error("script:", "", "no file", "script:HAND.csv or script:HAND.json");
          return open_scripted_hand(rest, options.rate, options.paced, options.tools);
        },
    .find = {},
};

}  // namespace typodont::haptics
