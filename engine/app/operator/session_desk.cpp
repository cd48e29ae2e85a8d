#include "engine/app/operator/session_desk.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/app/operator/exercise.h"
#include "engine/app/operator/library.h"
#include "engine/app/operator/session_scores.h"
#include "engine/app/picture/hud.h"
#include "engine/app/picture/live_views.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/base/log.h"
#include "engine/base/units.h"
#include "haptics/device_safety.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

constexpr Nanos kScoreInterval = 500'000'000;
constexpr Nanos kCurveInterval = 25'000'000;
// The session is at rest if no picture has changed for this time, ns; longer than the time between two frames.
constexpr Nanos kRest = 100'000'000;

}  // namespace

void SessionDesk::show_task(const Scene& scene) {
  s_.steps = {};
  s_.step_shown = -1;
  if (!scene.task) return;
  s_.steps = StepWatcher(*scene.task);
  if (!scene.task->title.empty()) s_.scene_title = scene.task->title.in(s_.language);
  s_.scene_goal = scene.task->goal.in(s_.language);
  std::string texts = s_.scene_title + s_.scene_goal;
  for (const session::TaskText& step : scene.task->steps) texts += step.in(s_.language);
  window_.announce_text(texts);
}

/// A session that was set up in the background.
struct SessionDesk::SetUp {
  Scene scene;
  fs::path recording, written, saved;  // as in SessionDesk
  bool embedded = false;               // as in RigChoice
  std::unique_ptr<Workbench> bench;
};

void SessionDesk::start(std::function<Scene()> read, const RigChoice& rig, const std::string& hand) {
  wanted_ = true;
  // Only the thread that calls this first has a stack for crash handlers. The window's thread ends last.
  haptics::install_exit_guard();
  WorkbenchOptions options;
  options.rig = rig.file.string();
  options.hand = hand;
  options.trainee = s_.trainee.data();
  options.language = hud_language(s_.language);
  options.no_real_time = s_.no_real_time;
  options.operated = true;
  options.embedded = rig.embedded;
  options.device = &window_.device();
  options.monitor = rig.embedded ? -1 : s_.monitor;
  options.save_at_end = false;
  work_.make(
      [read = std::move(read), options, author = s_.author, record = s_.record](Progress& progress) mutable {
        progress.stage("op.loading");
        SetUp made;
        made.embedded = options.embedded;
        made.scene = read();
        const Scene& scene = made.scene;
        if (!author) options.warnings = warning_levels(scene, options.trainee);
        // Every session is recorded from its beginning, so that the user can decide at the end to keep the recording.
        if (!author) made.recording = new_session_file(options.trainee, scene.name);
        made.written = record || author ? made.recording : temporary_recording_file();
        made.saved = new_session_file(options.trainee, scene.name).replace_extension(".vdb");
        options.record = made.written;
        options.save = made.saved;
        made.bench = std::make_unique<Workbench>(scene, options, &progress);
        return made;
      },
      [this](SetUp made) {
        try {
          if (!wanted_) throw Cancelled();
          open(std::move(made));
        } catch (...) {
          give_up();
          throw;
        }
      },
      [this](const std::exception&) {
        give_up();
        throw;
      });
  page_before_ = std::exchange(s_.page, Page::kLoading);
}

/// Takes a session that is set up, and opens its pictures.
void SessionDesk::open(SetUp made) {
  bench_ = std::move(made.bench);
  recording_ = made.recording;
  written_ = made.written;
  saved_ = made.saved;
  scene_ = std::move(made.scene);
  const Scene& scene = *scene_;
  bench_->open();
  show_task(scene);
  s_.exam = scene.exam;
  s_.keep = s_.record && !s_.author;
  s_.outcome = {};
  s_.settings = {};
  s_.stiffness.fill(1);
  for (std::size_t i = 0; i < s_.brush_colors.size(); ++i)
    s_.brush_colors[i] = glm::vec3(scene.servo.materials[i].color);
  s_.tools.clear();
  for (const haptics::Tool& tool : haptics::tool_set(scene.servo)) s_.tools.push_back(tool_title(tool, s_.language));
  s_.device = bench_->hand();
  take_step_tool();
  if (s_.device.address == "mouse:") s_.device.model = s_.text("op.mouse");
  s_.recording = bench_->recording();
  s_.score = {};
  s_.score_known = s_.score_current = false;
  s_.forces.fill(0);
  s_.curve_at = 0;
  score_time_ = 0;
  brush_down_ = at_rest_ = false;
  s_.status = bench_->status();
  if (PictureStage* stage = bench_->stage()) {
    const display::Screen& screen = stage->rig().screen;
    s_.live_aspect =
        glm::length(screen.lower_right - screen.lower_left) / glm::length(screen.upper_left - screen.lower_left);
    s_.live_upright = display::upright(stage->rig());
  }
  begin_views(scene);
  s_.live_is_own = made.embedded;
}

