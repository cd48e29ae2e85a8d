#include "engine/app/review/playback.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string_view>
#include <thread>
#include <vector>

#include "engine/app/assets.h"
#include "engine/app/picture/detail.h"
#include "engine/app/picture/hud.h"
#include "engine/app/picture/magnify.h"
#include "engine/app/picture/pair_stage.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/quality_ladder.h"
#include "engine/app/picture/teaching_views.h"
#include "engine/app/recording.h"
#include "engine/app/recording/replay.h"
#include "engine/app/review/player.h"
#include "engine/app/sound_link.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/task/task.h"
#include "engine/base/error.h"
#include "engine/base/progress.h"
#include "engine/base/units.h"
#include "engine/display/keys.h"
#include "engine/render/picture.h"
#include "engine/session/film.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;
using render::View;

constexpr double kJump = 5;  // s, time by which an arrow key moves the playback

/// Returns the view with this name (see view_name()); kLook if there is none.
View view_of(std::string_view name) {
  for (const View view : {View::kSection, View::kXray, View::kDifference, View::kTemperature})
    if (view_name(view) == name) return view;
  return View::kLook;
}

display::DisplayRig rig_of(const PlaybackOptions& options, const Scene& scene) {
  const char* usual = options.film.empty() ? "window" : "closeup";
  const fs::path file = options.rig.empty() ? usual_rig(scene, usual) : find_rig(options.rig);
  display::DisplayRig rig = display::load_rig(file);
  if (rig.kind == display::DisplayKind::kHmd)
    throw Error(file.string(), "\"display\"", "hmd", "window, mirror or offscreen: a session is watched on a screen");
  rig.head.tracker.clear();
  if (options.eye_W) rig.head.eye_center = *options.eye_W;
  if (options.ipd) rig.head.ipd = *options.ipd;
  if (options.magnify > 0) rig.magnify = options.magnify;
  return rig;
}

/// One of the recordings that are played, with its picture.
class Side {
 public:
  Side(const session::OpenedSession& session, std::string name, session::Language language)
      : player_(session), name_(std::move(name)), language_(language) {}

  SessionPlayer& player() { return player_; }
  World& world() { return player_.world(); }
  PictureStage& stage() { return *stage_; }
  const haptics::ServoSettings& servo() const { return player_.scene().servo; }

  void attach(PictureStage& stage) {
    stage_ = &stage;
    stage.surround(world().surroundings());
    const double voxel = player_.tissue().frame().voxel;
    detail_.emplace(surface_tolerance(stage.rig(), voxel, stage.quality()), voxel);
    player_.smooth_to(detail_->tolerance());
  }

  void show_as(View view) {
    const Scene& scene = player_.scene();
    view_ = can_show(scene, view) ? view : View::kLook;
    if (view_ == View::kDifference && !ideal_)
      ideal_.emplace(ideal_tissue(scene, load_untouched(scene)).value(), kDifferenceReach);
    if (view_ == View::kTemperature) player_.add_heat();
    player_.smooth_to(detail_->tolerance());
    stage_->show_as(View::kLook);
    inside_cuts_ = ~std::uint64_t{0};
  }
  View view() const { return view_; }

  /// Moves the session to the current time of the playback.
  void go(const PlayClock& clock) {
    player_.seek(player_.begin() + clock.at, clock.speed < 0);
    world().say(line(clock));
    std::vector<render::MeshUpdate> surface = player_.take_surface();
    const dvec3 origin = player_.tissue().frame().origin;
    if (view_ == View::kDifference) {
      mark_difference(*ideal_, origin, surface);
      stage_->show_as(View::kDifference);
    }
    stage_->show(surface, origin);
    if (render::cuts_section(view_) || view_ == View::kXray) look_inside();
  }
  /// Adapts the tolerance of the mesh to the size of a pixel at the tissue in the previous picture.
  void follow(const render::FrameStats& stats, const render::Quality& quality) {
    if (stats.drawn && detail_->follow(stats.pixel, quality)) player_.smooth_to(detail_->tolerance());
  }

 private:
  std::string line(const PlayClock& clock) {
    const auto number = [&](double value) { return session::number_text(value, 1, language_); };
    std::vector<std::string> parts;
    if (!name_.empty()) parts.push_back(name_);
    if (has_other_law(player_.session())) parts.push_back(hud_text(language_, "other_law"));
    parts.push_back(fmt::format("{} / {} s", number(to_seconds(world().tick().t)), number(player_.end())));
    parts.push_back(fmt::format("x{}", short_number(clock.speed, 3, language_)));
    if (clock.loop) parts.push_back(hud_text(language_, "loop"));
    if (clock.paused) parts.push_back(hud_text(language_, "paused"));
    parts.push_back(tool_line(world(), language_));
    return fmt::format("{}", fmt::join(parts, kHudGap));
  }

