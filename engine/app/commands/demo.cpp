// `typodont demo`: a scripted hand removes the caries of the CT molar, offscreen. `./run demo` starts it.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/app/assets.h"
#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/hands/demo_hand.h"
#include "engine/app/operator/child.h"
#include "engine/app/operator/library.h"
#include "engine/app/picture/eye_size.h"
#include "engine/app/picture/hud.h"
#include "engine/app/picture/magnify.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording.h"
#include "engine/app/recording/resume.h"
#include "engine/app/review/session_report.h"
#include "engine/app/sound_link.h"
#include "engine/app/stepped.h"
#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "engine/base/folder.h"
#include "engine/base/log.h"
#include "engine/base/progress.h"
#include "engine/base/units.h"
#include "engine/contract/session_length.h"
#include "engine/session/film.h"
#include "engine/session/recorder.h"
#include "engine/session/report.h"
#include "engine/session/strings.h"
#include "haptics/contact_method.h"

namespace typodont {

namespace fs = std::filesystem;

namespace {

struct DemoOptions {
  std::filesystem::path out = "demo";
  std::string scene;  // scene file; empty: the shipped scene molar-caries
  std::string rig;    // rig file or name; empty: the shipped rig `film`
  // pixels, size of one eye's picture; empty: kQuick, or with `film` the rig's size
  std::optional<glm::ivec2> eye_size;
  std::string model;                                         // contact model; empty: the scene's model
  bool film = false;                                         // films the whole session, in the rig's size and in stereo
  double fps = 25;                                           // frames per second of the film
  double seconds = 1e9;                                      // s, limit of the session's duration
  session::Language language = session::Language::kEnglish;  // language of the text over the picture
};

constexpr double kRate = 1000;        // Hz, rate of the servo
constexpr double kUsualLength = 221;  // s, duration of the shipped scene's session; used to estimate the time left
constexpr double kDuring =
    0.3;  // removed fraction of the caries, at which the picture "during" and the short film are made
constexpr auto kCaries = static_cast<std::size_t>(Tissue::kCaries);
constexpr double kFilmed = 10;        // s, length of the short film
constexpr double kStep = 1.0 / 25;    // s, time between two stops of the session
constexpr double kBehind = 10;        // s, chips and water may be this far behind the session
constexpr double kPictureEvery = 10;  // s, time between two pictures "at_…"
// Chips and water move only while they are drawn, and shortly before: kSettling (s) before a picture "at_…"; from the
// removed fraction kNearlyDuring of the caries until the picture "during" and the film are made.
constexpr double kSettling = 3, kNearlyDuring = 0.25;
constexpr glm::ivec2 kQuick{960, 540};  // pixels, size of one eye's picture without --film

/// Running mean of the time for one piece of work, s. Starts with an estimate for two processor cores.
class Pace {
 public:
  explicit Pace(double seconds) : each_(seconds) {}
  /// Adds a measured time, s.
  void took(double seconds) { each_ += (seconds - each_) / std::min(++count_, kRemembered); }
  double each() const { return each_; }

