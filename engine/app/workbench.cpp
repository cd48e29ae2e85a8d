#include "engine/app/workbench.h"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <mutex>
#include <optional>
#include <thread>

#include "engine/app/debris_view.h"
#include "engine/app/hands.h"
#include "engine/app/mouse_hand.h"
#include "engine/app/picture_stage.h"
#include "engine/app/quality_ladder.h"
#include "engine/app/resume.h"
#include "engine/app/session_record.h"
#include "engine/app/sound_link.h"
#include "engine/app/tissue_view.h"
#include "engine/app/wiring.h"
#include "engine/app/xr_hand.h"
#include "engine/app/xr_session.h"
#include "engine/base/check.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/realtime.h"
#include "engine/base/units.h"
#include "engine/contract/loop_timing.h"
#include "engine/session/recorder.h"
#include "haptics/carver.h"
#include "haptics/devices/driver.h"
#include "haptics/devices/exit_guard.h"
#include "haptics/solid.h"
#include "haptics/work.h"

namespace typodont {

namespace {

using namespace std::chrono_literals;

constexpr double kRampOut = 0.02;  // s at the end of a session
constexpr double kMirror = 22e-3;  // m, a mouth mirror of size 4, where the scene does not say
constexpr int kHoldKey = ' ', kGoOnKey = 'R';
constexpr Nanos kReviveInterval = 10 * kNanosPerSecond;  // a device lost more often than this is broken
constexpr Nanos kMeshInterval = 16'000'000;              // ns between looks for changed bricks

std::atomic<bool> g_asked_to_stop{false};
void ask_to_stop(int) {
  g_asked_to_stop = true;
}

/// What a session consists of. Threads refer to it; it outlives them.
struct Session {
  const Scene& scene;
  haptics::Carver carver;
  Wiring wiring;
  std::optional<haptics::Servo> servo;  // made for the hand, once that is known
  std::optional<LoopWatch> loop;        // servo thread until it has ended
  ServoTick last;                       // the same
  double servo_cpu = 0;                 // s, the same
  std::uint32_t faults = 0;
  bool draw = false, record = false, debris = false, operated = false;
  float tolerance = 0.1f;  // voxels, of the surface drawn
  Nanos began = 0;            // of recorded frames
  std::size_t xr_stream = 0;  // which of the recording's streams they are
  SoundLink* sound = nullptr;
  std::size_t left_stream = 0;  // of the recording, where there is a second hand
  std::filesystem::path save;  // of the tissue
  std::uint64_t bricks_meshed = 0, triangles_made = 0, voxels_cut = 0;  // carver thread until it has ended
  std::uint64_t queries = 0;                                            // servo thread until it has ended

  Session(const Scene& s, haptics::TissueVolume tissue)
      : scene(s), carver(std::move(tissue), haptics::tray(s.servo)), wiring(empty_patch(edge(s, carver.volume()))) {}
  void serve(const haptics::DeviceInfo& hand) {
    servo.emplace(servo_settings(scene, carver.volume(), hand.rate, hand.vibration_band, hand.position_step),
                  edge(scene, carver.volume()));
    loop.emplace(wiring, hand.rate);
  }

