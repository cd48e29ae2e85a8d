// The window's state as plain data. Pages draw it and add requests, which Operator executes between frames. Main thread
// only.
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
#include "engine/app/planning/implant_planner.h"
#include "engine/app/planning/scan_fusion.h"
#include "engine/app/planning/scan_review.h"
#include "engine/app/workbench.h"
#include "engine/base/log.h"
#include "engine/render/picture.h"
#include "engine/session/score.h"
#include "engine/session/strings.h"

namespace typodont {

enum class Page { kStart, kLoading, kSession, kResult, kDoctor, kArchive, kScan, kFuse, kPlan, kExperiment };

enum class Ask {
  kStart,            // with the selection; or the experiment
  kEndSession,       // ramp down, complete the recording, end
  kEmergencyStop,    // zero force from the next tick on, then end
  kToStart,          // return to the start page
  kAgain,            // repeat the last session
  kLanguage,         // set the language; number: index of the language
  kDoctor,           // as `typodont doctor`
  kRescan,           // search again for scenes, hands and rigs
  kOpenReport,       // in the browser; or the experiment's result
  kOpenFolder,       // open the folder of the sessions
  kDeleteRecording,  // of the session that just ended
  kSettings,         // apply the changed live settings
  kTool,             // number: index in the tool set
  kPhaseTool,        // the instrument of an implant's phase
  kUndo,             // undo a stroke
  kRedo,             // redo a stroke
  kSaveTissue,       // save the present tissue
  kKeep,             // number: 1 keeps the recording at the end, 0 deletes it
  kLook,             // apply the changed OperatorState::look
  kOwnView,          // number: 1 free viewpoint, 0 the trainee's picture
  kColor,            // of OperatorState::colors; number: the tissue
  kLoseDevice,       // tests: lose the GPU device
  kSaveExercise,     // save painted and drilled tissue as an exercise
  kHold,             // number: 1 stops drill and force; 0 continues
  kStepDone,         // mark the task's current step as done
  kStepBack,         // mark the last completed step as not done
  kArchive,          // show recorded sessions and imports
  kExperiment,       // show the page of experiments
  kSessionReport,    // of the selected session, in the browser
  kLearningCurve,    // of the selected session's trainee
  kFilm,             // make a film of the selected session
  kExpert,           // reports compare with the selected session
  kWatch,            // play the selected session in a separate window
  kExportMesh,       // final tissue of the selected session
  kGoOnFrom,         // continue the selected session from its end
  /// by ImportForm; on the scan page: the region
  kImport,
  kLookAtScan,     // of ImportForm, before its import
  kFuse,           // the scan of FuseForm with the scan page's CBCT
  kFuseDropPoint,  // remove the last point that the user picked
  kFuseRegister,   // register the intraoral scan by the picked points
  kFuseTake,       // crowns replaced; back to the scan page
  kFuseBack,       // return to the scan page
  kDropped,        // OperatorState::dropped
  kPlan,           // in the selected exercise's jaw; number: class of bone, from 1
  kSavePlan,       // save the planned implant as an exercise
  kTutorial,       // select and start the tutorial
  kWelcomed,       // close the introduction of the first start
  kCancel,         // cancel the running task, for example an import
  kLeaveKept,      // save, then execute OperatorState::leaving
  kLeaveDropped,   // discard, then execute OperatorState::leaving
  kStay,           // discard the waiting request OperatorState::leaving
  kQuit,
};
struct Request {
  Ask ask;
  int number = 0;
};

struct SceneChoice {
  std::filesystem::path file;
  std::string name;  // in the names of its recordings
  std::string title, description;
  std::string group;  // heading over it (assets/curriculum.json); empty: none
  std::string fault;  // why it cannot be used; empty: it can
  int picture = -1;   // in OperatorState::pictures; -1: none
  std::string model;  // the scene's, or the default
  bool own = false;   // the user's; false: shipped
  // an implant exercise, or an imported volume: a jaw to plan in
  bool jaw = false;
};
struct HandEntry {
  std::string address;  // empty: typed by the user
  std::string title, detail;
  bool usable = true;
};
struct RigChoice {
  std::filesystem::path file;  // empty: the exercise's usual window rig
  std::string title;
  bool embedded = false;  // in the operator's window
};
/// That an instructor can select.
struct RuleChoice {
  std::string name;
  bool counts = false;
  bool from_ideal = true;  // the ideal shape's own value, if there is an ideal
  float target = 0, tolerance = 1, weight = 10;
};
/// Where a new exercise's ideal comes from.
enum class IdealFrom { kBase, kDrilled, kMesh };
struct ExerciseForm {
  bool fresh = true;  // not yet filled with the session's values
  std::array<char, 96> name{};
  std::array<char, 512> goal{};
  std::array<char, 1024> steps{};  // one step per line
  IdealFrom ideal = IdealFrom::kDrilled;
  bool base_aims = false;  // true: the base scene has an ideal result
  bool aims() const { return ideal != IdealFrom::kBase || base_aims; }
  std::array<char, 512> mesh{};  // with the ideal result
  FileChooser chooser;
  float mesh_unit_mm = 1;
  std::vector<RuleChoice> rules;
};
constexpr int kScannedSurface = 4;  // ImportForm::preset: carve the mesh itself
struct ImportForm {
  std::array<char, 512> file{};
  FileChooser chooser;
  std::array<char, 96> name{};
  int preset = 0;  // an ImportPreset as a number, or kScannedSurface
  /// of a DICOM folder with several, from 1; 0: only one
  int series = 0;
  int crown = 0;  // index in Crown
  // mm: voxels (0: the file's), enamel (0: default)
  float voxel_mm = 0, shell_mm = 0;
  float unit_mm = 1;     // mm per unit of a mesh file
  float spacing_mm = 0;  // mm between samples of a scan; 0: the file's
};
/// Left mouse button in a section.
enum class ScanTool { kLook, kBrush, kSeed };
/// The page changes the ScanReview; ScanDesk computes labels and draws sections between frames.
struct ScanForm {
  ScanReview* review = nullptr;  // ScanDesk's; null until the scan is read
  std::size_t large = 0;         // index of the larger section
  ScanTool tool = ScanTool::kLook;
  int kind = 0;  // haptics::LabelKind of the tool
  float radius_mm = 1;
  bool only_tissue = true;
  // how far labels spread from a seed, in distance and grey difference
  float reach_mm = 5, tolerance = 0.3f;
  glm::ivec3 walls{0};  // dragged face per axis: −1 lower, +1 upper, 0 none
  dvec3 mouse_F{0};     // m, scan's frame F, where the brush has painted up to
  ScanPlanes planes;
  std::array<const gpu::Image*, kScanSections> pictures{};  // null until drawn
  std::uint64_t drawn = 0;                                  // number of times that the sections were drawn
};
/// The page changes the ScanFusion; FuseDesk registers and draws.
struct FuseForm {
  std::array<char, 512> file{};  // mesh of the intraoral scan
  FileChooser chooser;
  float unit_mm = 1;
  ScanFusion* fusion = nullptr;                 // FuseDesk's; null until the mesh is read
  glm::vec2 pressed{0};                         // pixels, where the button was pressed
  bool turning = false;                         // true while the mouse turns a surface
  bool changed = false;                         // true: the pictures must be drawn again
  std::array<const gpu::Image*, 2> pictures{};  // null until drawn
  std::uint64_t drawn = 0;                      // number of times that the surfaces were drawn
};
inline constexpr std::array<std::string_view, 4> kBoneClasses{"I", "II", "III", "IV"};
/// The page changes the plan; PlanDesk evaluates and draws between frames.
struct PlanForm {
  bool ready = false;  // true after the jaw is loaded
  std::array<char, 96> name{};
  std::vector<ImplantProcedure> procedures;
  int procedure = 0;
  int bone_class = 0;  // synthetic bone, 1 to 4; 0: from a scan
  session::ImplantPlan plan;
  float width_mm = 40;    // mm, of a section
  bool changed = false;   // findings and pictures must follow
  bool dragging = false;  // the mouse moves or tilts the implant
  bool tilting = false;   // true while the mouse tilts the implant
  PlanFindings findings;
  PlanPlanes planes;
  // Null until drawn.
  std::array<const gpu::Image*, std::tuple_size_v<PlanPlanes>> pictures{};
  std::uint64_t drawn = 0;  // number of times that the sections were drawn
};
/// Of --question of `typodont experiment`.
inline constexpr std::array kExperimentQuestions = {"stiffness", "force", "delay", "model"};
constexpr std::size_t kModelQuestion = 3;
struct ExperimentForm {
  int question = 0;                 // index of the question in kExperimentQuestions
  std::array<int, 2> models{0, 1};  // indices in OperatorState::models
  // At most, per question; for models: exactly.
  std::array<int, 4> trials{150, 150, 150, 40};
  float seconds = 4;  // s, duration of each stimulus
};
/// With 95 % interval; NaN where the answers do not determine it.
struct FoundValue {
  double value = 0, low = 0, high = 0;
};
/// Result of a finished experiment.
struct ExperimentFinding {
  std::filesystem::path log, page;  // trials, and HTML page
  std::string person;
  std::size_t question = 0;
  int trials = 0;
  double right = 0;  // % right; not for models
  /// just-noticeable difference, % or ms; for models: % of trials for `models[1]`
  FoundValue found;
  std::array<std::string, 2> models;  // empty for other questions
  /// models: p-value of the subject's preference
  double chance = 1;
};
struct DoctorFinding {
  std::string name, state, found, without, mend;
};

/// Of a finished session.
struct Outcome {
  WorkbenchSummary summary;
  std::filesystem::path recording, report;  // empty: none
  session::Score score;
  bool scored = false;  // final; no score is shown before
  // Final surface, with an ideal the difference to it. Empty if unknown.
  render::Picture picture;
  bool compared = false;  // the picture shows the difference to the ideal
  std::string failure;
};

struct OperatorState {
  Page page = Page::kStart;
  session::Language language = session::Language::kEnglish;
  bool chinese = false;  // true: this computer has a font for Chinese
  bool first_run = false;
  bool help = false;    // true: the list of keys is shown
  std::string message;  // error or hint of the message line
  bool message_is_error = false;
  std::vector<Request> asked;        // in this frame
  std::vector<std::string> to_open;  // files and folders that the desktop should open
  std::optional<Request> leaving;    // waits for a decision about unsaved work

