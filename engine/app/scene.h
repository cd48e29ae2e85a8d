// A scene, read from its file and checked: the tissue, the tools, and the parts of the program that the scene needs.
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
#include "engine/session/heat.h"
#include "engine/session/implant.h"
#include "engine/session/task.h"
#include "haptics/servo.h"
#include "haptics/tissue_volume.h"

namespace typodont {

struct Scene {
  std::filesystem::path file;
  ScenePlace place;  // folders in which relative file names are searched: that of the scene's file, or of the recording
  std::string text;  // text of the scene file
  std::string name;
  /// Parts of the program that the scene uses: haptics, render, sound, debris, record, score.
  std::set<std::string> parts;
  haptics::ServoSettings servo;      // servo settings, except the voxel frame, which depends on tissue
  DrawnAs drawn_as;                  // tissues that pictures show like another tissue, e.g. a hidden lesion
  std::string motor;                 // name of a motor in assets/motors/; empty: an ideal motor
  std::optional<Json> tissue;        // JSON of the initial tissue: a volume, or solids
  std::vector<Json> paint;           // JSON of tissue that is added to the initial tissue, for example a lesion
  std::filesystem::path paint_file;  // file with brush strokes that a user painted; empty: none
  std::vector<Json> prepare;         // JSON of solids removed from or added to the tissue before the session
  std::string resume;                // volume or session to continue; empty: starts with untouched tissue
  std::optional<Json> score;
  std::optional<session::Task> task;
  bool warnings = true;                         // false: no warnings over the picture (task/warnings.h)
  std::optional<session::ImplantTask> implant;  // task of an implant exercise; empty: no such exercise
  /// True: the scene sets the frequency band of the vibration. False: the hand's device sets it.
  bool vibration_band_set = false;
  /// Neighbouring teeth, gum and mouth around the tooth; empty: none.
  std::optional<SurroundingsPlan> surroundings;
  /// Mouth mirror in the second hand at the start; its diameter is 0 if there is none.
  MouthMirror mouth_mirror;
  HandpieceView handpieces;  // how the picture shows handpieces
  /// Suction nozzle with a fixed pose; empty: a default pose beside the tooth.
  std::optional<debris::Suction> suction;
  bool suction_on = false;       // true: the suction is on at the start
  SuctionTip suction_tip;        // suction tip at its initial pose; its opening is 0 if none is drawn
  std::optional<Nozzles> spray;  // the handpiece's water; empty: the scene has no water and no film of water
  bool spray_on = false;         // true: the spray is on at the start
  /// Settings of the heat in the tissue; empty: the scene computes no heat.
  std::optional<session::HeatSettings> heat;
  /// True: the sound models (autoregressive filters) may be shortened as long as no part of the sound is lost.
  bool sound_lower_order = false;

  std::string exam;  // seed of a school's sealed exam; empty: no exam
  std::string rig;   // name of the scene's display rig; empty: one of the usual rigs for a tooth

  bool needs(std::string_view part) const { return parts.contains(std::string(part)); }
};

/// The key "case" of scenes, reports and cached scores: a generated exercise.
struct CaseIdentity {
  std::string family;
  std::uint64_t seed = 1;
  double difficulty = 0.5;  // 0: easiest, 1: most difficult
  int icdas = 0;            // code of the lesion, 1 to 6 (on a root 1 or 2); 0: no coded lesion
};
void describe_case(Keys& keys, CaseIdentity& made);

// Declare the keys of a scene, and of a file of assets/suction/. `suction` receives flow and radius of the opening.
void describe_scene(Keys& keys, Scene& scene);
void describe_suction_tip(Keys& keys, SuctionTip& tip, debris::Suction& suction);
/// Reads a scene (docs/scene_format.md). `scene`: path of a file, or name of a shipped scene. Throws Error if something
/// in the file is missing, unknown or out of range.
Scene read_scene(const std::filesystem::path& scene);
/// Reads a scene from JSON. Relative paths in the scene start at the folder of `file`.
Scene parse_scene(const Json& json, const std::filesystem::path& file);
/// Reads a scene from JSON. Files that it names are searched in the folders of `place`.
Scene parse_scene(const Json& json, const std::filesystem::path& file, const ScenePlace& place);

/// The rig file that is used if the user names no rig. `usual`: name of a rig that shows a tooth: "closeup", "film" or
/// "window". A scene with the rig "hip" gets "hip", "hip_film" or "hip_window" instead. Throws Error.
std::filesystem::path usual_rig(const Scene& scene, const std::string& usual);

/// The path of the scene's volume; empty if the scene's tissue consists of solids. Throws Error.
std::filesystem::path volume_file(const Scene& scene);

/// Declares the keys of a mouth mirror. Throws Error.
void describe_mouth_mirror(Keys& keys, MouthMirror& mirror);

/// True if the second hand holds the suction tip. If the scene has a mouth mirror, the hand holds the mirror, and the
/// result is false.
inline bool hand_holds_suction(const Scene& scene) {
  return scene.suction_tip.opening > 0 && scene.mouth_mirror.diameter == 0;
}

/// Loads or samples the initial tissue of the scene, and adds the painted tissue. Ignores the key `resume`; see
/// load_tissue() in recording/resume.h. Throws Error.
haptics::TissueVolume load_untouched(const Scene& scene);

/// The scene's servo settings, completed for this tissue, servo rate (Hz) and device of the hand (haptics::DeviceInfo).
/// The scene's own vibration band (Hz) has priority over the device's band.
haptics::ServoSettings servo_settings(const Scene& scene, const haptics::TissueVolume& tissue, double rate,
                                      double vibration_band = 0, double position_step = 0, bool gives_torque = true);

/// Sets the contact model of the option --model; does nothing if `name` is empty. Also changes the scene's text, which
/// the recording contains. Throws Error that lists the available models.
void choose_model(Scene& scene, const std::string& name);
/// The name of the scene's contact model.
std::string_view model_name(const Scene& scene);
/// True if pictures show triangles of the contact model, not of the volume's surface.
bool draws_own_surface(const Scene& scene);

/// Names of the scene's tools, in the scene's order.
std::vector<std::string> tool_names(const Scene& scene);

/// Loads a tool from assets/tools/ or a motor from assets/motors/ by its name. Throws Error that lists the available
/// names.
haptics::Tool load_tool(std::string_view name);
haptics::Spindle load_spindle(std::string_view name);
/// Overwrites members of `material` with the keys in the JSON object. Throws Error.
void read_material(const Json& json, Material& material);
/// Loads the materials of assets/materials/hard_tissue.json.
MaterialTable load_materials();

}  // namespace typodont