  static int edge(const Scene& s, const haptics::TissueVolume& tissue) {
    return haptics::patch_edge_for(haptics::tray(s.servo), tissue.frame().voxel);
  }
  static haptics::SurfacePatch empty_patch(int edge) {
    haptics::SurfacePatch patch;
    patch.resize(edge);
    return patch;
  }
};

/// As HapticDevice::contact means it.
bool in_contact(const ServoTick& tick) {
  constexpr std::uint32_t kUnknown =
      haptics::kNoPose | bits(Fault::kPatchEdge) | bits(Fault::kDeepPenetration);
  return tick.depth > 0 || (tick.faults & kUnknown) != 0;
}

void servo_thread(Session& s, haptics::HapticDevice& hand) {
  const RealtimeGranted granted = enter_realtime({.priority = 80, .core = RealtimeRequest::kOwnCore});
  s.loop->granted(granted.fifo, granted.pinned, granted.memory_locked, granted.note);
  ::pthread_setname_np(::pthread_self(), "typodont-servo");
  Wiring& wiring = s.wiring;
  const Nanos period = from_seconds(1 / hand.info().rate);
  haptics::HandSample sample;
  SessionSettings settings;
  PedalLock pedal;
  ServoTick tick;
  Cut cut;
  std::uint64_t ticks = 0;
  while (!wiring.stop.load(std::memory_order_relaxed) && hand.read(sample)) {
    const Nanos woke = now(), cpu = thread_cpu_time();
    const std::int32_t chosen = wiring.chosen_tool.load(std::memory_order_relaxed);
    if (chosen >= 0) sample.tool = static_cast<std::uint32_t>(chosen);
    if (wiring.patch.fetch()) {
      haptics::SurfacePatch& fresh = wiring.patch.front();
      const PatchUse use{fresh.number, ticks, fresh.cuts, fresh.center_W};
      s.servo->adopt(fresh);
      if (s.record) wiring.patches_to_recorder.push(use);
    }
    if (ticks == 0) wiring.session_zero = woke - sample.t;
    sample.pedal = pedal.pass(sample.pedal, wiring.held.load(std::memory_order_relaxed));
    if (wiring.settings.fetch()) settings = wiring.settings.front();
    sample.pedal *= settings.speed_share;
    sample.faults = hand.faults();
    const bool did_cut = s.servo->tick(sample, tick, cut);
    if (wiring.emergency.load(std::memory_order_relaxed)) break;
    hand.contact(in_contact(tick));
    hand.write(settings.force_share * tick.f_T_W, settings.force_share * tick.tau_T_W);
    const Nanos wrote = now();
    // What the servo was told is in the tick; a replay tells it the same.
    tick.faults |= (hand.faults() & ~haptics::kNoPose) | (wrote - woke > period ? bits(Fault::kOverrun) : 0);
    tick.cpu_time = thread_cpu_time() - cpu;
    ++ticks;
    if (did_cut) {
      if (!wiring.cuts_to_carver.push(cut)) tick.faults |= bits(Fault::kRingFull);
      if (s.record) wiring.cuts_to_recorder.push(cut);
      if (s.debris) wiring.cuts_to_debris.push(cut);
    }
    wiring.tick_to_carver.publish(tick);
    if (s.draw || s.operated) wiring.tick_to_render.publish(tick);
    if (s.record) wiring.ticks_to_recorder.push(tick);
    if (s.sound) s.sound->push(tick);
    s.faults |= tick.faults;
    wiring.newest_faults.store(tick.faults, std::memory_order_relaxed);
    s.last = tick;
    s.loop->tick(woke, wrote, hand.safety());
    if (s.operated) wiring.ticks_to_score.push(tick);
  }
  s.loop->publish();
  // The end: the force fades within its ramp, the drill at rest. These ticks belong to no session and are not recorded.
  s.servo->ramp_out();
  const Nanos faded = now() + from_seconds(kRampOut);
  while (!wiring.emergency && now() < faded && hand.read(sample)) {
    sample.pedal = 0;
    sample.tool = s.last.tool;
    sample.faults = hand.faults();
    s.servo->tick(sample, tick, cut);
    hand.contact(in_contact(tick));
    hand.write(settings.force_share * tick.f_T_W, settings.force_share * tick.tau_T_W);
  }
  hand.write(dvec3(0), dvec3(0));
  hand.release();  // nor does an arm go on holding up its own weight
  s.servo_cpu = to_seconds(thread_cpu_time());
  s.queries = haptics::queries_of_this_thread();
  wiring.servo_ended = true;
}

/// Writes a copy of the tissue beside the session, which goes on.
class TissueSaver {
 public:
  void start(const haptics::TissueVolume& tissue, const std::filesystem::path& file) {
    if (file.empty()) return log::warn("nowhere to save to: start with --save VOLUME.vdb");
    thread_ = std::jthread([copy = std::make_shared<haptics::TissueVolume>(tissue.clone()), file] {
      try {
        copy->save(file);
        log::info("saved {}", file.string());
      } catch (const std::exception& e) {
        log::warn("not saved: {}", e.what());
      }
    });
  }