/// Draws a first picture. Starts the session's time when the pictures show the tissue.
SessionDesk::Turn SessionDesk::begin() {
  if (!wanted_) {
    cancel_start();
    return bench_ ? Turn::kSame : Turn::kChanged;
  }
  const std::uint64_t frames = s_.status.frames;
  const auto fail = [&](const std::exception& e) {
    give_up();
    s_.fail(e.what());
  };
  try {
    started_ = bench_->begin(s_.live_size);
  } catch (const gpu::DeviceLost& e) {
    fail(e);
    throw;
  } catch (const std::exception& e) {
    fail(e);
    return Turn::kChanged;
  }
  s_.held = bench_->held();
  s_.status = bench_->status();
  if (s_.status.frames > 0) s_.live = &bench_->stage()->pictures();
  if (s_.status.frames > 0 || started_) s_.page = Page::kSession;
  if (!started_) return s_.status.frames != frames ? Turn::kChanged : Turn::kSame;
  if (!s_.live_is_own && s_.trainee_seen) {
    window_.output().leave_monitor(s_.monitor);
    window_.output().take_focus();
  }
  authored_.reset();
  log::info("session started: {}", scene_->name);
  if (!scene_->resume.empty()) log::info("continued from {}", scene_->resume);
  return Turn::kChanged;
}

bool SessionDesk::drawing() const {
  return bench_ && !started_ && bench_->stage() && !bench_->stage()->finished();
}

/// Removes a session that has not started. Shows the page from before. Instead of a result, shows the start page,
/// because the computation of the result's score may have been cancelled.
void SessionDesk::give_up() {
  s_.live = nullptr;
  bench_.reset();
  s_.page = page_before_ == Page::kResult ? Page::kStart : page_before_;
}

void SessionDesk::cancel_start() {
  wanted_ = false;
  // The destructor would wait for the picture, so begin() calls this function again when the picture is finished.
  if (!bench_ || started_ || drawing()) return;
  give_up();
  s_.say(s_.text("op.cancelled"));
}

SessionDesk::Turn SessionDesk::step() {
  if (!started_) return begin();
  const WorkbenchStatus before = s_.status;
  bench_->look_from(s_.viewpoint, s_.own_view ? s_.live_size : glm::ivec2(0));
  if (s_.viewpoint != seen_from_) ++s_.viewpoint_changes;
  seen_from_ = s_.viewpoint;
  const bool goes_on = bench_->step(s_.live_input, s_.live_size);
  // This step has used the motion of the mouse wheel. The value is set to zero, because the next step may come before
  // the next page is drawn.
  s_.live_input.wheel = 0;
  s_.live_input.pressed.clear();
  if (!goes_on) return Turn::kOver;
  if (s_.author) paint();
  s_.status = bench_->status();
  s_.settings = bench_->settings();
  s_.held = bench_->held();
  const std::string save = saved_.filename().string();
  if (s_.status.saved > before.saved) s_.say(fmt::format("{} {}", s_.text("op.saved_as"), save));
  if (s_.status.not_saved > before.not_saved) s_.fail(fmt::format("{} {}", s_.text("op.not_saved"), save));
  const int step = s_.steps.current();
  if (s_.steps.follow({.tick = s_.status.tick,
                       .settings = s_.settings,
                       .chosen_tool = s_.status.chosen_tool,
                       .undone = static_cast<int>(s_.status.tissue.undone),
                       .redone = static_cast<int>(s_.status.tissue.redone),
                       .views = s_.look_changes,
                       .viewpoints = s_.viewpoint_changes,
                       .held = s_.held,
                       .phase = s_.status.implant ? s_.status.implant->phase : 0})) {
    log::info("step {} done", step + 1);
    take_step_tool();
  }
  PictureStage* stage = bench_->stage();
  s_.live = s_.own_view ? bench_->own_picture() : stage && bench_->status().frames > 0 ? &stage->pictures() : nullptr;
  s_.look_in_work = bench_->views()->making(s_.own_view ? Eyes::kOwn : Eyes::kTrainee);
  const Nanos t = now();
  if (t - score_time_ > kScoreInterval) {
    score_time_ = t;
    s_.score = bench_->score_so_far();
    s_.score_known = bench_->views()->score_known();
    s_.score_current = bench_->views()->score_current();
  }
  if (t - curve_time_ > kCurveInterval) {
    curve_time_ = t;
    s_.forces[static_cast<std::size_t>(s_.curve_at)] = static_cast<float>(glm::length(s_.status.tick.f_T_W));
    s_.curve_at = (s_.curve_at + 1) % static_cast<int>(s_.forces.size());
  }
  const bool new_picture = s_.status.frames + s_.status.own_frames != before.frames + before.own_frames;
  if (new_picture) picture_time_ = t;
  at_rest_ = nothing_moves(before) && t - picture_time_ > kRest;
  if (!looks_same(s_.status.tick.X_WT, rests_at_)) rests_at_ = s_.status.tick.X_WT;
  const bool next_second = std::floor(before.seconds) != std::floor(s_.status.seconds);
  return new_picture || next_second ? Turn::kChanged : Turn::kSame;
}

