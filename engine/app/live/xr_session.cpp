#include "engine/app/live/xr_session.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <mutex>
#include <optional>
#include <thread>

#include "calibration/still_touch.h"
#include "engine/app/live/xr_stage.h"
#include "engine/app/picture/detail.h"
#include "engine/app/picture/frame_report.h"
#include "engine/app/picture/hud.h"
#include "engine/app/picture/live_views.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/quality_ladder.h"
#include "engine/app/picture/world.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/units.h"
#include "haptics/device_safety.h"

namespace typodont {

namespace {

using namespace std::chrono_literals;

// Time in which a tool fades after its tracking is lost, or becomes opaque again after tracking returns, s.
constexpr double kFadeTime = 0.25;
constexpr double kLostOpacity = 0.35;
constexpr double kFullForce = 3;  // N, force at which the controller vibrates most strongly
// Hz, lowest and highest frequency of a controller's vibration
constexpr double kMinRate = 60, kMaxRate = 320;
// Spindle speed at which the controller vibrates with its highest frequency, rad/s.
constexpr double kFastSpindle = 400 * kKrpm;
// Limits for a controller and for an arm: a time (s) and a distance (m). The tip counts as still if it moves less than
// this distance in this time.
constexpr calibration::StillTouch::Limits kStillController{0.15, 2e-3}, kStillArm{0.15, 0.5e-3};
// Longest time for a frame, s. If a frame takes longer, the GPU is assumed to hang. Software rendering takes less time.
constexpr double kLongestFrame = 20;
// Longest wait for the headset's runtime to end the session, s.
constexpr double kLeaveTime = 2;

/// Computes the controller's vibration: its amplitude from the force on the hand, its frequency from the drill's speed.
/// This frequency is far below the spindle's frequency, which a controller cannot produce.
display::Vibration vibration_of(const ServoTick& tick) {
  const double force = glm::length(tick.f_T_W);
  // Amplitude for a drill that runs without contact; just perceptible.
  const double running = tick.spindle > 1 ? 0.04 : 0;
  const double speed = std::clamp(std::abs(tick.spindle) / kFastSpindle, 0.0, 1.0);
  return {std::clamp(running + force / kFullForce, 0.0, 1.0), kMinRate + (kMaxRate - kMinRate) * speed};
}

/// Call if a thread hangs in a call of the headset's runtime. At exit, the process then runs no destructors, because
/// the hanging thread might still use the data. The exit status remains the same.
void end_hard_at_exit() {
  on_exit(
      [](int status, void*) {
        haptics::release_all_devices();
        std::fflush(nullptr);
        _exit(status);
      },
      nullptr);
}

}  // namespace

/// All data of the headset's thread except the channels to other threads (Wiring). If the thread hangs, this object
/// continues to exist, because the thread might still use it.
struct XrSession::Thread {
  display::DisplayRig rig;
  const Scene scene;
  dvec3 origin;                             // m, frame W: origin of the tissue's voxels
  double voxel;                             // m, voxel size of the tissue
  std::optional<render::BoxInWorld> reach;  // m, frame W: box the tissue can occupy
  Wiring& wiring;
  Options options;
  World world;
  WorldReader reader{world, wiring.event_logs};
  int mirror_hand = -1;  // index of the controller holding the mouth mirror; -1: none

  display::RuntimeGate gate;
  std::atomic<bool> leave{false};
  std::atomic<std::uint64_t> frames{0};

  enum class Phase { kOpening, kAwake, kOver };
  // The mutex protects the members below.
  std::mutex mutex;
  std::condition_variable changed;
  Phase phase = Phase::kOpening;
  std::exception_ptr failure;
  std::vector<std::string> explanations;
  std::vector<Touch> touches;
  std::string notice, quality_notice;
  std::optional<DebrisBalance> debris_mass;
  // Counters of the work, and times of the frames; only this thread uses them until it ends.
  WorkCounts work;
  FrameReport report;

  std::thread thread;

  Thread(const display::DisplayRig& r, const Scene& shown, const haptics::TissueVolume& tissue, Wiring& w,
         const Options& o)
      : rig(r),
        scene(shown),
        origin(tissue.frame().origin),
        voxel(tissue.frame().voxel),
        reach(tissue_reach(scene, tissue)),
        wiring(w),
        options(o),
        world(scene) {
    world.place(options.start);
    if (options.debris) world.add_debris(tissue);
    world.add_warnings(tissue, options.warnings);
  }

