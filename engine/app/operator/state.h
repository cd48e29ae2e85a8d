// What the operator's window shows and what was asked of it: plain state. The pages draw it and append requests; the
// Operator carries them out between two frames. Main thread.
#pragma once

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/app/operator/archive.h"
#include "engine/app/operator/file_field.h"
#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/steps.h"
#include "engine/app/picture/look.h"
#include "engine/app/workbench.h"
#include "engine/base/log.h"
#include "engine/render/picture.h"
#include "engine/session/score.h"
#include "engine/session/strings.h"

namespace typodont {

enum class Page { kStart, kLoading, kSession, kResult, kDoctor, kArchive };

enum class Ask {
  kStart,            // a session with what is chosen
  kEndSession,       // force fades, the recording is completed
  kEmergencyStop,    // no force from the next tick on
  kToStart,          // back to the choice
  kAgain,            // the same once more
  kLanguage,         // number: which
  kDoctor,           // look at this computer
  kRescan,           // scenes, hands, rigs anew
  kOpenReport,       // in the browser
  kOpenFolder,       // where the sessions are
  kDeleteRecording,  // of the session just ended
  kSettings,         // live settings have changed
  kTool,             // number: its place in the tray
  kUndo,             // a stroke back …
  kRedo,             // … and again
  kSaveTissue,       // the preparation as it is
  kKeep,             // number: 1 the recording is kept, 0 it is not
  kLook,             // OperatorState::look has changed
  kOwnView,          // number: 1 from a viewpoint of one's own, 0 the trainee's picture
  kColor,            // OperatorState::colors has changed; number: the tissue
  kLoseDevice,       // for tests: as if the GPU had been reset
  kSaveExercise,     // what was painted, and perhaps drilled, as an exercise of one's own
  kHold,             // number: 1 no drill and no force for now, 0 go on
  kStepDone,         // tick the task's current step off
  kStepBack,         // take the last tick back
  kArchive,          // recorded sessions, imports
  kSessionReport,    // of the session chosen there: made where there is none, opened in the browser
  kLearningCurve,    // of its trainee
  kFilm,             // of the session
  kExpert,           // the session is what reports of its exercise compare with
  kWatch,            // the session again, in a window of its own
  kExportMesh,       // the tissue as it left it
  kGoOnFrom,         // a session from there
  kImport,           // a scan or mesh, as ImportForm says
  kDropped,          // the file or folder OperatorState::dropped was let fall on the window
  kTutorial,         // chosen and started
  kWelcomed,         // the first look around is over
  kCancel,           // the long work that is under way
  kLeaveKept,        // what is not saved is kept as an exercise; then OperatorState::leaving goes on
  kLeaveDropped,     // it is given up; then the same
  kStay,             // it does not go on
  kQuit,
};
struct Request {
  Ask ask;
  int number = 0;
};

struct SceneChoice {
  std::filesystem::path file;
  std::string name;  // as recordings are called after it
  std::string title, description;
  std::string fault;  // why it cannot be used; empty: it can
  int picture = -1;   // place in OperatorState::pictures
  std::string model;  // the contact model it names, or the usual one
  bool own = false;   // the user's, not shipped
};
struct HandEntry {
  std::string address;  // empty: typed by the user
  std::string title, detail;
  bool usable = true;
};
struct RigChoice {
  std::filesystem::path file;  // empty: in this window
  std::string title;
  bool embedded = false;
};
/// A rule an instructor may choose.
struct RuleChoice {
  std::string name;
  bool counts = false;
  bool from_ideal = true;  // the target is the ideal's own value, where there is one
  float target = 0, tolerance = 1, weight = 10;
};
/// What makes a new exercise's ideal.
enum class IdealFrom { kBase, kDrilled, kMesh };
struct ExerciseForm {
  bool fresh = true;  // not yet looked at
  std::array<char, 96> name{};
  std::array<char, 512> goal{};
  std::array<char, 1024> steps{};  // one a line
  IdealFrom ideal = IdealFrom::kDrilled;
  bool base_aims = false;  // the base has an ideal
  bool aims() const { return ideal != IdealFrom::kBase || base_aims; }
  std::array<char, 512> mesh{};  // a file
  FileChooser chooser;
  float mesh_unit_mm = 1;
  std::vector<RuleChoice> rules;
};
constexpr int kScannedSurface = 3;  // ImportForm::preset: the mesh itself is carved
struct ImportForm {
  std::array<char, 512> file{};
  FileChooser chooser;
  std::array<char, 96> name{};
  int preset = 0;                    // ImportPreset, or kScannedSurface
  int series = 0;                    // of several in a folder of DICOM files; 0: there is one
  int crown = 0;                     // Crown
  float voxel_mm = 0, shell_mm = 0;  // 0: as the file has it; the default
  float unit_mm = 1;                 // of a mesh
  float spacing_mm = 0;              // of a scan's samples; 0: as the file says
};
struct DoctorFinding {
  std::string name, state, found, without, mend;
};

/// What was done, when the session is over.
struct Outcome {
  WorkbenchSummary summary;
  std::filesystem::path recording, report;  // empty: there is none
  session::Score score;
  bool scored = false;      // the score is final; until then none is shown
  render::Picture picture;  // of what was left, against the ideal where there is one; none: no pixels
  bool compared = false;    // it is against the ideal
  std::string failure;
};

struct OperatorState {
  Page page = Page::kStart;
  session::Language language = session::Language::kEnglish;
  bool chinese = false;  // this computer can write it
  bool first_run = false;
  bool help = false;    // the list of keys is open
  std::string message;  // one line that matters now: an error, a hint
  bool message_is_error = false;
  std::vector<Request> asked;        // by the pages, this frame
  std::vector<std::string> to_open;  // files and folders for the desktop to open
  std::optional<Request> leaving;    // what was asked for while something is not saved: the user is asked first

