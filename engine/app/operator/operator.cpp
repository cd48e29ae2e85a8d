#include "engine/app/operator/operator.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <memory>
#include <thread>
#include <utility>

#include "engine/app/operator/archive.h"
#include "engine/app/operator/child.h"
#include "engine/app/operator/choices.h"
#include "engine/app/operator/fuse_desk.h"
#include "engine/app/operator/library.h"
#include "engine/app/operator/long_work.h"
#include "engine/app/operator/plan_desk.h"
#include "engine/app/operator/scan_desk.h"
#include "engine/app/operator/scene_works.h"
#include "engine/app/operator/school_desk.h"
#include "engine/app/operator/session_desk.h"
#include "engine/app/operator/session_scores.h"
#include "engine/app/operator/session_works.h"
#include "engine/app/operator/state.h"
#include "engine/app/recording/replay.h"
#include "engine/app/recording/resume.h"
#include "engine/app/workbench.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/log.h"
#include "engine/display/keys.h"
#include "engine/session/session_file.h"
#include "haptics/device_safety.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr double kIdleFrame = 60;  // s, time between two frames while nothing happens
// Interval between checks for changes that the desktop does not report, ns.
constexpr Nanos kIdleWait = 25'000'000;
// If the wait for input ends earlier than this, the loop pauses, ns.
constexpr Nanos kShortWait = 4'000'000;
constexpr double kSessionFrame = 0.05;  // s, interval between this window's frames during a session

struct PageEntry {
  void (*draw)(OperatorState&, InterfaceWindow&);
  const char* title;  // key of its text in the window's title; null: none
};
const std::map<Page, PageEntry> kPages{{Page::kStart, {draw_start_page, nullptr}},
                                       {Page::kLoading, {draw_loading_page, nullptr}},
                                       {Page::kSession, {draw_session_page, nullptr}},
                                       {Page::kResult, {draw_result_page, "op.result"}},
                                       {Page::kDoctor, {draw_doctor_page, "op.check_computer"}},
                                       {Page::kArchive, {draw_archive_page, "op.archive"}},
                                       {Page::kScan, {draw_scan_page, "op.scan"}},
                                       {Page::kFuse, {draw_fuse_page, "op.fuse"}},
                                       {Page::kPlan, {draw_plan_page, "op.plan"}},
                                       {Page::kExperiment, {draw_experiment_page, "op.experiment"}},
                                       {Page::kSchool, {draw_school_page, "op.school"}}};

/// Draws the pages, and executes their requests between two frames.
class Operator {
 public:
  ~Operator() { destroy_pictures(); }

  void run() {
    try {
      while (!quit_) {
        try {
          turn();
        } catch (const gpu::DeviceLost& e) {
          recreate_device(e);
        }
      }
    } catch (...) {
      leave();
      throw;
    }
    leave();
    choices_.remember();
  }

 private:
  /// At the end, also after an error: ends the session and stores an author's work.
  void leave() noexcept {
    try {
      work_.drop();
      if (desk_.started()) {
        (void)desk_.end("");
        school_.hand_in(s_.outcome.recording);
      }
      if (const Authored* made = desk_.authored(); made && made->unsaved)
        log::warn("not yet saved, kept as an exercise: {}", keep_exercise(s_, *made).string());
    } catch (const std::exception& e) {
      log::error("{}", e.what());
    }
  }

  /// One pass of the loop: reads input, and draws a frame if something has changed.
  void turn() {
    const auto moving = [&] { return desk_.running() && !desk_.at_rest(); };
    const bool due = window_.poll(moving() || s_.busy ? kSessionFrame : kIdleFrame);
    if (window_.input().close) {
      quit_ = true;
      return;
    }
    // Dropped files are ignored during sessions and long tasks.
    const std::vector<std::string>& dropped = window_.input().dropped;
    if (!dropped.empty() && !desk_.running() && !work_.under_way()) {
      s_.dropped = joined_files(dropped);
      s_.ask(Ask::kDropped);
    }
    const bool drew = desk_.running() && step_session();
    const bool finished = work_.look() || plan_desk_.look() || scan_desk_.look() || fuse_desk_.look() ||
                          school_.look() || look_around() || look_at_started();
    if (due || drew || finished) {
      draw();
      carry_out();
    } else if (moving()) {
      std::this_thread::sleep_for(2ms);
    } else {
      const Nanos since = now();
      window_.output().wait(kIdleWait);
      // A mouse can send a thousand events per second, so the loop pauses.
      if (now() - since < kShortWait) std::this_thread::sleep_for(4ms);
    }
  }