  void enter(Phase next, std::exception_ptr error = nullptr) {
    {
      const std::lock_guard lock(mutex);
      phase = next;
      if (error) failure = error;
    }
    changed.notify_all();
  }

  void run() {
    std::exception_ptr error;
    try {
      XrStage stage(
          rig, scene.servo, options.work_W, gate,
          {.handpieces = scene.handpieces, .force_in_hud = options.force_in_hud, .language = options.language});
      {
        const std::lock_guard lock(mutex);
        explanations = stage.hmd().explanations();
        explanations.push_back("drawn by " + stage.device_name());
      }
      stage.hmd().wake();
      enter(Phase::kAwake);
      frame_loop(stage);
    } catch (...) {
      error = std::current_exception();
    }
    publish_hand(nullptr);
    gate.done();
    if (world.debris()) {
      reader.read();
      const std::lock_guard lock(mutex);
      debris_mass = world.debris()->settle();
      debris_mass->events_lost = reader.lost();
    }
    enter(Phase::kOver, error);
  }

  void frame_loop(XrStage& stage) {
    display::Hmd& hmd = stage.hmd();
    QualityLadder ladder = options.quality.empty() ? QualityLadder(1.0 / 60, 1.0 / 250, stage.processor() ? 3 : 1)
                                                   : QualityLadder::fixed_at(options.quality);
    stage.set_quality(ladder.step());
    say_quality(ladder, stage.processor());
    stage.surround(world.surroundings());
    Detail detail(wiring.tolerance, voxel);
    // Releases the particles whenever this function ends, because that must happen before their GPU device is
    // destroyed.
    struct InUse {
      DebrisView* debris;
      ~InUse() {
        if (debris) debris->use(nullptr);
      }
    } in_use{world.debris()};
    if (in_use.debris) in_use.debris->use(&stage.device());
    double opacity = 1;
    std::array<calibration::StillTouch, 2> still_tips{calibration::StillTouch(kStillController),
                                                      calibration::StillTouch(kStillController)},
        still_arms{calibration::StillTouch(kStillArm), calibration::StillTouch(kStillArm)};
    Nanos last_frame = now(), leave_until = 0;
    while (hmd.poll()) {
      if (leave && !leave_until) {
        leave_until = now() + from_seconds(kLeaveTime);
        hmd.request_exit();
        continue;
      }
      if (leave_until && now() > leave_until) break;
      reader.read();         // reads the event logs even if the headset is off, so that no event is lost
      if (!hmd.running()) {  // The user has taken off the headset: the bench waits, and no hand holds the tool.
        publish_hand(nullptr);
        set_tissue_visible(false);
        std::this_thread::sleep_for(10ms);
        continue;
      }
      const display::HmdFrame frame = hmd.wait();
      const Nanos woke = now(), zero = wiring.session_zero;
      const double dt = to_seconds(woke - last_frame);
      last_frame = woke;
      reader.read();
      MeshBatch* batch = nullptr;
      while (wiring.bricks.pop(batch)) {
        const std::unique_ptr<MeshBatch> owned(batch);
        stage.show(*owned, origin);
      }
      if (world.debris()) world.debris()->count(work);
      for (std::size_t i = 0; options.touches && i < 2; ++i)
        if (frame.hands[i].tracked) take_touch(woke, frame.hands[i], still_tips[i], still_arms[i]);
      const bool held = publish_hand(&frame);
      for (const display::HmdHand& hand : frame.hands)
        if (hand.change_tool) choose_next_tool();
      hold_mirror(frame);
      const double step = dt / kFadeTime * (1 - kLostOpacity);
      opacity = std::clamp(opacity + (held ? step : -step), kLostOpacity, 1.0);
      {
        const std::lock_guard lock(mutex);
        world.say(notice);
      }
      set_tissue_visible(!reach || render::in_sight(XrStage::picture(frame, world, 1, false), *reach));
      const dvec3 left_W = frame.eyes[0].position, right_W = frame.eyes[1].position;
      if (const double ipd = glm::length(right_W - left_W); ipd > 0 && zero != 0)
        wiring.event_logs.view.write(SeenFrom{woke - zero, 0.5 * (left_W + right_W), (right_W - left_W) / ipd, ipd});
      const render::FrameStats drawn = stage.draw(frame, world, opacity);
      if (drawn.drawn) count_frame(drawn, work);
      if (drawn.drawn && zero != 0) report.add(stage.gpu_times());
      if (detail.follow(drawn.pixel, ladder.step())) wiring.tolerance = detail.tolerance();
      if (options.tool_hand >= 0 && frame.focused)
        hmd.vibrate(options.tool_hand, held ? vibration_of(world.tick()) : display::Vibration{});
      for (display::HmdTiming timing : hmd.timings()) {
        timing.t -= zero;
        if (zero == 0) continue;
        wiring.event_logs.view.write(timing);
        if (timing.drawn && frame.period > 0)
          report.add_interval((timing.missed + 1) * frame.period, {frame.period, "predicted by the headset's runtime"});
      }
      if (!frame.draw) continue;
      frames.fetch_add(1, std::memory_order_relaxed);
      if (ladder.frame_took(to_seconds(now() - woke))) {
        stage.set_quality(ladder.step());
        say_quality(ladder, stage.processor());
        log::info("picture quality: {}", ladder.step().name);
      }
    }
  }

