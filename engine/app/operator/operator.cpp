#include "engine/app/operator/operator.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <thread>

#include "engine/app/operator/archive.h"
#include "engine/app/operator/child.h"
#include "engine/app/operator/exercise.h"
#include "engine/app/operator/job.h"
#include "engine/app/operator/library.h"
#include "engine/app/operator/state.h"
#include "engine/app/picture/live_views.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/recording/replay.h"
#include "engine/app/recording/resume.h"
#include "engine/app/recording/session_report.h"
#include "engine/app/scene.h"
#include "engine/app/workbench.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/log.h"
#include "engine/base/units.h"
#include "engine/session/report.h"
#include "engine/session/session_file.h"
#include "haptics/devices/driver.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr double kIdleFrame = 60;       // s between frames while nothing happens
constexpr Nanos kIdleWait = 21'000'000;  // ns, between looks at what is no event of the desktop
constexpr double kSessionFrame = 0.05;  // s between frames of this window while a session runs
constexpr Nanos kReviveInterval = 10 * kNanosPerSecond;
constexpr Nanos kDeviceInterval = 2 * kNanosPerSecond;  // between two looks at what is plugged in: each takes milliseconds
constexpr Nanos kScoreInterval = 500'000'000;

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
    s_.monitor = r.monitor;
    rescan();
    for (std::size_t i = 0; i < s_.scenes.size(); ++i)
      if (s_.scenes[i].file.string() == r.scene) s_.scene = static_cast<int>(i);
    for (std::size_t i = 0; i < s_.rigs.size(); ++i)
      if (s_.rigs[i].title == r.rig) s_.rig = static_cast<int>(i);
    if (!r.hand.empty()) choose_hand(r.hand);
  }

  ~Operator() {
    job_.reset();
    picture_job_.reset();
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
      const bool due = window_.poll((bench_ && !at_rest_) || s_.busy ? kSessionFrame : kIdleFrame);
      if (window_.input().close) {
        quit_ = true;
        return;
      }
      bool drew = false;
      if (bench_) drew = step_session();
      const bool finished = look_at_job() || look_at_pictures() || look_at_devices();
      if (due || drew || finished) {
        draw();
        carry_out();
      } else if (bench_ && !at_rest_) {
        std::this_thread::sleep_for(2ms);
      } else {
        std::this_thread::sleep_for(4ms);  // a mouse says where it is a thousand times a second
        window_.output().wait(kIdleWait);
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
      case Page::kArchive:
        draw_archive_page(s_, window_);
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
        if (!bench_) start_session({});
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
        if (!s_.outcome.report.empty()) open_with_desktop(s_.outcome.report.string());
        break;
      case Ask::kOpenFolder:
        open_with_desktop(user_folder().string());
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
      case Ask::kUndo:
        if (bench_) bench_->ask(TissueCommand::kUndo);
        break;
      case Ask::kRedo:
        if (bench_) bench_->ask(TissueCommand::kRedo);
        break;
      case Ask::kSaveTissue:
        if (!bench_) break;
        bench_->ask(TissueCommand::kSave);
        say(fmt::format("{} {}", s_.text("op.saved_as"), saved_.filename().string()), false);
        break;
      case Ask::kKeep:
        s_.keep = r.number != 0;
        break;
      case Ask::kLook:
        change_look();
        break;
      case Ask::kOwnView:
        show_own_view(r.number != 0);
        break;
      case Ask::kColor: {
        if (!bench_) break;
        const auto& c = s_.colors[static_cast<std::size_t>(r.number)];
        s_.live = nullptr;
        window_.wait_idle();
        bench_->color(static_cast<Tissue>(r.number), {c[0], c[1], c[2]});
        break;
      }
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
      case Ask::kArchive:
        open_archive();
        break;
      case Ask::kSessionReport:
        show_report(chosen_session());
        break;
      case Ask::kLearningCurve:
        make_curve(chosen_session());
        break;
      case Ask::kFilm:
        make_film(chosen_session());
        break;
      case Ask::kWatch:
        start_self({"replay", chosen_session().file.string(), "--show"});
        break;
      case Ask::kExportMesh:
        export_mesh(chosen_session());
        break;
      case Ask::kGoOnFrom:
        if (!bench_) start_session(s_.page == Page::kArchive ? chosen_session().file : s_.outcome.recording);
        break;
      case Ask::kImport:
        import();
        break;
      case Ask::kTutorial:
        for (std::size_t i = 0; i < s_.scenes.size(); ++i)
          if (s_.scenes[i].file.stem() == "tutorial" && !s_.scenes[i].own) s_.scene = static_cast<int>(i);
        s_.first_run = s_.author = false;
        if (!bench_) start_session({});
        break;
      case Ask::kWelcomed:
        s_.first_run = false;
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
    std::string texts;
    for (const SceneChoice& scene : s_.scenes) texts += scene.title + scene.description;
    window_.will_show(texts);
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

  /// `from`: a recorded session to go on from; empty: the scene that is chosen.
  void start_session(const fs::path& from) {
    const SceneChoice& choice = s_.scenes.at(static_cast<std::size_t>(s_.scene));
    const RigChoice& rig = s_.rigs.at(static_cast<std::size_t>(s_.rig));
    const HandEntry& hand = s_.hands.at(static_cast<std::size_t>(s_.hand));
    remember_choice();
    job_.reset();
    s_.busy = false;
    say("", false);
    s_.scene_title = from.empty() ? choice.title : from.stem().string();
    s_.scene_goal = from.empty() ? choice.description : "";
    s_.steps = {};
    s_.step_shown = -1;
    picture_job_.reset();  // the session wants the computer for itself
    const Page before = s_.page;
    s_.page = Page::kLoading;
    draw();
    s_.page = before;  // where the session cannot begin

    const Scene scene = from.empty() ? read_scene(choice.file) : with_resume(scene_of(session::SessionReader(from)), from);
    if (scene.task) {
      s_.steps = StepWatcher(*scene.task);
      if (!scene.task->title.empty()) s_.scene_title = scene.task->title.in(s_.language);
      s_.scene_goal = scene.task->goal.in(s_.language);
      std::string texts = s_.scene_title + s_.scene_goal;
      for (const session::TaskText& step : scene.task->steps) texts += step.in(s_.language);
      window_.will_show(texts);
    }
    WorkbenchOptions options;
    options.rig = rig.file.string();
    options.hand = hand.address.empty() ? s_.address.data() : hand.address;
    options.trainee = s_.trainee.data();
    options.operated = true;
    authored_.reset();
    strokes_.clear();
    brush_down_ = false;
    authored_scene_ = scene;
    options.embedded = rig.embedded;
    options.device = &window_.device();
    options.monitor = rig.embedded ? -1 : s_.monitor;
    // A session is written down from its beginning, wherever that is kept, so that it may still be kept at its end.
    s_.keep = s_.record && !s_.author;
    recording_ = s_.author ? fs::path() : new_session_file(options.trainee, scene.name);
    written_ = s_.keep || s_.author ? recording_ : unkept_file();
    options.record = written_;
    saved_ = new_session_file(options.trainee, scene.name).replace_extension(".vdb");
    options.save = saved_;
    options.save_at_end = false;
    s_.outcome = {};
    try {
      bench_.emplace(scene, options);
      s_.settings = {};
      s_.stiffness.fill(1);
      for (std::size_t i = 0; i < s_.colors.size(); ++i) {
        const dvec3 c = scene.servo.materials[i].color;
        s_.colors[i] = {static_cast<float>(c.x), static_cast<float>(c.y), static_cast<float>(c.z)};
      }
      s_.tools.clear();
      for (const haptics::Tool& tool : haptics::tray(scene.servo)) s_.tools.push_back(tool_title(tool));
      s_.device = bench_->hand();
      s_.recording = bench_->recording();
      s_.score = {};
      s_.score_known = false;
      s_.forces.fill(0);
      s_.curve_at = 0;
      score_time_ = 0;
      if (PictureStage* stage = bench_->stage()) {
        const display::Screen& screen = stage->rig().screen;
        s_.live_aspect =
            glm::length(screen.lower_right - screen.lower_left) / glm::length(screen.upper_left - screen.lower_left);
        s_.live_upright = display::upright(stage->rig());
      }
      begin_views(scene);
      s_.live_is_own = rig.embedded;
      bench_->start();
    } catch (...) {
      window_.wait_idle();
      bench_.reset();
      s_.live = nullptr;
      throw;
    }
    if (!rig.embedded && s_.trainee_seen) {
      window_.output().leave_monitor(s_.monitor);
      window_.output().take_focus();
    }
    s_.page = Page::kSession;
    log::info("session started: {}", scene.name);
  }

  /// True when the trainee's picture changed.
  bool step_session() {
    const WorkbenchStatus before = s_.status;
    bench_->look_from(s_.viewpoint, s_.own_view ? s_.live_size : glm::ivec2(0));
    if (!bench_->step(s_.live_input, s_.live_size)) {
      quit_ = Workbench::asked_to_stop();
      end_session("");
      return true;
    }
    if (s_.author) paint();
    s_.status = bench_->status();
    s_.settings = bench_->settings();
    s_.held = bench_->held();
    const int step = s_.steps.current();
    if (s_.steps.follow({s_.status.tick, s_.settings, static_cast<int>(s_.status.tissue.undone),
                     static_cast<int>(s_.status.tissue.redone), s_.look_changes, s_.held}))
      log::info("step {} done", step + 1);
    PictureStage* stage = bench_->stage();
    s_.live = s_.own_view                           ? bench_->own_picture()
              : stage && bench_->status().frames > 0 ? &stage->pictures()
                                                     : nullptr;
    s_.look_in_work = bench_->views()->making(s_.own_view ? Eyes::kOwn : Eyes::kTrainee);
    const Nanos t = now();
    if (t - score_time_ > kScoreInterval) {
      score_time_ = t;
      s_.score = bench_->score_so_far();
      s_.score_known = bench_->views()->score_known();
    }
    if (t - curve_time_ > 25'000'000) {
      curve_time_ = t;
      s_.forces[static_cast<std::size_t>(s_.curve_at)] = static_cast<float>(glm::length(s_.status.tick.f_T_W));
      s_.curve_at = (s_.curve_at + 1) % static_cast<int>(s_.forces.size());
    }
    at_rest_ = nothing_moves(before);
    const bool next_second = std::floor(before.seconds) != std::floor(s_.status.seconds);  // the clock's
    return s_.status.frames + s_.status.own_frames != before.frames + before.own_frames || next_second;
  }

  /// Nothing that the session's page shows has changed but the clock, nor will, of itself.
  bool nothing_moves(const WorkbenchStatus& before) const {
    const WorkbenchStatus& is = s_.status;
    return is.tick.X_WT.p == before.tick.X_WT.p && is.tick.X_WT.R == before.tick.X_WT.R && is.tick.spindle == before.tick.spindle && is.tick.tool == before.tick.tool &&
           is.tick.cuts == before.tick.cuts && is.tissue.version == before.tissue.version && is.faults == before.faults &&
           is.frames == before.frames && is.own_frames == before.own_frames && !s_.look_in_work &&
           std::all_of(s_.forces.begin(), s_.forces.end(), [](float f) { return f == 0; });
  }

  /// What may be looked at in this session, and how.
  void begin_views(const Scene& scene) {
    const LiveViews& views = *bench_->views();
    s_.look = {};
    s_.look_changes = 0;
    s_.trainee_seen = bench_->stage() != nullptr;
    s_.own_possible = scene.needs("render");
    s_.own_view = !s_.trainee_seen && s_.own_possible;
    s_.viewpoint = {};
    if (s_.trainee_seen) {
      const double distance = s_.viewpoint.distance;
      s_.viewpoint = viewpoint_of(bench_->stage()->rig(), views.middle());
      s_.viewpoint.distance = distance;
    }
    s_.has_ideal = views.has_ideal();
    s_.has_surroundings = views.has_surroundings();
    s_.has_mirror = scene.mouth_mirror.diameter > 0;
    s_.has_debris = scene.needs("debris");
    s_.tissues = views.tissues();
    if (s_.author) s_.tissues |= 1u << static_cast<unsigned>(Tissue::kCaries);
  }

  void change_look() {
    if (!bench_) return;
    bench_->views()->look(s_.own_view ? Eyes::kOwn : Eyes::kTrainee, s_.look);
    ++s_.look_changes;
  }

  void show_own_view(bool own) {
    if (!bench_ || own == s_.own_view) return;
    s_.own_view = own;
    s_.live = nullptr;
    s_.look = bench_->views()->look(own ? Eyes::kOwn : Eyes::kTrainee);
    ++s_.look_changes;
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
      strokes_ = bench_->painted();
      s_.exercise.rules = rule_choices(*authored_scene_);
      s_.exercise.base_aims = authored_scene_->task && authored_scene_->task->ideal;
      s_.exercise.fresh = true;
      authored_ = std::make_unique<haptics::TissueVolume>(bench_->take_tissue());
    }
    bench_.reset();
    log::info("session ended: {:.1f} s", s_.outcome.summary.seconds);
    keep_recording();
    if (!s_.outcome.recording.empty()) make_report();
  }

  /// In the trainee's folder, or nowhere.
  void keep_recording() {
    s_.outcome.recording.clear();
    if (!s_.recording) return;
    std::error_code code;
    if (!s_.keep) {
      fs::remove(written_, code);
      return;
    }
    if (written_ != recording_) fs::rename(written_, recording_, code);
    s_.outcome.recording = code ? written_ : recording_;
  }

  /// The brush follows the tool's head: a ball where it is set down, then one swept as far as it moves.
  void paint() {
    if (!s_.painting) {
      brush_down_ = false;
      return;
    }
    BrushMove move;
    PaintStroke& stroke = move.stroke;
    stroke.tissue = s_.paint_tissue;
    stroke.radius = static_cast<double>(s_.paint_radius_mm) * kMillimetre;
    stroke.b_W = s_.status.tick.X_WT.p;
    stroke.a_W = brush_down_ ? brush_at_ : stroke.b_W;
    if (brush_down_ && glm::length(stroke.b_W - stroke.a_W) < 0.25 * stroke.radius) return;
    move.begins = !brush_down_;
    bench_->paint(move);
    brush_at_ = stroke.b_W;
    brush_down_ = true;
  }

  void save_exercise() {
    if (!authored_ || !authored_scene_) return;
    const ExerciseForm& form = s_.exercise;
    NewExercise made{.name = form.name.data(),
                     .goal = form.goal.data(),
                     .base = &*authored_scene_,
                     .strokes = strokes_,
                     .ideal = form.ideal == IdealFrom::kDrilled ? authored_.get() : nullptr,
                     .ideal_mesh = form.ideal == IdealFrom::kMesh ? form.mesh.data() : "",
                     .mesh_unit_mm = static_cast<double>(form.mesh_unit_mm)};
    std::istringstream lines(form.steps.data());
    for (std::string line; std::getline(lines, line);)
      if (line.find_first_not_of(" \t") != std::string::npos) made.steps.push_back(line);
    for (std::size_t i = 1; i < kTissueCount; ++i) {
      made.tissues[i].stiffness = static_cast<double>(s_.stiffness[i]);
      const dvec3 is(s_.colors[i][0], s_.colors[i][1], s_.colors[i][2]);
      if (glm::length(is - authored_scene_->servo.materials[i].color) > 2e-3) made.tissues[i].color = is;
    }
    if (std::any_of(form.rules.begin(), form.rules.end(), [](const RuleChoice& r) { return r.counts; }))
      made.rules = form.rules;
    if (made.rules)
      for (RuleChoice& rule : *made.rules) rule.from_ideal = rule.from_ideal && form.aims();
    const auto file = std::make_shared<fs::path>();
    job_ = std::make_unique<Job>([made, file](Progress& progress) { *file = write_exercise(made, progress); });
    when_done_ = [this, file] {
      rescan();
      choose_scene(*file);
      say(fmt::format("{} {}", s_.text("op.exercise_saved"), file->string()), false);
      log::info("exercise saved: {}", file->string());
    };
  }

  void choose_scene(const fs::path& file) {
    for (std::size_t i = 0; i < s_.scenes.size(); ++i)
      if (s_.scenes[i].file == file) s_.scene = static_cast<int>(i);
    s_.scene_shown = -1;
  }

  void open_archive() {
    s_.page = Page::kArchive;
    s_.sessions = find_sessions();
    s_.session = std::clamp(s_.session, 0, std::max(static_cast<int>(s_.sessions.size()) - 1, 0));
    say("", false);
  }
  const SessionEntry& chosen_session() const { return s_.sessions.at(static_cast<std::size_t>(s_.session)); }

  void show_report(const SessionEntry& of) {
    const fs::path report = fs::path(of.file).replace_extension(".html");
    if (of.report) return open_with_desktop(report.string());
    s_.outcome = {};
    s_.outcome.recording = of.file;
    make_report();
    const auto then = std::exchange(when_done_, {});
    when_done_ = [this, then, report] {
      then();
      s_.sessions = find_sessions();
      open_with_desktop(report.string());
    };
  }

  void make_curve(const SessionEntry& of) {
    const fs::path folder = of.file.parent_path(), page = folder / "learning_curve.html";
    const int language = static_cast<int>(s_.language);
    job_ = std::make_unique<Job>(
        [=](Progress& progress) { write_learning_curve(folder, page, language, progress); });
    when_done_ = [this, page] {
      say(fmt::format("{} {}", s_.text("op.written"), page.string()), false);
      log::info("learning curve written: {}", page.string());
      open_with_desktop(page.string());
    };
  }

  void export_mesh(const SessionEntry& of) {
    constexpr std::array kEndings = {".stl", ".ply", ".obj"};
    const fs::path from = of.file,
                   mesh = fs::path(from).replace_extension(kEndings.at(static_cast<std::size_t>(s_.mesh_format)));
    job_ = std::make_unique<Job>([=](Progress& progress) { export_surface(from, mesh, progress); });
    when_done_ = [this, mesh] {
      say(fmt::format("{} {}", s_.text("op.written"), mesh.string()), false);
      log::info("surface written: {}", mesh.string());
    };
  }

  void make_film(const SessionEntry& of) {
    const fs::path from = of.file, film = fs::path(from).replace_extension(".mp4");
    job_ = std::make_unique<Job>([=](Progress& progress) {
      progress.stage("op.filming");
      run_self({"replay", from.string(), "--film", film.string()}, progress);
    });
    when_done_ = [this, film] {
      say(fmt::format("{} {}", s_.text("op.written"), film.string()), false);
      log::info("film written: {}", film.string());
      open_with_desktop(film.string());
    };
  }

  void import() {
    const ImportForm& form = s_.import;
    NewTooth tooth;
    tooth.input = form.file.data();
    tooth.name = form.name.data();
    tooth.crown = static_cast<Crown>(form.crown);
    tooth.options.preset = form.preset == 1 ? haptics::ImportPreset::kBone : haptics::ImportPreset::kTooth;
    if (form.voxel_mm > 0) tooth.options.voxel = static_cast<double>(form.voxel_mm) * kMillimetre;
    if (form.shell_mm > 0) tooth.options.shell = static_cast<double>(form.shell_mm) * kMillimetre;
    const auto made = std::make_shared<fs::path>();
    job_ = std::make_unique<Job>([tooth, made](Progress& progress) { *made = bring_in(tooth, progress); });
    when_done_ = [this, made] {
      rescan();
      choose_scene(*made);
      say(fmt::format("{} {}", s_.text("op.imported"), made->string()), false);
      log::info("imported: {}", made->string());
    };
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
      const Json json = Json::parse(run_self({"doctor", "--json"}, progress), "doctor");
      for (const Json& c : json["checks"].items())
        findings->push_back(
            {c["name"].string(), c["state"].string(), c["found"].string(), c["without"].string(), c["mend"].string()});
    });
    when_done_ = [this, findings] {
      s_.findings = *findings;
      log::info("computer checked: {} findings", s_.findings.size());
    };
  }

  /// What is plugged in or out while hands are chosen. True when the list is another.
  bool look_at_devices() {
    if (bench_ || job_ || s_.page != Page::kStart || now() - plugged_looked_ < kDeviceInterval) return false;
    plugged_looked_ = now();
    if (plugged_.look().empty()) return false;
    const std::string chosen = s_.hands.at(static_cast<std::size_t>(s_.hand)).address;
    s_.hands = find_hands(s_);
    s_.hand = 0;
    choose_hand(chosen);
    return true;
  }
  /// Where it is there.
  void choose_hand(const std::string& address) {
    for (std::size_t i = 0; i < s_.hands.size(); ++i)
      if (s_.hands[i].address == address) s_.hand = static_cast<int>(i);
  }

  /// Pictures of scenes that have none, one after another, while one chooses. True when one has come.
  bool look_at_pictures() {
    if (picture_job_) {
      if (!picture_job_->done()) return false;
      const bool made = !picture_job_->failure();
      picture_job_.reset();
      if (made) take_picture(pictured_);
      return made;
    }
    if (bench_ || job_ || s_.page != Page::kStart) return false;
    const auto wanting = [&](const SceneChoice& scene) {
      return scene.picture < 0 && scene.fault.empty() && !tried_.contains(scene.file);
    };
    auto scene = s_.scenes.begin() + std::min<std::ptrdiff_t>(s_.scene, std::ssize(s_.scenes));
    if (scene == s_.scenes.end() || !wanting(*scene)) scene = std::find_if(s_.scenes.begin(), s_.scenes.end(), wanting);
    if (scene == s_.scenes.end()) return false;
    pictured_ = scene->file;
    tried_.insert(pictured_);
    picture_job_ = std::make_unique<Job>([file = pictured_](Progress& progress) {
      const fs::path picture = made_picture(file), folder = fs::path(picture).replace_extension();
      run_self({"render", file.string(), "--rig", "closeup", "--eye", "left", "--size", "640x480", "--out", folder.string()},
               progress, 19);
      std::error_code code;
      fs::rename(folder / "left.png", picture, code);
      std::error_code ignored;
      fs::remove_all(folder, ignored);
      if (code) throw RunFailure("no picture");
    });
    return false;
  }
  void take_picture(const fs::path& file) {
    for (SceneChoice& scene : s_.scenes) {
      if (scene.file != file || scene.picture >= 0) continue;
      try {
        s_.pictures.push_back(window_.upload(render::read_png(made_picture(file))));
        scene.picture = static_cast<int>(s_.pictures.size()) - 1;
      } catch (const Error& e) {
        log::warn("{}", e.what());
      }
    }
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
    r.monitor = s_.monitor;
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
  std::unique_ptr<Job> picture_job_;
  fs::path pictured_;         // the scene it draws
  std::set<fs::path> tried_;  // scenes that had their turn
  std::unique_ptr<haptics::TissueVolume> authored_;  // as an authoring session left it
  std::optional<Scene> authored_scene_;
  std::vector<PaintStroke> strokes_;
  bool brush_down_ = false;
  dvec3 brush_at_{0};
  fs::path recording_, written_, saved_;  // where the session's recording should lie, where it is written; its tissue
  Nanos revived_ = -kReviveInterval;
  haptics::DeviceWatch plugged_;
  Nanos plugged_looked_ = 0;
  Nanos score_time_ = 0, curve_time_ = 0;
  bool at_rest_ = false;  // the session: see nothing_moves()
  bool quit_ = false;
};

}  // namespace

void run_operator() {
  Operator op;
  op.run();
}

}  // namespace typodont
