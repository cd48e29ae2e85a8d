// The state of the operator's window and the user's requests, as plain data. The pages draw the state and append
// requests; the Operator executes them between two frames. Main thread.
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
  kStart,            // start a session with the selection; on the experiment page: start the experiment
  kEndSession,       // ramp the force down, complete the recording, end the session
  kEmergencyStop,    // no force from the next tick on; then the session ends
  kToStart,          // return to the start page
  kAgain,            // repeat the last session
  kLanguage,         // number: index of the language
  kDoctor,           // check this computer
  kRescan,           // search for scenes, hands and rigs again
  kOpenReport,       // show the report in the browser; on the experiment page: the experiment's result
  kOpenFolder,       // open the folder of the sessions
  kDeleteRecording,  // delete the recording of the session that just ended
  kSettings,         // live settings have changed
  kTool,             // number: index in the tool set
  kPhaseTool,        // take the instrument for the present phase of an implant exercise
  kUndo,             // undo a stroke
  kRedo,             // redo a stroke
  kSaveTissue,       // save the present tissue
  kKeep,             // number: 1 keeps the recording, 0 deletes it
  kLook,             // OperatorState::look has changed
  kOwnView,          // number: 1 shows the free viewpoint, 0 the trainee's picture
  kColor,            // OperatorState::colors has changed; number: the tissue
  kLoseDevice,       // for tests: the GPU device is lost
  kSaveExercise,     // save painted and drilled tissue as an exercise
  kHold,             // number: 1 stops drill and force, 0 continues
  kStepDone,         // mark the task's current step as done
  kStepBack,         // unmark the last step
  kArchive,          // show recorded sessions and imports
  kExperiment,       // show the page of experiments
  kSessionReport,    // report of the selected session: create it if necessary, and open it in the browser
  kLearningCurve,    // learning curve of the selected session's trainee
  kFilm,             // film of the selected session
  kExpert,           // use the selected session as the expert's session in reports
  kWatch,            // play the selected session in a separate window
  kExportMesh,       // export the final tissue of the selected session as a mesh
  kGoOnFrom,         // continue the selected session from its end
  kImport,           // import a scan or mesh with the settings in ImportForm; on the scan page: its region
  kLookAtScan,       // show the scan of ImportForm before its import
  kFuse,             // lay the intraoral scan of FuseForm over the CBCT of the scan page
  kFuseDropPoint,    // remove the latest picked point
  kFuseRegister,     // register the intraoral scan from the picked points
  kFuseTake,         // replace the crowns of the CBCT, and return to the scan page
  kFuseBack,         // return to the scan page
  kDropped,          // the file or folder OperatorState::dropped was dropped on the window
  kPlan,      // plan an implant in the jaw of the selected exercise; number: on the plan page, the bone's class, from 1
  kSavePlan,  // save the planned implant as an exercise
  kTutorial,  // select and start the tutorial
  kWelcomed,  // the introduction on the first start is finished
  kCancel,    // cancel the running task
  kLeaveKept,     // save the unsaved work as an exercise, then execute OperatorState::leaving
  kLeaveDropped,  // discard the unsaved work, then execute OperatorState::leaving
  kStay,          // do not execute OperatorState::leaving
  kQuit,
};
struct Request {
  Ask ask;
  int number = 0;
};

