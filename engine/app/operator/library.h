// What there is to choose from: exercises, hands, pictures, and where the user's own things lie.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/app/operator/state.h"
#include "engine/app/scene.h"
#include "haptics/tool.h"

namespace typodont {

/// Where the picture of a scene lies that has none beside it (NAME.png), once it was made; another when it changes.
std::filesystem::path made_picture(const std::filesystem::path& scene);

/// Shipped scenes, then the user's, by name. A scene that cannot be read is listed with its fault. `pictures[i]` is the
/// picture beside scene i (NAME.png), or the one made of it, or empty.
std::vector<SceneChoice> find_scenes(const OperatorState& s, std::vector<std::filesystem::path>& pictures);
/// "round_012" → "Round bur 1.2 mm", in this language.
std::string tool_title(const haptics::Tool& tool, session::Language language);

/// A name as a folder's or file's.
std::string file_name_of(const std::string& text);

/// What is plugged in, the mouse, and one that is typed.
std::vector<HandEntry> find_hands(const OperatorState& s);
/// In this window, then rigs for screens and mirrors, shipped and the user's.
std::vector<RigChoice> find_rigs(const OperatorState& s);

/// Here and now, as names of files begin: "2026-11-21_12-30-05".
std::string date_and_time();
/// ~/Typodont/sessions/TRAINEE/DATE_SCENE.h5, its folder made.
std::filesystem::path new_session_file(const std::string& trainee, const std::string& scene);

/// Where sessions lie that reports compare with, beside a trainee's folder: those of the trainee "expert".
std::filesystem::path expert_folder(const std::filesystem::path& trainee_folder);

/// A file for a recording that is not kept unless that is asked for before its end; those of programs that were killed
/// are taken away. Empty where there is no room for one.
std::filesystem::path unkept_file();

/// What was chosen last time: language, trainee, scene, hand, picture. Silent where it cannot be read or written.
struct Remembered {
  bool any = false;
  std::string language, trainee, scene, hand, rig;
  bool record = true;
  int monitor = -1;   // full screen there; −1: a window
  std::string model;  // contact model; empty: the exercise's own
};
Remembered remembered();
void remember(const Remembered& r);

}  // namespace typodont
