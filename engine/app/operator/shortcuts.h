// Shortcuts that several pages use. Each key has one meaning, and each action has one key.
#pragma once

#include <array>
#include <string_view>

#include "engine/app/operator/state.h"
#include "engine/display/keys.h"

namespace typodont {

struct Shortcut {
  int code = 0;  // key code, as in display::keys
  bool control = false;
  std::string_view name;      // key's name, on buttons and in the list of keys
  std::string_view help;      // key of the explanation in the text catalogue
  std::array<Ask, 2> does{};  // requests that the key makes; the user sees them as one action
};

inline constexpr std::array kShortcuts = {
    Shortcut{display::keys::kF1 + 1, false, "F2", "op.key_report", {Ask::kOpenReport, Ask::kSessionReport}},
    Shortcut{display::keys::kF1 + 2, false, "F3", "op.key_curve", {Ask::kLearningCurve, Ask::kLearningCurve}},
    Shortcut{display::keys::kF1 + 3, false, "F4", "op.key_save_exercise", {Ask::kSaveExercise, Ask::kSavePlan}},
    Shortcut{display::keys::kF1 + 4, false, "F5", "op.key_start", {Ask::kStart, Ask::kAgain}},
    Shortcut{display::keys::kF1 + 5, false, "F6", "op.key_go_on", {Ask::kGoOnFrom, Ask::kGoOnFrom}},
    Shortcut{display::keys::kF1 + 6, false, "F7", "op.key_archive", {Ask::kArchive, Ask::kArchive}},
    Shortcut{display::keys::kF1 + 7, false, "F8", "op.key_doctor", {Ask::kDoctor, Ask::kDoctor}},
    Shortcut{display::keys::kF1 + 8, false, "F9", "op.key_tutorial", {Ask::kTutorial, Ask::kTutorial}},
    Shortcut{display::keys::kF1 + 9, false, "F10", "op.key_end", {Ask::kEndSession, Ask::kToStart}},
    Shortcut{display::keys::kF1 + 10, false, "F11", "op.key_scan", {Ask::kLookAtScan, Ask::kLookAtScan}},
    Shortcut{display::keys::kF1 + 11, false, "F12", "op.key_next_case", {Ask::kNextCase, Ask::kNextCase}},
    Shortcut{'C', true, "Ctrl+C", "op.key_make_case", {Ask::kMakeCase, Ask::kMakeCase}},
    Shortcut{'F', true, "Ctrl+F", "op.key_film", {Ask::kFilm, Ask::kFilm}},
    Shortcut{'W', true, "Ctrl+W", "op.key_watch", {Ask::kWatch, Ask::kWatch}},
    Shortcut{'S', true, "Ctrl+S", "op.key_save", {Ask::kSaveTissue, Ask::kExportMesh}},
    Shortcut{'K', true, "Ctrl+K", "op.key_expert", {Ask::kExpert, Ask::kExpert}},
    Shortcut{'B', true, "Ctrl+B", "op.key_import", {Ask::kImport, Ask::kImport}},
    Shortcut{'J', true, "Ctrl+J", "op.key_plan", {Ask::kPlan, Ask::kPlan}},
    Shortcut{'N', true, "Ctrl+N", "op.key_experiment", {Ask::kExperiment, Ask::kExperiment}},
    Shortcut{'I', true, "Ctrl+I", "op.key_school", {Ask::kSchool, Ask::kSchoolTake}},
    Shortcut{'Q', true, "Ctrl+Q", "op.key_quit", {Ask::kQuit, Ask::kQuit}},
};

/// The shortcut of a request. A request without a shortcut does not compile.
consteval const Shortcut& shortcut(Ask ask) {
  for (const Shortcut& one : kShortcuts)
    if (one.does[0] == ask || one.does[1] == ask) return one;
  throw "a request without a key";
}

/// A request with its shortcut.
struct KeyedAsk {
  Ask ask;
  const Shortcut& key;
  consteval KeyedAsk(Ask request) : ask(request), key(shortcut(request)) {}
};

}  // namespace typodont
