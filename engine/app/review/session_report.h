// Prepares the data for the report of a recording: restores the tissue, computes the score, and meshes the surface.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "engine/app/scene.h"
#include "engine/session/report.h"
#include "haptics/tissue_volume.h"

namespace typodont {

class Progress;

/// Computes the report's data that is not in the session file. For a session of another force law, calls verify().
/// If the tissue is not available, the report contains only the volumes in the file, and a message.
session::ReportOptions report_of(const session::SessionReader& session);

/// Replays a session, and compares the result with its recording. Throws Error.
session::Verification verify(const session::SessionReader& session);

/// Computes the final surface and its distance from the target shape, for a session without a recording. Throws Error
/// if the scene's tissue or the target shape cannot be built.
session::ReportOptions result_of(const Scene& scene, const haptics::TissueVolume& after);

/// Computes the same score as report_of(), without pictures.
session::SessionSummary summary_of(const session::SessionReader& session);
/// Computes the summary with the score rules of `scene` instead of the recorded ones (see
/// evaluate_session). Throws Error if the scene's tissue or its target shape cannot be built.
session::SessionSummary summary_of(const session::SessionReader& session, const Scene& scene);

/// The summaries of all sessions below `folder`, sorted by file name relative to it. Unreadable files are skipped with
/// a message. Throws Error if there is no session, or Cancelled.
std::vector<session::SessionSummary> sessions_in(const std::filesystem::path& folder, Progress& progress);

/// The summaries of older sessions below `folder` with the same scene and trainee, oldest first. Skips files that are
/// not sessions.
std::vector<session::SessionSummary> earlier_sessions(const std::filesystem::path& folder,
                                                      const session::SessionReader& session);

/// The summary of the newest other session below `folder` with the same scene, by any trainee.
std::optional<session::SessionSummary> expert_session(const std::filesystem::path& folder,
                                                      const session::SessionReader& session);

}  // namespace typodont
