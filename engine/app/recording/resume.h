// Continues an unfinished preparation, from a saved volume or from the end of a recorded session. The score still
// compares the result with the scene's untouched tissue, not with the tissue at which the work continues.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "engine/session/session_file.h"

namespace typodont {

/// Returns a copy of the scene that begins with the tissue in `from`, a volume (.vdb) or a session (.h5). Throws Error
/// if the file is neither.
Scene with_resume(const Scene& scene, const std::filesystem::path& file);

/// Loads the tissue at the start of a session with this scene. It is the scene's own tissue, or the unfinished
/// preparation that the scene continues. If the preparation comes from a recorded session, the strokes of this session
/// can be undone. Throws Error, also if the preparation's voxel grid differs from that of the scene's own tissue.
haptics::TissueVolume load_tissue(const Scene& scene);

/// Tissue that a file contains, for commands that write it in other formats.
struct StoredTissue {
  haptics::TissueVolume volume;
  MaterialTable materials;
  // true: the scene's contact model carves a triangle mesh, and the tissue's surface is this mesh (volume.mesh())
  bool draws_own = false;
};
/// Loads the tissue of a volume (.vdb), of a scene, or of a session (.h5) at its end. `progress` is called with 0..1
/// and may throw. Throws Error.
StoredTissue stored_tissue(const std::filesystem::path& file, const std::function<void(double)>& progress = {});

/// Converts an undo or redo to an event of the recording, and back. For an event of another kind, edit_of() returns an
/// empty optional. Throws Error if the text of the event is damaged.
session::SessionEvent event_of(const StrokeEdit& edit);
std::optional<StrokeEdit> edit_of(const session::SessionEvent& event);

/// Returns all undos and redos of a recording, in order.
std::vector<StrokeEdit> edits_of(const session::SessionReader& session);

/// Makes the event for a loose piece of tissue. Only the report uses this event; a replay computes the piece again.
session::SessionEvent event_of(const LoosePiece& piece);

}  // namespace typodont
