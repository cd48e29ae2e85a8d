// The user's own data: recorded sessions, and teeth imported from scans and meshes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/planning/imported_exercise.h"
#include "engine/base/progress.h"
#include "haptics/import/import.h"

namespace typodont {

/// A session's score that was computed earlier and stored in a cache.
struct CachedScore {
  double points = 0;  // points of the session, 0..100
  bool counts = false, passed = false;
};

struct SessionEntry {
  std::filesystem::path file;
  std::string scene, trainee, date;  // parts of the name of the recording's file
  std::string title;                 // title of the exercise in the user's language; empty if it is unknown
  // score of the session; empty if it was not yet computed, or if there is no recording
  std::optional<CachedScore> score;
  double megabytes = 0;
  bool report = false;   // true: a report exists beside the recording
  bool recorded = true;  // false: the entry is only a saved preparation, without a recording
};
/// Finds the sessions of all trainees, newest first.
std::vector<SessionEntry> find_sessions();

/// Copies a session to the folder of the trainee "expert". Later reports of the same exercise compare their session
/// with this copy. Throws Error.
void make_expert(const std::filesystem::path& session);

struct NewTooth {
  std::filesystem::path input;  // a scan or a closed mesh; if as_scanned is true, any mesh
  /// other meshes of the same mouth; one of them may be a bite scan. If the list is not empty, the program computes the
  /// direction of the crown from the mesh `input`, and `crown` is not used.
  std::vector<std::filesystem::path> more;
  double open = 0;  // m, distance by which the opposing jaw is moved away, so that an instrument has room
  std::string name;
  /// true: the contact model vertex cuts the mesh itself, so an open mesh is also allowed; false: the input is
  /// converted to a volume
  bool as_scanned = false;
  haptics::ImportOptions options;
  Crown crown = Crown::kUp;
};
/// Converts the input to a volume, or to a mesh in millimetres, and creates a scene for practice. The tissue is turned
/// upright and moved to the point that the shipped display rigs show. Both files are written to the user's folder and
/// replace files of the same name. Returns the scene's file. Throws Error or Cancelled; then no file has changed.
std::filesystem::path import_tooth(const NewTooth& tooth, Progress& progress);

/// Does the same as import_tooth(), but for tissue that is already in memory. This function turns the
/// tissue upright, so the caller must not do so. `top`: m, point of the tissue that is moved to the point that the
/// display rigs show; empty: the middle of the tissue's top.
std::filesystem::path write_exercise_of(const NewTooth& tooth, haptics::Imported imported, Progress& progress,
                                        const std::optional<dvec3>& top = {});

/// Writes the final tissue of a session, or a saved tissue, as a surface. The extension of `mesh` is .stl, .ply or
/// .obj. Throws Error or Cancelled.
void export_surface(const std::filesystem::path& session, const std::filesystem::path& mesh, Progress& progress);

/// Writes the learning curve of all sessions in a folder to the file `page`. Throws Error or Cancelled.
void write_learning_curve(const std::filesystem::path& folder, const std::filesystem::path& page, int language,
                          Progress& progress);

}  // namespace typodont