  void say_quality(const QualityLadder& ladder, bool processor) {
    const Remedy remedy = ladder.remedy(processor, /*window=*/false, /*pixels=*/0);
    const std::lock_guard lock(mutex);
    if (remedy == Remedy::kNone && ladder.changes() == 0) return;
    quality_notice = quality_text(ladder.step().name, remedy, options.language);
  }

  void take_touch(Nanos t, const display::HmdHand& controller, calibration::StillTouch& tip,
                  calibration::StillTouch& arm) {
    using Verdict = calibration::StillTouch::Verdict;
    const Verdict of_tip = tip.add(t, controller.X_DT.p, controller.pedal, false);
    const Verdict of_arm = arm.add(t, inverse(rig.X_WH) * world.tick().X_WT.p, controller.pedal, false);
    if (of_tip == Verdict::kNone && of_arm == Verdict::kNone) return;
    if (of_tip != Verdict::kTaken || of_arm != Verdict::kTaken) {
      log::info("touch: not taken, hold both still");
      return;
    }
    const std::lock_guard lock(mutex);
    touches.push_back({arm.point(), tip.point()});
    log::info("touch {}: taken", touches.size());
  }

  /// Handles the mirror button of a controller, which puts the mouth mirror into the second hand or removes it. If the
  /// second hand's tracking is lost, the mirror keeps its pose.
  void hold_mirror(const display::HmdFrame& frame) {
    for (int i = 0; i < 2; ++i) {
      if (!frame.hands[static_cast<std::size_t>(i)].mirror) continue;
      mirror_hand = mirror_hand >= 0 ? -1 : options.tool_hand >= 0 ? 1 - options.tool_hand : i;
      world.hold(scene.mouth_mirror);
    }
    if (mirror_hand < 0) return;
    const display::HmdHand& hand = frame.hands[static_cast<std::size_t>(mirror_hand)];
    if (hand.tracked) world.hold(held(scene.mouth_mirror, hand.X_WT));
  }

  /// Requests the next tool of the tool set. The servo changes the tool as soon as the pedal is released, the drill
  /// stands still and the tool touches nothing.
  void choose_next_tool() {
    const auto tools = static_cast<std::int32_t>(world.tools().size());
    const std::int32_t chosen = wiring.chosen_tool;
    wiring.chosen_tool = ((chosen >= 0 ? chosen : static_cast<std::int32_t>(world.tick().tool)) + 1) % tools;
  }

  void set_tissue_visible(bool seen) { wiring.tissue_in_sight[static_cast<std::size_t>(Eyes::kTrainee)] = seen; }

