#include "engine/app/operator/operator.h"

#include <fmt/format.h>
#include <imgui.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <thread>

#include "engine/app/operator/exercise.h"
#include "engine/app/operator/job.h"
#include "engine/app/operator/library.h"
#include "engine/app/operator/state.h"
#include "engine/app/picture_stage.h"
#include "engine/app/scene.h"
#include "engine/app/session_report.h"
#include "engine/app/workbench.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/log.h"
#include "engine/base/units.h"
#include "engine/session/report.h"
#include "engine/session/session_file.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr double kIdleFrame = 1.0;      // s between frames while nothing happens
constexpr double kSessionFrame = 0.05;  // s between frames of this window while a session runs
constexpr Nanos kReviveInterval = 10 * kNanosPerSecond;
constexpr Nanos kScoreInterval = 500'000'000;

/// Opens a file with what the desktop has for it. Returns at once.
void open_with_desktop(const fs::path& file) {
  const pid_t first = fork();
  if (first == 0) {  // the grandchild is nobody's to wait for
    if (fork() == 0) {
      execlp("xdg-open", "xdg-open", file.c_str(), static_cast<char*>(nullptr));
      _exit(127);
    }
    _exit(0);
  }
  if (first > 0) waitpid(first, nullptr, 0);
}

/// This program's output, run with these arguments. Looks at `progress` while it waits.
std::string run_self(const std::string& arguments, Progress& progress) {
  std::error_code code;
  const fs::path self = fs::read_symlink("/proc/self/exe", code);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(
      popen(fmt::format("'{}' {} 2>/dev/null", self.string(), arguments).c_str(), "r"), pclose);
  if (!pipe) throw RunFailure("cannot start " + self.string());
  std::string out;
  std::array<char, 4096> piece;
  while (const std::size_t n = std::fread(piece.data(), 1, piece.size(), pipe.get())) {
    out.append(piece.data(), n);
    progress.at(0.5);
  }
  return out;
}

class Operator {
 public:
  Operator() : window_({}) {
    s_.chinese = can_show(session::Language::kChinese);
    const Remembered r = remembered();
    s_.first_run = !r.any;
    session::Language wanted = session::Language::kEnglish;
    for (const char* name : {"LC_ALL", "LC_MESSAGES", "LANG"}) {
      const char* value = std::getenv(name);
      if (!value || !*value) continue;
      wanted = session::language_named(value).value_or(wanted);
      break;
    }
    set_language(session::language_named(r.language).value_or(wanted));
    r.trainee.copy(s_.trainee.data(), s_.trainee.size() - 1);
    s_.record = r.record;
    rescan();
    for (std::size_t i = 0; i < s_.scenes.size(); ++i)
      if (s_.scenes[i].file.string() == r.scene) s_.scene = static_cast<int>(i);
    for (std::size_t i = 0; i < s_.rigs.size(); ++i)
      if (s_.rigs[i].title == r.rig) s_.rig = static_cast<int>(i);
    for (std::size_t i = 0; i < s_.hands.size(); ++i)
      if (!r.hand.empty() && s_.hands[i].address == r.hand) s_.hand = static_cast<int>(i);
  }

  ~Operator() {
    job_.reset();
    bench_.reset();
    window_.wait_idle();
    for (gpu::Image& picture : s_.pictures) picture.destroy(window_.device());
  }
  Operator(const Operator&) = delete;
  Operator& operator=(const Operator&) = delete;

  void run() {
    while (!quit_) {
      try {
        turn();
      } catch (const gpu::DeviceLost& e) {
        make_anew(e);
      }
    }
    if (bench_) end_session("");
    remember_choice();
  }

 private:
  /// One look at what was done, one frame where there is something to show.
  void turn() {
    {
      const bool due = window_.poll(bench_ || s_.busy ? kSessionFrame : kIdleFrame);
      if (window_.input().close) {
        quit_ = true;
        return;
      }
      bool drew = false;
      if (bench_) drew = step_session();
      const bool finished = look_at_job();
      if (due || drew || finished) {
        draw();
        carry_out();
      } else if (!bench_) {
        std::this_thread::sleep_for(8ms);
      } else {
        std::this_thread::sleep_for(2ms);
      }
    }
  }

  /// Everything that was on the GPU, on a new one; the session goes on meanwhile. A device that is lost again at once
  /// is broken.
  void make_anew(const gpu::DeviceLost& e) {
    if (now() - revived_ < kReviveInterval) throw RunFailure(e.what());
    log::warn("{}; the window is made anew", e.what());
    revived_ = now();
    s_.live = nullptr;
    if (bench_) bench_->drop_picture();
    for (gpu::Image& picture : s_.pictures) picture.destroy(window_.device());
    s_.pictures.clear();
    window_.make_anew();
    rescan();
    if (bench_) bench_->make_picture(window_.device());
  }

