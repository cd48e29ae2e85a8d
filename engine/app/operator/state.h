// The state of the window as plain data. Pages draw it and add requests, which Operator executes between frames. Main
// thread only.
#pragma once

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/app/operator/archive.h"
#include "engine/app/operator/file_field.h"
#include "engine/app/operator/finding.h"
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

enum class Page { kStart, kLoading, kSession, kResult, kDoctor, kArchive, kScan, kFuse, kPlan, kExperiment, kSchool };

enum class Ask {
  kStart,            // start a session with the selection, or the experiment
  kEndSession,       // ramp the force down, complete the recording, end
  kEmergencyStop,    // zero force from the next tick on, then end
  kToStart,          // return to the start page
  kAgain,            // repeat the last session
  kLanguage,         // set the language; number: index of the language
  kDoctor,           // check this computer, as `typodont doctor`
  kRescan,           // search again for scenes, hands and rigs
  kOpenReport,       // open the report, or the experiment's result, in the browser
  kDeleteRecording,  // delete the recording of the session that just ended
  kSettings,         // apply the changed live settings
  kTool,             // take a tool; number: index in the tool set
  kPhaseTool,        // take the instrument of the implant's current phase
  kUndo,             // undo a stroke
  kRedo,             // redo a stroke
  kSaveTissue,       // save the current tissue
  kLook,             // apply the changed OperatorState::look
  kOwnView,          // number: 1 free viewpoint, 0 the trainee's picture
  kLoseDevice,       // for tests: lose the GPU device
  kSaveExercise,     // save painted and drilled tissue as an exercise
  kHold,             // number: 1 stops drill and force, 0 continues
  kStep,             // number: 1 marks the current step as done, -1 the last completed step as not done
  kArchive,          // show recorded sessions and imports
  kExperiment,       // show the page of experiments
  kSchool,           // show the page of the school
  kSchoolSignIn,     // sign in by SchoolForm
  kSchoolSignOut,    // be a guest again
  kSchoolTake,       // get the exercise of the selected assignment, or start the exam
  kSessionReport,    // show the report of the selected session in the browser
  kLearningCurve,    // show the learning curve of the selected session's trainee
  kFilm,             // make a film of the selected session
  kExpert,           // let reports compare with the selected session
  kWatch,            // play the selected session in a separate window
  kExportMesh,       // export the final tissue of the selected session
  kGoOnFrom,         // continue the selected session from its end
  /// Import by ImportForm; on the scan page: import the region.
  kImport,
  kLookAtScan,    // show the scan of ImportForm before its import
  kFuse,          // align the scan of FuseForm with the scan page's CBCT
  kFuseRegister,  // register the intraoral scan by the picked points
  kFuseTake,      // replace the crowns, and return to the scan page
  kFuseBack,      // return to the scan page
  kDropped,       // take the file in OperatorState::dropped
  kPlan,          // plan in the selected exercise's jaw; number: bone class, from 1
  kSavePlan,      // save the planned implant as an exercise
  kNextCase,      // make and select the next case of the trainee's path
  kMakeCase,      // make and select the case of CaseForm
  kTutorial,      // select and start the tutorial
  kCancel,        // cancel the running task, for example an import
  kLeaveKept,     // save, then execute OperatorState::leaving
  kLeaveDropped,  // discard, then execute OperatorState::leaving
  kStay,          // discard the waiting request OperatorState::leaving
  kQuit,
};
/// A hint, or an error.
struct Message {
  std::string text;  // empty: none
  bool is_error = false;
};
struct Request {
  Ask ask;
  int number = 0;
};

