// Available exercises, hands and rigs, and the user's folders.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/app/operator/state.h"
#include "engine/app/scene.h"
#include "haptics/tool.h"

namespace typodont {

/// Shipped ones in the order of assets/curriculum.json, then own ones by name. Unreadable ones carry their error.
/// Throws Error if that file cannot be read.
std::vector<SceneChoice> find_scenes(const OperatorState& s);

/// Made valid for a file or folder.
std::string file_name_of(const std::string& text);

/// Connected devices, the mouse, and an entry for a typed address.
std::vector<HandEntry> find_hands(const OperatorState& s);
/// The operator's window, then rigs for screens and mirrors, shipped and own.
std::vector<RigChoice> find_rigs(const OperatorState& s);

/// Local: "2026-11-21_12-30-05".
std::string date_and_time();
/// ~/Typodont/sessions/TRAINEE/DATE_SCENE.h5; creates the folder.
std::filesystem::path new_session_file(const std::string& trainee, const std::string& scene);

/// Of the trainee "expert", beside the given one; reports compare with it.
std::filesystem::path expert_folder(const std::filesystem::path& trainee_folder);

/// Deleted at the end unless kept; also deletes those of killed programs. Empty if the disk is full.
std::filesystem::path temporary_recording_file();

/// The last selection. Errors of reading and writing are ignored.
struct Remembered {
  bool any = false;
  std::string language, trainee, scene, hand, rig;
  bool record = true;
  int monitor = -1;   // of full screen; −1: none
  std::string model;  // selected model; empty: the exercise's
};
Remembered remembered();
/// --language, otherwise the last run's, otherwise the desktop's. Throws Error if unknown.
session::Language user_language(const std::string& wanted);
void remember(const Remembered& r);

}  // namespace typodont
