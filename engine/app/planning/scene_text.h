// Makes JSON text for scene files that the program writes.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "engine/app/scene.h"

namespace typodont {

/// The scene's JSON text for a file in another folder: paths that are relative to the scene's folder become absolute.
/// Paths to shipped files do not change.
nlohmann::ordered_json scene_for_other_folder(const Scene& scene);

/// Converts a point to text for a scene: [x, y, z] in millimetres, rounded to micrometres. `p`: m.
nlohmann::ordered_json millimetres_text(const dvec3& p);

}  // namespace typodont
