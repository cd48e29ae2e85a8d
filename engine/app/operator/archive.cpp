#include "engine/app/operator/archive.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine/app/operator/library.h"
#include "engine/app/operator/session_scores.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/planning/mouth.h"
#include "engine/app/scene.h"
#include "engine/base/error.h"
#include "engine/base/folder.h"
#include "engine/base/log.h"
#include "engine/base/partial_file.h"
#include "engine/base/units.h"
#include "engine/surface/mesh_export.h"
#include "haptics/import/mesh_tissue.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

void stand_up(haptics::TissueMesh& mesh, Crown crown) {
  const std::string turn = upright_rotation(crown);
  if (turn.empty()) return;
  const glm::dmat3 by = haptics::quarter_turns(turn);
  for (dvec3& p : mesh.vertices) p = by * p;
}

/// Moves the mesh so that the middle of its top is at kCrownTop, the place that the shipped display rigs show. For
/// several teeth, moves their highest point there instead, because the middle may be empty.
void move_to_working_place(haptics::TissueMesh& mesh) {
  // A mesh wider than this contains several teeth, m.
  constexpr double kWidestTooth = 16e-3;
  dvec3 lo(mesh.vertices.front()), hi(lo), top(lo);
  for (const dvec3& p : mesh.vertices) {
    lo = glm::min(lo, p), hi = glm::max(hi, p);
    if (p.z > top.z) top = p;
  }
  if (std::max(hi.x - lo.x, hi.y - lo.y) <= kWidestTooth) top = dvec3((lo.x + hi.x) / 2, (lo.y + hi.y) / 2, hi.z);
  const dvec3 move = kCrownTop - top;
  for (dvec3& p : mesh.vertices) p += move;
}

/// Reads a mesh. Some scanners write metres: if a mesh in the default unit is too small for a tooth, it is read again
/// in metres.
haptics::ReadTissueMesh read_scanned(const NewTooth& tooth) {
  constexpr Tissue kTissue = Tissue::kEnamel;
  try {
    return haptics::read_tissue_mesh(tooth.input, tooth.options.mesh_unit, kTissue);
  } catch (const Error& e) {
    if (tooth.options.mesh_unit != kMillimetre) throw;
    try {
      haptics::ReadTissueMesh read = haptics::read_tissue_mesh(tooth.input, 1, kTissue);
      read.repairs.insert(read.repairs.begin(), "taken as metres: at a millimetre a unit it is too small");
      return read;
    } catch (const Error&) {
      throw e;  // reports the error of the first reading
    }
  }
}

/// The user's folder of scenes; created if it is missing.
fs::path own_scenes() {
  const fs::path folder = user_folder() / "scenes";
  make_folder(folder);
  return folder;
}

/// Imports a mesh as a scene without a volume.
fs::path bring_in_surface(const NewTooth& tooth, Progress& progress) {
  progress.stage("op.importing", 0, 1);
  haptics::ReadTissueMesh read = read_scanned(tooth);
  progress.at(0.5);
  stand_up(read.mesh, tooth.crown);
  move_to_working_place(read.mesh);
  std::string description = tooth.input.filename().string();
  for (const std::string& repair : read.repairs) description += fmt::format("; {}", repair);
  const fs::path folder = own_scenes();
  const std::string stem = file_name_of(tooth.name);
  const nlohmann::ordered_json scene = {
      {"name", tooth.name},
      {"description", description},
      {"tissue", {{"mesh", {{"file", stem + ".stl"}, {"unit_mm", 1}, {"tissue", "enamel"}}}}},
      {"model", "vertex"},
      {"tools", {"round_012", "round_014", "round_006", "explorer"}},
      {"spindle", "air_turbine"},
      {"parts", {"haptics", "render", "sound", "debris", "record", "score"}}};
  PartialFile file(folder / (stem + ".json"), FileKind::kJson, Over::kItsInput);
  write_file_atomically(file.path(), scene.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n",
                        FileKind::kJson);
  // From here on, the work cannot be cancelled, because files are now written under their final names.
  progress.at(1);
  const VoxelFrame in_place{dvec3(0), kMillimetre};
  surface::write_mesh(folder / (stem + ".stl"), whole_surface(read.mesh, in_place), in_place, load_materials(),
                      Over::kItsInput);
  file.keep();
  return file.file();
}

}  // namespace