  void draw() {
    window_.begin();
    switch (s_.page) {
      case Page::kStart:
        draw_start_page(s_, window_);
        break;
      case Page::kLoading:
        draw_loading_page(s_, window_);
        break;
      case Page::kSession:
        draw_session_page(s_, window_);
        break;
      case Page::kResult:
        draw_result_page(s_, window_);
        break;
      case Page::kDoctor:
        draw_doctor_page(s_, window_);
        break;
    }
    draw_help(s_, window_);
    window_.end();
  }

  void carry_out() {
    const std::vector<Request> asked = std::exchange(s_.asked, {});
    for (const Request& r : asked) {
      try {
        carry_out(r);
      } catch (const gpu::DeviceLost&) {
        throw;
      } catch (const std::exception& e) {
        say(e.what(), true);
        if (s_.page == Page::kLoading) s_.page = Page::kStart;
      }
    }
  }

  void carry_out(const Request& r) {
    switch (r.ask) {
      case Ask::kStart:
      case Ask::kAgain:
        if (!bench_) start_session();
        break;
      case Ask::kEndSession:
        if (bench_) end_session("");
        break;
      case Ask::kEmergencyStop:
        if (!bench_) break;
        bench_->emergency_stop();
        end_session(s_.text("op.was_stopped"));
        break;
      case Ask::kToStart:
        job_.reset();
        authored_.reset();
        s_.busy = false;
        s_.page = Page::kStart;
        say("", false);
        break;
      case Ask::kLanguage:
        set_language(static_cast<session::Language>(r.number));
        rescan();
        break;
      case Ask::kDoctor:
        look_at_computer();
        break;
      case Ask::kRescan:
        rescan();
        break;
      case Ask::kOpenReport:
        if (!s_.outcome.report.empty()) open_with_desktop(s_.outcome.report);
        break;
      case Ask::kOpenFolder:
        open_with_desktop(user_folder());
        break;
      case Ask::kDeleteRecording: {
        std::error_code code;
        fs::remove(s_.outcome.recording, code);
        fs::remove(s_.outcome.report, code);
        s_.outcome.recording = s_.outcome.report = fs::path();
        say(s_.text("op.deleted"), false);
        break;
      }
      case Ask::kSettings:
        if (bench_) bench_->set(s_.settings);
        break;
      case Ask::kTool:
        if (bench_) bench_->choose_tool(r.number);
        break;
      case Ask::kHold:
        if (bench_) bench_->hold(r.number != 0);
        break;
      case Ask::kLoseDevice:
        window_.device().lose();
        break;
      case Ask::kSaveExercise:
        save_exercise();
        break;
      case Ask::kStepDone:
        s_.steps.next();
        break;
      case Ask::kStepBack:
        s_.steps.back();
        break;
      case Ask::kCancel:
        if (job_) job_->progress().cancel();
        break;
      case Ask::kQuit:
        quit_ = true;
        break;
    }
  }

  void say(std::string text, bool error) {
    s_.message = std::move(text);
    s_.message_is_error = error;
    if (error) log::error("{}", s_.message);
  }

  void set_language(session::Language language) {
    if (window_.set_language(language)) s_.language = language;
  }

  void rescan() {
    window_.wait_idle();
    for (gpu::Image& picture : s_.pictures) picture.destroy(window_.device());
    s_.pictures.clear();
    std::vector<fs::path> files;
    s_.scenes = find_scenes(s_, files);
    for (std::size_t i = 0; i < files.size(); ++i) {
      if (files[i].empty()) continue;
      try {
        s_.pictures.push_back(window_.upload(render::read_png(files[i])));
        s_.scenes[i].picture = static_cast<int>(s_.pictures.size()) - 1;
      } catch (const Error& e) {
        log::warn("{}", e.what());
      }
    }
    s_.hands = find_hands(s_);
    s_.rigs = find_rigs(s_);
#ifdef TYPODONT_WINDOW
    s_.monitors = display::monitors();
#endif
    const auto within = [](int& chosen, std::size_t count) {
      chosen = std::clamp(chosen, 0, std::max(static_cast<int>(count) - 1, 0));
    };
    within(s_.scene, s_.scenes.size());
    within(s_.hand, s_.hands.size());
    within(s_.rig, s_.rigs.size());
  }

