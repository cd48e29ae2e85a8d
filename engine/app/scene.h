// A scene: its file is parsed and checked. Contains the tissue, the tools, and the parts of the program that it needs.
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
#include "engine/contract/handpiece.h"
#include "engine/contract/mouth_mirror.h"
#include "engine/contract/suction_tip.h"
#include "engine/debris/debris.h"
#include "engine/session/implant.h"
#include "engine/session/task.h"
#include "haptics/servo.h"
#include "haptics/tissue_volume.h"

namespace typodont {

struct Scene {
  std::filesystem::path file;
  ScenePlace place;  // folders for relative file names: the folder of the scene's file, or of the recording
  std::string text;  // text of the scene file
  std::string name;
  /// parts of the program that the scene needs: haptics, render, sound, debris, record, score
  std::set<std::string> parts;
  haptics::ServoSettings servo;      // servo settings except the voxel frame, which the tissue determines
  DrawnAs drawn_as;                  // tissues that are drawn like another tissue, e.g. a hidden lesion
  std::string motor;                 // name of a motor in assets/motors/; empty: an ideal motor
  std::optional<Json> tissue;        // the initial tissue: a volume or solids
  std::vector<Json> paint;           // tissue painted into the initial tissue, e.g. a lesion
  std::filesystem::path paint_file;  // file with manually painted strokes; empty: none
  std::vector<Json> prepare;         // solids that are removed from the tissue before the session begins
  std::string resume;  // volume or session from which to continue; empty: the session starts with untouched tissue
  std::optional<Json> score;
  std::optional<session::Task> task;
  std::optional<session::ImplantTask> implant;  // task of an exercise in implant surgery
  bool vibration_band_set = false;  // true: the scene sets the vibration band; false: the hand's device sets it
  std::optional<SurroundingsPlan> surroundings;  // surroundings of the tooth
  MouthMirror mouth_mirror;                      // initial mirror in the other hand; diameter 0: none
  HandpieceView handpieces;                      // how pictures show handpieces
  std::optional<debris::Suction> suction;        // fixed suction nozzle; empty: the default nozzle beside the tooth
  bool suction_on = false;                       // initial state of the suction
  SuctionTip suction_tip;                        // the tip at its initial pose; opening 0: nothing is drawn
  std::optional<Nozzles> spray;                  // the handpiece's water; empty: the scene has no water and no film
  bool spray_on = false;                         // initial state of the spray
  bool sound_lower_order = false;  // sound models may be reduced to the lowest order at which nothing is lost

  bool needs(std::string_view part) const { return parts.contains(std::string(part)); }
};

/// Reads a scene (docs/interface.md) from a file, or a shipped scene by its name. Throws Error for anything that is
/// missing, unknown or out of range.
Scene read_scene(const std::filesystem::path& scene);
/// Reads a scene from JSON; relative paths begin at the folder of `file`.
Scene parse_scene(const Json& json, const std::filesystem::path& file);
/// Reads a scene from JSON; the files that it names are searched in `place`.
Scene parse_scene(const Json& json, const std::filesystem::path& file, const ScenePlace& place);

/// Path of the scene's volume; empty if the tissue is made of solids. Throws Error.
std::filesystem::path volume_file(const Scene& scene);

/// Reads {"translation_mm", "normal" or "rotation_wxyz", "diameter_mm", "fog", "focal_mm"}. Throws Error.
MouthMirror read_mouth_mirror(const Json& json);

/// True if a second hand holds the suction tip. If the scene also has a mouth mirror, the hand holds that.
inline bool hand_holds_suction(const Scene& scene) {
  return scene.suction_tip.opening > 0 && scene.mouth_mirror.diameter == 0;
}

/// Loads or samples the initial tissue of the scene and paints into it. Ignores `resume`: load_tissue() in
/// recording/resume.h continues a partial preparation. Throws Error.
haptics::TissueVolume load_untouched(const Scene& scene);

/// The scene's servo settings, completed for this tissue, servo rate (Hz) and other properties of the hand's device
/// (haptics::DeviceInfo). The scene can override the device's vibration band (Hz).
haptics::ServoSettings servo_settings(const Scene& scene, const haptics::TissueVolume& tissue, double rate,
                                      double vibration_band = 0, double position_step = 0, bool gives_torque = true);

/// Replaces the scene's contact model by the model of the option --model; does nothing if `name` is empty. The
/// recorded text of the scene also changes. Throws Error that lists the available models.
void choose_model(Scene& scene, const std::string& name);
/// Name of the scene's contact model.
std::string_view model_name(const Scene& scene);
/// True if pictures show the contact model's own triangles instead of the volume's surface.
bool draws_own_surface(const Scene& scene);

/// Names of the scene's tools, in order.
std::vector<std::string> tool_names(const Scene& scene);

/// Loads a tool or motor by name from assets/tools/ and assets/motors/. Throws Error that lists the available names.
haptics::Tool load_tool(std::string_view name);
haptics::Spindle load_spindle(std::string_view name);
/// Loads assets/materials/hard_tissue.json.
MaterialTable load_materials();

}  // namespace typodont
