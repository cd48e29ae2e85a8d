// JSON text for scene files that the program writes.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "engine/app/scene.h"

namespace typodont {

/// The scene's text, in which absolute paths replace the paths that are relative to its folder. Paths to shipped
/// files do not change.
nlohmann::ordered_json scene_for_other_folder(const Scene& scene);

/// A point in a scene's text: [x, y, z] in millimetres, rounded to micrometres. `p`: m.
nlohmann::ordered_json millimetres_text(const dvec3& p);

}  // namespace typodont