 private:
  std::jthread thread_;  // a later one waits for an earlier one
};

void obey(Session& s, TissueCommand command, Nanos t, TissueSaver& saver) {
  Wiring& wiring = s.wiring;
  if (command == TissueCommand::kSave) return saver.start(s.carver.volume(), s.save);
  const bool redo = command == TissueCommand::kRedo;
  const StrokeEdit edit{t, redo, s.carver.cuts(), s.carver.patches()};
  if ((redo ? s.carver.redo() : s.carver.undo()) && s.record) wiring.edits_to_recorder.push(edit);
}

void carver_thread(Session& s) {
  Wiring& wiring = s.wiring;
  TissueSaver saver;
  TissueView view(s.tolerance);
  Nanos meshed = 0;
  bool first = true;
  int idle = 0;  // turns without work
  Cut cut;
  while (!wiring.stop.load(std::memory_order_relaxed)) {
    bool worked = false;
    while (wiring.cuts_to_carver.pop(cut)) {
      s.carver.apply(cut);
      worked = true;
    }
    TissueCommand command;
    while (wiring.tissue_commands.pop(command)) {
      obey(s, command, wiring.tick_to_carver.front().t, saver);
      worked = true;
    }
    if (worked) wiring.strokes_to_render.publish(s.carver.volume().strokes());
    PaintStroke stroke;
    bool painted = false;
    while (wiring.paint_to_carver.pop(stroke)) {
      paint(s.carver.volume(), {stroke});
      painted = true;
    }
    if (wiring.tick_to_carver.fetch() || painted) {
      const ServoTick& tick = wiring.tick_to_carver.front();
      if (is_finite(tick.X_WG.p) && (painted || s.carver.patch_due(tick))) {
        s.carver.cut_out(s.carver.patch_center(tick), wiring.patch.back());
        wiring.patch.publish();
        worked = true;
      }
    }
    if (wiring.mesh_all.exchange(false)) view = TissueView(s.tolerance);
    if (s.draw && (first || now() - meshed > kMeshInterval)) {
      meshed = now();
      first = false;
      auto batch = std::make_unique<MeshBatch>(view.update(s.carver.volume()));
      s.bricks_meshed += batch->size();
      for (const render::MeshUpdate& brick : *batch) s.triangles_made += brick.indices.size() / 3;
      if (!batch->empty() && wiring.bricks.push(batch.get())) (void)batch.release();
    }
    // Where nothing was to do for 30 ms the hand is slow: at 3 cm/s it comes a tenth of a millimetre further until it is
    // looked after again. Looking more often took three hundredths of a core of an idle session.
    idle = worked ? 0 : std::min(idle + 1, 100);
    if (!worked) std::this_thread::sleep_for(idle < 100 ? 300us : 3000us);
  }
  while (wiring.cuts_to_carver.pop(cut)) s.carver.apply(cut);
  s.voxels_cut = haptics::voxels_cut_by_this_thread();
}

void recorder_thread(Session& s, session::SessionWriter& writer) {
  Wiring& wiring = s.wiring;
  const auto drain = [&] {
    ServoTick tick;
    Cut cut;
    PatchUse use;
    StrokeEdit edit;
    while (wiring.patches_to_recorder.pop(use)) writer.append({&use, 1});
    // After the patches: the edit that made one of them due is then there too.
    while (wiring.edits_to_recorder.pop(edit)) writer.append(event_of(edit));
    while (wiring.cuts_to_recorder.pop(cut)) writer.append({&cut, 1});
    while (wiring.ticks_to_recorder.pop(tick)) writer.append({&tick, 1});
    haptics::HandSample left;
    while (wiring.left_to_recorder.pop(left)) {
      const Pose& X = left.X_WT;
      writer.append(s.left_stream, left.t, std::array{X.p.x, X.p.y, X.p.z, X.R.w, X.R.x, X.R.y, X.R.z, left.pedal});
    }
    if (wiring.loop_to_recorder.fetch()) writer.loop(wiring.loop_to_recorder.front());
    display::HmdTiming frame;
    while (wiring.xr_frames_to_recorder.pop(frame)) {
      writer.append(s.xr_stream, frame.t - s.began, xr_stream_row(frame));
    }
    writer.count_ring_losses(wiring.ticks_to_recorder.dropped(), wiring.cuts_to_recorder.dropped());
    writer.heartbeat();
    if (s.operated) {
      const session::WriterStatus& status = writer.status();
      wiring.record_to_render.publish({status.ticks, status.cuts, !status.lost.any()});
    }
  };
  // To the servo's last tick, which comes after it was asked to stop.
  while (!wiring.stop.load(std::memory_order_relaxed) || !wiring.servo_ended) {
    drain();
    std::this_thread::sleep_for(5ms);
  }
  drain();
}

}  // namespace

/// What one session holds, in the order in which it is set up. The drawing thread's, but for what is in `session`.
struct Workbench::Impl {
  const Scene scene;
  const WorkbenchOptions options;
  WorkbenchSummary summary;
  std::filesystem::path rig_file;
  std::optional<display::DisplayRig> rig;
  std::optional<Session> session;
  std::optional<Pointer> pointer;  // where the mouse is the hand
  Hands hands;
  std::optional<SoundLink> sound;
  std::optional<session::SessionWriter> writer;
  std::optional<PictureStage> stage;
  std::optional<XrSession> headset;  // draws on a thread of its own, in the stage's place
  QualityLadder ladder;
  std::optional<DebrisView> debris;
  WorkCounts before;  // of the process, when the session began
  dvec3 above{0, 0, 0};  // m, W: where the tool starts

