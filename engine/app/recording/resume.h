// Going on with a half-done preparation: from a saved volume, or from where a recorded session ended. What counts as
// the untouched tissue stays the scene's own.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "engine/session/session_file.h"

namespace typodont {

/// The scene as it is, going on from this volume (.vdb) or session (.h5). Throws Error when it is neither.
Scene with_resume(const Scene& scene, const std::filesystem::path& file);

/// The tissue that a session of this scene begins with: the untouched one, or the one that the scene goes on from. A
/// recorded session's tissue comes with its strokes, which can still be undone. Throws Error, also when what the scene
/// goes on from is not of the scene's own tissue.
haptics::TissueVolume load_tissue(const Scene& scene);

/// What a recording says of a stroke taken back or brought again, and the way back; nothing for other events. Throws
/// Error when the event's text is damaged.
session::SessionEvent event_of(const StrokeEdit& edit);
std::optional<StrokeEdit> edit_of(const session::SessionEvent& event);

/// All that a recording holds, in their order.
std::vector<StrokeEdit> edits_of(const session::SessionReader& session);

/// A loose piece, for the report: a replay finds it by itself.
session::SessionEvent event_of(const LoosePiece& piece);

}  // namespace typodont