  // Data of the start page.
  std::vector<SceneChoice> scenes;
  std::vector<HandEntry> hands;
  std::vector<RigChoice> rigs;
  std::vector<std::string> models;  // names of the contact models
  int model = -1;                   // in `models`; -1: the exercise's own
  std::vector<std::string> monitors;
  int scene_shown = -1;  // to which the list was last scrolled
  int scene = 0, hand = 0, rig = 0, monitor = -1;
  std::array<char, 256> address{};  // address of a hand that the user types
  std::array<char, 128> trainee{};
  bool record = true;
  std::string real_time_refused;  // why the system refuses it; empty: allowed
  /// accepted although the device has motors
  bool no_real_time = false;
  /// painting tissue and setting the ideal; not recorded
  bool author = false;
  std::vector<gpu::Image> pictures;

  // Data of the session page.
  WorkbenchStatus status;
  session::Score score;
  bool score_known = false;    // evaluated at least once
  bool score_current = false;  // true: the score includes the latest cuts
  haptics::DeviceInfo device;
  std::string scene_title, scene_goal;
  std::vector<std::string> tools;  // names of the session's tools
  StepWatcher steps;
  bool painting = false;  // while the button is pressed
  Tissue paint_tissue = Tissue::kCaries;
  float paint_radius_mm = 0.6f;
  float paint_hardness = 1;  // 0..1, of the next strokes
  int step_shown = -1;       // to which the list was last scrolled
  SessionSettings settings;
  bool recording = false;
  bool keep = false;          // the recording, at the end
  bool own_view = false;      // free viewpoint; false: the trainee's picture
  bool trainee_seen = false;  // true: this window can show the trainee's picture
  bool own_possible = false;  // true: this window can show a free viewpoint
  Viewpoint viewpoint;
  Look look;                  // view, colours, visible tissues in this window
  bool look_in_work = false;  // parts of the picture are still computed
  bool has_ideal = false, has_surroundings = false, has_mirror = false, has_debris = false;
  std::uint32_t tissues = 0;  // of the scene, one bit each
  int look_changes = 0;       // changes of `look` since the start
  /// authoring: factors per tissue
  std::array<float, kTissueCount> stiffness{};
  std::array<std::array<float, 3>, kTissueCount> colors{};  // authoring mode: sRGB colour of each tissue
  bool held = false;
  /// last seconds: N, and µs per tick
  std::array<float, 240> forces{}, ticks_us{};
  int curve_at = 0;
  const gpu::Image* live = nullptr;  // of the left eye; null: none
  glm::dmat2 live_upright{1.0};
  bool live_is_own = false;        // drawn by this window, not by another
  glm::ivec2 live_size{640, 360};  // pixels, set by the session page
  display::UserInput live_input;   // over the picture, set by the session page
  bool live_hovered = false;
  double live_aspect = 16.0 / 9;  // ratio of the picture's width to its height