struct SceneChoice {
  std::filesystem::path file;
  std::string name;  // name, used in the names of recordings
  std::string title, description;
  std::string fault;  // reason why the scene cannot be used; empty: it can be used
  int picture = -1;   // index in OperatorState::pictures
  std::string model;  // the scene's contact model, or the default
  bool own = false;   // created by the user, not shipped
  // an implant can be planned in this scene: it is an implant exercise, or a volume of the user's own
  bool jaw = false;
};
struct HandEntry {
  std::string address;  // address of the hand; empty: the user types it
  std::string title, detail;
  bool usable = true;
};
struct RigChoice {
  std::filesystem::path file;  // rig file; empty: the picture is in this window
  std::string title;
  bool embedded = false;
};
/// A rule that an instructor can select.
struct RuleChoice {
  std::string name;
  bool counts = false;
  bool from_ideal = true;  // the rule uses the ideal's own value as its target, if the ideal has one
  float target = 0, tolerance = 1, weight = 10;
};
/// Source of a new exercise's ideal.
enum class IdealFrom { kBase, kDrilled, kMesh };
struct ExerciseForm {
  bool fresh = true;  // the form does not contain values yet
  std::array<char, 96> name{};
  std::array<char, 512> goal{};
  std::array<char, 1024> steps{};  // one step per line
  IdealFrom ideal = IdealFrom::kDrilled;
  bool base_aims = false;  // the base scene has an ideal
  bool aims() const { return ideal != IdealFrom::kBase || base_aims; }
  std::array<char, 512> mesh{};  // path of the mesh file
  FileChooser chooser;
  float mesh_unit_mm = 1;
  std::vector<RuleChoice> rules;
};
constexpr int kScannedSurface = 4;  // value of ImportForm::preset: carve the mesh itself
struct ImportForm {
  std::array<char, 512> file{};
  FileChooser chooser;
  std::array<char, 96> name{};
  int preset = 0;  // ImportPreset, or kScannedSurface
  int series = 0;  // index among several series in a folder of DICOM files; 0: there is only one
  int crown = 0;   // index in the enumeration Crown
  // mm, voxel size and thickness of the shell; 0: voxel size of the file, default thickness
  float voxel_mm = 0, shell_mm = 0;
  float unit_mm = 1;     // mm, unit of a mesh file
  float spacing_mm = 0;  // mm, sample spacing of a scan; 0: the file's spacing
};
/// What the left mouse button does in a section of a scan.
enum class ScanTool { kLook, kBrush, kSeed };
/// The page of a scan before its import. The page changes the review; ScanDesk computes its labels and draws its
/// sections between two frames.
struct ScanForm {
  ScanReview* review = nullptr;  // belongs to ScanDesk; null until the scan is read
  std::size_t large = 0;         // index of the section that is shown larger than the others
  ScanTool tool = ScanTool::kLook;
  int kind = 0;  // haptics::LabelKind
  float radius_mm = 1;
  bool only_tissue = true;
  float reach_mm = 5, tolerance = 0.3f;  // parameters of a seed, see haptics::LabelSeed
  glm::ivec3 walls{0};                   // walls of the region that the mouse holds, see ScanReview::walls_at()
  dvec3 mouse_F{0};                      // m, position of the brush in the last frame
  ScanPlanes planes;
  std::array<const gpu::Image*, kScanSections> pictures{};  // null until they are drawn
  std::uint64_t drawn = 0;                                  // number of times that the sections were drawn
};
/// The page on which an intraoral scan is laid over a CBCT. The page changes the fusion; FuseDesk registers and draws
/// it.
struct FuseForm {
  std::array<char, 512> file{};  // path of the mesh
  FileChooser chooser;
  float unit_mm = 1;
  ScanFusion* fusion = nullptr;                 // belongs to FuseDesk; null until the mesh is read
  glm::vec2 pressed{0};                         // pixels, place where the mouse button was pressed
  bool turning = false;                         // the mouse turns a surface
  bool changed = false;                         // the pictures do not show the present state
  std::array<const gpu::Image*, 2> pictures{};  // null until they are drawn
  std::uint64_t drawn = 0;                      // number of times that the surfaces were drawn
};
inline constexpr std::array<std::string_view, 4> kBoneClasses{"I", "II", "III", "IV"};
/// The form for planning an implant. The page changes the plan; PlanDesk evaluates and draws the plan between two
/// frames.
struct PlanForm {
  bool ready = false;  // the jaw is loaded
  std::array<char, 96> name{};
  std::vector<ImplantProcedure> procedures;
  int procedure = 0;
  int bone_class = 0;  // class of synthetic bone, 1 to 4; 0: a scan
  session::ImplantPlan plan;
  float width_mm = 40;    // mm, width of each section
  bool changed = false;   // the plan has changed, but findings and pictures do not show the change yet
  bool dragging = false;  // the mouse moves or tilts the implant
  bool tilting = false;   // the mouse tilts the implant
  PlanFindings findings;
  PlanPlanes planes;
  // pictures of the sections; null until they are drawn
  std::array<const gpu::Image*, std::tuple_size_v<PlanPlanes>> pictures{};
  std::uint64_t drawn = 0;  // number of times that the sections were drawn
};
/// The questions of `typodont experiment`, as its option --question names them.
inline constexpr std::array kExperimentQuestions = {"stiffness", "force", "delay", "model"};
constexpr std::size_t kModelQuestion = 3;
struct ExperimentForm {
  int question = 0;                 // index in kExperimentQuestions
  std::array<int, 2> models{0, 1};  // compared models, indices in OperatorState::models
  // limits of the number of trials, one for each question; for models the exact number
  std::array<int, 4> trials{150, 150, 150, 40};
  float seconds = 4;  // s, duration of each stimulus
};
/// A value with its 95 % interval; a bound that the answers do not limit is NaN.
struct FoundValue {
  double value = 0, low = 0, high = 0;
};
/// Result of a finished experiment.
struct ExperimentFinding {
  std::filesystem::path log, page;  // files: the trials, and the page with the fit
  std::string person;
  std::size_t question = 0;
  int trials = 0;
  double right = 0;                   // %, fraction of correct answers; not for models
  FoundValue found;                   // just-noticeable difference, % or ms; for models the fraction of `models[1]`, %
  std::array<std::string, 2> models;  // names of the compared models; only for models
  double chance = 1;                  // only for models: probability of such answers if no difference was felt
};
struct DoctorFinding {
  std::string name, state, found, without, mend;
};

