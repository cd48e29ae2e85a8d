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
/// A rule of the score that an instructor can select.
struct RuleChoice {
  std::string name;
  bool counts = false;
  bool from_ideal = true;  // true: the target is the value that the ideal shape has, if there is an ideal
  float target = 0, tolerance = 1, weight = 10;
};
/// Source of the ideal result in a new exercise: the base scene, the drilled tissue, or a mesh file.
enum class IdealFrom { kBase, kDrilled, kMesh };
struct ExerciseForm {
  bool fresh = true;  // true: the form has not yet been filled with the values of the session
  std::array<char, 96> name{};
  std::array<char, 512> goal{};
  std::array<char, 1024> steps{};  // text of the exercise's steps, one step per line
  IdealFrom ideal = IdealFrom::kDrilled;
  bool base_aims = false;  // true: the base scene has an ideal result
  bool aims() const { return ideal != IdealFrom::kBase || base_aims; }
  std::array<char, 512> mesh{};  // path of the mesh file that contains the ideal result of the exercise
  FileChooser chooser;
  float mesh_unit_mm = 1;
  std::vector<RuleChoice> rules;
};
constexpr int kScannedSurface = 4;  // value of ImportForm::preset that means: carve the mesh itself, without a volume
struct ImportForm {
  std::array<char, 512> file{};
  FileChooser chooser;
  std::array<char, 96> name{};
  int preset = 0;  // an ImportPreset as a number, or kScannedSurface
  /// number of the series in a DICOM folder with several series, from 1; 0: the folder has only one series
  int series = 0;
  int crown = 0;  // direction of the crown, as an index in the enumeration Crown
  // voxel_mm: mm, voxel size; 0: the voxel size of the file. shell_mm: mm, thickness of the enamel; 0: the default.
  float voxel_mm = 0, shell_mm = 0;
  float unit_mm = 1;     // mm, length of the unit in which a mesh file states coordinates
  float spacing_mm = 0;  // mm, distance between two samples of a scan; 0: the distance that the file states
};
/// Action of the left mouse button in a section of a scan.
enum class ScanTool { kLook, kBrush, kSeed };
/// Data of the page that shows a scan before its import. The page changes the ScanReview. ScanDesk computes the labels
/// and draws the sections between two frames.
struct ScanForm {
  ScanReview* review = nullptr;  // the scan with the user's corrections; owned by ScanDesk; null until the scan is read
  std::size_t large = 0;         // index of the section that is shown larger than the others
  ScanTool tool = ScanTool::kLook;
  int kind = 0;  // kind of label that the correction tool makes, a haptics::LabelKind as a number
  float radius_mm = 1;
  bool only_tissue = true;
  // the labels spread from the clicked point (seed) up to these limits of distance and of grey difference
  float reach_mm = 5, tolerance = 0.3f;
  glm::ivec3 walls{0};  // dragged face of the region's box per axis: −1 lower, +1 upper, 0 none
  dvec3 mouse_F{0};     // m, in the scan's coordinate frame F: the point up to which the brush has painted
  ScanPlanes planes;
  std::array<const gpu::Image*, kScanSections> pictures{};  // pictures of the sections; null until they are drawn
  std::uint64_t drawn = 0;                                  // number of times that the sections were drawn
};
/// Data of the page on which an intraoral scan is aligned with a CBCT. The page changes the ScanFusion. FuseDesk
/// registers and draws the surfaces.
struct FuseForm {
  std::array<char, 512> file{};  // path of the mesh file of the intraoral scan
  FileChooser chooser;
  float unit_mm = 1;
  ScanFusion* fusion = nullptr;  // the two surfaces that are aligned; owned by FuseDesk; null until the mesh is read
  glm::vec2 pressed{0};          // pixels, position at which the mouse button was pressed
  bool turning = false;          // true while the mouse turns a surface
  bool changed = false;          // true: the pictures must be drawn again
  std::array<const gpu::Image*, 2> pictures{};  // pictures of the two surfaces; null until they are drawn
  std::uint64_t drawn = 0;                      // number of times that the surfaces were drawn
};
inline constexpr std::array<std::string_view, 4> kBoneClasses{"I", "II", "III", "IV"};
/// Data of the page on which an implant is planned. The page changes the plan. PlanDesk evaluates and draws the plan
/// between two frames.
struct PlanForm {
  bool ready = false;  // true after the jaw is loaded
  std::array<char, 96> name{};
  std::vector<ImplantProcedure> procedures;
  int procedure = 0;
  int bone_class = 0;  // class of synthetic bone, 1 to 4; 0: the bone comes from a scan
  session::ImplantPlan plan;
  float width_mm = 40;    // mm, width of the shown part in each section
  bool changed = false;   // true: the plan has changed, so the findings and the pictures must be updated
  bool dragging = false;  // true while the mouse moves or tilts the implant
  bool tilting = false;   // true while the mouse tilts the implant
  PlanFindings findings;
  PlanPlanes planes;
  // Pictures of the sections; null until they are drawn.
  std::array<const gpu::Image*, std::tuple_size_v<PlanPlanes>> pictures{};
  std::uint64_t drawn = 0;  // number of times that the sections were drawn
};
/// The questions that the option --question of `typodont experiment` accepts.
inline constexpr std::array kExperimentQuestions = {"stiffness", "force", "delay", "model"};
constexpr std::size_t kModelQuestion = 3;
struct ExperimentForm {
  int question = 0;                 // index of the question in kExperimentQuestions
  std::array<int, 2> models{0, 1};  // the two compared contact models, as indices in OperatorState::models
  // Largest number of trials for each question. In a comparison of models, exactly this number is run.
  std::array<int, 4> trials{150, 150, 150, 40};
  float seconds = 4;  // s, duration of each stimulus
};
/// A value with its 95 % confidence interval. An end of the interval that the answers do not determine is NaN.
struct FoundValue {
  double value = 0, low = 0, high = 0;
};
/// Result of a finished experiment.
struct ExperimentFinding {
  std::filesystem::path log, page;  // file with the trials, and HTML page with the result
  std::string person;
  std::size_t question = 0;
  int trials = 0;
  double right = 0;  // %, fraction of right answers; not used if models are compared
  /// the result: the just-noticeable difference in % or ms; for a comparison of models instead the fraction of trials
  /// in which the subject chose `models[1]`, in %
  FoundValue found;
  std::array<std::string, 2> models;  // names of the compared models; empty for other questions
  /// for a comparison of models: p-value; probability that random answers prefer one of the models at least as often as
  /// the subject's answers do
  double chance = 1;
};
struct DoctorFinding {
  std::string name, state, found, without, mend;
};

