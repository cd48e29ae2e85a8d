// Finds recorded sessions, and imports teeth from scans and meshes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/cases/mastery.h"
#include "engine/app/planning/imported_exercise.h"
#include "engine/base/progress.h"
#include "haptics/import/import.h"

namespace typodont {

/// A score that is stored in the cache.
struct CachedScore {
  double points = 0;  // points of the session, 0..100
  bool counts = false, passed = false;
  double completion = 1;  // completed fraction of the task
  std::string date;       // of the recording, ISO 8601; empty: unknown
  std::vector<ItemPoints> items;
  std::optional<CaseIdentity> made;  // the generated case; empty: another exercise
};

struct SessionEntry {
  std::filesystem::path file;
  std::string scene, trainee, date;  // parts of the name of the recording's file
  std::string title;                 // title of the exercise in the user's language; empty: unknown
  // The session's score. Empty: not yet computed, or there is no recording.
  std::optional<CachedScore> score;
  double megabytes = 0;
  bool report = false;   // true: there is a report in the recording's folder
  bool recorded = true;  // false: there is only a saved preparation
};
/// Sessions of all trainees, newest first.
std::vector<SessionEntry> find_sessions();

/// Copies a session to the trainee "expert"; later reports compare other sessions with it. Throws Error.
void make_expert(const std::filesystem::path& session);

struct NewTooth {
  std::filesystem::path input;  // a scan or a closed mesh; if `as_scanned`, any mesh
  /// More meshes of the same mouth, for example a bite scan. The direction `crown` is then computed from `input`.
  std::vector<std::filesystem::path> more;
  double open = 0;  // m, distance by which the opposing jaw is moved away to make room for an instrument
  std::string name;
  /// True: the mesh itself, which may be open, is cut by moving its vertices. False: it is converted to a volume.
  bool as_scanned = false;
  haptics::ImportOptions options;
  Crown crown = Crown::kUp;
};
/// Makes a scene for practice from a volume or mesh, turned upright and moved to kCrownTop, which shipped rigs show.
/// Replaces the user's files of this name. Returns the scene file. If it throws (Error, Cancelled), no file changes.
std::filesystem::path import_tooth(const NewTooth& tooth, Progress& progress);

/// Makes a scene for practice from tissue in memory, which it turns upright. `top`: point
/// that is moved to kCrownTop, the place that the shipped rig files' displays show, m; empty: the middle of the top.
std::filesystem::path write_exercise_of(const NewTooth& tooth, haptics::Imported imported, Progress& progress,
                                        const std::optional<dvec3>& top = {});

}  // namespace typodont
