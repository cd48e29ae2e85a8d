// The user's own things: recorded sessions, and teeth brought in from scans and meshes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/progress.h"
#include "haptics/import/import.h"

namespace typodont {

/// What a session scored, as it is kept beside it from the time it was worked out.
struct KnownScore {
  double points = 0;  // of a hundred
  bool counts = false, passed = false;
};

struct SessionEntry {
  std::filesystem::path file;
  std::string scene, trainee, date;  // as the file's name has them
  std::string title;                 // of the exercise in the reader's language; empty: not known
  std::optional<KnownScore> score;   // nothing: not worked out yet, or a preparation without its course
  double megabytes = 0;
  bool report = false;   // there is one beside it
  bool recorded = true;  // else a preparation as it was saved, without its course
};
/// Of all trainees, newest first.
std::vector<SessionEntry> find_sessions();

/// From now on reports of this exercise compare with this session: a copy of it, as the trainee "expert"'s. Throws
/// Error.
void make_expert(const std::filesystem::path& session);

/// Which way the crown of an imported tooth points in its file.
enum class Crown { kUp, kDown, kRight, kLeft, kBack, kFront };  // +z −z +x −x +y −y

struct NewTooth {
  std::filesystem::path input;  // scan or closed mesh; as_scanned: any mesh
  std::string name;
  bool as_scanned = false;  // the mesh itself is carved, by the contact model vertex; open ones too
  haptics::ImportOptions options;
  Crown crown = Crown::kUp;
};
/// Makes a volume of it, or a mesh of millimetres, stood upright where the shipped rigs look, and a scene to practise
/// on; both in the user's folder, in the place of any of that name. Returns the scene. Throws Error, Cancelled: then
/// nothing has changed.
std::filesystem::path bring_in(const NewTooth& tooth, Progress& progress);

/// The tissue as a session left it, or as it was saved, as a surface: .stl, .ply or .obj. Throws Error, Cancelled.
void export_surface(const std::filesystem::path& session, const std::filesystem::path& mesh, Progress& progress);

/// The page of a folder of sessions. Throws Error, Cancelled.
void write_learning_curve(const std::filesystem::path& folder, const std::filesystem::path& page, int language,
                          Progress& progress);

}  // namespace typodont
