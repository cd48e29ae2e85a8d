// Reads and checks a scene's "implant": the set of instruments, the plan and the procedure.
#pragma once

#include <filesystem>
#include <span>

#include "engine/app/assets.h"
#include "engine/base/json.h"
#include "engine/session/implant.h"
#include "haptics/tissue_volume.h"
#include "haptics/tool.h"

namespace typodont {

/// Loads a tool of a set from FOLDER/NAME.json. Throws Error that names the available tools.
haptics::Tool load_set_tool(const std::filesystem::path& folder, const Json& name);

/// Reads {"procedure": FILE, "plan": {…}, "neighbours": […]} of a scene (docs/interface.md). `tissue`: the scene's, for
/// the canal; `tools`: the session's. Throws Error, also if the tool of a phase is not among them.
session::ImplantTask read_implant(const Json& implant, const Json& tissue, std::span<const haptics::Tool> tools,
                                  const ScenePlace& place);

/// Throws Error if the tissue has no grey values, or if the planned implant does not lie in bone. `file`: the scene's.
void check_plan(const session::ImplantTask& task, const haptics::TissueVolume& tissue,
                const std::filesystem::path& file);

/// Adds the measures that need the final tissue: diameter and ovality of the bed, openings in its wall, contact of the
/// implant with bone.
void measure_bed(const session::ImplantTask& task, const haptics::TissueVolume& after,
                 session::ImplantMeasures& measures);

}  // namespace typodont