  /// While the window is idle: loads the selected scene's picture, computes missing scores, searches for devices.
  bool look_around() {
    if (desk_.running() || work_.under_way()) return false;
    if (s_.page == Page::kArchive) return scores_.look();
    return s_.page == Page::kStart && (choices_.pictures().look() || choices_.look_at_devices());
  }

  /// Opens requested files, and reports failures of started programs.
  bool look_at_started() {
    for (const std::string& file : std::exchange(s_.to_open, {})) started_.open(file);
    const auto failed = started_.look();
    if (!failed) return false;
    s_.fail(failed->file.empty() ? failed->words : s_.words("op.not_opened", failed->file));
    return true;
  }

  /// Creates the GPU device again while the session continues. Throws RunFailure if the GPU is broken.
  void recreate_device(const gpu::DeviceLost& e) {
    if (now() - revived_ < gpu::kReviveInterval) throw RunFailure(e.what());
    log::warn("{}; the window is created again", e.what());
    revived_ = now();
    s_.live = nullptr;
    desk_.drop_picture();
    destroy_pictures();
    window_.recreate_device();
    choices_.rescan();
    desk_.make_picture();
  }

  /// Frees the GPU memory of all uploaded pictures. They are uploaded again when a page needs them.
  void destroy_pictures() {
    for (auto* pictures : {&s_.pictures, &s_.result_pictures, &s_.scan.pictures, &s_.fuse.pictures, &s_.plan.pictures})
      window_.replace(*pictures, {});
    uploaded_result_.reset();
  }

  void upload_result() {
    if (uploaded_result_ == s_.outcome.result) return;
    uploaded_result_ = s_.outcome.result;
    const bool any = uploaded_result_ && !uploaded_result_->picture.rgba.empty();
    window_.replace(s_.result_pictures, std::span(any ? &uploaded_result_->picture : nullptr, any ? 1u : 0u));
  }

  /// Window title: name of the page; during a session, also the trainee.
  std::string title() const {
    const char* const name = kPages.at(s_.page).title;
    const bool of_scene = s_.page == Page::kLoading || s_.page == Page::kSession || s_.page == Page::kResult;
    std::string title = "Typodont";
    if (of_scene) title += ": " + s_.scene_title;
    if (name) title += (of_scene ? ", " : ": ") + std::string(s_.text(name));
    return title;
  }

  void draw() {
    window_.set_title(title());
    upload_result();
    const bool shown = !(s_.live_is_own && desk_.drawing());
    window_.begin(s_.page == Page::kSession || s_.page == Page::kLoading);
    kPages.at(s_.page).draw(s_, window_);
    draw_help(s_, window_);
    draw_leaving(s_, window_);
    window_.end(shown);
  }

  void carry_out() {
    const std::vector<Request> asked = std::exchange(s_.asked, {});
    for (const Request& r : asked) {
      try {
        if (s_.page == Page::kLoading && !allowed_while_loading(r.ask)) continue;
        if (r.ask == Ask::kLanguage && desk_.drawing()) continue;  // new fonts would wait for the GPU
        if (s_.leaving) {
          answer(r.ask);
        } else if (leads_away(r.ask) && unsaved()) {
          s_.leaving = r;
        } else if (!desk_.carry_out(r)) {
          carry_out(r);
        }
      } catch (const gpu::DeviceLost&) {
        throw;
      } catch (const std::exception& e) {
        s_.fail(e.what());
      }
    }
  }

