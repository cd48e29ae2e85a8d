// Reads and checks the block "implant" of a scene: the instruments, the plan and the procedure.
#pragma once

#include <cmath>
#include <filesystem>
#include <span>

#include "engine/app/assets.h"
#include "engine/base/json.h"
#include "engine/base/units.h"
#include "engine/session/implant.h"
#include "haptics/tissue_volume.h"
#include "haptics/tool.h"

namespace typodont {

/// Loads a tool of an instrument set from FOLDER/NAME.json. Throws Error that names the available tools.
haptics::Tool load_set_tool(const std::filesystem::path& folder, const Json& name);

/// Returns the path of assets/implants/exercise.json, which contains the parts that all implant exercises have in
/// common.
std::filesystem::path implant_exercise_file();

/// Reads the block {"procedure": FILE, "plan": {…}, "neighbours": […], "canal": {…}} of a scene (docs/scene_format.md).
/// `tissue`: JSON of the scene's tissue; a tissue of kind "bone" contains the nerve canal. `tools`: the session's
/// tools. Throws Error, also if the tool of a phase is not among the tools.
session::ImplantTask read_implant(const Json& implant, const Json& tissue, std::span<const haptics::Tool> tools,
                                  const ScenePlace& place);

/// m, depth below the implant's upper end; above this depth, an implant need not be surrounded by bone everywhere
inline constexpr double kCrest = 1.5e-3;

/// Calls visit(p_W, depth) for points on the surface of the planned implant's thread, from the depth kCrest down to the
/// apex (lower end). It ends early if visit() returns false.
template <class Visit>
void for_thread_surface(const session::ImplantPlan& plan, Visit visit) {
  constexpr int kDown = 8, kAround = 24;
  const dquat R = rotation_between({0, 0, -1}, plan.axis_W);
  for (int d = 0; d <= kDown; ++d) {
    const double depth = kCrest + (plan.length - kCrest) * d / kDown;
    for (int i = 0; i < kAround; ++i) {
      const double a = 2 * kPi * i / kAround, r = plan.diameter / 2;
      const dvec3 p_W = plan.entry_W + depth * plan.axis_W + R * dvec3(r * std::cos(a), r * std::sin(a), 0);
      if (!visit(p_W, depth)) return;
    }
  }
}

/// Throws Error if the tissue has no grey values. `file`: the scene's file, whose name the message contains.
void require_greys(const haptics::TissueVolume& tissue, const std::filesystem::path& file);
/// Throws Error if the tissue has no grey values, or if the planned implant does not lie in bone. `file`: the scene's
/// file, whose name the message contains.
void check_plan(const session::ImplantTask& task, const haptics::TissueVolume& tissue,
                const std::filesystem::path& file);

/// Adds the measures that are computed from the final tissue: diameter and ovality of the bed (drilled hole), openings
/// in its wall, and contact of the implant with bone. If the scene lists no neighbouring roots, it also adds the
/// distance to the nearest tooth.
void measure_bed(const session::ImplantTask& task, const haptics::TissueVolume& after,
                 session::ImplantMeasures& measures);

}  // namespace typodont
