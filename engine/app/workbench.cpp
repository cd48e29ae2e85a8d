#include "engine/app/workbench.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <mutex>
#include <optional>
#include <thread>
#include <tuple>
#include <utility>

#include "engine/app/assets.h"
#include "engine/app/hands/hands.h"
#include "engine/app/hands/live_expert.h"
#include "engine/app/hands/mouse_hand.h"
#include "engine/app/live/live_picture.h"
#include "engine/app/live/session.h"
#include "engine/app/live/xr_hand.h"
#include "engine/app/live/xr_session.h"
#include "engine/app/picture/hud.h"
#include "engine/app/picture/magnify.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording.h"
#include "engine/app/recording/resume.h"
#include "engine/app/sound_link.h"
#include "engine/app/task/damage.h"
#include "engine/app/task/task.h"
#include "engine/app/wiring.h"
#include "engine/base/check.h"
#include "engine/base/error.h"
#include "engine/base/interrupt.h"
#include "engine/base/log.h"
#include "engine/base/partial_file.h"
#include "engine/base/units.h"
#include "engine/contract/loop_timing.h"
#include "engine/session/recorder.h"
#include "haptics/carver.h"
#include "haptics/device_safety.h"
#include "haptics/devices.h"
#include "haptics/solid.h"
#include "haptics/work.h"

namespace typodont {

namespace {

using namespace std::chrono_literals;

// If the distance between tool and hand is larger than this, the tool counts as caught in the tissue, m.
constexpr double kStuckDistance = 3e-3;
// Only a tool that is caught for longer than this is reported to the user, ns.
constexpr Nanos kStuckTime = 1 * kNanosPerSecond;
constexpr Nanos kFirstPictures = 10 * kNanosPerSecond;  // longest wait for the first pictures
constexpr Nanos kQuickPass = kNanosPerSecond / 4;       // a first picture for which the driver compiles takes longer
constexpr int kViewKey = 'V', kSuctionKey = 'A', kSprayKey = 'W';
// Keys in an implant exercise: take the phase's instrument, make the drill slower or faster, reverse it.
constexpr int kPhaseToolKey = 'T', kSlowerKey = ',', kFasterKey = '.', kBackwardsKey = 'B';
// Change of the drill's speed per key press, as a fraction of the motor's full speed.
constexpr double kSpeedStep = 0.05;

std::atomic<bool> g_asked_to_stop{false};
void ask_to_stop(int) {
  g_asked_to_stop = true;
}

}  // namespace

/// The parts of a session, in the order of their set-up. Only the render thread uses them, except `session`.
struct Workbench::Impl {
  const Scene scene;
  const WorkbenchOptions options;
  WorkbenchSummary summary;
  std::filesystem::path rig_file;
  std::optional<display::DisplayRig> rig;
  std::optional<LiveSession> session;
  std::optional<Pointer> pointer;  // the pointer that moves the tool if the mouse is the hand; empty for other hands
  Hands hands;
  std::optional<SoundLink> sound;
  std::optional<SessionRecorder> recording;
  std::optional<StateStream> stream;
  std::optional<StreamTurns> streaming;
  // Pictures in the session's own window or in the operator's window; empty if neither shows the session.
  std::optional<LivePicture> picture;
  std::optional<XrSession> headset;  // headset: replaces the picture and draws on its own thread
  WorkCounts before;                 // counts of the process when the session started
  dvec3 above{0, 0, 0};              // m, frame W, initial position of the tool

  bool running = false;
  std::optional<InterruptHandler> on_interrupt;
  int first_pictures = 0;  // number of pictures that were drawn before the session's time
  Nanos begins_by = 0;     // ns, time at which the session's time starts even if the pictures do not show the tissue
  Nanos began = 0;
  /// Positions up to which the application thread has read the event logs.
  struct Places {
    explicit Places(const EventLogs& event_logs)
        : servo(event_logs.servo), carver(event_logs.carver), loop(event_logs.loop) {}
    EventLog<ServoEvent>::Reader servo;
    EventLog<CarverEvent>::Reader carver;
    EventLog<LoopReport>::Reader loop;
  };
  std::optional<Places> places;
  // The newest events: the servo's tick, the tissue's state, and the report about the servo loop.
  ServoTick tick;
  TissueState tissue_state;
  LoopReport loop;
  SessionSettings settings;  // the settings that were last sent to the servo
  // Measures the motion of the hand for the score; empty if no operator's window shows the session.
  std::optional<session::HandMeter> meter;
  // Measures the damage for the score; empty if no operator's window shows the session.
  std::optional<DamageMeter> damage;
  /// The temperatures of pulp and bone; null if no picture shows them or the scene does not ask for them.
  const HeatMeter* heat() const { return picture ? picture->world().heat() : nullptr; }
  // Determines the current phase of an implant exercise; empty in other exercises.
  std::optional<session::ImplantMeter> implant;
  // Volume of each tissue at the start, m³; used only if an operator's window shows the session.
  PerTissue volumes_before{};
  // Result of an exploration task; valid after the session.
  std::pair<std::optional<session::ExploreMeter>, std::vector<ServoTick>> explored;
  Nanos fault_time = 0;
  std::uint32_t recent_faults = 0;
  Nanos followed = 0;             // ns, session time at which the tool was last near the hand
  std::vector<std::string> keys;  // help texts about keys, which the picture shows
  std::string told;               // text of say(), which the picture shows instead of `keys` during an experiment
  std::vector<int> pressed;       // keys that were pressed in the last step
  std::size_t printed = 0;        // number of explanations that were printed
  std::string failure;
  bool hand_gone = false;
  // The session's threads wait at this gate until all of them exist and the recording has its name. The carver thread
  // starts earlier.
  struct Gate {
    enum State { kShut, kOpen, kClosed };
    void set(State to) {
      state = to;
      state.notify_all();
    }
    bool passed() const {
      State found;
      while ((found = state) == kShut) state.wait(kShut);
      return found == kOpen;
    }
    std::atomic<State> state{kShut};
  } gate;
  std::atomic<bool> thread_failed{false};
  // Declared last, so that the threads are joined before the members that they use are destroyed.
  std::jthread carver, servo, left, recorder, streamer;