std::vector<SessionEntry> find_sessions() {
  std::vector<SessionEntry> sessions;
  std::error_code code;
  for (const auto& trainee : fs::directory_iterator(user_folder() / "sessions", code)) {
    const std::string who = trainee.path().filename().string();
    if (who.starts_with(".") || !trainee.is_directory(code)) continue;
    for (const auto& entry : fs::directory_iterator(trainee.path(), code)) {
      SessionEntry session;
      session.recorded = entry.path().extension() == ".h5";
      if (!session.recorded && entry.path().extension() != ".vdb") continue;
      session.file = entry.path();
      session.trainee = who;
      // Form of the recording's name: DATE_TIME_SCENE, for example 2026-11-20_10-15-00_scene.
      const std::string stem = entry.path().stem().string();
      const bool dated = stem.size() > 20 && stem[10] == '_' && stem[19] == '_';
      session.scene = dated ? stem.substr(20) : stem;
      if (dated) {
        std::string clock = stem.substr(11, 5);
        std::replace(clock.begin(), clock.end(), '-', ':');
        session.date = stem.substr(0, 10) + "  " + clock;
      }
      session.megabytes = static_cast<double>(entry.file_size(code)) * 1e-6;
      session.report = fs::exists(fs::path(entry.path()).replace_extension(".html"), code);
      if (session.recorded) session.score = cached_score(session.file);
      sessions.push_back(std::move(session));
    }
  }
  std::sort(sessions.begin(), sessions.end(),
            [](const SessionEntry& a, const SessionEntry& b) { return a.file.filename() > b.file.filename(); });
  return sessions;
}

void make_expert(const fs::path& session) {
  const fs::path folder = expert_folder(session.parent_path());
  make_folder(folder);
  PartialFile copy(folder / session.filename(), FileKind::kSession, Over::kItsInput);
  std::error_code code;
  fs::copy_file(session, copy.path(), fs::copy_options::overwrite_existing, code);
  if (code) throw Error(copy.file().string(), "", code.message(), "a file that can be written");
  copy.keep();
}

fs::path import_tooth(const NewTooth& tooth, Progress& progress) {
  if (tooth.as_scanned && !tooth.more.empty())
    throw Error(tooth.more[0].string(), "", "a second mesh", "one mesh if the surface itself is carved");
  if (tooth.as_scanned) return bring_in_surface(tooth, progress);
  progress.stage("op.importing", 0, 0.9);
  haptics::ImportOptions options = tooth.options;
  options.progress = [&](double fraction) { progress.at(fraction); };
  if (tooth.more.empty()) return write_exercise_of(tooth, haptics::import_tissue(tooth.input, options), progress);
  std::vector<fs::path> meshes{tooth.input};
  meshes.insert(meshes.end(), tooth.more.begin(), tooth.more.end());
  MouthFiles files = mouth_files(meshes);
  files.open = tooth.open;
  ImportedMouth mouth = import_mouth(files, options);
  for (const std::string& note : mouth.imported.report.notes) log::info("note: {}", note);
  NewTooth placed = tooth;
  placed.crown = crown_along(mouth.up);
  return write_exercise_of(placed, std::move(mouth.imported), progress, mouth.top);
}

fs::path write_exercise_of(const NewTooth& tooth, haptics::Imported imported, Progress& progress,
                           const std::optional<dvec3>& top) {
  progress.stage("op.importing", 0.9, 1);
  const fs::path file = own_scenes() / (file_name_of(tooth.name) + ".json");
  // The names of DICOM files are left out, because they often contain patients' names.
  std::string description = imported.report.format == "DICOM" ? "DICOM" : tooth.input.filename().string();
  for (const fs::path& mesh : tooth.more) description += ", " + mesh.filename().string();
  write_imported_exercise({tooth.name, description, tooth.crown, top}, imported, file, Over::kItsInput, progress);
  return file;
}

}  // namespace typodont