/// Result of a finished session.
struct Outcome {
  WorkbenchSummary summary;
  std::filesystem::path recording, report;  // files; empty: there is none
  session::Score score;
  bool scored = false;  // the score is final; an earlier score is not shown
  // The final surface; it shows the difference to the ideal if there is one. Without pixels if the surface is
  // unknown.
  render::Picture picture;
  bool compared = false;  // the picture shows the difference to the ideal
  std::string failure;
};

struct OperatorState {
  Page page = Page::kStart;
  session::Language language = session::Language::kEnglish;
  bool chinese = false;  // this computer has a font for Chinese
  bool first_run = false;
  bool help = false;    // true: the list of keys is shown
  std::string message;  // one line: an error or a hint
  bool message_is_error = false;
  std::vector<Request> asked;        // requests of the pages in this frame
  std::vector<std::string> to_open;  // files and folders that the desktop should open
  std::optional<Request> leaving;    // request that waits for the user's decision about unsaved work

  // Members of the start page.
  std::vector<SceneChoice> scenes;
  std::vector<HandEntry> hands;
  std::vector<RigChoice> rigs;
  std::vector<std::string> models;  // names of the contact models
  int model = -1;                   // index in `models`; -1: the exercise's own model
  std::vector<std::string> monitors;
  int scene_shown = -1;  // the scene to which the page has scrolled
  int scene = 0, hand = 0, rig = 0, monitor = -1;
  std::array<char, 256> address{};  // typed address of a hand
  std::array<char, 128> trainee{};
  bool record = true;
  std::string real_time_refused;  // reason why the system refuses real-time scheduling; empty: it does not refuse
  bool no_real_time = false;      // the user accepts a device with motors without real-time scheduling
  bool author = false;            // authoring mode: paint tissue, set the ideal; such sessions are not recorded
  std::vector<gpu::Image> pictures;