struct SceneChoice {
  std::filesystem::path file;
  std::string name;  // name for the files of this scene's recordings
  std::string title, description;
  std::string group;  // heading over the scene (assets/curriculum.json); empty: none
  std::string fault;  // why the scene cannot be used; empty: it can
  int picture = -1;   // index in OperatorState::pictures; -1: none
  std::string model;  // contact model of the scene, or the default
  bool own = false;   // true: made by the user; false: shipped
  // True: implants can be planned in this scene (an implant exercise or an imported volume).
  bool jaw = false;
};
struct HandEntry {
  std::string address;  // empty: the user types the address
  std::string title, detail;
  bool usable = true;
};
struct RigChoice {
  std::filesystem::path file;  // display rig file; empty: the exercise's default rig for a window
  std::string title;
  bool embedded = false;  // true: drawn in the operator's window
};
/// A rule of the score, which an instructor can include in an exercise or leave out.
struct RuleChoice {
  std::string name;
  bool counts = false;
  bool from_ideal = true;  // true: the target is the value of the ideal shape, if there is an ideal shape
  float target = 0, tolerance = 1, weight = 10;
  std::optional<float> critical;  // of the base exercise
};
/// Source of the ideal shape (target shape) for a new exercise.
enum class IdealFrom { kBase, kDrilled, kMesh };
struct ExerciseForm {
  bool fresh = true;  // true: the form is not yet filled with the values of the session
  std::array<char, 96> name{};
  std::array<char, 512> goal{};
  std::array<char, 1024> steps{};  // the steps of the exercise, one per line
  IdealFrom ideal = IdealFrom::kDrilled;
  bool base_aims = false;  // true: the scene on which the exercise is based has a target shape
  bool aims() const { return ideal != IdealFrom::kBase || base_aims; }
  std::array<char, 512> mesh{};  // file with the ideal shape's mesh
  FileChooser chooser;
  float mesh_unit_mm = 1;
  std::vector<RuleChoice> rules;
};
/// The case that the user can make on the start page.
struct CaseForm {
  std::vector<std::pair<std::string, std::string>> families;  // names and titles
  int family = 0, seed = 1;
  float difficulty = 0.5f;
};
constexpr int kScannedSurface = 4;  // value of ImportForm::preset: the mesh itself is carved
struct ImportForm {
  std::array<char, 512> file{};
  FileChooser chooser;
  std::array<char, 96> name{};
  int preset = 0;  // an ImportPreset as a number, or kScannedSurface
  /// Number of the series in a DICOM folder with several, from 1; 0: there is only one.
  int series = 0;
  int crown = 0;  // index in Crown
  // Voxel size (0: that of the file) and thickness of the enamel (0: default), mm.
  float voxel_mm = 0, shell_mm = 0;
  float unit_mm = 1;     // mm per unit of the mesh file
  float spacing_mm = 0;  // mm, distance between a scan's samples; 0: that of the file
};
/// Function of the left mouse button in a section.
enum class ScanTool { kLook, kBrush, kSeed };
/// The scan page. ScanDesk computes labels and draws sections on other threads. Meanwhile the ScanReview must not
/// change, so changes wait.
struct ScanForm {
  std::shared_ptr<ScanReview> review;  // null until the scan is read
  std::vector<std::function<void(ScanReview&)>> changes;
  void change(std::function<void(ScanReview&)> by) {
    if (review) changes.push_back(std::move(by));
  }
  std::size_t large = 0;  // index of the section that is drawn larger
  ScanTool tool = ScanTool::kLook;
  int kind = 0;  // label that the tool paints: a haptics::LabelKind as a number
  float radius_mm = 1;
  bool only_tissue = true;
  // Limits within which labels spread from a seed: distance in mm, and difference of grey values.
  float reach_mm = 5, tolerance = 0.3f;
  glm::ivec3 walls{0};  // for each axis, dragged face of the region: −1 lower, +1 upper, 0 none
  dvec3 mouse_F{0};     // m, in the scan's frame F: the painted stroke's end
  ScanPlanes planes;
  std::vector<gpu::Image> pictures;  // of the planes; empty until drawn
};
/// The fusion page. The page changes the ScanFusion; FuseDesk registers the surfaces and draws them on other threads.
struct FuseForm {
  std::array<char, 512> file{};  // mesh of the intraoral scan
  FileChooser chooser;
  float unit_mm = 1;
  std::shared_ptr<ScanFusion> fusion;  // null until the mesh is read
  glm::vec2 pressed{0};                // pixels, position at which the mouse button was pressed
  bool turning = false;                // true while the mouse turns a surface
  bool changed = false;                // true: the pictures must be drawn again
  std::vector<gpu::Image> pictures;    // of the surfaces; empty until drawn
};
inline constexpr std::array<std::string_view, 4> kBoneClasses{"I", "II", "III", "IV"};
/// The planning page. The page changes the plan; PlanDesk evaluates and draws it on another thread.
struct PlanForm {
  std::shared_ptr<const ImplantPlanner> planner;  // jaw and scene; null until they are loaded
  std::array<char, 96> name{};
  std::vector<ImplantProcedure> procedures;
  int procedure = 0;
  int bone_class = 0;  // class of synthetic bone, 1 to 4; 0: the bone is from a scan
  session::ImplantPlan plan;
  float width_mm = 40;    // mm, width of a section
  bool changed = false;   // true: findings and pictures must be updated
  bool dragging = false;  // true: the mouse moves or tilts the implant
  int drags = 0;          // number of drags so far
  bool tilting = false;   // true while the mouse tilts the implant
  PlanFindings findings;
  PlanPlanes planes;
  std::vector<gpu::Image> pictures;  // of the planes; empty until drawn
};
/// Values of the option --question of `typodont experiment`.
inline constexpr std::array kExperimentQuestions = {"stiffness", "force", "delay", "model"};
constexpr std::size_t kModelQuestion = 3;
struct ExperimentForm {
  int question = 0;                 // index of the question in kExperimentQuestions
  std::array<int, 2> models{0, 1};  // the two compared contact models, as indices in OperatorState::models
  // Largest number of trials for each question; for the question "model", the exact number.
  std::array<int, 4> trials{150, 150, 150, 40};
  float seconds = 4;  // s, duration of each stimulus
};
/// A value with its 95 % confidence interval. A number is NaN if the answers do not determine it.
struct FoundValue {
  double value = 0, low = 0, high = 0;
};
/// Result of a finished experiment.
struct ExperimentFinding {
  std::filesystem::path log, page;  // file of the trials, and HTML page
  std::string person;
  std::size_t question = 0;
  int trials = 0;
  double right = 0;  // %, fraction of right answers; not used for the question "model"
  /// Just-noticeable difference, % or ms. For the question "model": % of the trials in which `models[1]` was chosen.
  FoundValue found;
  std::array<std::string, 2> models;  // names of the two compared contact models; empty for other questions
  /// For the question "model": p-value of the subject's preference.
  double chance = 1;
};
/// The school's service as the window shows it. SchoolDesk asks the service between frames.
struct SchoolForm {
  struct Curve {
    std::string title;
    std::vector<float> points;  // by attempt, 0 to 100
  };
  struct Assignment {
    int number = 0;
    std::string title, due, scene;
    int left = 0;         // attempts
    bool sealed = false;  // true: an exam
    bool files = false;   // true: the exercise must be downloaded
  };
  bool set_up = false;  // true: this computer has a bench's token
  std::array<char, 128> name{}, password{};
  std::string student;  // pseudonym; empty: a guest
  bool hand_in = true;  // true: a student's sessions are handed in at their end
  std::vector<Curve> curves;
  std::vector<Assignment> assignments;
  int assignment = 0;
  bool busy = false;
  Message message;  // state of the last request
};

