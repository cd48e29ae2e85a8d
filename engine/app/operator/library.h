// Finds available exercises, hands and rigs, and the user's folders.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/app/operator/state.h"
#include "engine/app/scene.h"
#include "haptics/tool.h"

namespace typodont {

/// Exercises: the shipped ones in the order of assets/curriculum.json, then the user's own by name. An unreadable one
/// contains its error message. Generated cases come last. Throws Error if assets/curriculum.json cannot be read.
std::vector<SceneChoice> find_scenes(const OperatorState& s);

/// Names and titles of the families of cases. Throws Error.
std::vector<std::pair<std::string, std::string>> find_case_families(session::Language language);

/// A valid file or folder name from a text.
std::string file_name_of(const std::string& text);

/// Hands (input devices): connected devices, the mouse, and an entry for an address that the user types.
std::vector<HandEntry> find_hands(const OperatorState& s);
/// Display rigs: the operator's window, then rigs for screens and mirrors, both shipped and the user's own.
std::vector<RigChoice> find_rigs(const OperatorState& s);

/// Local date and time, for example "2026-11-21_12-30-05".
std::string date_and_time();
/// Path of a new recording: ~/Typodont/sessions/TRAINEE/DATE_SCENE.h5. Creates the folder.
std::filesystem::path new_session_file(const std::string& trainee, const std::string& scene);

/// Folder of the trainee "expert", beside `trainee_folder`. Reports compare a session with the sessions in this folder.
std::filesystem::path expert_folder(const std::filesystem::path& trainee_folder);

/// A file for a recording that is deleted at the end unless the user keeps it. Also deletes such files of killed
/// programs. Empty if the disk is full.
std::filesystem::path temporary_recording_file();

/// The user's last selection. Read and write errors are ignored.
struct Remembered {
  bool any = false;
  std::string language, trainee, scene, hand, rig;
  bool record = true;
  int monitor = -1;     // number of the monitor for full screen; −1: none
  std::string model;    // selected contact model; empty: the model of the exercise
  bool hand_in = true;  // a signed-in student's sessions are handed in
};
Remembered remembered();
/// Language: from --language, otherwise from the last run, otherwise from the desktop. Throws Error if it is unknown.
session::Language user_language(const std::string& wanted);
void remember(const Remembered& r);

}  // namespace typodont
