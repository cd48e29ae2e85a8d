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
#include <utility>

#include "engine/app/damage.h"
#include "engine/app/debris_view.h"
#include "engine/app/detail.h"
#include "engine/app/hands.h"
#include "engine/app/live_views.h"
#include "engine/app/mouse_hand.h"
#include "engine/app/picture_record.h"
#include "engine/app/picture_stage.h"
#include "engine/app/quality_ladder.h"
#include "engine/app/resume.h"
#include "engine/app/session_record.h"
#include "engine/app/sound_link.h"
#include "engine/app/task.h"
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
constexpr int kHoldKey = ' ', kGoOnKey = 'R', kViewKey = 'V', kSuctionKey = 'A';
constexpr Nanos kReviveInterval = 10 * kNanosPerSecond;  // a device lost more often than this is broken
constexpr std::size_t kProcessorStep = 3;  // of the quality ladder, where a processor draws: about what it is quick enough for
constexpr Nanos kOwnInterval = 30'000'000;               // ns between pictures from a viewpoint of one's own
// ns between looks for changed bricks: no more often than they are drawn
constexpr Nanos kMeshInterval = 16'000'000, kProcessorMeshInterval = 33'000'000;

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
  bool watched = false;  // bricks go to the operator too: the headset takes the others
  StrokeBook book;       // carver thread until it has ended
  Nanos began = 0;            // of recorded frames
  Nanos mesh_interval = kMeshInterval;
  std::size_t xr_stream = 0;  // which of the recording's streams they are
  std::size_t picture_stream = 0;  // the same, of a picture on a screen
  SoundLink* sound = nullptr;
  std::size_t left_stream = 0;  // of the recording, where there is a second hand
  std::optional<std::size_t> head_stream;  // the same, where there is a screen
  std::optional<TickNotes> notes;          // recorder thread, where recorded
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

/// N/m
PerTissue scaled(const MaterialTable& materials, const PerTissue& share) {
  PerTissue stiffness{};
  for (std::size_t i = 0; i < share.size(); ++i) stiffness[i] = share[i] * materials[i].stiffness;
  return stiffness;
}

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
    if (wiring.settings.fetch()) {
      settings = wiring.settings.front();
      if (!s.record) s.servo->set_stiffness(scaled(s.scene.servo.materials, settings.stiffness));
    }
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

/// True when the tissue is another one afterwards.
bool obey(Session& s, TissueCommand command, Nanos t, TissueSaver& saver) {
  Wiring& wiring = s.wiring;
  if (command == TissueCommand::kSave) {
    saver.start(s.carver.volume(), s.save);
    return false;
  }
  const bool redo = command == TissueCommand::kRedo;
  const StrokeEdit edit{t, redo, s.carver.cuts(), s.carver.patches()};
  if (!(redo ? s.carver.redo() : s.carver.undo())) return false;
  s.book.edited(redo, s.carver.volume());
  if (s.record) wiring.edits_to_recorder.push(edit);
  return true;
}

/// The brush's stroke is one that can be taken back.
void brush(Session& s, const BrushMove& move) {
  if (move.begins) {
    s.carver.end_stroke();
    s.carver.volume().begin_stroke();
  }
  paint(s.carver.volume(), {move.stroke});
  s.book.painted(move.stroke, s.carver.volume());
}

