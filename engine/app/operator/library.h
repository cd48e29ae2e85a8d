// Finds the available exercises, hands and display rigs, and the user's folders.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/app/operator/state.h"
#include "engine/app/scene.h"
#include "haptics/tool.h"

namespace typodont {

/// Finds the shipped scenes and then the user's scenes, sorted by name. A scene that cannot be read is listed with its
/// error.
std::vector<SceneChoice> find_scenes(const OperatorState& s);

/// Changes a text so that it is a valid name of a file or folder.
std::string file_name_of(const std::string& text);

/// Lists the connected devices, the mouse, and an entry for an address that the user types.
std::vector<HandEntry> find_hands(const OperatorState& s);
/// Lists the operator's window as a display rig, then the shipped rigs and the user's rigs for screens and mirrors.
std::vector<RigChoice> find_rigs(const OperatorState& s);

/// Returns the local time in the form that file names use: "2026-11-21_12-30-05".
std::string date_and_time();
/// Returns the path of a new recording, ~/Typodont/sessions/TRAINEE/DATE_SCENE.h5, and creates its folder.
std::filesystem::path new_session_file(const std::string& trainee, const std::string& scene);

/// Returns the folder of the trainee "expert", beside the folder of the given trainee. Reports compare a session with
/// the sessions in this folder.
std::filesystem::path expert_folder(const std::filesystem::path& trainee_folder);

/// Returns the path of a temporary file for a recording. The file is deleted when the program ends, unless the user
/// keeps it. This function also deletes temporary files of earlier programs that were killed. The path is empty if the
/// disk is full.
std::filesystem::path temporary_recording_file();

/// The user's last selection: language, trainee, scene, hand, picture. Errors while reading and writing it are ignored.
struct Remembered {
  bool any = false;
  std::string language, trainee, scene, hand, rig;
  bool record = true;
  int monitor = -1;   // number of the monitor for full screen; −1: no full screen
  std::string model;  // contact model that the user selected; empty: the exercise's own model
};
Remembered remembered();
/// Chooses the language of the window: from the option --language, otherwise from the last run, otherwise from the
/// desktop. Throws Error if the language is unknown.
session::Language user_language(const std::string& wanted);
void remember(const Remembered& r);

}  // namespace typodont
