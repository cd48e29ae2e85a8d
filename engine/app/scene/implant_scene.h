// Reads a scene's block "implant": instruments, plan and procedure.
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <span>

#include "engine/app/assets.h"
#include "engine/app/tissue/bone_tissue.h"
#include "engine/base/json.h"
#include "engine/base/units.h"
#include "engine/session/implant.h"
#include "haptics/tissue_volume.h"
#include "haptics/tool.h"

namespace typodont {

/// Loads FOLDER/NAME.json. Throws Error that names the available tools.
haptics::Tool load_set_tool(const std::filesystem::path& folder, const Json& name);

/// Index of the scene's tool with this name. Throws Error that lists the scene's tools.
std::uint32_t tool_named(const Json& name, std::span<const haptics::Tool> tools);

/// Path of assets/implants/exercise.json, the part that all implant exercises share.
std::filesystem::path implant_exercise_file();

/// The keys of the block "implant". `bones`: nerve canal that the tissue of kind "bone"
/// contains; may be empty. `tools`: the session's tools. Throws Error, also if a phase's tool is missing.
void describe_implant(Keys& keys, session::ImplantTask& task, const NerveCanal& bones,
                      std::span<const haptics::Tool> tools, const ScenePlace& place);
/// Declares the keys of a procedure file.
void describe_procedure(Keys& keys, session::ImplantTask& task, std::span<const haptics::Tool> tools);

/// Depth below the implant's upper end, m. The part of the implant above this depth need not be surrounded by bone.
inline constexpr double kCrest = 1.5e-3;

/// Calls visit(p_W, depth) for points on the thread's surface, from depth kCrest to the apex, until it returns false.
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

/// Throws Error if the tissue has no grey values. `file`: the scene file, named in the message.
void require_greys(const haptics::TissueVolume& tissue, const std::filesystem::path& file);
/// Throws Error if the tissue has no grey values, or if the planned implant is not in bone.
void check_plan(const session::ImplantTask& task, const haptics::TissueVolume& tissue,
                const std::filesystem::path& file);

/// Measures the final tissue: diameter, ovality and openings of the drilled hole, and
/// contact with bone. If no roots are listed, also the distance to the nearest tooth.
void measure_bed(const session::ImplantTask& task, const haptics::TissueVolume& after,
                 session::ImplantMeasures& measures);

}  // namespace typodont