struct SessionResult {
  session::Score score;
  // Picture of the final surface, coloured by the difference from an ideal shape, if any. Empty: surface unknown.
  render::Picture picture;
  bool compared = false;  // true: the picture shows the difference from the target shape
};
struct Outcome {
  WorkbenchSummary summary;
  std::filesystem::path recording, report;      // files of the session; empty: there is none
  std::shared_ptr<const SessionResult> result;  // null: there is none, or it is still being computed
  std::string failure;
};

struct OperatorState {
  Page page = Page::kStart;
  session::Language language = session::Language::kEnglish;
  bool chinese = false;  // true: this computer has a font for Chinese
  bool first_run = false;
  bool help = false;                 // true: the list of keys is shown
  Message message;                   // in the message line
  std::vector<Request> asked;        // requests of this frame
  std::vector<std::string> to_open;  // files and folders that the desktop should open
  std::optional<Request> leaving;    // request that waits for a decision about unsaved work

  // Data of the start page.
  std::vector<SceneChoice> scenes;
  CaseForm cases;
  std::vector<HandEntry> hands;
  std::vector<RigChoice> rigs;
  std::vector<std::string> models;  // names of the contact models
  int model = -1;                   // index in `models`; -1: the exercise's own model
  std::vector<std::string> monitors;
  int scene_shown = -1;  // scene to which the list was last scrolled
  int scene = 0, hand = 0, rig = 0, monitor = -1;
  std::array<char, 256> address{};  // the hand's address, as typed by the user
  std::array<char, 128> trainee{};
  bool record = true;
  std::string real_time_refused;  // why the system refuses real-time scheduling; empty: it allows it
  /// The user accepts missing real-time scheduling although the device has motors.
  bool no_real_time = false;
  /// Authoring mode: the user paints tissue and drills the ideal shape. The session is not recorded.
  bool author = false;
  std::vector<gpu::Image> pictures;