bool SessionDesk::nothing_moves(const WorkbenchStatus& before) const {
  const WorkbenchStatus& is = s_.status;
  return looks_same(is.tick.X_WT, rests_at_) && is.tick.spindle == before.tick.spindle &&
         is.tick.tool == before.tick.tool && is.tick.cuts == before.tick.cuts &&
         is.tissue.version == before.tissue.version && is.faults == before.faults && !s_.look_in_work &&
         std::all_of(s_.forces.begin(), s_.forces.end(), [](float f) { return f == 0; });
}

/// Finds out which pictures and views are available in this session.
void SessionDesk::begin_views(const Scene& scene) {
  const LiveViews& views = *bench_->views();
  s_.look = {};
  s_.look_changes = s_.viewpoint_changes = 0;
  s_.trainee_seen = bench_->stage() != nullptr;
  s_.own_possible = scene.needs("render");
  s_.own_view = !s_.trainee_seen && s_.own_possible;
  s_.viewpoint = {};
  if (s_.trainee_seen) {
    const double distance = s_.viewpoint.distance;
    s_.viewpoint = viewpoint_of(bench_->stage()->rig(), views.middle());
    s_.viewpoint.distance = distance;
  }
  seen_from_ = s_.viewpoint = clamped(s_.viewpoint);
  s_.has_ideal = views.can_show(render::View::kDifference);
  s_.has_heat = views.can_show(render::View::kTemperature);
  s_.has_surroundings = views.has_surroundings();
  s_.has_mirror = scene.mouth_mirror.diameter > 0;
  s_.has_debris = scene.needs("debris");
  s_.tissues = views.tissues();
  if (s_.author) s_.tissues |= 1u << static_cast<unsigned>(Tissue::kCaries);
}

bool SessionDesk::carry_out(const Request& r) {
  switch (r.ask) {
    case Ask::kSettings:
      if (bench_) bench_->set(s_.settings);
      return true;
    case Ask::kPhaseTool:
      if (bench_) bench_->choose_phase_tool();
      return true;
    case Ask::kTool:
      if (bench_) bench_->choose_tool(r.number);
      return true;
    case Ask::kUndo:
      if (bench_) bench_->ask(TissueCommand::kUndo);
      return true;
    case Ask::kRedo:
      if (bench_) bench_->ask(TissueCommand::kRedo);
      return true;
    case Ask::kSaveTissue:
      if (bench_) bench_->ask(TissueCommand::kSave);
      return true;
    case Ask::kLook:
      if (bench_) bench_->views()->look(s_.own_view ? Eyes::kOwn : Eyes::kTrainee, s_.look);
      ++s_.look_changes;
      return true;
    case Ask::kOwnView:
      if (bench_) show_own_view(r.number != 0);
      return true;
    case Ask::kHold:
      if (bench_) bench_->hold(r.number != 0);
      return true;
    case Ask::kStep:
      r.number > 0 ? s_.steps.next() : s_.steps.back();
      take_step_tool();
      return true;
    default:
      return false;
  }
}

