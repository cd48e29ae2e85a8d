// Prepares the report of a recording: restores, scores, meshes and compares the tissue.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "engine/app/scene.h"
#include "engine/session/report.h"
#include "haptics/tissue_volume.h"

namespace typodont {

class Progress;

/// Computes the data for the report that the session file lacks. If the tissue is not available, the report contains
/// only the volumes from the file, and a message.
session::ReportOptions report_of(const session::SessionReader& session);

/// The final surface and its distance from the task's ideal, for a session without a recording. Throws Error if the
/// scene's tissue or its ideal cannot be built.
session::ReportOptions result_of(const Scene& scene, const haptics::TissueVolume& after);

/// Computes the same score as report_of(), without pictures.
session::SessionSummary summary_of(const session::SessionReader& session);
/// Same as summary_of(), but by the rules of `scene` (evaluate_session). Throws Error if the scene's tissue or its
/// ideal cannot be built.
session::SessionSummary summary_of(const session::SessionReader& session, const Scene& scene);

/// Summaries of all sessions in `folder`, sorted by file name; unreadable files are skipped with a message. Throws
/// Error if there is no session, or Cancelled.
std::vector<session::SessionSummary> sessions_in(const std::filesystem::path& folder, Progress& progress);

/// Sessions in `folder` of the same scene and trainee that are older than this one; oldest first. Files that are not
/// sessions are skipped.
std::vector<session::SessionSummary> earlier_sessions(const std::filesystem::path& folder,
                                                      const session::SessionReader& session);

/// The newest other session in `folder` with the same scene, by any trainee.
std::optional<session::SessionSummary> expert_session(const std::filesystem::path& folder,
                                                      const session::SessionReader& session);

}  // namespace typodont