/// Result of a finished session, as the result page shows it.
struct Outcome {
  WorkbenchSummary summary;
  std::filesystem::path recording, report;  // files of the session; empty if they do not exist
  session::Score score;
  bool scored = false;  // true: the score is final; until then, no score is shown
  // Picture of the final surface. If there is an ideal result, it shows the difference to the ideal. Empty if the
  // surface is unknown.
  render::Picture picture;
  bool compared = false;  // true: the picture shows the difference to the ideal result
  std::string failure;
};

struct OperatorState {
  Page page = Page::kStart;
  session::Language language = session::Language::kEnglish;
  bool chinese = false;  // true: this computer has a font for Chinese
  bool first_run = false;
  bool help = false;    // true: the list of keys is shown
  std::string message;  // text of the message line: an error or a hint
  bool message_is_error = false;
  std::vector<Request> asked;        // requests that the pages have made in this frame
  std::vector<std::string> to_open;  // files and folders that the desktop should open
  std::optional<Request> leaving;    // request that waits for the user's decision about unsaved work

  // Data of the start page.
  std::vector<SceneChoice> scenes;
  std::vector<HandEntry> hands;
  std::vector<RigChoice> rigs;
  std::vector<std::string> models;  // names of the contact models
  int model = -1;                   // index of the selected model in `models`; -1: the exercise's own model
  std::vector<std::string> monitors;
  int scene_shown = -1;  // index of the scene to which the list of scenes was last scrolled
  int scene = 0, hand = 0, rig = 0, monitor = -1;
  std::array<char, 256> address{};  // address of a hand that the user types
  std::array<char, 128> trainee{};
  bool record = true;
  std::string real_time_refused;  // reason why the system refuses real-time scheduling; empty if it allows it
  /// true: the user accepts a device with motors although real-time scheduling is refused
  bool no_real_time = false;
  /// true: authoring mode, in which tissue is painted and the ideal result is set; such sessions are not recorded
  bool author = false;
  std::vector<gpu::Image> pictures;

