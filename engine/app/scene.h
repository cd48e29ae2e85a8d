// A scene file, read and checked: what is drilled, with what, and which parts of the program it needs.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engine/app/assets.h"
#include "engine/app/surroundings/plan.h"
#include "engine/app/tissue/drawn_as.h"
#include "engine/base/json.h"
#include "engine/contract/mouth_mirror.h"
#include "engine/debris/debris.h"
#include "engine/session/implant.h"
#include "engine/session/task.h"
#include "haptics/servo.h"
#include "haptics/tissue_volume.h"

namespace typodont {

struct Scene {
  std::filesystem::path file;
  ScenePlace place;  // beside `file`, unless the scene comes out of a recording
  std::string text;  // the file as read, for the record
  std::string name;
  std::set<std::string> parts;       // haptics, render, sound, debris, record, score
  haptics::ServoSettings servo;      // without the voxel frame, which comes with the tissue
  DrawnAs drawn_as;                  // tissues that look like others, e.g. a hidden lesion
  std::string motor;                 // named in assets/motors/; empty: an ideal one
  std::optional<Json> tissue;        // a volume, or solids
  std::vector<Json> paint;           // tissue painted into it, e.g. a lesion
  std::filesystem::path paint_file;  // strokes painted by hand; empty: none
  std::vector<Json> prepare;         // solids taken away before the session begins
  std::string resume;                // a volume or session to go on from; empty: the tissue is untouched
  std::optional<Json> score;
  std::optional<session::Task> task;
  std::optional<session::ImplantTask> implant;  // of an exercise in implant surgery
  bool vibration_band_set = false;  // the scene says how far the spindle's vibration goes; otherwise the hand's device
  std::optional<SurroundingsPlan> surroundings;  // what stands around the tooth
  MouthMirror mouth_mirror;                      // where the other hand holds it; diameter 0: none
  std::optional<debris::Suction> suction;        // where its nozzle is held; nothing: beside the tooth
  bool suction_on = false;                       // when the session begins
  bool sound_lower_order = false;                // models may be cut to the order at which nothing is lost

  bool needs(std::string_view part) const { return parts.contains(std::string(part)); }
};

/// Reads INTERFACE.md's scene. Throws Error for anything missing, unknown or out of range.
Scene read_scene(const std::filesystem::path& file);
/// The same from JSON; `file` is where its relative paths start from.
Scene parse_scene(const Json& json, const std::filesystem::path& file);
/// The same; the files that it names may lie where `place` says.
Scene parse_scene(const Json& json, const std::filesystem::path& file, const ScenePlace& place);

/// The file of the scene's volume, found; empty where the tissue is made of solids. Throws Error.
std::filesystem::path volume_file(const Scene& scene);

/// {"translation_mm", "normal" or "rotation_wxyz", "diameter_mm", "fog"}. Throws Error.
MouthMirror read_mouth_mirror(const Json& json);

/// Loads or samples the tissue as the scene begins, and paints into it. A scene that goes on from a half-done
/// preparation: see load_tissue() in recording/resume.h. Throws Error.
haptics::TissueVolume load_untouched(const Scene& scene);

/// The scene's servo settings completed for this tissue, servo rate (Hz) and what else the hand's device determines
/// (haptics::DeviceInfo); its vibration band (Hz) the scene may overrule.
haptics::ServoSettings servo_settings(const Scene& scene, const haptics::TissueVolume& tissue, double rate,
                                      double vibration_band = 0, double position_step = 0, bool gives_torque = true);

/// The contact model of the option --model instead of the scene's; nothing where `name` is empty. The scene's text,
/// which is recorded, then has it too. Throws Error, which names those there are.
void choose_model(Scene& scene, const std::string& name);
/// What the scene's contact model is called.
std::string_view model_name(const Scene& scene);
/// Whether pictures show triangles of its contact model's own, not the surface of the volume.
bool draws_own_surface(const Scene& scene);

/// What its tools are called, in their order.
std::vector<std::string> tool_names(const Scene& scene);

/// A tool or motor by name from assets/tools/ and assets/motors/. Throws Error listing the names there are.
haptics::Tool load_tool(std::string_view name);
haptics::Spindle load_spindle(std::string_view name);
/// assets/materials/hard_tissue.json.
MaterialTable load_materials();

}  // namespace typodont