  /// False for requests that could replace the set-up of a session, such as a second key in the frame of the start.
  static bool allowed_while_loading(Ask ask) {
    constexpr std::array kAllowed = {Ask::kCancel,   Ask::kEndSession, Ask::kEmergencyStop, Ask::kHold,
                                     Ask::kLanguage, Ask::kLoseDevice, Ask::kQuit};
    return std::ranges::find(kAllowed, ask) != kAllowed.end();
  }

  /// True if the request would discard an author's unsaved work.
  static bool leads_away(Ask ask) {
    constexpr std::array kAway = {Ask::kStart,      Ask::kAgain,  Ask::kToStart,  Ask::kTutorial, Ask::kArchive,
                                  Ask::kDropped,    Ask::kDoctor, Ask::kGoOnFrom, Ask::kPlan,     Ask::kExperiment,
                                  Ask::kLookAtScan, Ask::kSchool, Ask::kQuit};
    return std::find(kAway.begin(), kAway.end(), ask) != kAway.end();
  }
  bool unsaved() {
    const Authored* made = desk_.authored();
    return made && made->unsaved && !desk_.running();
  }

  /// Executes or discards the waiting request after the user's answer.
  void answer(Ask ask) {
    if (ask != Ask::kLeaveKept && ask != Ask::kLeaveDropped && ask != Ask::kStay) return;
    const Request wanted = *std::exchange(s_.leaving, {});
    if (ask == Ask::kStay) return;
    std::string kept;
    if (ask == Ask::kLeaveKept) {
      kept = keep_exercise(s_, *desk_.authored()).string();
      log::info("kept as an exercise: {}", kept);
    }
    desk_.forget_authored();
    if (!kept.empty()) choices_.rescan();
    carry_out(wanted);
    if (!kept.empty() && s_.page != Page::kLoading) s_.say(fmt::format("{} {}", s_.text("op.kept_exercise"), kept));
  }

