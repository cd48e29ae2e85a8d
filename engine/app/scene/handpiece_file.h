// Reads assets/handpieces/, and chooses a tool's handpiece.
#pragma once

#include <string>

#include "engine/base/json.h"
#include "engine/contract/handpiece.h"
#include "haptics/spindle.h"
#include "haptics/tool.h"

namespace typodont {

/// Returns the file name of the tool's handpiece in assets/handpieces/; empty: none. The first rule that applies
/// decides:
///   1. the tool's own key "handpiece";
///   2. none for a head wider than 8 mm;
///   3. "gauge" for an implant tool of the kind gauge;
///   4. "ratchet" for an implant tool that is turned by hand;
///   5. a handle for a tool that does not turn;
///   6. a straight handpiece for a shank 1xx in the ISO 6360 code;
///   7. the motor's key "handpiece";
///   8. a contra-angle for a shank 2xx;
///   9. "turbine".
std::string handpiece_name(const haptics::Tool& tool, const haptics::Spindle& spindle);

/// Declares the keys of a handpiece file. Throws Error.
void describe_handpiece(Keys& keys, Handpiece& handpiece);
Handpiece read_handpiece(const Json& json);
/// Loads the file of assets/handpieces/ with this name. Throws Error that lists the available names.
Handpiece load_handpiece(const std::string& name);

/// The block "handpieces" of a scene: how handpieces are shown. Throws Error.
void describe_handpiece_view(Keys& keys, HandpieceView& view);

}  // namespace typodont
