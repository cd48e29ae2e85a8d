// Finds the available exercises, hands and pictures, and the user's folders.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/app/operator/state.h"
#include "engine/app/scene.h"
#include "haptics/tool.h"

namespace typodont {

/// Path of a picture that the program draws for a scene without a picture beside it (NAME.png). The path changes with
/// the scene's content.
std::filesystem::path made_picture(const std::filesystem::path& scene);

/// The shipped scenes, then the user's scenes, sorted by name. A scene that cannot be read is listed with its error.
/// `pictures[i]` is the path of the picture beside scene i (NAME.png), of a picture that the program drew, or empty.
std::vector<SceneChoice> find_scenes(const OperatorState& s, std::vector<std::filesystem::path>& pictures);

/// Converts a text to a valid name of a file or folder.
std::string file_name_of(const std::string& text);

/// Lists the connected devices, the mouse, and an entry for an address that the user types.
std::vector<HandEntry> find_hands(const OperatorState& s);
/// Lists the window, then the shipped rigs and the user's rigs for screens and mirrors.
std::vector<RigChoice> find_rigs(const OperatorState& s);

/// The local time in the form used by file names: "2026-11-21_12-30-05".
std::string date_and_time();
/// Path ~/Typodont/sessions/TRAINEE/DATE_SCENE.h5 of a new recording; creates the folder.
std::filesystem::path new_session_file(const std::string& trainee, const std::string& scene);

/// Folder of the trainee "expert", which lies beside the trainee's folder. Reports compare with the sessions in it.
std::filesystem::path expert_folder(const std::filesystem::path& trainee_folder);

/// A temporary file for a recording. It is deleted at the end unless the user keeps it. Also removes such files of
/// killed programs. Empty if no disk space is left.
std::filesystem::path temporary_recording_file();

/// The last selection: language, trainee, scene, hand, picture. Errors during reading and writing are ignored.
struct Remembered {
  bool any = false;
  std::string language, trainee, scene, hand, rig;
  bool record = true;
  int monitor = -1;   // number of the monitor for full screen; −1: a window
  std::string model;  // contact model; empty: the exercise's model
};
Remembered remembered();
/// The language of the option --language, otherwise of the window's last session, otherwise of the desktop. Throws
/// Error for an unknown language.
session::Language user_language(const std::string& wanted);
void remember(const Remembered& r);

}  // namespace typodont