  // Data of the session page.
  WorkbenchStatus status;
  session::Score score;
  bool score_known = false;    // true: the result has been evaluated at least once
  bool score_current = false;  // true: the score includes the latest cuts
  haptics::DeviceInfo device;
  std::string scene_title, scene_goal;
  std::vector<std::string> tools;  // names of the session's tools
  StepWatcher steps;
  bool painting = false;  // true while the button of the brush is pressed
  Tissue paint_tissue = Tissue::kCaries;
  float paint_radius_mm = 0.6f;
  float paint_hardness = 1;  // 0..1, hardness that the next strokes of the brush give to the tissue
  int step_shown = -1;       // index of the step to which the list of steps was last scrolled
  SessionSettings settings;
  bool recording = false;
  bool keep = false;          // true: the recording is kept at the session's end
  bool own_view = false;      // true: this window shows a free viewpoint; false: it shows the trainee's picture
  bool trainee_seen = false;  // true: this window can show the trainee's picture
  bool own_possible = false;  // true: this window can show a free viewpoint
  Viewpoint viewpoint;
  Look look;                  // settings of the picture in this window: view, colours, visible tissues
  bool look_in_work = false;  // true: the program still computes parts of the picture with these settings
  bool has_ideal = false, has_surroundings = false, has_mirror = false, has_debris = false;
  std::uint32_t tissues = 0;  // tissues that the scene contains, one bit for each
  int look_changes = 0;       // number of changes of `look` since the session's start
  /// authoring mode: factors by which the stiffness of each tissue is multiplied
  std::array<float, kTissueCount> stiffness{};
  std::array<std::array<float, 3>, kTissueCount> colors{};  // authoring mode: sRGB colour of each tissue
  bool held = false;
  /// values of the last seconds for the curves on the session page: force in N, and computing time of a tick in µs
  std::array<float, 240> forces{}, ticks_us{};
  int curve_at = 0;
  const gpu::Image* live = nullptr;  // the trainee's picture, as the left eye sees it; null: there is no picture
  glm::dmat2 live_upright{1.0};
  bool live_is_own = false;        // true: this window draws the trainee's picture; false: another window draws it
  glm::ivec2 live_size{640, 360};  // pixels, size of the area for the picture; the session page sets it
  display::UserInput live_input;   // input of mouse and keys over the picture; the session page sets it
  bool live_hovered = false;
  double live_aspect = 16.0 / 9;  // ratio of the picture's width to its height

  // Data of the result page.
  Outcome outcome;
  const gpu::Image* result_picture = nullptr;  // picture of the session's result, on the GPU
  ExerciseForm exercise;

  // Data of the page of recorded sessions.
  std::vector<SessionEntry> sessions;
  int session = 0, mesh_format = 0;
  ImportForm import;
  std::string dropped;

  // Data of the scan page. File, name and crown are in ImportForm.
  ScanForm scan;
  FuseForm fuse;
  // Data of the page for planning an implant.
  PlanForm plan;
  // Data of the experiment page. Exercise, hand, picture and person are those of the start page.
  ExperimentForm experiment;
  std::optional<ExperimentFinding> experiment_found;

  // Data of the page about this computer.
  std::vector<DoctorFinding> findings;

  // State of a long task that runs in the background.
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
  /// Returns a text of the catalogue, with its placeholders replaced by the arguments.
  template <class... Args>
  std::string words(std::string_view key, Args&&... args) const {
    return fmt::format(fmt::runtime(session::text(key, language)), std::forward<Args>(args)...);
  }
  /// Returns the text of a shortcut with the key names of the language. For example, "Ctrl+Z" is "Strg+Z" in German.
  std::string keys(std::string name) const {
    for (const auto& [english, key] : {std::pair{"Ctrl", "op.control"}, std::pair{"Space", "op.space_bar"}})
      if (const std::size_t at = name.find(english); at != std::string::npos)
        name.replace(at, std::string_view(english).size(), text(key));
    return name;
  }
  /// Formats a number with the decimal sign of the language.
  std::string number(double value, int decimals) const { return session::number_text(value, decimals, language); }
};

// Functions that draw the pages. Call them between InterfaceWindow::begin() and end().
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