  /// Computes what a section or the X-ray view shows inside the tooth: the cut face, or pulp, caries and dentin.
  /// It is computed again only after the tissue was cut.
  void look_inside() {
    const haptics::TissueVolume& volume = player_.tissue();
    const std::uint64_t cuts = world().tick().cuts;
    const dvec3 origin = volume.frame().origin;
    if (render::cuts_section(view_) && inside_cuts_ == ~std::uint64_t{0}) {
      // The fixed section plane through the middle of all cuts.
      dvec3 middle(0);
      for (const Cut& cut : player_.session().cuts()) middle += cut.X_WB.p;
      const auto count = static_cast<double>(player_.session().cuts().size());
      plane_ = section_facing(count > 0 ? middle / count : world().tick().X_WG.p, stage_->rig().head.eye_center);
      if (const auto around = view_ == View::kSection ? surroundings_shape(player_.scene().surroundings) : std::nullopt)
        stage_->show_inside(render::kSectionFaceAround, around->section_face(dvec3(plane_), -plane_.w, origin), origin);
    }
    if (cuts != inside_cuts_)
      for (const ViewBody& body : view_bodies(view_, plane_, 0, volume))
        stage_->show_inside(body.mesh, body.bricks, origin);
    stage_->show_as(view_, plane_);
    inside_cuts_ = cuts;
  }

  SessionPlayer player_;
  std::string name_;
  session::Language language_;
  PictureStage* stage_ = nullptr;
  std::optional<Detail> detail_;
  std::optional<ToothField> ideal_;
  View view_ = View::kLook;
  std::uint64_t inside_cuts_ = ~std::uint64_t{0};
  glm::dvec4 plane_{0, 0, 1, 0};
};

/// The playback: its sessions, the screen and its state.
class Playback {
 public:
  Playback(const session::OpenedSession& session, const PlaybackOptions& options) {
    const bool pair = !options.beside.empty();
    sides_.push_back(std::make_unique<Side>(session, pair ? session.file().stem().string() : "", options.language));
    if (pair)
      sides_.push_back(std::make_unique<Side>(options.beside, options.beside.stem().string(), options.language));
    const display::DisplayRig rig =
        magnified_for(rig_of(options, sides_[0]->player().scene()), sides_[0]->player().tissue());
    PictureStage::Options look;
    look.quality = render::kQualityLadder[1];
    look.handpieces = sides_[0]->player().scene().handpieces;
    look.window = options.film.empty();
    look.language = options.language;
    look.monitor = options.monitor;
    if (pair) {
      pair_.emplace(rig, std::array{sides_[0]->servo(), sides_[1]->servo()}, look);
      for (std::size_t k = 0; k < 2; ++k) sides_[k]->attach(pair_->side(k));
    } else {
      stage_.emplace(rig, sides_[0]->servo(), look);
      sides_[0]->attach(*stage_);
    }
    // Lowers the quality if drawing takes too long, but only in a window, where motion must be smooth. A film may take
    // any time.
    if (look.window) follow_time(sides_[0]->stage().device().processor);
    double longest = 0;
    for (const auto& side : sides_) longest = std::max(longest, side->player().end() - side->player().begin());
    const double zero = sides_[0]->player().begin();
    clock.begin = 0;
    clock.end = longest;
    clock.set_range(std::max(options.from - zero, 0.0), options.to - zero);
    if (!(clock.to > clock.from))
      throw Error("", "--from, --to", fmt::format("{} to {} s", options.from, options.to),
                  fmt::format("a part of {:.3f} s", longest));
    clock.speed = options.speed;
    clock.at = options.speed < 0 ? clock.to : clock.from;
    for (const auto& side : sides_) side->show_as(view_of(options.view));
    if (options.view != view_name(sides_[0]->view()))
      throw Error("", "--view", options.view,
                  options.view == "difference" ? "a session whose task names an ideal"
                                               : "a session whose scene has the key \"heat\"");
  }

  void draw() {
    for (const auto& side : sides_) side->go(clock);
    const Nanos began = now();
    std::array<render::FrameStats, 2> stats;
    if (pair_) {
      stats = pair_->draw({&sides_[0]->world(), &sides_[1]->world()}, {});
    } else {
      stats[0] = stage_->draw(sides_[0]->world());
    }
    for (std::size_t k = 0; k < sides_.size(); ++k) sides_[k]->follow(stats[k], sides_[k]->stage().quality());
    if (!ladder_ || !(stats[0].drawn || stats[1].drawn)) return;
    const double took = to_seconds(now() - began);
    if (ladder_->frame_took(stage_ ? std::max(took, stage_->timing().cost()) : took)) set_quality(ladder_->step());
  }
  void next_view() {
    const View next = typodont::next_view(sides_[0]->player().scene(), sides_[0]->view());
    for (const auto& side : sides_) side->show_as(next);
  }
  render::Picture screen() { return pair_ ? pair_->screen() : stage_->screen(); }
  display::Output& output() { return pair_ ? pair_->output() : stage_->output(); }
  Side& first() { return *sides_[0]; }