  // Data of the session page.
  WorkbenchStatus status;
  session::Score score;
  bool score_known = false;    // true: the score was evaluated at least once
  bool score_current = false;  // true: the score includes the latest cuts
  haptics::DeviceInfo device;
  std::string scene_title, scene_goal;
  std::string exam;                // seed of the running or ended exam; empty: no exam
  std::vector<std::string> tools;  // names of the session's tools
  StepWatcher steps;
  bool painting = false;  // true while the brush's button is pressed
  Tissue paint_tissue = Tissue::kCaries;
  float paint_radius_mm = 0.6f;
  float paint_hardness = 1;  // 0 to 1, hardness for the next strokes
  int step_shown = -1;       // step to which the list was last scrolled
  SessionSettings settings;
  bool recording = false;
  bool keep = false;          // true: the recording is kept at the end
  bool own_view = false;      // true: free viewpoint; false: the trainee's picture
  bool trainee_seen = false;  // true: this window can show the trainee's picture
  bool own_possible = false;  // true: this window can show a free viewpoint
  Viewpoint viewpoint;
  Look look;                  // view, colours and visible tissues in this window
  bool look_in_work = false;  // true: parts of the picture are still being computed
  bool has_ideal = false, has_heat = false, has_surroundings = false, has_mirror = false, has_debris = false;
  std::uint32_t tissues = 0;  // tissues of the scene, one bit each
  /// Numbers of the user's changes of `look` and of the viewpoint since the start.
  int look_changes = 0, viewpoint_changes = 0;
  /// Authoring mode: factor on the stiffness of each tissue.
  std::array<float, kTissueCount> stiffness{};
  // Authoring mode: sRGB colour of the brush for each tissue. The tissue's own colour (default) is not stored.
  std::array<glm::vec3, kTissueCount> brush_colors{};
  bool held = false;
  /// Curve of the last seconds: force, N.
  std::array<float, 240> forces{};
  int curve_at = 0;
  const gpu::Image* live = nullptr;  // picture of the left eye; null: none
  glm::dmat2 live_upright{1.0};
  bool live_is_own = false;        // true: this window draws the trainee's picture; false: another window does
  glm::ivec2 live_size{640, 360};  // pixels, size of the picture; set by the session page
  display::UserInput live_input;   // input over the picture; set by the session page
  bool live_hovered = false;
  double live_aspect = 16.0 / 9;  // ratio of the picture's width to its height

  // Data of the result page.
  Outcome outcome;
  std::vector<gpu::Image> result_pictures;  // picture of the result; empty: there is none
  ExerciseForm exercise;

  // Data of the page of recorded sessions.
  std::vector<SessionEntry> sessions;
  int session = 0, mesh_format = 0;
  ImportForm import;
  std::string dropped;

  // The scan page's data. File, name and crown: in ImportForm.
  ScanForm scan;
  FuseForm fuse;
  // Data of the planning page.
  PlanForm plan;
  // Data of the experiment page. Exercise, hand, picture and person are those of the start page.
  ExperimentForm experiment;
  std::optional<ExperimentFinding> experiment_found;

  SchoolForm school;

  // Data of the page about this computer.
  std::vector<DoctorFinding> findings;

  // State of a long task in the background.
  bool busy = false;
  double busy_fraction = 0;
  std::string busy_what;

  void ask(Ask what, int number = 0) { asked.push_back({what, number}); }
  void open(Page next) {
    page = next;
    message = {};
  }
  void say(std::string text) { message = {std::move(text), false}; }
  void fail(std::string text) {
    log::error("{}", text);
    message = {std::move(text), true};
  }
  /// Null: none is selected.
  const SceneChoice* selected_scene() const {
    return scene >= 0 && scene < std::ssize(scenes) ? &scenes[static_cast<std::size_t>(scene)] : nullptr;
  }
  bool can_start() const { return selected_scene() && selected_scene()->fault.empty(); }
  const char* text(std::string_view key) const { return session::text(key, language).data(); }
  /// Returns a text of the catalogue, with its placeholders replaced.
  template <class... Args>
  std::string words(std::string_view key, Args&&... args) const {
    return fmt::format(fmt::runtime(session::text(key, language)), std::forward<Args>(args)...);
  }
  /// A key's translated name: "Ctrl+Z" is "Strg+Z" in German.
  std::string keys(std::string name) const {
    for (const auto& [english, key] : {std::pair{"Ctrl", "op.control"}, std::pair{"Space", "op.space_bar"}})
      if (const std::size_t at = name.find(english); at != std::string::npos)
        name.replace(at, std::string_view(english).size(), text(key));
    return name;
  }
  /// A number with the language's decimal sign.
  std::string number(double value, int decimals) const { return session::number_text(value, decimals, language); }
};

// Draw the pages. Call these functions between InterfaceWindow::begin() and end().
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
void draw_school_page(OperatorState& s, InterfaceWindow& w);
void draw_help(OperatorState& s, InterfaceWindow& w);
/// Asks about unsaved work while OperatorState::leaving contains a request.
void draw_leaving(OperatorState& s, InterfaceWindow& w);

}  // namespace typodont