  /// Executes requests that do not concern a running session; SessionDesk executes the others.
  void carry_out(const Request& r) {
    switch (r.ask) {
      case Ask::kStart:
      case Ask::kAgain:
        if (s_.page == Page::kExperiment)
          begin_experiment();
        else
          start_session({});
        break;
      case Ask::kGoOnFrom:
        return start_session(s_.page == Page::kArchive ? chosen_session().file : s_.outcome.recording);
      case Ask::kNextCase:
      case Ask::kMakeCase:
        return begin_case(s_, work_, choices_, r.ask == Ask::kNextCase);
      case Ask::kTutorial:
        choices_.choose_tutorial();
        start_session({});
        break;
      case Ask::kEndSession:
        if (desk_.running()) end_session("");
        break;
      case Ask::kEmergencyStop:
        if (!desk_.running()) break;
        desk_.emergency_stop();
        end_session(s_.text("op.was_stopped"));
        break;
      case Ask::kToStart:
        work_.drop();
        plan_desk_.close();
        fuse_desk_.close();
        scan_desk_.close();
        desk_.forget_authored();
        s_.open(Page::kStart);
        break;
      case Ask::kLanguage:
        choices_.set_language(static_cast<session::Language>(r.number));
        choices_.rescan();
        break;
      case Ask::kRescan:
        return choices_.rescan();
      case Ask::kDoctor:
        return look_at_computer();
      case Ask::kOpenReport:
        if (s_.page == Page::kExperiment)
          s_.to_open.push_back(s_.experiment_found->page.string());
        else if (!s_.outcome.report.empty())
          s_.to_open.push_back(s_.outcome.report.string());
        break;
      case Ask::kDeleteRecording:
        work_.drop();  // cancels tasks that may use this recording, e.g. a report
        fs::remove(s_.outcome.report);
        // If this throws, s_.outcome.recording keeps its path, so the user can try again.
        fs::remove(s_.outcome.recording);
        s_.outcome.recording = s_.outcome.report = fs::path();
        s_.say(s_.text("op.deleted"));
        break;
      case Ask::kSaveExercise:
        if (Authored* authored = desk_.authored()) save_exercise(s_, work_, choices_, *authored);
        break;
      case Ask::kArchive:
        return open_archive();
      case Ask::kExperiment:
        return s_.open(Page::kExperiment);
      case Ask::kSchool:
        s_.open(Page::kSchool);
        school_.refresh();
        break;
      case Ask::kSchoolSignIn:
        return school_.sign_in();
      case Ask::kSchoolSignOut:
        return school_.sign_out();
      case Ask::kSchoolTake:
        return school_.take();
      case Ask::kDropped:
        if (s_.page == Page::kScan && take_dropped_mesh(s_)) {
          fuse_desk_.open();
          break;
        }
        fuse_desk_.close();
        scan_desk_.close();
        open_archive();
        if (take_dropped(s_)) scan_desk_.open();
        break;
      case Ask::kFuse:
        return fuse_desk_.open();
      case Ask::kFuseRegister:
        return fuse_desk_.register_points();
      case Ask::kFuseTake:
        return fuse_desk_.take();
      case Ask::kFuseBack:
        fuse_desk_.close();
        s_.open(Page::kScan);
        break;
      case Ask::kLookAtScan:
        return scan_desk_.open();
      case Ask::kPlan:
        return plan_desk_.open(work_, s_.page == Page::kPlan ? r.number : 0);
      case Ask::kSavePlan:
        return save_plan(s_, work_, choices_);
      case Ask::kSessionReport:
        return show_report(s_, work_, chosen_session());
      case Ask::kLearningCurve:
        return make_curve(s_, work_, chosen_session());
      case Ask::kFilm:
        return make_film(s_, work_, chosen_session());
      case Ask::kWatch:
        return started_.self({"replay", chosen_session().file.string(), "--show"});
      case Ask::kExpert:
        make_expert(chosen_session().file);
        list_sessions(s_);
        s_.say(s_.text("op.is_expert"));
        break;
      case Ask::kExportMesh:
        return make_surface(s_, work_, chosen_session());
      case Ask::kImport:
        if (s_.page == Page::kScan)
          scan_desk_.import(choices_);
        else
          import_tooth(s_, work_, choices_);
        break;
      case Ask::kCancel:
        work_.cancel();
        desk_.cancel_start();
        break;
      case Ask::kLoseDevice:
        return window_.device().lose();
      case Ask::kQuit:
        quit_ = true;
        break;
      default:
        break;  // SessionDesk executes all other requests
    }
  }

  /// Starts a session. `from`: session or preparation to continue; empty: the selected scene.
  void start_session(const fs::path& from) {
    if (desk_.running() || s_.page == Page::kLoading) return;
    // Ends an emergency stop of an earlier session. A stop during the set-up stays in force.
    haptics::set_emergency_stop(false);
    const SceneChoice& choice = s_.scenes.at(static_cast<std::size_t>(s_.scene));
    const RigChoice& rig = s_.rigs.at(static_cast<std::size_t>(s_.rig));
    const HandEntry& hand = s_.hands.at(static_cast<std::size_t>(s_.hand));
    const fs::path file = from.empty() ? choice.file : scene_file_of(from);
    choices_.remember();
    work_.drop();
    choices_.pictures().drop();  // the session needs all processors
    scores_.drop();
    s_.say("");
    s_.scene_title = from.empty() ? choice.title : from.stem().string();
    s_.scene_goal = from.empty() ? choice.description : "";
    // A continued preparation keeps its contact model.
    const std::string model = from.empty() && s_.model >= 0 ? s_.models[static_cast<std::size_t>(s_.model)] : "";
    const auto read = [from, file, model, author = s_.author] {
      Scene scene = file.empty() ? scene_of(session::SessionReader(from)) : read_scene(file);
      if (!from.empty()) scene = with_resume(scene, from);
      if (!model.empty()) choose_model(scene, model);
      // The author's brush changes the distance field, so contact and picture must use the field.
      if (author && draws_own_surface(scene)) scene.servo.method = nullptr;
      return scene;
    };
    desk_.start(read, rig, hand.address.empty() ? s_.address.data() : hand.address);
  }