  PlayClock clock;

 private:
  void follow_time(bool processor) {
    ladder_ = processor ? QualityLadder::for_processor() : QualityLadder();
    set_quality(ladder_->step());
  }
  void set_quality(const render::Quality& quality) {
    for (const auto& side : sides_) side->stage().set_quality(quality);
  }

  std::vector<std::unique_ptr<Side>> sides_;
  std::optional<PictureStage> stage_;
  std::optional<PairStage> pair_;
  std::optional<QualityLadder> ladder_;
};

}  // namespace

void show_session(const session::OpenedSession& session, const PlaybackOptions& options) {
  Playback playback(session, options);
  PlayClock& clock = playback.clock;
  clock.loop = options.loops != 0;
  namespace keys = display::keys;
  const std::map<int, std::function<void()>> actions{
      {' ',
       [&] {
         if (clock.over)
           clock.seek(clock.speed < 0 ? clock.to : clock.from);
         else
           clock.paused = !clock.paused;
       }},
      {keys::kLeft, [&] { clock.seek(clock.at - kJump); }},
      {keys::kRight, [&] { clock.seek(clock.at + kJump); }},
      {keys::kUp, [&] { clock.faster(true); }},
      {keys::kDown, [&] { clock.faster(false); }},
      {keys::kHome, [&] { clock.seek(clock.from); }},
      {keys::kEnd, [&] { clock.seek(clock.to); }},
      {'L', [&] { clock.loop = !clock.loop; }},
      {'R', [&] { clock.speed = -clock.speed, clock.over = false; }},
      {'V', [&] { playback.next_view(); }},
      {'[', [&] { clock.set_range(clock.at, clock.to); }},
      {']', [&] { clock.set_range(clock.from, clock.at); }},
      {keys::kBackspace, [&] { clock.set_range(clock.begin, clock.end); }}};
  Nanos last = now();
  while (true) {
    const display::UserInput input = playback.output().poll();
    if (input.close) return;
    for (const int key : input.pressed) {
      if (key == keys::kEscape) return;
      if (const auto action = actions.find(key); action != actions.end()) action->second();
    }
    const double dt = std::min(to_seconds(now() - last), 0.25);
    last = now();
    clock.advance(dt);
    playback.draw();
    if (clock.paused || clock.over) std::this_thread::sleep_for(std::chrono::milliseconds(4));
  }
}

PlaybackResult film_session(const session::OpenedSession& session, const PlaybackOptions& options, Progress& progress) {
  Playback playback(session, options);
  PlayClock& clock = playback.clock;
  const int times = std::max(1, options.loops);
  clock.loop = times > 1;
  const double length = (clock.to - clock.from) / std::abs(clock.speed) * times;
  std::optional<SoundLink> sound;
  fs::path wav;
  SessionPlayer& player = playback.first().player();
  const Nanos zero = from_seconds(player.begin() + clock.from);
  if (options.speed == 1 && times == 1 && player.scene().needs("sound")) {
    wav = options.film;
    wav += ".wav";
    sound.emplace("wav:" + wav.string(), voice_of(player.scene()), player.event_logs(), /*live=*/false,
                  /*binaural=*/false, zero);
  }
  const auto remove_wav = [&] {
    std::error_code code;
    if (!wav.empty()) fs::remove(wav, code);
  };
  PlaybackResult result;
  try {
    std::optional<session::FilmWriter> film;
    const auto frames = static_cast<std::uint64_t>(std::max(1.0, std::round(length * options.fps)));
    for (; result.frames < frames; ++result.frames) {
      progress.at(static_cast<double>(result.frames) / static_cast<double>(frames));
      playback.draw();
      const render::Picture screen = playback.screen();
      if (!film) film.emplace(options.film, session::FilmOptions{screen.size.x, screen.size.y, options.fps});
      film->add(screen.rgba);
      if (sound) sound->advance(from_seconds(player.begin() + clock.at) - zero);
      clock.advance(1 / options.fps);
    }
    result.seconds = static_cast<double>(frames) / options.fps;
    if (sound) sound->stop(from_seconds(result.seconds));
    std::optional<session::FilmSound> heard_file;
    if (sound) heard_file = {wav};
    if (!film->finish(heard_file)) throw RunFailure(film->message());
    result.message = film->message();
  } catch (...) {
    remove_wav();
    throw;
  }
  remove_wav();
  return result;
}

}  // namespace typodont