  void start_session() {
    const SceneChoice& choice = s_.scenes.at(static_cast<std::size_t>(s_.scene));
    const RigChoice& rig = s_.rigs.at(static_cast<std::size_t>(s_.rig));
    const HandEntry& hand = s_.hands.at(static_cast<std::size_t>(s_.hand));
    remember_choice();
    job_.reset();
    s_.busy = false;
    say("", false);
    s_.scene_title = choice.title;
    s_.scene_goal = choice.description;
    s_.steps = {};
    s_.step_shown = -1;
    s_.page = Page::kLoading;
    draw();

    const Scene scene = read_scene(choice.file);
    if (scene.task) {
      s_.steps = StepWatcher(*scene.task);
      if (!scene.task->title.empty()) s_.scene_title = scene.task->title.in(s_.language);
      s_.scene_goal = scene.task->goal.in(s_.language);
    }
    WorkbenchOptions options;
    options.rig = rig.file.string();
    options.hand = hand.address.empty() ? s_.address.data() : hand.address;
    options.trainee = s_.trainee.data();
    options.operated = true;
    authored_.reset();
    strokes_.clear();
    brush_down_ = false;
    s_.strokes = 0;
    authored_scene_ = scene;
    options.embedded = rig.embedded;
    options.device = &window_.device();
    options.monitor = rig.embedded ? -1 : s_.monitor;
    if (s_.record && !s_.author) options.record = new_session_file(options.trainee, scene.name);
    s_.outcome = {};
    s_.outcome.recording = options.record;
    try {
      bench_.emplace(scene, options);
      s_.settings = {};
      s_.tools = tool_names(scene);
      s_.device = bench_->hand();
      s_.recording = bench_->recording();
      s_.score = {};
      s_.forces.fill(0);
      s_.curve_at = 0;
      score_time_ = 0;
      if (PictureStage* stage = bench_->stage()) {
        const display::Screen& screen = stage->rig().screen;
        s_.live_aspect =
            glm::length(screen.lower_right - screen.lower_left) / glm::length(screen.upper_left - screen.lower_left);
        s_.live_upright = display::upright(stage->rig());
      }
      s_.live_is_own = rig.embedded;
      bench_->start();
    } catch (...) {
      window_.wait_idle();
      bench_.reset();
      s_.live = nullptr;
      s_.page = Page::kStart;
      throw;
    }
    s_.page = Page::kSession;
    log::info("session started: {}", scene.name);
  }

  /// True when the trainee's picture changed.
  bool step_session() {
    const std::uint64_t before = s_.status.frames;
    if (!bench_->step(s_.live_input, s_.live_size)) {
      quit_ = Workbench::asked_to_stop();
      end_session("");
      return true;
    }
    if (s_.author) paint();
    s_.status = bench_->status();
    s_.settings = bench_->settings();
    s_.held = bench_->held();
    s_.steps.follow({s_.status.tick, s_.settings, 0, 0, 0});
    PictureStage* stage = bench_->stage();
    s_.live = stage && s_.status.frames > 0 ? &stage->pictures() : nullptr;
    const Nanos t = now();
    if (t - score_time_ > kScoreInterval) {
      score_time_ = t;
      s_.score = bench_->score_so_far();
    }
    if (t - curve_time_ > 25'000'000) {
      curve_time_ = t;
      s_.forces[static_cast<std::size_t>(s_.curve_at)] = static_cast<float>(glm::length(s_.status.tick.f_T_W));
      s_.curve_at = (s_.curve_at + 1) % static_cast<int>(s_.forces.size());
    }
    return s_.status.frames != before;
  }

  void end_session(const std::string& why) {
    s_.score = bench_->score_so_far();
    s_.outcome.score = s_.score;
    s_.live = nullptr;
    s_.page = Page::kResult;
    say(why, !why.empty());
    try {
      s_.outcome.summary = bench_->stop();
    } catch (const std::exception& e) {
      s_.outcome.failure = e.what();
    }
    window_.wait_idle();  // it may still be showing the picture
    if (s_.author && s_.outcome.failure.empty()) {
      authored_ = std::make_unique<haptics::TissueVolume>(bench_->take_tissue());
    }
    bench_.reset();
    log::info("session ended: {:.1f} s", s_.outcome.summary.seconds);
    if (!s_.outcome.recording.empty()) make_report();
  }