  void begin_experiment() {
    choices_.remember();
    choices_.pictures().drop();  // the experiment needs all processors
    scores_.drop();
    s_.say("");
    make_experiment(s_, work_);
  }

  /// The scene file of a saved preparation. The preparation's file name states the name of the scene. Empty for a
  /// recording, because a recording contains its scene.
  fs::path scene_file_of(const fs::path& from) const {
    if (from.extension() != ".vdb") return {};
    for (const SceneChoice& choice : s_.scenes)
      if (choice.fault.empty() && file_name_of(choice.name) == chosen_session().scene) return choice.file;
    throw Error(from.string(), "", fmt::format("no exercise \"{}\"", chosen_session().scene),
                "the exercise in which it was made");
  }

  /// Runs one session step. True: the trainee's picture changed.
  bool step_session() {
    const SessionDesk::Turn turn = desk_.step();
    if (turn == SessionDesk::Turn::kOver) {
      quit_ = Workbench::asked_to_stop();
      end_session("");
    }
    return turn != SessionDesk::Turn::kSame;
  }

  void end_session(const std::string& why) {
    if (!desk_.started()) return desk_.cancel_start();
    const auto unscored = desk_.end(why);
    school_.hand_in(s_.outcome.recording);
    if (!s_.outcome.recording.empty())
      make_report(s_, work_, s_.outcome.recording);
    else if (unscored)
      make_score(s_, work_, unscored);
  }

  void open_archive() {
    s_.open(Page::kArchive);
    list_sessions(s_);
    s_.session = std::clamp(s_.session, 0, std::max(static_cast<int>(s_.sessions.size()) - 1, 0));
  }
  const SessionEntry& chosen_session() const { return s_.sessions.at(static_cast<std::size_t>(s_.session)); }

  void look_at_computer() {
    s_.page = Page::kDoctor;
    s_.first_run = false;
    s_.findings.clear();
    work_.make(
        [](Progress& progress) {
          progress.stage("op.looking", 0, 1);
          std::vector<DoctorFinding> findings;
          const Json json = Json::parse(run_self({"doctor", "--json"}, progress), "doctor");
          for (const Json& c : json["checks"].items()) {
            DoctorFinding& finding = findings.emplace_back(c["id"].string(), c["name"].string());
            finding.state = part_state_named(c["state"].string());
            finding.found = c["found"].string();
            finding.without = c["without"].string();
            finding.mend = c["mend"].string();
            finding.required = c["required"].boolean();
          }
          return findings;
        },
        [this](std::vector<DoctorFinding> findings) {
          s_.findings = std::move(findings);
          log::info("computer checked: {} findings", s_.findings.size());
        });
  }

  // The emergency keys work on every page. Starting a session ends an earlier emergency stop.
  InterfaceWindow window_{InterfaceWindow::Options{
      .urgent = {{' ', display::keys::kEscape, 'H'}, [](int) { haptics::set_emergency_stop(true); }}}};
  OperatorState s_;
  Choices choices_{s_, window_};
  std::shared_ptr<const SessionResult> uploaded_result_;  // the result whose picture is on the GPU
  PlanDesk plan_desk_{s_, window_};
  SessionScores scores_{s_};
  SchoolDesk school_{s_, window_, choices_};
  Started started_;
  BackgroundTask work_{s_};  // leave() ends it before anything that it uses is destroyed
  SessionDesk desk_{s_, window_, work_};
  ScanDesk scan_desk_{s_, window_, work_};
  FuseDesk fuse_desk_{s_, window_, work_};
  Nanos revived_ = -gpu::kReviveInterval;
  bool quit_ = false;
};

}  // namespace

void run_operator() {
  Operator op;
  try {
    op.run();
    // Once the window is open, an error is no longer a usage error: RunFailure gives exit status 1.
  } catch (const Error& e) {
    throw RunFailure(e.what());
  }
}

}  // namespace typodont