  bool running = false;
  Nanos began = 0, last_frame = 0;
  ServoTick tick;  // the newest, as drawn
  std::uint64_t drawn = 0;
  double frame_seconds = 0, frame_period = 0;  // s, smoothed
  SessionSettings settings;                    // as last sent to the servo
  std::optional<session::HandMeter> meter;     // where operated
  PerTissue volumes_before{};                  // m³, the same
  Nanos fault_time = 0;
  Nanos revived = -kReviveInterval;  // when the picture was last made anew
  std::uint32_t recent_faults = 0;
  std::string keys;  // what the hand and the keyboard do, drawn below the picture
  std::string failure;
  bool held = false, hand_gone = false;
  std::jthread carver, servo, left, recorder;  // last: they refer to all of the above

  Impl(const Scene& s, const WorkbenchOptions& o) : scene(s), options(o) { set_up(); }
  ~Impl() { end(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void explain(std::string text) { summary.explanations.push_back(std::move(text)); }
  void set_up();
  void start_headset(const std::string& hand_address);
  void start();
  bool step(const display::UserInput* input, glm::ivec2 picture_size);
  void make_stage(gpu::Device* device);
  void score_ticks();
  void follow_keys(const display::UserInput& input);
  void edit_tissue(const display::UserInput& input);
  void draw();
  void count(const render::FrameStats& frame);
  void count_work(const WorkCounts& running);
  void hold(bool on) noexcept;
  void report_hand();
  std::string hint() const;
  void end();
};

void Workbench::Impl::set_up() {
  // What this session needs.
  rig_file = options.rig;
  if (rig_file.empty() && display::has_desktop()) rig_file = assets_folder() / "rigs/window.json";
  if (!rig_file.empty()) rig = display::load_rig(rig_file);
  if (rig && options.embedded) rig->screen.layout = display::Layout::kMono;
  const bool window = rig && (rig->kind == display::DisplayKind::kWindow || rig->kind == display::DisplayKind::kMirror);
  const bool hmd = rig && rig->kind == display::DisplayKind::kHmd;
  if (!options.touches.empty() && !hmd) throw Error("--touches", "", rig_file.string(), "a headset's rig");
  HandChoice choice{options.hand, options.left_hand, options.pedal, options.rate, tool_names(scene)};
  choice.hand = hand_address(choice, rig ? &*rig : nullptr, window ? "mouse:" : hmd ? "openxr:right" : "");

  Session& s = session.emplace(scene, load_tissue(scene));
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
  if (!scene.resume.empty()) explain("tissue: going on from " + scene.resume);
  explain(s.record ? "recording: on, " + options.record.string() : "recording: off, no --record FILE.h5");
  s.debris = s.draw && scene.needs("debris");
  explain(s.debris ? "debris: on"
          : s.draw ? "debris: off, the scene does not name it"
                   : "debris: off, nothing is drawn");

  // The hand.
  glm::ivec3 lo, hi;
  tissue.bounds(lo, hi);
  above = tissue.frame().to_world(dvec3((lo.x + hi.x) / 2.0, (lo.y + hi.y) / 2.0, hi.z)) + dvec3(0, 0, 1e-3);
  if (s.draw && hmd) start_headset(choice.hand);
  const WindowHands in_window = [&](const std::string& scheme, const std::string& rest) {
    if (scheme == "openxr") {
      if (!headset)
        throw Error("--hand", "", scheme + ":" + rest, "a headset's rig, and a scene that names \"render\"");
      return make_xr_hand(s.wiring, scheme + ":" + rest, {above, {1, 0, 0, 0}}, options.rate);
    }
    if (!window) throw Error("--hand", "", scheme + ":", "a window rig for it to move in");
    pointer.emplace(*rig, above);
    return make_mouse_hand(s.wiring, pointer->follow({}, 0).X_WT, options.rate);
  };
  hands = open_hands(choice, rig ? &*rig : nullptr, in_window);
  const haptics::DeviceInfo& hand = hands.right->info();
  s.serve(hand);
  explain("hand: " + in_words(hand));
  explain(hands.left ? "left hand, with the mouth mirror: " + in_words(hands.left->info()) : "left hand: none");

  // Sound.
  if (scene.needs("sound") && options.audio != "none:") {
    std::string address = options.audio;
    if (address.empty() && !audio::audio_devices().empty()) address = "portaudio:";
    if (address.empty()) {
      explain("sound: off, there is no sound card; --audio wav:FILE writes it to a file");
    } else {
      sound.emplace(address, scene, !address.starts_with("wav:"));
      s.sound = &*sound;
      explain("sound: on, " + address);
    }
  } else {
    explain(scene.needs("sound") ? "sound: off, --audio none:" : "sound: off, the scene does not name it");
  }

  if (s.record) {
    session::SessionHeader header = session_header(scene, rig_file, *hands.right, tissue, hand.rate);
    if (hands.left) {
      s.left_stream = header.streams.size();
      header.streams.push_back(left_hand_stream());
    }
    header.trainee = options.trainee;
    s.xr_stream = header.streams.size();
    if (headset) header.streams.push_back(xr_stream());
    writer.emplace(options.record, header);
  }
  if (s.operated) {
    meter.emplace(hand.rate);
    volumes_before = tissue.volumes();
  }
  if (s.draw && window) {
    make_stage(options.device);
    s.tolerance = surface_tolerance(*rig, tissue.frame().voxel);
    explain("drawn by " + stage->device_name());
    explain(rig->head.tracker.empty() ? "head: at rest, the rig names no tracker" : "head: " + rig->head.tracker);
  }
  if (s.debris && window) debris.emplace(scene.servo.materials, tissue);
  if (options.explain) {
    for (const std::string& line : summary.explanations) log::info("{}", line);
  }
}

void Workbench::Impl::start_headset(const std::string& hand_address) {
  Session& s = *session;
  XrSession::Options o;
  if (hand_address.starts_with("openxr:")) {
    if (hand_address != "openxr:right" && hand_address != "openxr:left")
      throw Error("--hand", "", hand_address, "openxr:right or openxr:left");
    o.tool_hand = hand_address == "openxr:right" ? 1 : 0;
  }
  o.touches = !options.touches.empty();
  if (o.touches && o.tool_hand >= 0)
    throw Error("--touches", "", hand_address, "an arm as the hand, which touches the controller's tip");
  o.debris = s.debris;
  o.record = s.record;
  o.work_W = above;
  o.start.X_WT.p = o.start.X_WG.p = above;
  headset.emplace(*rig, scene, s.carver.volume(), s.wiring, o);
  for (std::string& line : headset->explanations()) explain(std::move(line));
  if (o.tool_hand < 0 && !rig->hmd.X_WD)
    explain("headset: not registered to the hand's device: what is seen is not where it is felt");
}

void Workbench::Impl::start() {
  // The first patch is there before the first tick.
  Session& s = *session;
  tick.X_WT.p = tick.X_WG.p = above;
  s.carver.cut_out(above, s.wiring.patch.back());
  s.wiring.patch.publish();

  g_asked_to_stop = false;
  set_check_handler(haptics::release_all_devices);  // a broken assumption, too, ends in zero force
  std::signal(SIGINT, ask_to_stop);
  std::signal(SIGTERM, ask_to_stop);
  running = true;
  before = process_counts();
  s.began = now();
  carver = std::jthread(carver_thread, std::ref(s));
  servo = std::jthread(servo_thread, std::ref(s), std::ref(*hands.right));
  if (hands.left)
    left = std::jthread(left_hand_thread, std::ref(s.wiring), std::ref(*hands.left),
                        scene.mouth_mirror.diameter > 0 ? scene.mouth_mirror.diameter : kMirror, s.record);
  if (writer) recorder = std::jthread(recorder_thread, std::ref(s), std::ref(*writer));
  began = last_frame = now();
  const std::size_t tools = std::min<std::size_t>(haptics::tray(scene.servo).size(), 9);
  if (pointer) keys = "left button: drill   wheel: in and out   ";
  keys += "Z, Y: undo, redo   ";
  if (tools > 1) keys += fmt::format("1–{}: tools   ", tools);
  if (headset) headset->start(began);
}

/// One turn of the drawing thread: a frame, or a short wait. False when the session is over.
bool Workbench::Impl::step(const display::UserInput* input, glm::ivec2 picture_size) {
  Session& s = *session;
  if (meter) score_ticks();
  if (s.wiring.servo_ended || g_asked_to_stop || to_seconds(now() - began) >= options.seconds) return false;
  if (sound && !headset) sound->advance(s.wiring.tick_to_render.front().t);
  s.wiring.loop_to_render.fetch();
  report_hand();
  if (!s.draw || headset || !stage) {
    std::this_thread::sleep_for(10ms);
    if (sound && (headset || options.audio.starts_with("wav:"))) sound->advance(now() - began);
    if (!headset) return true;
  }
  try {
    if (headset) return headset->step();
    const display::UserInput own = options.embedded ? display::UserInput() : stage->output().poll();
    if (own.close) return false;
    const display::UserInput& over = input && options.embedded ? *input : own;
    if (pointer) s.wiring.pointer.publish(pointer->follow(over, now() - began));
    if (options.embedded && stage->resize(picture_size) && pointer) pointer->follow_rig(stage->rig());
    follow_keys(over);
    edit_tissue(over);
    draw();
    return true;
  } catch (const gpu::DeviceLost& e) {
    if (options.device) throw;  // the operator makes a new one for both
    if (now() - revived < kReviveInterval) {
      failure = e.what();
      return false;
    }
    log::warn("{}; the picture is made anew", e.what());
    revived = now();
    stage.reset();
    make_stage(nullptr);
    s.wiring.mesh_all = true;
    return true;
  } catch (const std::exception& e) {  // the picture is lost: the session ends in order
    failure = e.what();
    return false;
  }
}

/// The picture of this rig, on the operator's device or one of its own.
void Workbench::Impl::make_stage(gpu::Device* device) {
  PictureStage::Options look;
  look.window = !options.embedded;
  look.embedded = options.embedded;
  look.hud = !options.embedded;
  look.device = device;
  look.monitor = options.monitor;
  look.quality = ladder.step();
  stage.emplace(*rig, scene.servo, look);
  stage->surround(make_surroundings(scene));
  stage->hold_mirror(scene.mouth_mirror);
}

void Workbench::Impl::hold(bool on) noexcept {
  held = on;
  hold_hands(session->wiring, on);
}

/// A device that was unplugged, and that is there again: said once.
void Workbench::Impl::report_hand() {
  const bool gone = (session->wiring.newest_faults.load(std::memory_order_relaxed) & bits(Fault::kDeviceLost)) != 0;
  if (gone == hand_gone) return;
  hand_gone = gone;
  if (gone) {
    log::warn("{} is gone; plug it in again to go on", hands.right->info().address);
  } else {
    log::info("{} is back; force returns when the hand is free of contact", hands.right->info().address);
  }
}

/// One line under the picture: what the hand can do, and what its motors bear.
std::string Workbench::Impl::hint() const {
  const LoopReport& loop = session->wiring.loop_to_render.front();
  if (held) return "STOPPED: no drill, no force   R: go on";
  if (hand_gone) return "the hand's device is gone: plug it in again";
  std::string text = keys;
  if (loop.bearable_force > 0) {
    text += fmt::format("motors {:.0f} %, up to {:.1f} N   {}", 100 * loop.heat, loop.bearable_force,
                        loop.armed ? "" : "no force until the hand is free   ");
  }
  return text + "space: stop";
}

/// 1 … 9: another tool of the tray. Space: the emergency key.
void Workbench::Impl::follow_keys(const display::UserInput& input) {
  for (const int key : input.pressed) {
    if (key == kHoldKey) hold(true);
    if (key == kGoOnKey) hold(false);
    const int place = key - '1';
    if (place >= 0 && place < 9 && place < static_cast<int>(haptics::tray(scene.servo).size())) {
      session->wiring.chosen_tool = place;
    }
  }
}

/// Ctrl+Z, Ctrl+Y and Ctrl+S; the letters alone do as well.
void Workbench::Impl::edit_tissue(const display::UserInput& input) {
  for (const int key : input.pressed) {
    if (key == 'Z') session->wiring.tissue_commands.push(TissueCommand::kUndo);
    if (key == 'Y') session->wiring.tissue_commands.push(TissueCommand::kRedo);
    if (key == 'S') session->wiring.tissue_commands.push(TissueCommand::kSave);
  }
}

void Workbench::Impl::draw() {
  Session& s = *session;
  if (s.wiring.tick_to_render.fetch()) tick = s.wiring.tick_to_render.front();
  MeshBatch* batch = nullptr;
  while (s.wiring.bricks.pop(batch)) {
    const std::unique_ptr<MeshBatch> owned(batch);
    stage->show(*owned, s.carver.volume().frame().origin);
  }
  const double dt = to_seconds(now() - last_frame);
  last_frame = now();
  frame_period += 0.1 * (std::min(dt, 1.0) - frame_period);
  if (debris) {
    Cut cut;
    while (s.wiring.cuts_to_debris.pop(cut)) debris->add(cut, haptics::tray(scene.servo)[cut.tool]);
    summary.work.particles_stepped += debris->debris().alive();
    debris->step(std::min(dt, 0.1));
  }
  if (hands.left && s.wiring.mouth_mirror.fetch()) stage->hold_mirror(s.wiring.mouth_mirror.front());
  const auto stats = stage->draw(tick, debris ? debris->particles() : std::span<const render::Particle>{}, dt, hint());
  drawn += stats.drawn;
  if (stats.drawn) count(stats);
  if (stats.drawn) frame_seconds += 0.1 * (to_seconds(now() - last_frame) - frame_seconds);
  if (stats.drawn && ladder.frame_took(to_seconds(now() - last_frame))) {
    stage->set_quality(ladder.step());
    log::info("picture quality: {}", ladder.step().name);
  }
  if (!stats.drawn && !options.embedded) std::this_thread::sleep_for(4ms);
}

void Workbench::Impl::count(const render::FrameStats& frame) {
  WorkCounts& work = summary.work;
  const auto plus = [](std::uint64_t& sum, auto value) { sum += static_cast<std::uint64_t>(value); };
  plus(work.passes, frame.passes), plus(work.draw_calls, frame.commands);
  plus(work.triangles_drawn, frame.triangles + frame.mirror_triangles);
  plus(work.bricks_skipped, frame.bricks_culled + frame.bricks_facing_away + frame.bricks_covered);
  work.pipelines = std::max(work.pipelines, static_cast<std::uint64_t>(frame.pipelines));
}

/// The hand's measures and the faults of the last second, from every tick.
void Workbench::Impl::score_ticks() {
  ServoTick next;
  while (session->wiring.ticks_to_score.pop(next)) {
    meter->add({&next, 1});
    if (next.faults != 0) {
      recent_faults = next.t - fault_time < kNanosPerSecond ? recent_faults | next.faults : next.faults;
      fault_time = next.t;
    }
  }
}

/// Zero force, all threads joined, the recording complete. Does nothing the second time.
void Workbench::Impl::end() {
  if (!running) return;
  running = false;
  Session& s = *session;
  const WorkCounts process = process_counts();
  s.wiring.stop = true;
  servo.join();
  if (left.joinable()) left.join();
  carver.join();
  if (recorder.joinable()) recorder.join();
  if (headset) {
    drawn = headset->frames();
    headset->stop();
    if (!options.touches.empty()) write_touches(options.touches, headset->touches());
  }
  if (sound) sound->stop(s.last.t);
  MeshBatch* batch = nullptr;
  while (s.wiring.bricks.pop(batch)) delete batch;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);

  if (!s.save.empty()) {
    try {
      s.carver.volume().save(s.save);
    } catch (const std::exception& e) {
      failure = e.what();
    }
  }
  if (writer && !writer->finish(session_result(s.carver.volume()))) failure = writer->status().message;
  summary.seconds = to_seconds(s.last.t);
  const LoopTiming& timing = s.loop->report().timing;
  summary.ticks = timing.ticks;
  summary.frames = drawn;
  if (stage) summary.tracker = stage->tracker_stats();
  summary.cuts = s.last.cuts;
  summary.removed = s.last.removed;
  summary.faults = s.faults;
  summary.deadline_misses = timing.misses;
  summary.tick_us_median = timing.work.quantile(0.5) * 1e-3;
  summary.tick_us_p999 = timing.work.quantile(0.999) * 1e-3;
  summary.worst_tick_us = static_cast<double>(timing.worst_tick) * 1e-3;
  summary.worst_jitter_us = static_cast<double>(timing.worst_jitter) * 1e-3;
  // Of its bin the upper edge, which the worst may lie below.
  summary.jitter_us_p999 = std::min(timing.jitter.quantile(0.999) * 1e-3, summary.worst_jitter_us);
  summary.loop = s.loop->report();
  if (!summary.loop.words().empty()) explain("real time: " + std::string(summary.loop.words()));
  count_work(process);
}

/// What was done, once all threads have ended; `running`: the process while it still ran.
void Workbench::Impl::count_work(const WorkCounts& running_process) {
  Session& s = *session;
  WorkCounts& work = summary.work;
  work.ticks = summary.ticks, work.frames = drawn;
  work.queries = s.queries;
  work.patches = s.carver.patches(), work.voxels_cut = s.voxels_cut;
  work.bricks_meshed = s.bricks_meshed, work.triangles_made = s.triangles_made;
  if (sound) work.samples = sound->stats().samples;
  work.threads = running_process.threads, work.libraries = running_process.libraries;
  work.allocations = running_process.allocations - before.allocations;
  work.bytes_written = process_counts().bytes_written - before.bytes_written;
  work.cpu_seconds = running_process.cpu_seconds - before.cpu_seconds;
  work.servo_cpu_seconds = s.servo_cpu;
  if (!options.explain) return;
  std::array<WorkCount, kWorkCounts> room;
  for (const WorkCount& c : listed(work, room)) log::info("{:>14} {}", c.value, c.words);
  log::info("{:>13.2f} % of a core beyond the device's loop", 100 * (work.cpu_seconds - work.servo_cpu_seconds) / std::max(1e-9, to_seconds(now() - began)));
}

Workbench::Workbench(const Scene& scene, const WorkbenchOptions& options)
    : impl_(std::make_unique<Impl>(scene, options)) {}
Workbench::~Workbench() = default;
void Workbench::start() {
  impl_->start();
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
void Workbench::paint(const PaintStroke& stroke) {
  if (!impl_->writer) impl_->session->wiring.paint_to_carver.push(stroke);
}
haptics::TissueVolume Workbench::take_tissue() {
  return std::move(impl_->session->carver.volume());
}
void Workbench::drop_picture() {
  impl_->stage.reset();
}
void Workbench::make_picture(gpu::Device& device) {
  if (!impl_->session->draw) return;
  impl_->make_stage(&device);
  impl_->session->wiring.mesh_all = true;
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
bool Workbench::held() const {
  return impl_->held;
}
bool Workbench::asked_to_stop() {
  return g_asked_to_stop;
}

WorkbenchStatus Workbench::status() {
  Impl& m = *impl_;
  Wiring& wiring = m.session->wiring;
  wiring.record_to_render.fetch();
  WorkbenchStatus s;
  if (!m.session->draw && wiring.tick_to_render.fetch()) m.tick = wiring.tick_to_render.front();
  s.tick = m.tick;
  s.seconds = to_seconds(s.tick.t);
  s.faults = s.tick.t - m.fault_time < kNanosPerSecond ? m.recent_faults : 0;
  s.timing = wiring.loop_to_render.front().timing;
  s.frame_ms = m.frame_seconds * 1e3;
  s.frames_per_second = m.frame_period > 0 ? 1 / m.frame_period : 0;
  s.quality = m.ladder.step().name;
  s.frames = m.drawn;
  s.record = wiring.record_to_render.front();
  return s;
}
session::Score Workbench::score_so_far() {
  Impl& m = *impl_;
  session::ScoreInput input;
  input.before = input.after = m.volumes_before;
  for (std::size_t i = 0; i < input.after.size(); ++i) input.after[i] -= m.tick.removed[i];
  if (m.meter) input.hand = m.meter->result();
  return session::score(input, session::rules_of_scene(Json::parse(m.scene.text, m.scene.file.string()), input));
}
const haptics::DeviceInfo& Workbench::hand() const {
  return impl_->hands.right->info();
}
bool Workbench::recording() const {
  return impl_->writer.has_value();
}
PictureStage* Workbench::stage() {
  return impl_->stage ? &*impl_->stage : nullptr;
}
void Workbench::hold(bool on) noexcept {
  impl_->hold(on);
}
void Workbench::ask(TissueCommand command) {
  impl_->session->wiring.tissue_commands.push(command);
}
haptics::TissueVolume::Strokes Workbench::strokes() {
  auto& latest = impl_->session->wiring.strokes_to_render;
  latest.fetch();
  return latest.front();
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