  /// The brush follows the tool's head: a ball where it is set down, then one swept as far as it moves.
  void paint() {
    if (!s_.painting) {
      brush_down_ = false;
      return;
    }
    PaintStroke stroke;
    stroke.tissue = s_.paint_tissue;
    stroke.radius = static_cast<double>(s_.paint_radius_mm) * kMillimetre;
    stroke.b_W = s_.status.tick.X_WT.p;
    stroke.a_W = brush_down_ ? strokes_.back().b_W : stroke.b_W;
    if (brush_down_ && glm::length(stroke.b_W - stroke.a_W) < 0.25 * stroke.radius) return;
    bench_->paint(stroke);
    strokes_.push_back(stroke);
    s_.strokes = strokes_.size();
    brush_down_ = true;
  }

  void save_exercise() {
    if (!authored_ || !authored_scene_) return;
    const fs::path file = write_exercise({.name = s_.exercise_name.data(),
                                          .goal = s_.exercise_goal.data(),
                                          .base = &*authored_scene_,
                                          .strokes = strokes_,
                                          .ideal = s_.drilled_is_ideal ? authored_.get() : nullptr});
    rescan();
    for (std::size_t i = 0; i < s_.scenes.size(); ++i)
      if (s_.scenes[i].file == file) s_.scene = static_cast<int>(i);
    say(fmt::format("{} {}", s_.text("op.exercise_saved"), file.string()), false);
    log::info("exercise saved: {}", file.string());
  }

  void make_report() {
    const fs::path recording = s_.outcome.recording, report = fs::path(recording).replace_extension(".html");
    const session::Language language = s_.language;
    const auto score = std::make_shared<session::Score>();
    job_ = std::make_unique<Job>([recording, report, language, score](Progress& progress) {
      progress.stage("op.making_report", 0, 0.6);
      session::repair_session(recording);
      const session::SessionReader reader(recording);
      progress.at(0.2);
      session::ReportOptions options = report_of(reader);
      options.language = language;
      if (!options.score) options.score = session::score_session(reader);
      *score = *options.score;
      progress.stage("op.making_report", 0.6, 1);
      options.earlier = earlier_sessions(recording.parent_path(), reader);
      progress.at(0.5);
      write_file_atomically(report, session::report_html(reader, options));
      progress.at(1);
    });
    when_done_ = [this, report, score] {
      s_.outcome.report = report;
      s_.outcome.score = *score;
      say(s_.text("op.report_ready"), false);
      log::info("report written: {}", report.string());
    };
  }

  void look_at_computer() {
    s_.page = Page::kDoctor;
    s_.first_run = false;
    s_.findings.clear();
    const auto findings = std::make_shared<std::vector<DoctorFinding>>();
    job_ = std::make_unique<Job>([findings](Progress& progress) {
      progress.stage("op.looking", 0, 1);
      const Json json = Json::parse(run_self("doctor --json", progress), "doctor");
      for (const Json& c : json["checks"].items())
        findings->push_back(
            {c["name"].string(), c["state"].string(), c["found"].string(), c["without"].string(), c["mend"].string()});
    });
    when_done_ = [this, findings] { s_.findings = *findings; };
  }

  /// True when it has just ended.
  bool look_at_job() {
    if (!job_) return false;
    s_.busy = !job_->done();
    s_.busy_share = job_->progress().share();
    s_.busy_what = s_.text(job_->progress().what());
    if (s_.busy) return false;
    const auto finished = std::move(job_);
    const auto then = std::exchange(when_done_, {});
    try {
      if (finished->failure()) std::rethrow_exception(finished->failure());
      if (then) then();
    } catch (const Cancelled&) {
      say(s_.text("op.cancelled"), false);
    } catch (const std::exception& e) {
      say(e.what(), true);
    }
    return true;
  }

  void remember_choice() {
    Remembered r;
    r.language = session::tag_of(s_.language);
    r.trainee = s_.trainee.data();
    r.record = s_.record;
    if (!s_.scenes.empty()) r.scene = s_.scenes[static_cast<std::size_t>(s_.scene)].file.string();
    if (!s_.hands.empty()) r.hand = s_.hands[static_cast<std::size_t>(s_.hand)].address;
    if (!s_.rigs.empty()) r.rig = s_.rigs[static_cast<std::size_t>(s_.rig)].title;
    remember(r);
  }

  InterfaceWindow window_;
  OperatorState s_;
  std::optional<Workbench> bench_;
  std::unique_ptr<Job> job_;
  std::function<void()> when_done_;
  std::unique_ptr<haptics::TissueVolume> authored_;  // as an authoring session left it
  std::optional<Scene> authored_scene_;
  std::vector<PaintStroke> strokes_;
  bool brush_down_ = false;
  Nanos revived_ = -kReviveInterval;
  Nanos score_time_ = 0, curve_time_ = 0;
  bool quit_ = false;
};

}  // namespace

void run_operator() {
  Operator op;
  op.run();
}

}  // namespace typodont