  // Members of the session page.
  WorkbenchStatus status;
  session::Score score;
  bool score_known = false;    // the result has been evaluated at least once
  bool score_current = false;  // the score includes the latest cuts
  haptics::DeviceInfo device;
  std::string scene_title, scene_goal;
  std::vector<std::string> tools;  // names of the session's tools
  StepWatcher steps;
  bool painting = false;  // the brush is pressed
  Tissue paint_tissue = Tissue::kCaries;
  float paint_radius_mm = 0.6f;
  float paint_hardness = 1;  // 0..1, hardness for the next strokes
  int step_shown = -1;       // the step to which the page has scrolled
  SessionSettings settings;
  bool recording = false;
  bool keep = false;          // keep the recording at the session's end
  bool own_view = false;      // this window shows a free viewpoint instead of the trainee's picture
  bool trainee_seen = false;  // this window can show the trainee's picture
  bool own_possible = false;  // this window can show the operator's free viewpoint
  Viewpoint viewpoint;
  Look look;                  // settings of the picture in this window (views, colours)
  bool look_in_work = false;  // parts of the picture with these settings are still being computed
  bool has_ideal = false, has_surroundings = false, has_mirror = false, has_debris = false;
  std::uint32_t tissues = 0;                                // tissues in the scene, one bit each
  int look_changes = 0;                                     // number of changes of `look` since the session's start
  std::array<float, kTissueCount> stiffness{};              // authoring: factors on the materials' stiffness
  std::array<std::array<float, 3>, kTissueCount> colors{};  // authoring: sRGB colours
  bool held = false;
  std::array<float, 240> forces{}, ticks_us{};  // curves of the last seconds: force in N, and duration of a tick in µs
  int curve_at = 0;
  const gpu::Image* live = nullptr;  // left eye of the trainee's picture
  glm::dmat2 live_upright{1.0};
  bool live_is_own = false;        // the trainee sees the picture in this window
  glm::ivec2 live_size{640, 360};  // pixels, size available for the picture; set by the page
  display::UserInput live_input;   // input over the picture; set by the page
  bool live_hovered = false;
  double live_aspect = 16.0 / 9;  // width / height of the picture

  // Members of the result page.
  Outcome outcome;
  const gpu::Image* result_picture = nullptr;  // picture of the outcome
  ExerciseForm exercise;

  // Members of the archive page.
  std::vector<SessionEntry> sessions;
  int session = 0, mesh_format = 0;
  ImportForm import;
  std::string dropped;

  // Members of the page of a scan before its import. File, name and crown are those of ImportForm.
  ScanForm scan;
  FuseForm fuse;
  // Members of the page for planning an implant.
  PlanForm plan;
  // Members of the page of experiments. Exercise, hand, picture and person are those of the start page.
  ExperimentForm experiment;
  std::optional<ExperimentFinding> experiment_found;

  // Members of the page about this computer.
  std::vector<DoctorFinding> findings;

  // State of the running long task.
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
  /// A catalogue text with its placeholders filled in.
  template <class... Args>
  std::string words(std::string_view key, Args&&... args) const {
    return fmt::format(fmt::runtime(session::text(key, language)), std::forward<Args>(args)...);
  }
  /// Text of a shortcut with the reader's key names: "Ctrl+Z" in German is "Strg+Z".
  std::string keys(std::string name) const {
    for (const auto& [english, key] : {std::pair{"Ctrl", "op.control"}, std::pair{"Space", "op.space_bar"}})
      if (const std::size_t at = name.find(english); at != std::string::npos)
        name.replace(at, std::string_view(english).size(), text(key));
    return name;
  }
  /// A number with the language's decimal sign.
  std::string number(double value, int decimals) const { return session::number_text(value, decimals, language); }
};

// Functions that draw the pages. Call each between InterfaceWindow::begin() and end().
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
/// Asks the user about unsaved work while OperatorState::leaving contains a request.
void draw_leaving(OperatorState& s, InterfaceWindow& w);

}  // namespace typodont
