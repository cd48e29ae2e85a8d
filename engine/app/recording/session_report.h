// From a recording to its report: the tissue made again, judged, meshed and compared.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "engine/session/report.h"

namespace typodont {

/// Everything the report shows beyond the file itself. Where the tissue is not at hand, the volumes in the file are all,
/// and a message says so.
session::ReportOptions report_of(const session::SessionReader& session);

/// The score as report_of has it, without pictures.
session::SessionSummary summary_of(const session::SessionReader& session);

/// Sessions in `folder` of the same scene and trainee, made before this one; oldest first. What is no session is passed
/// over.
std::vector<session::SessionSummary> earlier_sessions(const std::filesystem::path& folder,
                                                      const session::SessionReader& session);

/// The newest session in `folder` of the same scene, whoever made it, other than this one.
std::optional<session::SessionSummary> expert_session(const std::filesystem::path& folder,
                                                      const session::SessionReader& session);

}  // namespace typodont