  /// Passes the controller's sample to the servo. True if the headset tracks the controller, or if another device holds
  /// the tool.
  bool publish_hand(const display::HmdFrame* frame) {
    if (options.tool_hand < 0) return true;
    const display::HmdHand hand =
        frame ? frame->hands[static_cast<std::size_t>(options.tool_hand)] : display::HmdHand{};
    wiring.xr_hand.publish({hand.X_WT, hand.pedal, hand.tracked, now()});
    return hand.tracked;
  }
};

XrSession::XrSession(const display::DisplayRig& rig, const Scene& scene, const haptics::TissueVolume& tissue,
                     Wiring& wiring, const Options& options)
    : thread_(std::make_shared<Thread>(rig, scene, tissue, wiring, options)), stall_(rig.hmd.stall) {
  thread_->thread = std::thread([state = thread_] { state->run(); });
  std::unique_lock lock(thread_->mutex);
  // Waits until the headset's thread has opened the runtime and the user wears the headset; wake() limits this time. If
  // a single call of the runtime takes too long, the session cannot start.
  while (thread_->phase == Thread::Phase::kOpening) {
    thread_->changed.wait_for(lock, 20ms);
    if (thread_->gate.silent() < std::max(rig.hmd.wait, stall_)) continue;
    lock.unlock();
    const std::string call = thread_->gate.call();
    stop();
    throw Error("OpenXR", "",
                fmt::format("no answer of the runtime for {:g} s (in {})", std::max(rig.hmd.wait, stall_), call),
                "a runtime that works: restart it");
  }
  const std::exception_ptr failure = thread_->phase == Thread::Phase::kOver ? thread_->failure : nullptr;
  lock.unlock();
  if (!failure) return;
  stop();
  std::rethrow_exception(failure);
}

XrSession::~XrSession() {
  stop();
}

void XrSession::say(std::string notice) {
  const std::lock_guard lock(thread_->mutex);
  thread_->notice = std::move(notice);
}

bool XrSession::step() {
  {
    const std::lock_guard lock(thread_->mutex);
    if (thread_->failure) std::rethrow_exception(thread_->failure);
    if (thread_->phase == Thread::Phase::kOver) return false;
  }
  const double silent = thread_->gate.silent();
  if (silent > stall_)
    throw RunFailure(
        fmt::format("headset: the runtime has not answered for {:.1f} s (in {})", silent, thread_->gate.call()));
  if (thread_->gate.busy() > kLongestFrame) throw RunFailure("headset: no picture arrives: the GPU hangs");
  return true;
}

void XrSession::stop() {
  if (!thread_->thread.joinable()) return;
  thread_->leave = true;
  for (;;) {
    {
      const std::lock_guard lock(thread_->mutex);
      if (thread_->phase == Thread::Phase::kOver) break;
    }
    // The headset's thread hangs in a call of the runtime, so it is not joined, and all its data remain in memory.
    if (thread_->gate.silent() > stall_ && thread_->gate.give_up()) {
      thread_->thread.detach();
      end_hard_at_exit();
      return;
    }
    // The thread does not end although it is not in a call of the runtime, so the GPU must hang.
    if (thread_->gate.busy() > kLongestFrame) {
      log::error("headset: its thread does not end");
      haptics::release_all_devices();
      std::fflush(nullptr);
      _exit(1);
    }
    std::this_thread::sleep_for(5ms);
  }
  thread_->thread.join();
}

std::uint64_t XrSession::frames() const {
  return thread_->frames.load(std::memory_order_relaxed);
}

std::vector<std::string> XrSession::explanations() const {
  const std::lock_guard lock(thread_->mutex);
  return thread_->explanations;
}

std::string XrSession::quality_notice() const {
  const std::lock_guard lock(thread_->mutex);
  return thread_->quality_notice;
}

std::vector<std::string> XrSession::report() const {
  const std::lock_guard lock(thread_->mutex);
  if (thread_->phase != Thread::Phase::kOver) return {};
  return thread_->report.lines();
}

std::optional<DebrisBalance> XrSession::debris() const {
  const std::lock_guard lock(thread_->mutex);
  return thread_->debris_mass;
}

void XrSession::add_work(WorkCounts& work) const {
  const std::lock_guard lock(thread_->mutex);
  if (thread_->phase != Thread::Phase::kOver) return;
  const WorkCounts& own = thread_->work;
  work.passes += own.passes;
  work.triangles_drawn += own.triangles_drawn;
  work.bricks_skipped += own.bricks_skipped;
  work.pipelines += own.pipelines;
  work.particles_stepped += own.particles_stepped;
}

std::vector<XrSession::Touch> XrSession::touches() const {
  const std::lock_guard lock(thread_->mutex);
  return thread_->touches;
}

void write_touches(const std::filesystem::path& file, std::span<const XrSession::Touch> touches) {
  std::string text = "hx_mm,hy_mm,hz_mm,dx_mm,dy_mm,dz_mm\n";
  for (const XrSession::Touch& t : touches) {
    const dvec3 h = t.p_H / kMillimetre, d = t.p_D / kMillimetre;
    text += fmt::format("{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f}\n", h.x, h.y, h.z, d.x, d.y, d.z);
  }
  write_file_atomically(file, text, FileKind::kTable);
}

}  // namespace typodont