  // Data of the result page.
  Outcome outcome;
  const gpu::Image* result_picture = nullptr;  // picture of the session's result, on the GPU
  ExerciseForm exercise;

  // Of the page of recorded sessions.
  std::vector<SessionEntry> sessions;
  int session = 0, mesh_format = 0;
  ImportForm import;
  std::string dropped;

  // File, name and crown are in ImportForm.
  ScanForm scan;
  FuseForm fuse;
  // Of the planning page.
  PlanForm plan;
  // Exercise, hand, picture and person are the start page's.
  ExperimentForm experiment;
  std::optional<ExperimentFinding> experiment_found;

  // Of the page about this computer.
  std::vector<DoctorFinding> findings;

  // Of a long task in the background.
  bool busy = false;
  double busy_fraction = 0;
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
  /// A text with its placeholders replaced.
  template <class... Args>
  std::string words(std::string_view key, Args&&... args) const {
    return fmt::format(fmt::runtime(session::text(key, language)), std::forward<Args>(args)...);
  }
  /// With the language's key names: "Ctrl+Z" is "Strg+Z" in German.
  std::string keys(std::string name) const {
    for (const auto& [english, key] : {std::pair{"Ctrl", "op.control"}, std::pair{"Space", "op.space_bar"}})
      if (const std::size_t at = name.find(english); at != std::string::npos)
        name.replace(at, std::string_view(english).size(), text(key));
    return name;
  }
  /// With the language's decimal sign.
  std::string number(double value, int decimals) const { return session::number_text(value, decimals, language); }
};

// Between InterfaceWindow::begin() and end().
void draw_start_page(OperatorState& s, InterfaceWindow& w);
void draw_loading_page(OperatorState& s, InterfaceWindow& w);
void draw_session_page(OperatorState& s, InterfaceWindow& w);
void draw_result_page(OperatorState& s, InterfaceWindow& w);
void draw_doctor_page(OperatorState& s, InterfaceWindow& w);
void draw_archive_page(OperatorState& s, InterfaceWindow& w);
void draw_fuse_page(OperatorState& s, InterfaceWindow& w);
void draw_scan_page(OperatorState& s, InterfaceWindow& w);
void draw_plan_page(OperatorState& s, InterfaceWindow& w);
void draw_experiment_page(OperatorState& s, InterfaceWindow& w);
void draw_help(OperatorState& s, InterfaceWindow& w);
/// While OperatorState::leaving waits.
void draw_leaving(OperatorState& s, InterfaceWindow& w);

}  // namespace typodont
