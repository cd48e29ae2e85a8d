// From a recording to its report: the tissue made again, judged, meshed and compared.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "engine/app/scene.h"
#include "engine/session/report.h"
#include "haptics/tissue_volume.h"

namespace typodont {

class Progress;

/// Everything the report shows beyond the file itself. Where the tissue is not at hand, the volumes in the file are
/// all, and a message says so.
session::ReportOptions report_of(const session::SessionReader& session);

/// The surface of a result, and how far it is off the task's ideal, without a recording. Throws Error where the scene's
/// tissue or its ideal cannot be made.
session::ReportOptions result_of(const Scene& scene, const haptics::TissueVolume& after);

/// The score as report_of has it, without pictures.
session::SessionSummary summary_of(const session::SessionReader& session);
/// The same by the rules of `scene` (judge_session). Throws Error where its tissue or its ideal cannot be made.
session::SessionSummary summary_of(const session::SessionReader& session, const Scene& scene);

/// Of all sessions in `folder`, by their files' names; what cannot be read is left out, and said. Throws Error where
/// there is none, Cancelled.
std::vector<session::SessionSummary> sessions_in(const std::filesystem::path& folder, Progress& progress);

/// Sessions in `folder` of the same scene and trainee, made before this one; oldest first. What is no session is passed
/// over.
std::vector<session::SessionSummary> earlier_sessions(const std::filesystem::path& folder,
                                                      const session::SessionReader& session);

/// The newest session in `folder` of the same scene, whoever made it, other than this one.
std::optional<session::SessionSummary> expert_session(const std::filesystem::path& folder,
                                                      const session::SessionReader& session);

}  // namespace typodont