  Impl(const Scene& s, const WorkbenchOptions& o, Progress* progress) : scene(s), options(o) { set_up(progress); }
  ~Impl() {
    if (!running) {  // the session has not begun, so its threads end now
      session->wiring.stop = true;
      gate.set(Gate::kClosed);
    }
    end();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void explain(std::string text) { summary.explanations.push_back(std::move(text)); }
  /// Prints the explanations that were not printed before, if the user asked for them (--explain).
  void print_explanations() {
    if (!options.explain) return;
    for (; printed < summary.explanations.size(); ++printed) log::info("{}", summary.explanations[printed]);
  }
  void set_up(Progress* progress);
  void start_headset(const std::string& hand_address);
  void open();
  bool begin(glm::ivec2 picture_size);
  /// Draws a picture, if its pipelines exist and the last picture is finished. True: a finished picture shows the
  /// tissue, and the next one takes less than kQuickPass; or kFirstPictures have passed and no picture is being drawn.
  /// The carver thread already runs.
  bool shows_tissue(glm::ivec2 picture_size);
  /// Sets the size in pixels of the picture in the operator's window.
  void fit(glm::ivec2 size) {
    if (options.embedded && picture->stage()->resize(size) && pointer) pointer->follow_rig(picture->stage()->rig());
  }
  /// Starts a session's thread. If its work throws, the session ends.
  template <class Work>
  void launch(std::jthread& thread, Work work) {
    thread = std::jthread([this, work] {
      if (!gate.passed()) return;
      try {
        work();
      } catch (const std::exception& e) {
        log::error("{}", e.what());
        thread_failed = true;
        session->wiring.stop = true;
      }
    });
  }
  bool step(const display::UserInput* input, glm::ivec2 picture_size);
  void follow_event_logs();
  void advance_sound();
  /// Passes a tick to the objects that measure the score.
  void score(ServoTick next);
  void follow_keys(const display::UserInput& input);
  void edit_tissue(const display::UserInput& input);
  void count_work(const WorkCounts& running);
  /// Number of requests that this program has sent to the window system so far; 0 if another program's window shows the
  /// picture.
  std::uint64_t desktop_requests() {
    return picture && picture->stage() && !options.embedded ? picture->stage()->output().requests() : 0;
  }
  void report_hand();
  double caught() const;
  std::string hint() const;
  std::string quality_notice() const {
    return headset ? headset->quality_notice() : picture ? picture->quality_notice() : "";
  }
  ServoTick tool_at_start() const {
    ServoTick start;
    start.X_WT.p = start.X_WG.p = above;
    return start;
  }
  void follow_implant_key(int key);
  void take_phase_tool();
  ImplantStatus implant_status() const;
  std::string implant_line() const;
  void end();
};

void Workbench::Impl::set_up(Progress* progress) {
  const auto reached = [&](double fraction) {
    if (progress) progress->at(fraction);
  };
  // Loads the files that this session needs.
  if (!options.rig.empty()) rig_file = find_rig(options.rig);
  if (rig_file.empty() && display::has_desktop()) rig_file = usual_rig(scene, "window");
  if (!rig_file.empty()) rig = display::load_rig(rig_file);
  if (rig && options.embedded) rig->screen.layout = display::Layout::kMono;
  const bool window = rig && (rig->kind == display::DisplayKind::kWindow || rig->kind == display::DisplayKind::kMirror);
  const bool hmd = rig && rig->kind == display::DisplayKind::kHmd;
  if (options.magnify > 0) {
    if (!window && !hmd) throw Error("--magnify", "", rig ? rig_file.string() : "no rig", "a rig with a live picture");
    if (hmd && rig->hmd.X_WD) throw Error("--magnify", "", rig_file.string(), "a rig whose space is not measured");
    (hmd ? rig->hmd.magnify : rig->magnify) = options.magnify;
  }
  if (!options.touches.empty() && !hmd) throw Error("--touches", "", rig_file.string(), "a headset's rig");
  HandChoice choice{options.hand, options.left_hand, options.pedal, options.rate, tool_names(scene)};
  choice.hand = hand_address(choice, rig ? &*rig : nullptr, window ? "mouse:" : hmd ? "openxr:right" : "");

  reached(0.1);
  LiveSession& s = session.emplace(scene, load_tissue(scene));
  reached(0.4);
  places.emplace(s.wiring.event_logs);
  // Checks the file name now, so that an invalid name is reported before the session.
  if (!options.save.empty()) require_output(options.save, FileKind::kVolume);
  const haptics::TissueVolume& tissue = s.carver.volume();
  s.draw = (window || hmd) && scene.needs("render");
  explain(s.draw ? fmt::format("picture: on, {}", rig_file.string())
          : !rig ? "picture: off, there is no desktop and no rig was given"
          : !window && !hmd
              ? "picture: off, an offscreen rig shows nothing live; use 'typodont render' or 'typodont demo'"
              : "picture: off, the scene does not name \"render\"");
  s.operated = options.operated;
  s.record = !options.record.empty();
  s.save = options.save;
  if (!scene.resume.empty()) explain("tissue: continued from " + scene.resume);
  explain(s.record ? "recording: on, " + options.record.string() : "recording: off, no --record FILE.h5");
  s.debris = s.draw && scene.needs("debris");
  explain(options.warnings.empty() ? "warnings: off, or the scene's task has none"
                                   : fmt::format("warnings: on, {}", fmt::join(options.warnings, ", ")));
  explain(s.debris ? "debris: on"
          : s.draw ? "debris: off, the scene does not name it"
                   : "debris: off, nothing is drawn");

  // Opens the hand (device, mouse or script). With the mouse, the tool starts above the tissue.
  glm::ivec3 lo, hi;
  tissue.bounds(lo, hi);
  above = tissue.frame().to_world(dvec3((lo.x + hi.x) / 2.0, (lo.y + hi.y) / 2.0, hi.z)) + dvec3(0, 0, 1e-3);
  if (rig && !hmd) rig = magnified_for(*rig, tissue);
  if (s.draw && hmd) start_headset(choice.hand);
  const WindowHands in_window = [&](const std::string& scheme, const std::string& rest) {
    if (scheme == "openxr") {
      if (!headset)
        throw Error("--hand", "", scheme + ":" + rest, "a headset's rig, and a scene that names \"render\"");
      return make_xr_hand(s.wiring, scheme + ":" + rest, {above, {1, 0, 0, 0}}, options.rate);
    }
    if (scheme == "expert") return make_live_expert(scene, s.carver.volume(), s.wiring, options.rate, /*paced=*/true);
    if (!window) throw Error("--hand", "", scheme + ":", "a window rig for it to move in");
    pointer.emplace(*rig, above, wheel_step_of(rest), scene.task ? std::optional(scene.task->axis_W) : std::nullopt);
    pointer->come_into_sight(s.carver.volume());
    return make_mouse_hand(s.wiring, pointer->follow({}, 0).X_WT, options.rate);
  };
  hands = open_hands(choice, rig ? &*rig : nullptr, in_window);
  const haptics::DeviceInfo& hand = hands.right->info();
  if (!options.no_real_time) require_real_time(hands);
  s.serve(hand, options.max_delay);
  explain("hand: " + in_words(hand));
  explain(hands.left ? fmt::format("left hand, with the {}: {}", hand_holds_suction(scene) ? "suction" : "mouth mirror",
                                   in_words(hands.left->info()))
                     : "left hand: none");

  // Opens the sound output, if scene and options ask for sound.
  if (scene.needs("sound") && options.audio != "none:") {
    std::string address = options.audio;
    if (address.empty() && !audio::audio_devices().empty()) address = "portaudio:";
    if (address.empty()) {
      explain("sound: off, there is no sound card; --audio wav:FILE writes it to a file");
    } else {
      sound.emplace(address, voice_of(scene), s.wiring.event_logs, !address.starts_with("wav:"), options.binaural);
      // Without a picture, no other code writes the eyes' position, which the binaural sound needs.
      if (rig && !s.draw)
        s.wiring.event_logs.view.write(SeenFrom{0, rig->head.eye_center, rig->head.right, rig->head.ipd});
      explain("sound: on, " + address + (options.binaural ? ", for two ears" : ""));
    }
  } else {
    explain(scene.needs("sound") ? "sound: off, --audio none:" : "sound: off, the scene does not name it");
  }

  if (!options.stream.empty()) {
    stream.emplace(options.stream, StreamedSession{scene.name, tool_names(scene), hand.rate, voice_of(scene)});
    streaming.emplace(s, *stream, options.stream_rate);
    explain(fmt::format("stream: on, {}", fmt::join(options.stream, ", ")));
  }
  if (s.operated) {
    meter.emplace(hand.rate);
    volumes_before = tissue.volumes();
    s.watched = s.draw && hmd;
    damage = damage_meter(scene);
  }
  if (scene.implant) implant.emplace(*scene.implant);
  reached(0.6);
  if ((s.draw && window) || s.operated) {
    picture.emplace(scene,
                    LivePicture::Options{.operated = options.operated,
                                         .steered = options.steered,
                                         .embedded = options.embedded,
                                         .urgent = emergency_keys(),
                                         .cursor = pointer.has_value(),
                                         .monitor = options.monitor,
                                         .language = options.language,
                                         .quality = options.quality,
                                         .device = options.device},
                    s, tool_at_start());
    picture->add_heat(hand.rate);
    picture->add_warnings(options.warnings);
  }
  reached(0.9);
  // The recording has a temporary name until the session's threads exist. A session that cannot start leaves no file.
  if (s.record) {
    session::SessionHeader header = session_header(scene, rig_file, hand, tissue, hand.rate);
    if (hands.left) header.streams.push_back(left_hand_stream());
    header.trainee = options.trainee;
    if (s.draw || s.operated) header.warnings = options.warnings;
    if (headset) header.streams.push_back(xr_stream());
    if (s.draw && window) header.streams.insert(header.streams.end(), {picture_stream(), head_stream()});
    if (s.debris && window) header.streams.push_back(water_stream());
    if (sound) header.streams.push_back(sound_stream());
    recording.emplace(options.record, scene, header, s.wiring.event_logs,
                      session::WriterOptions{.named_by_start = true},
                      sound ? [this] { return sound->latency(); } : std::function<double()>());
    if (sound) recording->writer().event(0, session::EventKind::kNote, sound->about());
  }
  reached(1);
}

void Workbench::Impl::start_headset(const std::string& hand_address) {
  LiveSession& s = *session;
  XrSession::Options o;
  if (hand_address.starts_with("openxr:")) {
    if (hand_address != "openxr:right" && hand_address != "openxr:left")
      throw Error("--hand", "", hand_address, "openxr:right or openxr:left");
    o.tool_hand = hand_address == "openxr:right" ? 1 : 0;
  }
  o.quality = options.quality;
  o.touches = !options.touches.empty();
  if (o.touches && o.tool_hand >= 0)
    throw Error("--touches", "", hand_address, "an arm as the hand, which touches the controller's tip");
  o.debris = s.debris;
  o.work_W = above;
  o.start = tool_at_start();
  o.force_in_hud = !options.steered;
  o.warnings = options.warnings;
  o.language = options.language;
  headset.emplace(*rig, scene, s.carver.volume(), s.wiring, o);
  for (std::string& line : headset->explanations()) explain(std::move(line));
  if (o.tool_hand < 0 && !rig->hmd.X_WD)
    explain("headset: not registered to the hand's device: what is seen is not where it is felt");
}

void Workbench::Impl::open() {
  LiveSession& s = *session;
  if (s.draw && !headset) picture->open(*rig, summary.explanations);
  print_explanations();
  // The carver thread offers the first tissue patch before the servo's first tick.
  tick = tool_at_start();
  s.wiring.patch.offer(s.carver, above);

  g_asked_to_stop = false;
  // After a failed check in the code, this handler sets the force to zero.
  set_check_handler(haptics::release_all_devices);
  on_interrupt.emplace(ask_to_stop);
  before = process_counts();
  before.desktop_requests = desktop_requests();
  // The carver thread makes the surface. The session's time starts when the user sees the tissue.
  launch(carver, [&s] { carver_thread(s); });
  gate.set(Gate::kOpen);
  if (picture) picture->begin();
  if (picture && picture->stage()) picture->stage()->draw_ahead(true);
  begins_by = now() + kFirstPictures;
}

bool Workbench::Impl::begin(glm::ivec2 picture_size) {
  if (!shows_tissue(picture_size)) return false;
  LiveSession& s = *session;
  if (picture && picture->stage()) picture->stage()->draw_ahead(false);
  gate.set(Gate::kShut);
  launch(servo, [&] { servo_thread(s, *hands.right); });
  if (hands.left) launch(left, [&] { left_hand_thread(s.wiring, *hands.left); });
  if (recording) launch(recorder, [&] { recorder_thread(s, *recording); });
  if (streaming) launch(streamer, [&] { stream_thread(s, *streaming); });
  if (recording) recording->writer().start();
  running = true;
  gate.set(Gate::kOpen);
  began = now();
  const std::size_t tools = std::min<std::size_t>(haptics::tool_set(scene.servo).size(), 9);
  const session::Language language = options.language;
  keys.push_back(hud_text(language, "undo"));
  if (picture && !options.operated) keys.push_back(hud_text(language, "view"));
  if (picture && picture->world().debris()) keys.push_back(hud_text(language, "suction"));
  if (picture && picture->world().debris() && picture->world().debris()->has_spray())
    keys.push_back(hud_text(language, "water"));
  if (tools > 1) keys.push_back(hud_text(language, "tools", tools));
  return true;
}

bool Workbench::Impl::shows_tissue(glm::ivec2 picture_size) {
  if (!session->draw || headset || !picture->stage()) return true;
  const Nanos began_pass = now();
  if (thread_failed || g_asked_to_stop) return true;
  if (!picture->stage()->finished()) return false;
  if (!options.embedded) picture->stage()->output().poll();
  if (began_pass >= begins_by) return true;
  picture->collect();
  const std::atomic<bool>& seen = session->wiring.tissue_in_sight[static_cast<std::size_t>(Eyes::kTrainee)];
  if (!picture->has_surface() && seen) {
    picture->prepare();  // at the same time as the carver thread makes the surface
    return false;
  }
  if (picture->frames() > 0) fit(picture_size);
  picture->draw(told, summary.work);
  if (picture->stage()->waits()) return false;
  return ++first_pictures > 1 && now() - began_pass < kQuickPass;
}

/// Reads the servo's and the carver's events since the last call.
void Workbench::Impl::follow_event_logs() {
  for (ServoEvent event; places->servo.next(event);) {
    if (picture) picture->apply(event);
    const auto* const next = std::get_if<ServoTick>(&event);
    if (!next) continue;
    tick = *next;
    if (meter) score(tick);
    if (tick.faults != 0) {
      recent_faults = tick.t - fault_time < kNanosPerSecond ? recent_faults | tick.faults : tick.faults;
      fault_time = tick.t;
    }
  }
  for (CarverEvent event; places->carver.next(event);) {
    if (picture) picture->apply(event);
    if (const auto* const next = std::get_if<TissueState>(&event)) tissue_state = *next;
  }
  places->loop.newest(loop);
}

/// Continues the sound up to the current time of the session's clock, which begins with the first tick.
void Workbench::Impl::advance_sound() {
  const Nanos zero = session->wiring.session_zero.load(std::memory_order_relaxed);
  if (zero == 0) return;
  sound->advance(sound->live() ? now() - zero : tick.t);
}

/// Runs one pass of the drawing loop: draws a frame or waits for a short time. Returns false at the session's end.
bool Workbench::Impl::step(const display::UserInput* input, glm::ivec2 picture_size) {
  LiveSession& s = *session;
  ++summary.work.turns;
  pressed.clear();
  follow_event_logs();
  if (s.wiring.servo_ended || thread_failed || g_asked_to_stop || to_seconds(now() - began) >= options.seconds)
    return false;
  s.wiring.record_to_render.fetch();
  report_hand();
  if (!(tick.depth > kStuckDistance)) followed = tick.t;
  try {
    if (sound && picture) sound->water(picture->world().water().spray, picture->world().suction_flow());
    if (sound) advance_sound();
    if (!s.draw || headset || !picture || !picture->stage()) {
      std::this_thread::sleep_for(10ms);
      if (!headset) return true;
    }
    if (headset) {
      if (picture) {
        picture->collect();
        picture->draw_own(summary.work);
      }
      headset->say(hint());
      return headset->step();
    }
    const display::UserInput own = options.embedded ? display::UserInput() : picture->stage()->output().poll();
    if (own.close) return false;
    const display::UserInput& over = input && options.embedded ? *input : own;
    if (pointer)
      s.wiring.pointer.publish(
          pointer->follow(over, now() - began, tick.depth > 0 ? std::optional(tick.X_WG.p) : std::nullopt));
    fit(picture_size);
    pressed = over.pressed;
    follow_keys(over);
    // If the score is computed (in the operator's window; `meter` exists), score() passes every tick to `implant`.
    // Otherwise the newest tick is sufficient.
    if (implant && !meter) implant->add({&tick, 1});
    edit_tissue(over);
    picture->draw(hint(), summary.work);
    return true;
  } catch (const gpu::DeviceLost& e) {
    if (options.device) throw;  // the operator's window creates a new GPU device for itself and for the session
    log::warn("{}; the picture is created again", e.what());
    if (picture->recreate_lost_device()) return true;
    failure = e.what();
    return false;
  } catch (const std::exception& e) {  // the picture or the sound failed; the session ends properly
    failure = e.what();
    return false;
  }
}

/// Reports once that a device was unplugged, and once that it is connected again.
void Workbench::Impl::report_hand() {
  const bool gone = (tick.faults & bits(Fault::kDeviceLost)) != 0;
  if (gone == hand_gone) return;
  hand_gone = gone;
  if (gone) {
    log::warn("{} is disconnected; plug it in again to continue", hands.right->info().address);
  } else {
    log::info("{} is back; force returns when the hand is free of contact", hands.right->info().address);
  }
}

/// Distance between tool and hand, m, if the tool has not followed the hand for kStuckTime; otherwise 0.
double Workbench::Impl::caught() const {
  return tick.t - followed > kStuckTime ? tick.depth : 0;
}

/// The text over the picture: the keys and states of the session, and the load of the device's motors.
std::string Workbench::Impl::hint() const {
  const session::Language language = options.language;
  const auto words = [&](std::string_view key, const auto&... values) { return hud_text(language, key, values...); };
  const auto number = [&](double value, int decimals) { return session::number_text(value, decimals, language); };
  const RecordState& record = session->wiring.record_to_render.front();
  std::vector<std::string> parts;
  if (haptics::emergency_stopped()) {
    parts = {words("stopped"), words("continue")};
  } else if (hand_gone) {
    parts = {words("hand_gone")};
  } else if (caught() > 0) {
    parts = {words("stuck", number(caught() / kMillimetre, 0)), words("stop")};
  } else if (options.steered) {
    parts = {told, words("stop")};
  } else {
    if (record.failed) {
      parts.push_back(words("no_record"));
    } else if (!record.complete || record.disk_low) {
      parts.push_back(words(record.complete ? "disk_low" : "gaps"));
    }
    if (implant && picture && !options.operated) {
      // The line is too short for the current phase and all keys. The phase is more important, so some keys are left
      // out.
      parts.insert(parts.end(), {implant_line(), words("implant_keys"), words("view")});
    } else {
      if (pointer) parts.push_back(words("mouse", short_number(pointer->wheel_step() / kMillimetre, 3, language)));
      parts.insert(parts.end(), keys.begin(), keys.end());
    }
    if (heat() && heat()->pulp() > HeatMeter::kBody + HeatMeter::kPulpHarm)
      parts.push_back(words("pulp_hot", number(heat()->pulp() - HeatMeter::kBody, 1)));
    if (heat() && heat()->bone() > HeatMeter::kBoneHarm) parts.push_back(words("bone_hot", number(heat()->bone(), 0)));
    if (loop.bearable_force > 0) {
      parts.push_back(words("motors", number(100 * loop.heat, 0), number(loop.bearable_force, 1)));
      if (!loop.armed) parts.push_back(words("not_armed"));
    }
    if (picture && picture->world().water().suction) parts.push_back(words("suction_on"));
    if (picture && picture->world().debris() && picture->world().debris()->has_spray() &&
        !picture->world().water().spray)
      parts.push_back(words("water_off"));
    if (std::string quality = quality_notice(); !quality.empty()) parts.push_back(std::move(quality));
    parts.push_back(words("stop"));
  }
  return fmt::format("{}", fmt::join(parts, kHudGap));
}

/// Handles the keys, except emergency_keys(). 1 … 9 select a tool of the tool set.
void Workbench::Impl::follow_keys(const display::UserInput& input) {
  for (const int key : input.pressed) {
    if (key == kViewKey && !options.operated) picture->show_next_view();
    if (key == kSuctionKey) picture->switch_suction();
    if (key == kSprayKey) picture->switch_spray();
    if (implant) follow_implant_key(key);
    const int place = key - '1';
    if (place >= 0 && place < 9 && place < static_cast<int>(haptics::tool_set(scene.servo).size())) {
      session->wiring.chosen_tool = place;
    }
  }
}

void Workbench::Impl::take_phase_tool() {
  if (!implant || implant->phase() >= scene.implant->phases.size()) return;
  const session::ImplantPhase& phase = scene.implant->phases[implant->phase()];
  session->wiring.chosen_tool = static_cast<int>(phase.tool);
  const double top = haptics::tool_set(scene.servo)[phase.tool].free_speed(scene.servo.spindle.free_speed);
  if (phase.speed > 0 && top > 0) settings.speed_fraction = std::min(1.0, phase.speed / top);
  settings.backwards = false;
}

ImplantStatus Workbench::Impl::implant_status() const {
  ImplantStatus status;
  status.phase = implant->phase();
  status.note = implant->note();
  status.depth = implant->depth();
  if (status.phase < scene.implant->phases.size()) status.phase_depth = scene.implant->phases[status.phase].depth;
  status.speed =
      settings.speed_fraction * haptics::tool_set(scene.servo)[tick.tool].free_speed(scene.servo.spindle.free_speed);
  status.temperature = implant->temperature();
  return status;
}

void Workbench::Impl::follow_implant_key(int key) {
  if (key == kPhaseToolKey) {
    take_phase_tool();
  } else if (key == kSlowerKey || key == kFasterKey) {
    settings.speed_fraction =
        std::clamp(settings.speed_fraction + (key == kFasterKey ? kSpeedStep : -kSpeedStep), 0.0, 1.0);
  } else if (key == kBackwardsKey) {
    settings.backwards = !settings.backwards;
  } else {
    return;
  }
  session->wiring.settings.publish(settings);
}

/// Text about the current phase of an implant exercise and its problems: "4/16 Pilot drill …: 3.2 of 6 mm, …".
std::string Workbench::Impl::implant_line() const {
  const session::Language language = options.language;
  const session::ImplantTask& task = *scene.implant;
  const std::size_t at = implant->phase();
  if (at >= task.phases.size()) return hud_text(language, "phases_done");
  std::string text = fmt::format("{}/{} {}: ", at + 1, task.phases.size(), task.phases[at].name.in(language));
  if (implant->note() != session::ImplantNote::kNone) {
    const std::string key = fmt::format("implant.note.{}", session::name_of(implant->note()));
    text.append(session::text(key, language)).append("!").append(kHudGap);
  }
  const ImplantStatus status = implant_status();
  const auto number = [&](double value, int decimals) { return session::number_text(value, decimals, language); };
  text += hud_text(language, "phase_depth", number(status.depth / kMillimetre, 1),
                   number(status.phase_depth / kMillimetre, 1),
                   session::tool_text(haptics::tool_set(scene.servo)[tick.tool].name, language),
                   display::spindle_text(status.speed / kKrpm, hud_words(language)));
  return settings.backwards ? fmt::format("{} {}", text, hud_text(language, "backwards")) : text;
}

/// Handles the keys for undo, redo and save: Ctrl+Z, Ctrl+Y and Ctrl+S, or the same letters without Ctrl.
void Workbench::Impl::edit_tissue(const display::UserInput& input) {
  for (const int key : input.pressed) {
    if (key == 'Z') session->wiring.tissue_commands.push(TissueCommand::kUndo);
    if (key == 'Y') session->wiring.tissue_commands.push(TissueCommand::kRedo);
    if (key == 'S') session->wiring.tissue_commands.push(TissueCommand::kSave);
  }
}

void Workbench::Impl::score(ServoTick next) {
  session::set_scored_times({&next, 1}, hands.right->info().rate);
  meter->add({&next, 1});
  if (damage) damage->add({&next, 1});
  if (implant) implant->add({&next, 1});
  picture->views()->explore(next);
}

/// Sends zero force, joins all threads and completes the recording. A second call does nothing.
void Workbench::Impl::end() {
  if (!running) return;
  running = false;
  LiveSession& s = *session;
  WorkCounts process = process_counts();
  process.desktop_requests = desktop_requests();
  s.wiring.stop = true;
  for (std::jthread* thread : {&servo, &left, &carver})
    if (thread->joinable()) thread->join();
  // Ends one part of the session. If this fails, the run counts as failed, but the remaining parts are still ended.
  const auto try_to = [&](const auto& part) {
    try {
      part();
    } catch (const std::exception& e) {
      if (failure.empty()) failure = e.what();
    }
  };
  const bool carved = s.carver_failure.empty();
  if (thread_failed && failure.empty()) failure = "a thread of the session failed";
  if (!carved && failure.empty()) failure = "the tissue cannot be kept up with the hand: " + s.carver_failure;
  // Applies to the tissue the cuts that the servo made after the carver thread had ended.
  if (carved) try_to([&] { s.side.follow([](const Cut&) {}, /*to_end=*/true); });
  follow_event_logs();  // reads up to the last tick, so that the score equals that of the recording
  if (meter) explored = picture->views()->take_explored();
  s.wiring.nothing_more = true;
  if (recorder.joinable()) recorder.join();
  if (streamer.joinable()) streamer.join();
  summary.frames = headset ? headset->frames() : picture ? picture->frames() : 0;
  if (headset) {
    headset->stop();
    if (!options.touches.empty()) try_to([&] { write_touches(options.touches, headset->touches()); });
  }
  if (sound) try_to([&] { sound->stop(s.last.t); });
  if (sound && recording) {
    const audio::AudioStats heard = sound->stats();
    if (heard.underruns + heard.losses + sound->unheard() > 0)
      recording->writer().event(s.last.t, session::EventKind::kNote,
                                fmt::format("sound: {} under-runs, the device lost {} times, {} ticks not played",
                                            heard.underruns, heard.losses, sound->unheard()));
  }
  if (picture) {
    try_to([&] { summary.debris = picture->settle_debris(); });
    if (summary.debris) summary.debris->events_lost = places->servo.lost();
    picture->close();
  }
  if (headset) summary.debris = headset->debris();
  on_interrupt.reset();

  if (!s.save.empty() && options.save_at_end) try_to([&] { save_tissue(copy_of(s.carver), s.save); });
  const session::SessionResult result = carved ? session_result(s.carver.volume()) : session::SessionResult();
  if (recording && !recording->writer().finish(result) && failure.empty())
    failure = recording->writer().status().message;
  summary.seconds = to_seconds(s.last.t);
  const auto since_command = [at = now(), age = seconds_since_command()](Nanos t) {
    return t ? age - to_seconds(at - t) : 0;
  };
  summary.first_tick_s = since_command(s.first_tick);
  if (picture) summary.first_frame_s = since_command(picture->first_shown());
  const LoopTiming& timing = s.loop->report().timing;
  summary.ticks = timing.ticks;
  PictureStage* const stage = picture ? picture->stage() : nullptr;
  if (stage) summary.tracker = stage->tracker_stats();
  summary.cuts = s.last.cuts;
  summary.removed = s.last.removed;
  summary.faults = s.faults;
  summary.deadline_misses = timing.misses;
  summary.tick_us_median = timing.work.quantile(0.5) * 1e-3;
  summary.tick_us_p999 = timing.work.quantile(0.999) * 1e-3;
  summary.worst_tick_us = static_cast<double>(timing.worst_tick) * 1e-3;
  summary.worst_jitter_us = static_cast<double>(timing.worst_jitter) * 1e-3;
  // The histogram states the upper edge of a bin as the quantile. This value may exceed the largest measured value, so
  // the largest measured value is its limit.
  summary.jitter_us_p999 = std::min(timing.jitter.quantile(0.999) * 1e-3, summary.worst_jitter_us);
  summary.loop = s.loop->report();
  if (stage && summary.frames > 0) {
    const QualityLadder& ladder = picture->ladder();
    explain(
        fmt::format("picture: {} frames, {:.1f} a second, {:.1f} ms each at the end, {:.0f} ms from hand to screen "
                    "(estimated); quality "
                    "\"{}\", step {} of {}, after {} changes",
                    summary.frames, static_cast<double>(summary.frames) / std::max(summary.seconds, 1e-3),
                    1e3 * picture->frame_seconds(), 1e3 * picture->photon_seconds(), ladder.step().name,
                    ladder.place() + 1, render::kQualityLadder.size(), ladder.changes()));
    explain(fmt::format("GPU memory in use: {:.0f} MB", 1e-6 * static_cast<double>(stage->device().memory_used())));
    explain(fmt::format("pipelines that no other thread prepared: {}", stage->device().unprepared_pipelines));
  }
  const auto times = headset ? headset->report() : picture ? picture->report().lines() : std::vector<std::string>{};
  for (const std::string& line : times) explain(line);
  if (!summary.loop.words().empty()) explain("real time: " + std::string(summary.loop.words()));
  print_explanations();
  count_work(process);
}

/// Collects the counters after all threads have ended. `running_process`: counts of the process while the session was
/// running.
void Workbench::Impl::count_work(const WorkCounts& running_process) {
  LiveSession& s = *session;
  WorkCounts& work = summary.work;
  work.ticks = summary.ticks, work.frames = summary.frames + (picture ? picture->own_frames() : 0);
  if (headset) headset->add_work(work);
  work.queries = s.queries;
  work.sphere_looks = s.looks.spheres, work.triangle_looks = s.looks.triangles, work.vertex_looks = s.looks.vertices;
  work.patches = s.carver.snapshots(), work.voxels_cut = s.voxels_cut;
  work.bricks_meshed = s.bricks_meshed, work.triangles_made = s.triangles_made;
  if (sound) work.samples = sound->stats().samples;
  work.desktop_requests = running_process.desktop_requests - before.desktop_requests;
  work.threads = running_process.threads, work.libraries = running_process.libraries;
  work.allocations = running_process.allocations - before.allocations;
  work.bytes_written = process_counts().bytes_written - before.bytes_written;
  work.cpu_seconds = running_process.cpu_seconds - before.cpu_seconds;
  work.servo_cpu_seconds = s.servo_cpu;
  if (!options.explain) return;
  for (const WorkCount& c : listed(work)) log::info("{:>14} {}", c.value, c.words);
  log::info("{:>13.2f} % of a core beyond the device's loop",
            100 * (work.cpu_seconds - work.servo_cpu_seconds) / std::max(1e-9, to_seconds(now() - began)));
}

Workbench::Workbench(const Scene& scene, const WorkbenchOptions& options, Progress* progress)
    : impl_(std::make_unique<Impl>(scene, options, progress)) {}
Workbench::~Workbench() = default;
void Workbench::open() {
  impl_->open();
}
bool Workbench::begin(glm::ivec2 picture_size) {
  return impl_->begin(picture_size);
}
void Workbench::start() {
  open();
  while (!begin()) std::this_thread::sleep_for(1ms);
}
bool Workbench::step() {
  return impl_->step(nullptr, {0, 0});
}
bool Workbench::step(const display::UserInput& input, glm::ivec2 picture_size) {
  return impl_->step(&input, picture_size);
}
void Workbench::set(const SessionSettings& settings) {
  impl_->settings = settings;
  impl_->session->wiring.settings.publish(settings);
}
const SessionSettings& Workbench::settings() const {
  return impl_->settings;
}
void Workbench::paint(const BrushMove& move) {
  if (!impl_->recording) impl_->session->wiring.paint_to_carver.push(move);
}
std::vector<PaintStroke> Workbench::painted() const {
  return impl_->session->book.paint(impl_->session->carver.strokes());
}
LiveViews* Workbench::views() {
  return impl_->picture ? impl_->picture->views() : nullptr;
}
void Workbench::look_from(const Viewpoint& from, glm::ivec2 pixels) {
  if (impl_->picture) impl_->picture->look_from(from, pixels);
}
const gpu::Image* Workbench::own_picture() const {
  return impl_->picture ? impl_->picture->own_picture() : nullptr;
}
haptics::TissueVolume Workbench::take_tissue() {
  return impl_->session->carver.take_tissue();
}
void Workbench::drop_picture() {
  if (impl_->picture) impl_->picture->drop();
}
void Workbench::make_picture(gpu::Device& device) {
  if (impl_->picture) impl_->picture->make(&device);
}
const std::vector<int>& Workbench::pressed() const {
  return impl_->pressed;
}
void Workbench::say(const std::string& line) {
  impl_->told = line;
}
void Workbench::emergency_stop() {
  Wiring& wiring = impl_->session->wiring;
  wiring.emergency = true;
  wiring.stop = true;
  const Nanos patience = now() + 50'000'000;
  while (impl_->running && !wiring.servo_ended && now() < patience) std::this_thread::sleep_for(1ms);
  if (impl_->running && !wiring.servo_ended) haptics::release_all_devices();
}

void Workbench::choose_tool(int place) {
  impl_->session->wiring.chosen_tool = place;
}
void Workbench::choose_phase_tool() {
  impl_->take_phase_tool();
  impl_->session->wiring.settings.publish(impl_->settings);
}
bool Workbench::held() const {
  return haptics::emergency_stopped();
}
bool Workbench::asked_to_stop() {
  return g_asked_to_stop;
}

WorkbenchStatus Workbench::status() {
  Impl& m = *impl_;
  Wiring& wiring = m.session->wiring;
  wiring.record_to_render.fetch();
  WorkbenchStatus s;
  s.tick = m.tick;
  s.chosen_tool = wiring.chosen_tool;
  s.seconds = to_seconds(s.tick.t);
  s.faults = s.tick.t - m.fault_time < kNanosPerSecond ? m.recent_faults : 0;
  s.caught = m.caught();
  s.timing = m.loop.timing;
  if (m.picture) {
    const LivePicture& picture = *m.picture;
    s.frame_ms = picture.frame_seconds() * 1e3;
    s.frames_per_second = picture.frame_period() > 0 ? 1 / picture.frame_period() : 0;
    s.quality = picture.ladder().step().name;
    s.quality_notice = m.quality_notice();
    s.frames = picture.frames();
    s.own_frames = picture.own_frames();
    s.warning = picture.world().warning();
  }
  if (m.implant) s.implant = m.implant_status();
  s.record = wiring.record_to_render.front();
  s.tissue = m.tissue_state;
  s.saved = wiring.saved;
  s.not_saved = wiring.not_saved;
  const LoopReport& loop = m.loop;
  s.motor_heat = loop.heat;
  s.bearable_force = loop.bearable_force;
  s.armed = loop.armed;
  s.granted = {loop.fifo, loop.pinned, loop.memory_locked};
  s.real_time = loop.words();
  return s;
}
session::Score Workbench::score_so_far() {
  Impl& m = *impl_;
  session::ScoreInput input;
  LiveViews* const views = m.picture ? m.picture->views() : nullptr;
  const bool judged = views && views->judged();
  if (judged) input = *views->judged();  // the result of the latest evaluation of the tissue
  // If the session continues an unfinished preparation, the tissue volumes before and after the work come from the
  // latest evaluation. Otherwise the volumes after the work are those at the start minus the removed volumes.
  if (m.scene.resume.empty() || !judged) {
    input.before = input.after = m.volumes_before;
    const PerTissue& removed = m.tissue_state.removed;
    for (std::size_t i = 0; i < input.after.size(); ++i) input.after[i] -= removed[i];
  }
  if (m.meter) input.hand = m.meter->result();
  if (m.damage) input.damage = m.damage->result();
  if (m.heat()) input.heat = m.heat()->result();
  if (m.implant) input.implant = m.implant->result();
  return session::score_of_scene(Json::parse(m.scene.text, m.scene.file.string()), input);
}
FinishedHand Workbench::take_hand() {
  Impl& m = *impl_;
  FinishedHand finished;
  if (m.meter) finished.input.hand = m.meter->result();
  if (m.damage) finished.input.damage = m.damage->result();
  if (m.heat()) finished.input.heat = m.heat()->result();
  if (m.implant) finished.input.implant = m.implant->result();
  std::tie(finished.explore, finished.unexplored) = std::move(m.explored);
  return finished;
}
const haptics::DeviceInfo& Workbench::hand() const {
  return impl_->hands.right->info();
}
bool Workbench::recording() const {
  return impl_->recording.has_value();
}
PictureStage* Workbench::stage() {
  return impl_->picture ? impl_->picture->stage() : nullptr;
}
void Workbench::hold(bool on) noexcept {
  haptics::set_emergency_stop(on);
}
void Workbench::ask(TissueCommand command) {
  impl_->session->wiring.tissue_commands.push(command);
}
haptics::TissueVolume::Strokes Workbench::strokes() {
  return impl_->tissue_state.strokes;
}
WorkbenchSummary Workbench::stop() {
  impl_->end();
  if (!impl_->failure.empty()) throw RunFailure(impl_->failure);
  return impl_->summary;
}

WorkbenchSummary run_workbench(const Scene& scene, const WorkbenchOptions& options) {
  Workbench bench(scene, options);
  bench.start();
  while (bench.step()) {
  }
  return bench.stop();
}

}  // namespace typodont
