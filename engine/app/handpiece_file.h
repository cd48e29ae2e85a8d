// Reads the files of assets/handpieces/, and chooses the handpiece of a tool.
#pragma once

#include <string>

#include "engine/base/json.h"
#include "engine/contract/handpiece.h"
#include "haptics/spindle.h"
#include "haptics/tool.h"

namespace typodont {

/// Returns the name of the file in assets/handpieces/ for the handpiece that holds the tool; empty if there is none.
/// The rules are tried in this order, and the first that applies decides: - the tool's own key "handpiece"; - no
/// handpiece for a head wider than 8 mm; - "gauge" for an implant tool of the kind gauge, and "ratchet" for an implant
/// tool that is turned by hand; - a handle for a tool that does not turn; - the shank in the ISO 6360 code (1xx:
/// straight handpiece, 2xx: contra-angle); - the motor's key "handpiece"; - "turbine".
std::string handpiece_name(const haptics::Tool& tool, const haptics::Spindle& spindle);

/// Reads a handpiece from JSON (docs/interface.md describes the keys). Throws Error.
Handpiece read_handpiece(const Json& json);
/// Loads the file of assets/handpieces/ with this name. Throws Error that lists the available names.
Handpiece load_handpiece(const std::string& name);

/// Reads the key "handpieces" of a scene: how handpieces are shown. Throws Error.
HandpieceView read_handpiece_view(const Json& json);

}  // namespace typodont