void carver_thread(Session& s) {
  Wiring& wiring = s.wiring;
  TissueSaver saver;
  TissueView view(wiring.tolerance);
  Nanos meshed = 0;
  bool first = true;
  int idle = 0;  // turns without work
  Cut cut;
  while (!wiring.stop.load(std::memory_order_relaxed)) {
    bool worked = false;
    while (wiring.cuts_to_carver.pop(cut)) {
      s.carver.apply(cut);
      if (s.operated) s.book.cut(cut, s.carver.volume());
      worked = true;
    }
    for (const LoosePiece& piece : s.carver.take_pieces()) {
      if (s.debris) wiring.pieces_to_debris.push(piece);
      if (s.record) wiring.pieces_to_recorder.push(piece);
    }
    TissueCommand command;
    bool edited = false;  // then a patch is cut out before any later cut, and the servo knows which cuts to repeat
    while (wiring.tissue_commands.pop(command)) {
      edited |= obey(s, command, wiring.tick_to_carver.front().t, saver);
      worked = true;
    }
    BrushMove move;
    bool painted = false;
    while (wiring.paint_to_carver.pop(move)) {
      brush(s, move);
      painted = true;
    }
    if (worked || painted) {
      const TissueState state = s.book.state(s.carver.volume());
      wiring.tissue_to_render.publish(state);
      wiring.tissue_version.store(state.version, std::memory_order_relaxed);
    }
    if (wiring.tick_to_carver.fetch() || painted || edited) {
      const ServoTick& tick = wiring.tick_to_carver.front();
      if (is_finite(tick.X_WG.p) && (painted || s.carver.patch_due(tick))) {
        s.carver.cut_out(s.carver.patch_center(tick), wiring.patch.back());
        wiring.patch.publish();
        worked = true;
      }
    }
    if (s.draw && (first || now() - meshed > s.mesh_interval)) {
      meshed = now();
      first = false;
      view.set_tolerance(wiring.tolerance);
      auto batch = std::make_unique<MeshBatch>(view.update(s.carver.volume()));
      s.bricks_meshed += batch->size();
      for (const render::MeshUpdate& brick : *batch) s.triangles_made += brick.indices.size() / 3;
      if (s.watched && !batch->empty()) {
        auto copy = std::make_unique<MeshBatch>(*batch);
        if (wiring.bricks_to_watch.push(copy.get())) (void)copy.release();
      }
      if (!batch->empty() && wiring.bricks.push(batch.get())) (void)batch.release();
    }
    if (wiring.copy_wanted.exchange(false)) {
      auto copy = std::make_unique<haptics::TissueVolume>(s.carver.volume().clone());
      if (wiring.copies_to_watch.push(copy.get())) (void)copy.release();
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
  render::View viewed = render::View::kLook;
  const auto drain = [&] {
    ServoTick tick;
    Cut cut;
    PatchUse use;
    StrokeEdit edit;
    while (wiring.patches_to_recorder.pop(use)) writer.append({&use, 1});
    // After the patches: the edit that made one of them due is then there too.
    while (wiring.edits_to_recorder.pop(edit)) writer.append(event_of(edit));
    LoosePiece piece;
    while (wiring.pieces_to_recorder.pop(piece)) writer.append(event_of(piece));
    while (wiring.cuts_to_recorder.pop(cut)) writer.append({&cut, 1});
    while (wiring.ticks_to_recorder.pop(tick)) {
      writer.append({&tick, 1});
      s.notes->add(tick, writer);
    }
    SeenFrom seen;
    while (wiring.seen_to_recorder.pop(seen)) {
      if (seen.view != viewed) writer.event(seen.t, session::EventKind::kView, view_name(seen.view));
      viewed = seen.view;
      const dvec3 &eye = seen.eye_W, &right = seen.right_W;
      writer.append(*s.head_stream, seen.t, std::array{eye.x, eye.y, eye.z, right.x, right.y, right.z, seen.ipd, static_cast<double>(seen.view)});
    }
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
    PictureTiming picture;
    while (wiring.pictures_to_recorder.pop(picture))
      writer.append(s.picture_stream, picture.t - s.began, picture_stream_row(picture));
    writer.count_ring_losses(wiring.ticks_to_recorder.dropped(), wiring.cuts_to_recorder.dropped());
    writer.heartbeat();
    if (s.operated) {
      const session::WriterStatus& status = writer.status();
      wiring.record_to_render.publish({status.ticks, status.cuts, !status.lost.any()});
    }
  };
  while (!wiring.nothing_more.load()) {
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
  Surroundings around;               // of the tooth, where a picture is drawn here
  std::unique_ptr<LiveViews> views;  // where operated or drawn here
  std::optional<PictureStage> own_stage;  // from a viewpoint of one's own
  Viewpoint own_from;
  glm::ivec2 own_size{0};            // 0: there is none
  Nanos own_drawn = 0;
  std::uint64_t own_frames = 0;
  MaterialTable materials;           // as drawn
  QualityLadder ladder;
  std::optional<Detail> detail;      // of the tooth in the stage's picture
  std::optional<DebrisView> debris;
  WorkCounts before;  // of the process, when the session began
  dvec3 above{0, 0, 0};  // m, W: where the tool starts

  bool running = false;
  Nanos began = 0, last_frame = 0, last_drawn = 0;
  ServoTick tick;  // the newest, as drawn
  std::uint64_t drawn = 0;
  double frame_seconds = 0, frame_period = 0, photon_seconds = 0;  // s, smoothed
  SessionSettings settings;                    // as last sent to the servo
  std::optional<SeenFrom> seen;                // as last given to the recording
  std::optional<session::HandMeter> meter;     // where operated
  std::optional<DamageMeter> damage;           // the same
  PerTissue volumes_before{};                  // m³, the same
  Nanos fault_time = 0;
  Nanos revived = -kReviveInterval;  // when the picture was last made anew
  std::uint32_t recent_faults = 0;
  bool drew_last = false;  // the last turn drew a frame
  bool sucking = false;    // the suction is on
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
  void collect();
  void draw_own(double dt);
  void count_frame();
  bool in_one_window() const { return options.embedded && own_size.x > 0; }
  void score_ticks();
  void record_view();
  void follow_keys(const display::UserInput& input);
  void edit_tissue(const display::UserInput& input);
  void draw();
  void count(const render::FrameStats& frame);
  void count_work(const WorkCounts& running);
  void show_next_view();
  void hold(bool on) noexcept;
  void suck(bool on);
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
  materials = scene.servo.materials;
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
    s.picture_stream = header.streams.size();
    if (s.draw && window) header.streams.push_back(picture_stream());
    if (s.draw && window) {
      s.head_stream = header.streams.size();
      header.streams.push_back(head_stream());
    }
    std::optional<std::size_t> heard;
    if (sound) {
      heard = header.streams.size();
      header.streams.push_back(sound_stream());
    }
    s.notes.emplace(scene, heard);
    writer.emplace(options.record, header);
    if (sound) writer->event(0, session::EventKind::kNote, sound->about());
  }
  if (s.operated) {
    meter.emplace(hand.rate);
    volumes_before = tissue.volumes();
    s.watched = s.draw && hmd;
    damage = damage_meter(scene);
  }
  if ((s.draw && window) || s.operated) {
    around = make_surroundings(scene);
    views = std::make_unique<LiveViews>(scene, tissue, around, s.wiring, s.operated);
  }
  if (s.draw && window) {
    make_stage(options.device);
    detail.emplace(surface_tolerance(*rig, tissue.frame().voxel, ladder.step()), tissue.frame().voxel);
    s.wiring.tolerance = detail->tolerance();
    if (stage->device().processor) s.mesh_interval = kProcessorMeshInterval;
    explain("drawn by " + stage->device_name());
    explain(fmt::format("picture quality: begins at \"{}\"; steps down while a frame takes over {:.0f} ms, up when there is "
                        "room", ladder.step().name, 1e3 / 30));
    explain(rig->head.tracker.empty() ? "head: at rest, the rig names no tracker" : "head: " + rig->head.tracker);
  }
  if (s.debris && window) {
    debris.emplace(scene.servo.materials, tissue);
    debris->use(&stage->device());
    suck(scene.suction_on);
    explain(debris->cloud() ? "debris: moved by the GPU" : "debris: moved by the processor, which also draws");
  }
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
  if (views && !options.operated) keys += "V: view   ";
  if (debris) keys += "A: suction   ";
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
    if (headset) {
      collect();
      draw_own(0.01);
      return headset->step();
    }
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
    if (debris) debris->use(nullptr);
    views->attach(Eyes::kTrainee, nullptr);
    stage.reset();
    make_stage(nullptr);
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
  look.hud = !options.operated;  // what the operator's window says need not stand in the trainee's picture
  look.device = device;
  look.monitor = options.monitor;
  look.quality = ladder.step();
  haptics::ServoSettings shown = scene.servo;
  shown.materials = materials;
  stage.emplace(*rig, shown, look);
  if (stage->device().processor && ladder.changes() == 0) {
    ladder = QualityLadder(1.0 / 30, 1.0 / 90, kProcessorStep);
    stage->set_quality(ladder.step());
  }
  stage->surround(around);
  stage->hold_mirror(scene.mouth_mirror);
  views->attach(Eyes::kTrainee, &*stage);
  if (debris) debris->use(&stage->device());
}

/// The nozzle beside the tooth draws chips in, or not.
void Workbench::Impl::suck(bool on) {
  sucking = on;
  constexpr double kBeside = 9e-3;  // m, behind the tooth as the trainee sees it
  debris::Suction nozzle = scene.suction.value_or(debris::Suction{.p_W = above + dvec3(0, kBeside, 0)});
  debris->suck(on ? std::optional(nozzle) : std::nullopt);
}

/// The picture from a viewpoint of one's own, where it is wanted and due.
void Workbench::Impl::draw_own(double dt) {
  if (!views || own_size.x <= 0 || !options.device) {
    if (own_stage) {
      views->attach(Eyes::kOwn, nullptr);
      own_stage.reset();
    }
    return;
  }
  if (now() - own_drawn < kOwnInterval) return;
  own_drawn = now();
  if (!own_stage) {
    PictureStage::Options look;
    look.embedded = true;
    look.hud = false;
    look.device = options.device;
    look.quality = ladder.step();
    haptics::ServoSettings shown = scene.servo;
    shown.materials = materials;
    own_stage.emplace(rig_of(own_from, views->middle(), own_size), shown, look);
    own_stage->surround(around);
    views->attach(Eyes::kOwn, &*own_stage);
    views->advance();
  }
  own_stage->resize(own_size);
  own_stage->look_from(rig_of(own_from, views->middle(), own_size));
  const Look& look = views->look(Eyes::kOwn);
  own_stage->hold_mirror(!look.mirror ? MouthMirror{} : hands.left ? session->wiring.mouth_mirror.front() : scene.mouth_mirror);
  const auto particles = debris && look.debris ? debris->particles() : std::span<const render::Particle>{};
  if (!own_stage->draw(tick, particles, dt).drawn) return;
  ++own_frames;
  if (in_one_window() || !stage) count_frame();
}

/// One more picture has been drawn.
void Workbench::Impl::count_frame() {
  const Nanos t = now();
  if (last_drawn) frame_period += 0.1 * (std::min(to_seconds(t - last_drawn), 1.0) - frame_period);
  last_drawn = t;
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
  if (sucking) text += "suction on   ";
  if (ladder.changes() > 0) text += fmt::format("picture: {}   ", ladder.step().name);
  return text + "space: stop";
}

/// 1 … 9: another tool of the tray. Space: the emergency key.
void Workbench::Impl::follow_keys(const display::UserInput& input) {
  for (const int key : input.pressed) {
    if (key == kHoldKey) hold(true);
    if (key == kGoOnKey) hold(false);
    if (key == kViewKey && views && !options.operated) show_next_view();
    if (key == kSuctionKey && debris) suck(!sucking);
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

/// As it looks, cut open where the bur is, as glass, against the ideal where the scene has one, and again as it looks.
void Workbench::Impl::show_next_view() {
  using render::View;
  constexpr std::array kOrder{View::kLook, View::kSection, View::kXray, View::kDifference};
  Look next = views->look(Eyes::kTrainee);
  const auto now_at = std::find(kOrder.begin(), kOrder.end(), next.view);
  const bool last = now_at + 1 == kOrder.end() || (now_at[1] == View::kDifference && !views->has_ideal());
  next.view = last ? View::kLook : now_at[1];
  if (next.view == View::kSection) {
    // Upright through the bur, facing the viewer: what lies behind it stays.
    const dvec3 away = stage->rig().head.eye_center - tick.X_WG.p, level(away.x, away.y, 0);
    const dvec3 n = glm::length(level) > 0.2 * glm::length(away) ? -glm::normalize(level) : dvec3(0, 1, 0);
    next.plane = {n, -glm::dot(n, tick.X_WG.p)};
  }
  views->look(Eyes::kTrainee, next);
}

/// What changed since the last picture.
void Workbench::Impl::collect() {
  Session& s = *session;
  if (!headset && s.wiring.tick_to_render.fetch()) tick = s.wiring.tick_to_render.front();
  MeshBatch* batch = nullptr;
  while ((headset ? s.wiring.bricks_to_watch : s.wiring.bricks).pop(batch)) {
    const std::unique_ptr<MeshBatch> owned(batch);
    views->take(std::move(*owned));
  }
  if (views) views->advance();
}

void Workbench::Impl::draw() {
  Session& s = *session;
  collect();
  const double dt = to_seconds(now() - last_frame);
  last_frame = now();
  if (debris) {
    Cut cut;
    while (s.wiring.cuts_to_debris.pop(cut)) debris->add(cut, haptics::tray(scene.servo)[cut.tool]);
    LoosePiece piece;
    while (s.wiring.pieces_to_debris.pop(piece)) debris->add(piece);
    summary.work.particles_stepped += debris->debris().alive();
    debris->step(std::min(dt, 0.1));
  }
  if (hands.left) s.wiring.mouth_mirror.fetch();
  draw_own(dt);
  if (in_one_window()) {
    frame_seconds += 0.1 * (to_seconds(now() - last_frame) - frame_seconds);
    return std::this_thread::sleep_for(4ms);
  }
  const Look& look = views->look(Eyes::kTrainee);
  stage->hold_mirror(!look.mirror ? MouthMirror{} : hands.left ? s.wiring.mouth_mirror.front() : scene.mouth_mirror);
  const bool chips = debris && look.debris;
  stage->show_cloud(chips ? debris->cloud() : nullptr);
  const auto stats = stage->draw(tick, chips ? debris->particles() : std::span<const render::Particle>{}, dt, hint());
  drawn += stats.drawn;
  record_view();
  if (stats.drawn) {
    if (detail->follow(stats.pixel, ladder.step())) s.wiring.tolerance = detail->tolerance();
    count(stats);
    count_frame();
    // The trainee's picture alone: what else is drawn must not cost its quality.
    const PictureStage::Timing& took = stage->timing();
    frame_seconds += 0.1 * (took.cost() - frame_seconds);
    // The hand's sample was that old when the frame began.
    const Nanos zero = s.wiring.session_zero.load(std::memory_order_relaxed);
    const double age = zero ? std::max(to_seconds(last_frame - zero - tick.t), 0.0) : 0.0;
    photon_seconds += 0.1 * (age + took.shown - photon_seconds);
    if (s.record)
      s.wiring.pictures_to_recorder.push(
          {last_frame, dt, took.record, took.gpu, age + took.shown, stats.redrawn, ladder.place()});
    // Composing and presenting are the processor's work, too, where it plays the GPU: frames on end show what all takes.
    const bool on_end = std::exchange(drew_last, true) && stage->device().processor && !options.embedded;
    if (ladder.frame_took(on_end && dt > 1.0 / 30 ? std::max(dt, took.cost()) : took.cost())) {
      stage->set_quality(ladder.step());
      log::info("picture quality: {}, for a frame took {:.0f} ms", ladder.step().name, 1e3 * frame_seconds);
    }
  }
  if (!stats.drawn) drew_last = false;
  if (!stats.drawn && !options.embedded) std::this_thread::sleep_for(4ms);
}

void Workbench::Impl::count(const render::FrameStats& frame) {
  WorkCounts& work = summary.work;
  const auto plus = [](std::uint64_t& sum, auto value) { sum += static_cast<std::uint64_t>(value); };
  plus(work.passes, frame.passes);
  plus(work.triangles_drawn, frame.triangles + frame.mirror_triangles);
  plus(work.bricks_skipped, frame.bricks_culled + frame.bricks_facing_away + frame.bricks_covered);
  work.pipelines = std::max(work.pipelines, static_cast<std::uint64_t>(frame.pipelines));
}

/// Where it is seen from, and how: to the recording, whenever that changed.
void Workbench::Impl::record_view() {
  Wiring& wiring = session->wiring;
  const Nanos zero = wiring.session_zero;
  if (!session->head_stream || zero == 0) return;
  const display::Head& head = stage->rig().head;
  const SeenFrom now_seen{now() - zero, head.eye_center, head.right, head.ipd, stage->view()};
  if (seen && seen->eye_W == now_seen.eye_W && seen->right_W == now_seen.right_W && seen->view == now_seen.view) return;
  if (wiring.seen_to_recorder.push(now_seen)) seen = now_seen;
}

/// The hand's measures and the faults of the last second, from every tick.
void Workbench::Impl::score_ticks() {
  ServoTick next;
  while (session->wiring.ticks_to_score.pop(next)) {
    meter->add({&next, 1});
    if (damage) damage->add({&next, 1});
    views->explore(next);
    if (headset || !session->draw) tick = next;
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
  Cut last_cut;  // of a tick that the servo was still in when the carver left
  while (s.wiring.cuts_to_carver.pop(last_cut)) s.carver.apply(last_cut);
  s.wiring.nothing_more = true;
  if (recorder.joinable()) recorder.join();
  if (headset) {
    drawn = headset->frames();
    headset->stop();
    if (!options.touches.empty()) write_touches(options.touches, headset->touches());
  }
  if (sound) sound->stop(s.last.t);
  if (sound && writer && sound->stats().underruns + sound->stats().losses > 0) {
    writer->event(s.last.t, session::EventKind::kNote,
                  fmt::format("sound: {} gaps, the device away {} times", sound->stats().underruns, sound->stats().losses));
  }
  MeshBatch* batch = nullptr;
  while (s.wiring.bricks.pop(batch)) delete batch;
  while (s.wiring.bricks_to_watch.pop(batch)) delete batch;
  if (views) views->attach(Eyes::kTrainee, nullptr), views->attach(Eyes::kOwn, nullptr);
  own_stage.reset();
  views.reset();
  haptics::TissueVolume* copy = nullptr;
  while (s.wiring.copies_to_watch.pop(copy)) delete copy;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);

  if (!s.save.empty() && options.save_at_end) {
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
  if (stage && drawn > 0) {
    explain(fmt::format("picture: {} frames, {:.1f} ms each at the end, {:.0f} ms from hand to screen (estimated); quality "
                        "\"{}\", step {} of {}, after {} changes",
                        drawn, 1e3 * frame_seconds, 1e3 * photon_seconds, ladder.step().name, ladder.place() + 1,
                        render::kQualityLadder.size(), ladder.changes()));
  }
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
  for (const WorkCount& c : listed(work)) log::info("{:>14} {}", c.value, c.words);
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
void Workbench::paint(const BrushMove& move) {
  if (!impl_->writer) impl_->session->wiring.paint_to_carver.push(move);
}
std::vector<PaintStroke> Workbench::painted() const {
  return impl_->session->book.paint(impl_->session->carver.volume());
}
void Workbench::color(Tissue tissue, const dvec3& color) {
  Impl& m = *impl_;
  m.materials[static_cast<std::size_t>(tissue)].color = color;
  if (m.own_stage) {
    m.views->attach(Eyes::kOwn, nullptr);
    m.own_stage.reset();
  }
  if (!m.stage) return;
  m.views->attach(Eyes::kTrainee, nullptr);
  m.stage.reset();
  m.make_stage(m.options.device);
}
LiveViews* Workbench::views() {
  return impl_->views.get();
}
void Workbench::look_from(const Viewpoint& from, glm::ivec2 pixels) {
  impl_->own_from = clamped(from);
  impl_->own_size = pixels.x > 0 ? glm::max(pixels, glm::ivec2(16)) : glm::ivec2(0);
}
const gpu::Image* Workbench::own_picture() const {
  return impl_->own_stage && impl_->own_frames > 0 ? &impl_->own_stage->pictures() : nullptr;
}
haptics::TissueVolume Workbench::take_tissue() {
  return std::move(impl_->session->carver.volume());
}
void Workbench::drop_picture() {
  if (impl_->debris) impl_->debris->use(nullptr);
  if (impl_->views) impl_->views->attach(Eyes::kTrainee, nullptr), impl_->views->attach(Eyes::kOwn, nullptr);
  impl_->own_stage.reset();
  impl_->stage.reset();
}
void Workbench::make_picture(gpu::Device& device) {
  if (!impl_->session->draw || impl_->headset) return;
  impl_->make_stage(&device);
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
  if (!m.session->draw && !m.meter && wiring.tick_to_render.fetch()) m.tick = wiring.tick_to_render.front();
  s.tick = m.tick;
  s.seconds = to_seconds(s.tick.t);
  s.faults = s.tick.t - m.fault_time < kNanosPerSecond ? m.recent_faults : 0;
  s.timing = wiring.loop_to_render.front().timing;
  s.frame_ms = m.frame_seconds * 1e3;
  s.frames_per_second = m.frame_period > 0 ? 1 / m.frame_period : 0;
  s.quality = m.ladder.step().name;
  s.frames = m.drawn;
  s.record = wiring.record_to_render.front();
  wiring.tissue_to_render.fetch();
  s.tissue = wiring.tissue_to_render.front();
  s.own_frames = m.own_frames;
  const LoopReport& loop = wiring.loop_to_render.front();
  s.motor_heat = loop.heat;
  s.bearable_force = loop.bearable_force;
  s.armed = loop.armed;
  s.real_time = loop.words();
  return s;
}
session::Score Workbench::score_so_far() {
  Impl& m = *impl_;
  session::ScoreInput input;
  if (m.views && m.views->judged()) input = *m.views->judged();  // the geometry as it was a moment ago
  if (m.scene.resume.empty() || !m.views || !m.views->judged()) {  // the volumes as they are
    input.before = input.after = m.volumes_before;
    const PerTissue removed = m.session->wiring.tissue_to_render.front().removed;
    for (std::size_t i = 0; i < input.after.size(); ++i) input.after[i] -= removed[i];
  }
  if (m.meter) input.hand = m.meter->result();
  if (m.damage) input.damage = m.damage->result();
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
  auto& latest = impl_->session->wiring.tissue_to_render;
  latest.fetch();
  return latest.front().strokes;
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
