// The data of a live session, and the loops of the threads that work on it. Each thread has its own file in this
// folder, and they communicate only through wiring.h. The workbench starts and joins the threads and draws.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/hands/hands.h"
#include "engine/app/recording/session_record.h"
#include "engine/app/scene.h"
#include "engine/app/sound_link.h"
#include "engine/app/stream/state_stream.h"
#include "engine/app/tissue/stroke_book.h"
#include "engine/app/wiring.h"
#include "engine/session/recorder.h"
#include "haptics/carver.h"
#include "haptics/force_delay.h"
#include "haptics/haptic_device.h"
#include "haptics/servo.h"
#include "haptics/work.h"

namespace typodont {

/// The data of a session. It outlives the threads, which have references to the data. A member marked SERVO, CARVER
/// or RECORDER is used only by that thread until the thread has ended.
struct LiveSession {
  const Scene& scene;
  haptics::Carver carver;
  Wiring wiring;
  std::optional<haptics::Servo> servo;       // created once the hand is known
  std::optional<haptics::ForceDelay> delay;  // SERVO: delays the force; empty if the session does not delay forces
  std::optional<LoopStatistics> loop;        // SERVO: statistics of the loop
  ServoTick last;                            // SERVO: the last tick
  double servo_cpu = 0;                      // SERVO: s, CPU time of the thread
  Nanos first_tick = 0;                      // SERVO: ns, time at which the first tick was finished
  std::uint32_t faults = 0;
  bool draw = false, record = false, debris = false, operated = false;
  bool steered = false;  // true: the newest tick is read even if nothing is drawn
  bool watched = false;  // true: bricks are also sent to the operator's picture; the other copy goes to the headset
  StrokeHistory book;    // CARVER: the changes that each stroke made
  std::string carver_failure;        // CARVER: reason for a failure of the carver
  Nanos mesh_interval = 16'000'000;  // ns, time between searches for changed bricks; not shorter than a frame
  std::size_t xr_stream = 0;         // index of the recorded stream for a headset's frames
  std::size_t picture_stream = 0;    // index of the recorded stream for a screen's frames
  SoundLink* sound = nullptr;
  std::size_t left_stream = 0;             // index of the recorded stream for a second hand
  std::optional<std::size_t> head_stream;  // index of the recorded stream for the head's position, if there is a screen
  std::optional<std::size_t> water_stream;  // index of the recorded stream for water and suction, if there is debris
  std::optional<TickNotes> notes;           // RECORDER: notes derived from the ticks; empty without recording
  std::filesystem::path save;               // file to which the tissue is saved
  // CARVER: counts of the carver's work
  std::uint64_t bricks_meshed = 0, triangles_made = 0, voxels_cut = 0;
  haptics::SearchCounts looks;                      // CARVER: number of searches by the contact model
  std::shared_ptr<const haptics::SoftSurface> gum;  // the soft gum; null if the gum is rigid
  std::uint64_t queries = 0;                        // SERVO: number of queries of the distance field

  LiveSession(const Scene& s, haptics::TissueVolume tissue)
      : scene(s), carver(std::move(tissue), s.servo), wiring(carver) {}
  /// Creates the servo for the hand. `most_delay`: s, limit of the delay of the force that may be requested; 0: none
  /// may be requested.
  void serve(const haptics::DeviceInfo& hand, double most_delay = 0) {
    const haptics::ServoSettings settings = servo_settings(scene, carver.volume(), hand.rate, hand.vibration_band,
                                                           hand.position_step, hand.torque_limit > 0);
    servo.emplace(settings);
    gum = settings.soft;
    if (most_delay > 0) delay.emplace(settings, most_delay);
    loop.emplace(wiring, hand.rate);
  }
};

/// The servo's loop, turn by turn. Its thread calls turn() until turn() returns false, then end(). A test can call the
/// turns of all loops in any order.
class ServoTurns {
 public:
  /// `clock`: ns, any steady clock.
  ServoTurns(LiveSession& s, haptics::HapticDevice& hand, Nanos (*clock)() noexcept = now);
  /// One tick: reads the hand, computes contact and cut, writes the force, publishes the tick. Returns false at the
  /// end of the session.
  bool turn() noexcept;
  /// Ramps the force down and releases the hand.
  void end() noexcept;

 private:
  /// Sends the tick's force and torque to the hand.
  void send() noexcept;
  /// Sends the changes of the soft gum to the picture.
  void send_gum() noexcept;

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
  Nanos ticks_since_gum_ = 0;    // number of ticks since send_gum(), in ns
  std::size_t wounds_sent_ = 0;  // number of wounds that were sent to the picture
};

/// The carver's loop, turn by turn.
class CarverTurns {
 public:
  /// `between` is called between the steps of a turn; a test lets the servo continue there. Empty in a live session.
  explicit CarverTurns(LiveSession& s, std::function<void()> between = {});
  ~CarverTurns();
  struct Done {
    bool worked = false;   // the turn had work
    bool awaited = false;  // a patch is offered, and the servo has not adopted it yet
  };
  /// Repeats the servo's cuts, executes the user's commands, offers a patch if one is due, and meshes the changed
  /// bricks. Throws OpenVDB's exceptions.
  Done turn();
  /// Repeats the remaining cuts.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The recorder's loop, turn by turn.
class RecorderTurns {
 public:
  RecorderTurns(LiveSession& s, session::SessionWriter& writer) : s_(s), writer_(writer) {}
  /// Writes the contents of the rings to the file.
  void turn();

 private:
  LiveSession& s_;
  session::SessionWriter& writer_;
  render::View viewed_ = render::View::kLook;
  // the last state that was written to the log
  session::WriterStatus::State told_ = session::WriterStatus::State::kRecording;
};

/// The loop of the state stream, turn by turn: publishes the session's state to other programs.
class StreamTurns {
 public:
  /// `rate`: Hz, states per second. Creates the ring that the servo fills, so it must be constructed before the servo
  /// begins.
  StreamTurns(LiveSession& s, StateStream& stream, double rate);
  /// Empties the ring, and publishes new events and, if it is due, the latest tick.
  void turn();
  /// Publishes the last tick and the end of the session.
  void end();

 private:
  LiveSession& s_;
  StateStream& stream_;
  const Nanos interval_;
  std::vector<std::string> tools_;
  bool begun_ = false;
  Nanos told_ = 0;  // time of the last published state
  ServoTick tick_;  // the latest tick
};

/// Runs the servo loop at the rate of the hand. The force is zero when it returns.
void servo_thread(LiveSession& s, haptics::HapticDevice& hand);
/// Owns the tissue: repeats the servo's cuts on it, creates patches from it, meshes the changes, and executes undo. If
/// memory is exhausted, it ends the session.
void carver_thread(LiveSession& s);
/// Moves all data for the recording from the rings to the file.
void recorder_thread(LiveSession& s, session::SessionWriter& writer);
/// Publishes the session's state until all other threads have ended.
void stream_thread(LiveSession& s, StreamTurns& turns);

}  // namespace typodont
