// The data of a live session, and the loops of its threads; the code of each thread is in its own file in this folder.
// Threads exchange data only through wiring.h. The workbench starts and joins the threads, and draws.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/hands/hands.h"
#include "engine/app/live/state_stream.h"
#include "engine/app/recording.h"
#include "engine/app/scene.h"
#include "engine/app/sides.h"
#include "engine/app/tissue/stroke_book.h"
#include "engine/app/wiring.h"
#include "haptics/carver.h"
#include "haptics/force_delay.h"
#include "haptics/haptic_device.h"
#include "haptics/servo.h"
#include "haptics/work.h"

namespace typodont {

/// The data of a session, which outlives its threads. While the servo or carver thread runs, no other thread uses the
/// members marked "… thread only" for it.
struct LiveSession {
  const Scene& scene;
  haptics::Carver carver;
  Wiring wiring;
  CarverSide side{carver, wiring.patch, wiring.event_logs};  // carver thread only
  std::optional<haptics::Servo> servo;                       // created as soon as the hand's device is known
  std::optional<haptics::ForceDelay>
      delay;                           // servo thread only: delays the force; empty if this session needs no delay
  std::optional<LoopStatistics> loop;  // servo thread only: statistics of the servo loop's timing
  ServoTick last;                      // servo thread only: the last tick
  double servo_cpu = 0;                // servo thread only: s, CPU time of the servo thread
  Nanos first_tick = 0;                // servo thread only: ns, when the first tick was finished
  std::uint32_t faults = 0;
  bool draw = false, record = false, debris = false, operated = false;
  /// True: each mesh brick (block of the surface) is sent to a headset and to the operator's picture.
  bool watched = false;
  StrokeHistory book;          // carver thread only: the changes of each stroke, for undo
  std::string carver_failure;  // carver thread only: reason why the carver failed; empty if it did not fail
  /// Time between two searches for changed mesh bricks, at least the duration of a frame, ns.
  Nanos mesh_interval = 16'000'000;
  std::filesystem::path save;  // file for the tissue; empty: not saved
  // Carver thread only: counters of the carver's work.
  std::uint64_t bricks_meshed = 0, triangles_made = 0, voxels_cut = 0;
  // Carver thread only: numbers of elements (spheres, triangles, vertices) that the contact models examined.
  haptics::SearchCounts looks;
  std::shared_ptr<const haptics::SoftSurface> gum;  // the soft gum; null if the gum is rigid
  std::uint64_t queries = 0;                        // servo thread only: number of queries of the distance field

  LiveSession(const Scene& s, haptics::TissueVolume tissue)
      : scene(s), carver(std::move(tissue), s.servo), wiring(carver) {}
  /// Creates the servo for the hand. `max_delay`: largest delay of the force that may be requested later, s; 0: none.
  void serve(const haptics::DeviceInfo& hand, double max_delay = 0) {
    const haptics::ServoSettings settings = servo_settings(scene, carver.volume(), hand.rate, hand.vibration_band,
                                                           hand.position_step, hand.torque_limit > 0);
    servo.emplace(settings);
    gum = settings.soft;
    if (max_delay > 0) delay.emplace(settings, max_delay);
    loop.emplace(wiring, hand.rate);
  }
};

/// The loop of the servo: the servo thread calls turn() until it returns false, then end(). A test can call the
/// functions turn() of all loops in any order.
class ServoTurns {
 public:
  /// `clock`: returns the time in ns; any steady clock.
  ServoTurns(LiveSession& s, haptics::HapticDevice& hand, Nanos (*clock)() noexcept = now);
  /// Runs one tick: reads the hand, computes contact and cut, writes the force, publishes the tick. Returns false at
  /// the session's end.
  bool turn() noexcept;
  /// Ramps the force down to zero and releases the hand's device.
  void end() noexcept;

 private:
  /// Sends the tick's force and torque to the hand.
  void send() noexcept;

  LiveSession& s_;
  haptics::HapticDevice& hand_;
  Nanos (*clock_)() noexcept;
  const Nanos period_;
  haptics::HandSample sample_;
  SessionSettings settings_;
  PedalInterlock pedal_;
  ServoTick tick_;
  Cut cut_;
  std::uint64_t ticks_ = 0;
  ServoSide side_;
};

/// The loop of the carver thread. Each call of turn() runs the loop once.
class CarverTurns {
 public:
  /// `between`: function called between the steps of turn(), so that a test can run the servo there; empty in a live
  /// session.
  explicit CarverTurns(LiveSession& s, std::function<void()> between = {});
  ~CarverTurns();
  struct Done {
    bool worked = false;   // true: this pass of the carver's loop had work
    bool awaited = false;  // true: the servo has not yet adopted the offered tissue patch (its copy of the tissue)
  };
  /// Repeats the servo's cuts, executes the user's commands, offers a new tissue patch if one is due, and meshes
  /// changed mesh bricks. Throws std::bad_alloc.
  Done turn();
  /// Call at the session's end: applies all remaining cuts of the servo to the tissue.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The loop that publishes the session's state to other programs. Each call of turn() runs the loop once.
class StreamTurns {
 public:
  /// `rate`: number of published states per second.
  StreamTurns(LiveSession& s, StateStream& stream, double rate);
  /// Reads the servo's event log. Publishes all new events, and the latest tick if enough time has passed since the
  /// last published tick.
  void turn();
  /// Publishes the last tick and the end of the session.
  void end();

 private:
  LiveSession& s_;
  StateStream& stream_;
  const Nanos interval_;
  std::vector<std::string> tools_;
  EventLog<ServoEvent>::Reader servo_;
  bool begun_ = false;
  Nanos told_ = 0;  // ns, time at which a state was last published
  ServoTick tick_;  // the latest tick in the event log
  // number of ticks that the event log no longer contained; 1 + index of the latest tick
  std::uint64_t lost_ = 0, next_ = 0;
};

/// Runs the servo loop at the rate of the hand. The force is zero when it returns.
void servo_thread(LiveSession& s, haptics::HapticDevice& hand);
/// Owns the tissue. Repeats the servo's cuts on it, copies the tissue around the tool for the servo, meshes its
/// changes, and executes undo. Ends the session if memory is exhausted.
void carver_thread(LiveSession& s);
/// Writes the events in the event logs to the file.
void recorder_thread(LiveSession& s, SessionRecorder& recorder);
/// Publishes the session's state until all other threads have ended.
void stream_thread(LiveSession& s, StreamTurns& turns);

}  // namespace typodont
