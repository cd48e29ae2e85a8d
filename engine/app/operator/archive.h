// The user's own data: recorded sessions, and teeth imported from scans and meshes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/progress.h"
#include "haptics/import/import.h"

namespace typodont {

/// Score of a session from the cache.
struct CachedScore {
  double points = 0;  // points out of 100
  bool counts = false, passed = false;
};

struct SessionEntry {
  std::filesystem::path file;
  std::string scene, trainee, date;  // parts of the file name
  std::string title;                 // title of the exercise in the reader's language; empty: unknown
  // score; empty: not yet computed, or a preparation that was saved without a recording
  std::optional<CachedScore> score;
  double megabytes = 0;
  bool report = false;   // a report exists beside the recording
  bool recorded = true;  // false: a preparation that was saved without a recording
};
/// The sessions of all trainees, newest first.
std::vector<SessionEntry> find_sessions();

/// Copies this session to the trainee "expert", so that reports of its exercise compare with it. Throws Error.
void make_expert(const std::filesystem::path& session);

/// Direction of the crown of an imported tooth in its file.
enum class Crown { kUp, kDown, kRight, kLeft, kBack, kFront };  // directions +z −z +x −x +y −y, in this order

struct NewTooth {
  std::filesystem::path input;  // a scan or a closed mesh; with as_scanned, any mesh
  std::string name;
  bool as_scanned = false;  // carves the mesh itself with the contact model vertex; also for open meshes
  haptics::ImportOptions options;
  Crown crown = Crown::kUp;
};
/// Converts the input to a volume, or to a mesh in millimetres, and creates a scene for practice. The tissue is placed
/// upright at the point that the shipped rigs show. Both files are written to the user's folder and replace files of
/// the same name. Returns the scene's file. Throws Error or Cancelled; then nothing has changed.
std::filesystem::path import_tooth(const NewTooth& tooth, Progress& progress);

/// The same for tissue that is already imported, but not turned upright.
std::filesystem::path write_exercise_of(const NewTooth& tooth, haptics::Imported imported, Progress& progress);

/// Writes the final tissue of a session, or a saved tissue, as a surface: .stl, .ply or .obj. Throws Error, Cancelled.
void export_surface(const std::filesystem::path& session, const std::filesystem::path& mesh, Progress& progress);

/// Writes the learning curve of a folder of sessions. Throws Error, Cancelled.
void write_learning_curve(const std::filesystem::path& folder, const std::filesystem::path& page, int language,
                          Progress& progress);

}  // namespace typodont
