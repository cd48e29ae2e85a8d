// Files of assets/handpieces/, and the rule that chooses the handpiece of a tool.
#pragma once

#include <string>

#include "engine/base/json.h"
#include "engine/contract/handpiece.h"
#include "haptics/spindle.h"
#include "haptics/tool.h"

namespace typodont {

/// Name of the file in assets/handpieces/ of the handpiece that holds the tool; empty if none does. The first rule
/// that applies decides: the tool's own "handpiece"; none for a head wider than 8 mm; a gauge or a ratchet for such
/// implant tools; a handle for a tool that does not turn; the shank in the ISO 6360 code (1xx: straight handpiece,
/// 2xx: contra-angle); the motor's "handpiece"; a turbine.
std::string handpiece_name(const haptics::Tool& tool, const haptics::Spindle& spindle);

/// Reads a handpiece (docs/interface.md). Throws Error.
Handpiece read_handpiece(const Json& json);
/// Loads a file of assets/handpieces/. `place`: the key that names the file, for the error message. Throws Error that
/// lists the available names.
Handpiece load_handpiece(const std::string& name);

/// Reads the key "handpieces" of a scene. Throws Error.
HandpieceView read_handpiece_view(const Json& json);

}  // namespace typodont