  // Start.
  std::vector<SceneChoice> scenes;
  std::vector<HandEntry> hands;
  std::vector<RigChoice> rigs;
  std::vector<std::string> models;  // contact models by name
  int model = -1;                   // of them; -1: the exercise's own
  std::vector<std::string> monitors;
  int scene_shown = -1;  // the page scrolled to it
  int scene = 0, hand = 0, rig = 0, monitor = -1;
  std::array<char, 256> address{};  // of a hand that is typed
  std::array<char, 128> trainee{};
  bool record = true;
  std::string real_time_refused;  // why the system gives no real time; empty: it does
  bool no_real_time = false;      // the user takes a hand with motors all the same
  bool author = false;            // paint tissue, set the ideal; such sessions are not recorded
  std::vector<gpu::Image> pictures;

  // Session.
  WorkbenchStatus status;
  session::Score score;
  bool score_known = false;    // the result has been looked at once …
  bool score_current = false;  // … and nothing was cut since
  haptics::DeviceInfo device;
  std::string scene_title, scene_goal;
  std::vector<std::string> tools;  // of the tray
  StepWatcher steps;
  bool painting = false;  // the brush is down
  Tissue paint_tissue = Tissue::kCaries;
  float paint_radius_mm = 0.6f;
  float paint_hardness = 1;  // 0..1, of what is painted next
  int step_shown = -1;       // the page scrolled to it
  SessionSettings settings;
  bool recording = false;
  bool keep = false;          // the recording, at the session's end
  bool own_view = false;      // this window shows a viewpoint of its own, not the trainee's picture
  bool trainee_seen = false;  // there is a trainee's picture to be shown here
  bool own_possible = false;  // and one of one's own
  Viewpoint viewpoint;
  Look look;                  // of the picture that is shown here
  bool look_in_work = false;  // parts of it are still being made
  bool has_ideal = false, has_surroundings = false, has_mirror = false, has_debris = false;
  std::uint32_t tissues = 0;                                // in the scene, a bit each
  int look_changes = 0;                                     // since the session's start
  std::array<float, kTissueCount> stiffness{};              // author: of the material's own
  std::array<std::array<float, 3>, kTissueCount> colors{};  // author: sRGB
  bool held = false;
  std::array<float, 240> forces{}, ticks_us{};  // the last seconds, for the curves
  int curve_at = 0;
  const gpu::Image* live = nullptr;  // the trainee's left picture
  glm::dmat2 live_upright{1.0};
  bool live_is_own = false;        // the picture is drawn for this window, which then is the trainee's too
  glm::ivec2 live_size{640, 360};  // set by the page: pixels there are for it
  display::UserInput live_input;   // set by the page: what was done over the picture
  bool live_hovered = false;
  double live_aspect = 16.0 / 9;  // width / height of the picture

  // Result.
  Outcome outcome;
  const gpu::Image* result_picture = nullptr;  // the outcome's
  ExerciseForm exercise;

  // Archive.
  std::vector<SessionEntry> sessions;
  int session = 0, mesh_format = 0;
  ImportForm import;
  std::string dropped;

  // Doctor.
  std::vector<DoctorFinding> findings;

  // Long work under way.
  bool busy = false;
  double busy_share = 0;
  std::string busy_what;

  void ask(Ask what, int number = 0) { asked.push_back({what, number}); }
  void say(std::string text) {
    message = std::move(text);
    message_is_error = false;
  }
  void fail(std::string text) {
    message = std::move(text);
    message_is_error = true;
    log::error("{}", message);
  }
  const char* text(std::string_view key) const { return session::text(key, language).data(); }
  /// A text of the catalogue with its gaps filled.
  template <class... Args>
  std::string words(std::string_view key, Args&&... args) const {
    return fmt::format(fmt::runtime(session::text(key, language)), std::forward<Args>(args)...);
  }
  /// "Ctrl+Z" as it stands on the reader's keyboard: "Strg+Z".
  std::string keys(std::string name) const {
    for (const auto& [english, key] : {std::pair{"Ctrl", "op.control"}, std::pair{"Space", "op.space_bar"}})
      if (const std::size_t at = name.find(english); at != std::string::npos)
        name.replace(at, std::string_view(english).size(), text(key));
    return name;
  }
  /// With the language's decimal sign.
  std::string number(double value, int decimals) const { return session::number_text(value, decimals, language); }
};

// The pages, each between InterfaceWindow::begin() and end().
void draw_start_page(OperatorState& s, InterfaceWindow& w);
void draw_loading_page(OperatorState& s, InterfaceWindow& w);
void draw_session_page(OperatorState& s, InterfaceWindow& w);
void draw_result_page(OperatorState& s, InterfaceWindow& w);
void draw_doctor_page(OperatorState& s, InterfaceWindow& w);
void draw_archive_page(OperatorState& s, InterfaceWindow& w);
void draw_help(OperatorState& s, InterfaceWindow& w);
/// Asks what is to become of what is not saved, while OperatorState::leaving waits.
void draw_leaving(OperatorState& s, InterfaceWindow& w);

}  // namespace typodont