void SessionDesk::show_own_view(bool own) {
  if (own == s_.own_view) return;
  s_.own_view = own;
  s_.live = nullptr;
  s_.look = bench_->views()->look(own ? Eyes::kOwn : Eyes::kTrainee);
  ++s_.viewpoint_changes;
}

void SessionDesk::take_step_tool() {
  const std::string_view tool = s_.steps.tool();
  if (!bench_ || tool.empty() || s_.device.chooses_tools) return;
  const std::vector<std::string> names = tool_names(*scene_);
  bench_->choose_tool(static_cast<int>(std::find(names.begin(), names.end(), tool) - names.begin()));
}

/// Paints with the tool's head. A stroke begins with a ball, and then paints the volume through which the head moves.
void SessionDesk::paint() {
  if (!s_.painting || !is_finite(s_.status.tick.X_WT.p)) {  // a broken device may give a non-finite pose
    brush_down_ = false;
    return;
  }
  BrushMove move;
  PaintStroke& stroke = move.stroke;
  stroke.tissue = s_.paint_tissue;
  stroke.radius = static_cast<double>(s_.paint_radius_mm) * kMillimetre;
  stroke.hardness = static_cast<double>(s_.paint_hardness);
  const auto tissue = static_cast<std::size_t>(stroke.tissue);
  if (s_.brush_colors[tissue] != glm::vec3(scene_->servo.materials[tissue].color))
    stroke.color = voxel_color(dvec3(s_.brush_colors[tissue]));
  stroke.b_W = s_.status.tick.X_WT.p;
  stroke.a_W = brush_down_ ? brush_at_ : stroke.b_W;
  if (brush_down_ && glm::length(stroke.b_W - stroke.a_W) < 0.25 * stroke.radius) return;
  move.begins = !brush_down_;
  bench_->paint(move);
  brush_at_ = stroke.b_W;
  brush_down_ = true;
}

std::shared_ptr<const Unscored> SessionDesk::end(const std::string& why) {
  s_.live = nullptr;
  s_.page = Page::kResult;
  if (why.empty())
    s_.say("");
  else
    s_.fail(why);
  try {
    s_.outcome.summary = bench_->stop();
  } catch (const std::exception& e) {
    s_.outcome.failure = e.what();
  }
  window_.wait_idle();  // the GPU may still be drawing the picture
  if (s_.author) {      // the tissue is complete even after a failure
    s_.exercise.rules = rule_choices(*scene_);
    s_.exercise.base_aims = scene_->task && scene_->task->ideal;
    s_.exercise.fresh = true;
    const bool unsaved = bench_->strokes().done > 0;
    std::vector<PaintStroke> strokes = bench_->painted();
    authored_.reset(new Authored{*scene_, bench_->take_tissue(), std::move(strokes), unsaved});
  }
  std::optional<FinishedHand> hand;
  std::optional<haptics::TissueVolume> tissue;
  if (!s_.author && s_.outcome.failure.empty()) {
    hand = bench_->take_hand();
    tissue = bench_->take_tissue();
  }
  bench_.reset();
  started_ = false;
  log::info("session ended: {:.1f} s", s_.outcome.summary.seconds);
  keep_recording();
  s_.outcome.result.reset();
  if (!hand || !s_.outcome.recording.empty()) return nullptr;
  return std::make_shared<const Unscored>(*scene_, std::move(*tissue), std::move(*hand));
}

/// Moves the recording to the trainee's folder if the user keeps it, otherwise deletes it.
void SessionDesk::keep_recording() {
  s_.outcome.recording.clear();
  if (!s_.recording) return;
  std::error_code code;
  if (!s_.keep) {
    fs::remove(written_, code);
    return;
  }
  if (written_ != recording_) {
    fs::rename(written_, recording_, code);
    // If the file cannot be renamed because the trainee's folder is on another disk, it is copied.
    if (code) fs::copy_file(written_, recording_, code);
  }
  s_.outcome.recording = code ? written_ : recording_;
  if (code) s_.fail(fmt::format("{}: {} ({})", recording_.string(), code.message(), written_.string()));
}

void SessionDesk::drop_picture() {
  if (bench_) bench_->drop_picture();
}

void SessionDesk::make_picture() {
  if (bench_) bench_->make_picture(window_.device());
}

}  // namespace typodont
