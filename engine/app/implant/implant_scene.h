// A scene's "implant": the set of instruments, the plan and the procedure, read and checked.
#pragma once

#include <filesystem>
#include <span>

#include "engine/app/assets.h"
#include "engine/base/json.h"
#include "engine/session/implant.h"
#include "haptics/tissue_volume.h"
#include "haptics/tool.h"

namespace typodont {

/// A tool of a set: FOLDER/NAME.json. Throws Error naming the tools there are.
haptics::Tool load_set_tool(const std::filesystem::path& folder, const Json& name);

/// {"procedure": FILE, "plan": {…}, "neighbours": […]} of a scene (docs/interface.md). `tissue`: the scene's, for the
/// canal; `tools`: the session's. Throws Error, also for a phase whose tool is not among them.
session::ImplantTask read_implant(const Json& implant, const Json& tissue, std::span<const haptics::Tool> tools,
                                  const ScenePlace& place);

/// Throws Error where the tissue has no grey values, or the planned implant does not lie in bone. `file`: of the scene.
void check_plan(const session::ImplantTask& task, const haptics::TissueVolume& tissue,
                const std::filesystem::path& file);

/// Adds what only the tissue tells: diameter and ovality of the bed, where its wall is open, what the implant touches.
void measure_bed(const session::ImplantTask& task, const haptics::TissueVolume& after,
                 session::ImplantMeasures& measures);

}  // namespace typodont
