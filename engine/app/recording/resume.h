// Continues a partial preparation: from a saved volume, or from the end of a recorded session. The scene's own tissue
// still counts as the untouched tissue.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "engine/session/session_file.h"

namespace typodont {

/// Returns a copy of the scene that continues from this volume (.vdb) or session (.h5). Throws Error if the file is
/// neither.
Scene with_resume(const Scene& scene, const std::filesystem::path& file);

/// The tissue at the start of a session with this scene: the untouched tissue, or the tissue to continue from. The
/// tissue of a recorded session includes its strokes, which can be undone. Throws Error; also if that tissue does not
/// belong to the scene's own tissue.
haptics::TissueVolume load_tissue(const Scene& scene);

/// Converts an undo or redo to the event in a recording, and back. For other events, edit_of() returns an empty
/// optional. Throws Error if the event's text is damaged.
session::SessionEvent event_of(const StrokeEdit& edit);
std::optional<StrokeEdit> edit_of(const session::SessionEvent& event);

/// All edits of a recording, in order.
std::vector<StrokeEdit> edits_of(const session::SessionReader& session);

/// The event for a loose piece; the report uses it, but a replay computes the piece again.
session::SessionEvent event_of(const LoosePiece& piece);

}  // namespace typodont
