// Continues an unfinished preparation, from a saved volume or the end of a recorded session. The score still compares
// the result with the scene's untouched tissue.
#pragma once

#include <filesystem>
#include <functional>

#include "engine/app/scene.h"
#include "engine/session/session_file.h"

namespace typodont {

/// A copy of the scene that begins with the tissue in `file`, a volume (.vdb) or a session (.h5). Throws Error if the
/// file is neither.
Scene with_resume(const Scene& scene, const std::filesystem::path& file);

/// Loads the tissue at the start of a session with this scene: the scene's own tissue, or the unfinished preparation
/// that it continues. Strokes of a continued session can be undone. Throws Error, also if the preparation's voxel grid
/// differs from that of the scene's own tissue.
haptics::TissueVolume load_tissue(const Scene& scene);

/// A file's tissue, for commands that write it in other formats.
struct StoredTissue {
  haptics::TissueVolume volume;
  MaterialTable materials;
  // True: the contact model carves a triangle mesh (volume.mesh()), which is the surface of the tissue.
  bool draws_own = false;
};
/// Loads the tissue of a volume (.vdb), of a scene, or of a session (.h5) at its end. `progress` is called with 0 to 1,
/// and may throw. Throws Error.
StoredTissue stored_tissue(const std::filesystem::path& file, const std::function<void(double)>& progress = {});

}  // namespace typodont
