// A scene's JSON text for a scene file in another folder.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "engine/app/scene.h"

namespace typodont {

/// The scene's text with absolute paths instead of those that are relative to its folder. Paths to shipped files stay
/// as they are.
nlohmann::ordered_json scene_for_other_folder(const Scene& scene);

}  // namespace typodont