 private:
  static constexpr int kRemembered = 250;
  double each_;
  int count_ = 0;
};

/// The quality of the film. The best quality would take too long for thousands of full-HD frames. Only the handpiece
/// has the best level's triangles: it fills a large part of a frame, and coarse triangles would spoil its highlights.
render::Quality film_quality() {
  render::Quality quality = render::kQualityLadder[2];
  quality.handpiece_side = render::kQualityLadder[0].handpiece_side;
  return quality;
}

/// Writes one eye's last picture, with the text over it.
void write_eye(PictureStage& stage, int eye, const fs::path& file) {
  render::Picture picture = stage.eye(eye);
  stage.write_over(picture);
  render::write_png(file, picture);
}

/// Writes the pictures of one moment: the picture of each eye, and the picture on the screen.
void write_pictures(PictureStage& stage, World& world, const Look& look, const fs::path& folder,
                    const std::string& name, std::vector<session::SessionPicture>& kept, const std::string& title) {
  // The pictures of the demo have the best quality. The film has a lower quality because of its many frames.
  const render::Quality of_film = stage.quality();
  const bool one_eye = stage.draws_one_eye();
  stage.set_quality(render::kQualityLadder[0]);
  stage.draw_one_eye(false);
  stage.draw(world, look);
  for (const int eye : {0, 1}) write_eye(stage, eye, folder / (name + (eye == 0 ? "_left.png" : "_right.png")));
  render::write_png(folder / (name + "_screen.png"), stage.screen());
  kept.push_back(session::read_picture(folder / (name + "_left.png"), name, title));
  stage.set_quality(of_film);
  stage.draw_one_eye(one_eye);
}

/// Describes the result of the exercise by comparing the remaining tissue with the tissue at the start.
std::string result_text(const haptics::TissueVolume& tissue, const PerTissue& before, session::Language language) {
  return hud_text(language, "caries_left",
                  session::number_text(100 * tissue.volumes()[kCaries] / before[kCaries], 1, language));
}

/// Runs the demonstration. Writes pictures, film, sound, session and report to the folder `out`, and prints their
/// names. Throws Error or RunFailure.
void run(const DemoOptions& options) {
  const Nanos began = now();
  Progress progress("demo");
  make_folder(options.out);

  Scene scene =
      read_scene(options.scene.empty() ? assets_folder() / "scenes/molar-caries.json" : fs::path(options.scene));
  choose_model(scene, options.model);
  const fs::path rig_file = options.rig.empty() ? usual_rig(scene, "film") : find_rig(options.rig);
  display::DisplayRig rig = display::load_rig(rig_file);
  if (options.eye_size || !options.film) draw_eyes_at(rig, options.eye_size.value_or(kQuick));
  log::info("scene {} ({})", scene.name, scene.file.string());
  SteppedSession session(scene, load_tissue(scene), kRate);
  haptics::Carver& carver = session.carver();
  rig = magnified_for(rig, carver.volume());
  DemoHand demo_hand(scene, carver, kRate);
  const double length = std::min(kUsualLength, options.seconds);

  PictureStage::Options look;
  look.quality = film_quality();
  look.handpieces = scene.handpieces;
  look.language = options.language;
  PictureStage stage(rig, scene.servo, look);
  stage.draw_one_eye(!options.film);
  World world(scene, session.settings().soft);
  if (scene.needs("debris")) world.add_debris(carver.volume());
  stage.surround(world.surroundings());
  const VoxelFrame frame = carver.volume().frame();
  TissueView view(surface_tolerance(rig, frame.voxel, look.quality), scene.drawn_as);
  const std::vector<render::MeshUpdate> first = view.update(carver);
  stage.show(first, frame.origin);
  std::size_t triangles = 0;
  for (const render::MeshUpdate& brick : first) triangles += brick.indices.size() / 3;
  log::info("drawing with {}: {} triangles", stage.device_name(), triangles);

  const fs::path session_file = options.out / "session.h5", wav = options.out / "drill.wav",
                 mp4 = options.out / "session.mp4", stereo_mp4 = options.out / "session_stereo.mp4";
  SoundLink sound("wav:" + wav.string(), voice_of(scene), session.event_logs(), /*live=*/false);
  session::SessionHeader header = session_header(scene, rig_file, demo_hand.info(), carver.volume(), kRate);
  header.streams.push_back(sound_stream());
  session::WriterOptions whole;
  whole.whole_or_nothing = true;
  SessionRecorder recorder(session_file, scene, header, session.event_logs(), whole);
  recorder.writer().event(0, session::EventKind::kNote, sound.about());
  WorldReader reader(world, session.event_logs());
  sound.water(world.water().spray, world.suction_flow());
  std::optional<session::FilmWriter> film, stereo;
  std::string end;  // text that the last pictures show

  std::vector<session::SessionPicture> pictures;
  const ServoTick& tick = session.last();
  const Nanos end_t = from_seconds(options.seconds), period = from_seconds(1 / kRate);
  // Initial estimates on two cores, s: for a second of the session, for a frame of the film with the ticks until the
  // next one, and for a stereo picture in the best quality.
  Pace second(0.15), frame_pace(options.film ? 0.25 : 0.08), moment(4);
  constexpr double kEnding = 4;
  constexpr int kMoments = 3;
  int moments = 0;  // number of moments whose pictures were ordered
  Nanos last = now();
  const auto lap = [&] { return to_seconds(now() - std::exchange(last, now())); };
  std::uint64_t frames = 0;
  double fraction = 0;
  const auto show_progress = [&] {
    const double t = to_seconds(tick.t), filmed = options.film ? length : std::min(length, kFilmed);
    const double unfilmed = std::max(0.0, filmed - static_cast<double>(frames) / options.fps);
    const double left = std::max(0.0, length - t - unfilmed) * second.each() +
                        unfilmed * options.fps * frame_pace.each() + (kMoments - moments) * moment.each() + kEnding;
    const double passed = to_seconds(now() - began);
    fraction = std::max(fraction, passed / (passed + left));
    progress.at(fraction);
  };
  const auto take_pictures = [&](const std::string& name, const char* title, const Look& shown) {
    write_pictures(stage, world, shown, options.out, name, pictures, title);
    log::info("drew {}", (options.out / (name + "_left.png")).string());
  };
  const auto notice = [&] {
    using Phase = DemoHand::Phase;
    const Phase phase = demo_hand.phase();
    if (phase == Phase::kAway && end.empty())
      end = result_text(carver.volume(), header.volumes_before, options.language);
    return phase == Phase::kExplore ? hud_text(options.language, "exploring")
           : phase == Phase::kDrill ? hud_text(options.language, "removing")
                                    : end;
  };

  show_progress();
  double next_look = 0, next_frame = 0, next_picture = kPictureEvery, film_began = options.film ? 0 : -1;
  // File, sound and pictures follow the session's event logs.
  const auto record = [&] {
    recorder.turn();
    recorder.writer().heartbeat();
    sound.advance(tick.t);
  };
  bool drawing = false;  // true: the stage draws a frame that the film does not have yet
  const auto take_frame = [&] {
    if (!std::exchange(drawing, false)) return;
    render::Picture left = stage.eye(0);
    stage.write_over(left);
    if (!film) film.emplace(mp4, session::FilmOptions{left.size.x, left.size.y, options.fps});
    film->add(left.rgba);
    if (!options.film) return;
    const render::Picture screen = stage.screen();
    if (!stereo) stereo.emplace(stereo_mp4, session::FilmOptions{screen.size.x, screen.size.y, options.fps});
    stereo->add(screen.rgba);
  };
  // A second thread moves chips and water and draws the pictures, while the session advances to the next stop. Where it
  // draws nothing, it may be up to kBehind behind.
  std::future<void> following;
  bool filming = false, picturing = false, rested = false;
  Nanos stop = 0, followed = 0;  // ns, times of the last stop, and of the last one that the second thread was given
  while (tick.t + period <= end_t && session.advance(demo_hand)) {
    const double t = to_seconds(tick.t);
    const auto in_film = [&] { return film_began >= 0 && (options.film || t < film_began + kFilmed); };
    const bool films = in_film() && t >= next_frame;
    const bool looks = t >= next_look;
    if (!looks && !films) continue;
    record();
    if (looks) next_look += kStep;
    const double removed = tick.removed[kCaries] / header.volumes_before[kCaries];
    const bool before = moments == 0, during = moments == 1 && removed > kDuring, at = t >= next_picture;
    if (before || during) ++moments;
    if (during && !options.film) film_began = next_frame = t;
    const double at_time = next_picture;
    if (at) next_picture += kPictureEvery;
    const bool pictured = before || during || at;
    const bool near_during = moments == 1 && removed > kNearlyDuring;
    const bool rests = !(in_film() || near_during || t >= next_picture - kSettling);
    const Nanos earlier = std::exchange(stop, tick.t);
    if (!films && !pictured && rests == rested && to_seconds(stop - followed) < kBehind && following.valid() &&
        following.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
      continue;
    std::vector<render::MeshUpdate> bricks;
    if (films || pictured) bricks = view.update(carver);
    if (following.valid()) following.get();
    if (const double took = lap(); filming || picturing) {
      (filming ? frame_pace : moment).took(took);
    } else {
      second.took(took / std::max(kStep, to_seconds(stop - followed)));
    }
    filming = films, picturing = before || during, rested = rests, followed = stop;
    if (!bricks.empty()) stage.show(bricks, frame.origin);
    if (films) {
      ++frames;
      next_frame += 1 / options.fps;
    }
    following = std::async(std::launch::async, [&, before, during, at, at_time, pictured, films, rests, earlier,
                                                until = stop, text = notice()] {
      reader.read(pictured ? until : earlier);
      if (pictured) take_frame();
      world.say(text);
      if (before) take_pictures("before", "Before", {});
      if (during) take_pictures("during", "While drilling", {});
      if (at) {
        stage.draw(world);
        const fs::path file = options.out / fmt::format("at_{:03.0f}_s.png", at_time);
        write_eye(stage, 0, file);
        log::info("drew {}", file.string());
      }
      world.rest_debris(rests);
      reader.read(until);
      if (!films) return;
      stage.draw(world, {}, take_frame);
      drawing = true;
    });
    show_progress();
  }
  if (following.valid()) following.get();
  take_frame();
  record();
  sound.stop(tick.t);
  // Completes the films while the last pictures and the report are made.
  const session::FilmSound heard{wav, std::max(0.0, film_began)};
  const auto finish = [&heard](auto& writer) { return writer && writer->finish(heard); };
  auto finished = std::async(std::launch::async, [&] { return std::pair(finish(film), finish(stereo)); });
  reader.read(tick.t);
  world.say(result_text(carver.volume(), header.volumes_before, options.language));
  stage.show(view.update(carver), frame.origin);
  take_pictures("after", "After", {.debris = false});

  recorder.turn();
  session::SessionResult result = session_result(carver.volume());
  result.pictures = pictures;
  if (!recorder.writer().finish(result)) throw RunFailure(recorder.writer().status().message);
  const session::SessionReader recorded(session_file);
  const fs::path report = options.out / "report.html";
  write_file_atomically(report, session::report_html(recorded, report_of(recorded)), FileKind::kPage);
  const auto [filmed, filmed_stereo] = finished.get();
  progress.at(1);

  const PerTissue& removed = tick.removed;
  const auto mm3 = [&](Tissue tissue_kind) {
    return removed[static_cast<std::size_t>(tissue_kind)] / kCubicMillimetre;
  };
  const double caries = recorded.header().volumes_before[kCaries] / kCubicMillimetre;
  fmt::print(
      "Removed {:.2f} of {:.2f} mm³ caries, with {:.2f} mm³ sound enamel and {:.2f} mm³ sound dentin, in {:.1f} s.\n",
      mm3(Tissue::kCaries), caries, mm3(Tissue::kEnamel), mm3(Tissue::kDentin), to_seconds(tick.t));
  fmt::print("Made in {}:\n", fs::absolute(options.out).string());
  fmt::print("  before_*.png during_*.png after_*.png  stereo pictures: left, right, and the screen as composed\n");
  fmt::print("  at_*_s.png    the left eye every {:.0f} seconds of the session\n", kPictureEvery);
  if (filmed) {
    fmt::print("  session.mp4   film with sound, {} frames\n", frames);
  } else {
    fmt::print("  (no session.mp4: {})\n", film ? film->message() : "nothing was drawn");
  }
  if (filmed_stereo) {
    fmt::print("  session_stereo.mp4   the same for both eyes\n");
  } else if (options.film) {
    fmt::print("  (no session_stereo.mp4: {})\n", stereo ? stereo->message() : "nothing was drawn");
  }
  fmt::print("  drill.wav     the drill's sound\n");
  fmt::print("  session.h5    the recording: typodont replay {} --check\n", session_file.string());
  fmt::print("  report.html   open it in a browser\n");
  std::fflush(stdout);
  if (isatty(STDOUT_FILENO) != 0 && (std::getenv("DISPLAY") || std::getenv("WAYLAND_DISPLAY")))
    Started().open(fs::absolute(report).string());
}

}  // namespace

void add_demo_command(cli::Command& app) {
  auto options = std::make_shared<DemoOptions>();
  auto size = std::make_shared<std::string>();
  auto language = std::make_shared<std::string>();
  cli::Command* command =
      app.add_command("demo", "A demonstration: a scripted hand removes the caries of a CT molar, offscreen");
  command->footer("Example:\n  typodont demo --out demo");
  command->add_setting("--out", options->out, "folder for the results", cli::writes_folder());
  command->add_option("--scene", options->scene, "another scene with caries (JSON)");
  command->add_option("--rig", options->rig, "another rig (JSON), or the name of one in assets/rigs");
  command->add_option("--size", *size,
                      "WIDTHxHEIGHT of one eye's picture; where not given 960x540, with --film the rig's (full HD)");
  command->add_option("--model", options->model,
                      "contact model instead of the scene's, " + haptics::known_contact_methods());
  command->add_flag("--film", options->film,
                    "film the whole session in the rig's size, also in stereo: ten minutes on two cores");
  command->add_setting("--fps", options->fps, "frames a second of the film", cli::range(1.0, 120.0));
  command->add_option("--seconds", options->seconds, "stop after this session time", cli::range(0.1, kLongestSession));
  command->add_option("--language", *language,
                      "language of the text over the picture: en, de or zh; otherwise the window's language");
  command->callback([options, size, language] {
    options->language = hud_language(user_language(*language));
    if (!size->empty()) options->eye_size = parse_size(*size);
    run(*options);
  });
}

}  // namespace typodont
