// Recorded sessions, and teeth imported from scans and meshes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/planning/imported_exercise.h"
#include "engine/base/progress.h"
#include "haptics/import/import.h"

namespace typodont {

/// A score from the cache.
struct CachedScore {
  double points = 0;  // points of the session, 0..100
  bool counts = false, passed = false;
};

struct SessionEntry {
  std::filesystem::path file;
  std::string scene, trainee, date;  // parts of the name of the recording's file
  std::string title;                 // of the exercise, in the user's language; empty: unknown
  // empty: not computed yet, or no recording
  std::optional<CachedScore> score;
  double megabytes = 0;
  bool report = false;   // true: a report exists beside the recording
  bool recorded = true;  // false: only a saved preparation
};
/// Of all trainees, newest first.
std::vector<SessionEntry> find_sessions();

/// Copies a session to the trainee "expert", with whom later reports compare. Throws Error.
void make_expert(const std::filesystem::path& session);

struct NewTooth {
  std::filesystem::path input;  // a scan or closed mesh; as_scanned: any mesh
  /// more meshes of this mouth, one may be a bite scan; `crown` is then computed from `input`
  std::vector<std::filesystem::path> more;
  double open = 0;  // m, by which the opposing jaw is moved away for an instrument
  std::string name;
  /// cut as mesh by vertex, may be open; false: converted to a volume
  bool as_scanned = false;
  haptics::ImportOptions options;
  Crown crown = Crown::kUp;
};
/// A scene for practice from a volume or mesh, upright, where the shipped rigs show it. Replaces files of the same name
/// in the user's folder. Returns the scene. Throws Error or Cancelled without changing a file.
std::filesystem::path import_tooth(const NewTooth& tooth, Progress& progress);

/// The same for tissue in memory, which this function turns upright. `top`: m, point for the shown place; empty: middle
/// of the top.
std::filesystem::path write_exercise_of(const NewTooth& tooth, haptics::Imported imported, Progress& progress,
                                        const std::optional<dvec3>& top = {});

/// Final or saved tissue as a surface, .stl, .ply or .obj. Throws Error or Cancelled.
void export_surface(const std::filesystem::path& session, const std::filesystem::path& mesh, Progress& progress);

/// Learning curve of a folder's sessions. Throws Error or Cancelled.
void write_learning_curve(const std::filesystem::path& folder, const std::filesystem::path& page, int language,
                          Progress& progress);

}  // namespace typodont
