// What a live session consists of, and the threads that work on it: each has a file of its own here, and they meet in
// wiring.h only. The workbench draws; it starts and joins them.
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

/// What a session consists of. Threads refer to it; it outlives them.
struct LiveSession {
  const Scene& scene;
  haptics::Carver carver;
  Wiring wiring;
  std::optional<haptics::Servo> servo;       // made for the hand, once that is known
  std::optional<haptics::ForceDelay> delay;  // servo thread; where the session may delay forces
  std::optional<LoopWatch> loop;             // servo thread until it has ended
  ServoTick last;                            // the same
  double servo_cpu = 0;                      // s, the same
  Nanos first_tick = 0;                      // when it was done, the same
  std::uint32_t faults = 0;
  bool draw = false, record = false, debris = false, operated = false;
  bool steered = false;              // somebody looks at the newest tick, also where nothing is drawn
  bool watched = false;              // bricks go to the operator too: the headset takes the others
  StrokeBook book;                   // carver thread until it has ended
  std::string carver_failure;        // the same: why it could not go on
  Nanos mesh_interval = 16'000'000;  // ns between looks for changed bricks: no more often than they are drawn
  std::size_t xr_stream = 0;         // which of the recording's streams a headset's frames are
  std::size_t picture_stream = 0;    // the same, of a picture on a screen
  SoundLink* sound = nullptr;
  std::size_t left_stream = 0;             // of the recording, where there is a second hand
  std::optional<std::size_t> head_stream;  // the same, where there is a screen
  std::optional<TickNotes> notes;          // recorder thread, where recorded
  std::filesystem::path save;              // of the tissue
  std::uint64_t bricks_meshed = 0, triangles_made = 0, voxels_cut = 0;  // carver thread until it has ended
  haptics::ModelLooks looks;                                            // the same
  std::uint64_t queries = 0;                                            // servo thread until it has ended

  LiveSession(const Scene& s, haptics::TissueVolume tissue)
      : scene(s), carver(std::move(tissue), s.servo), wiring(carver) {}
  /// `most_delay`: s that the force may be asked to reach the hand late; 0: never.
  void serve(const haptics::DeviceInfo& hand, double most_delay = 0) {
    const haptics::ServoSettings settings = servo_settings(scene, carver.volume(), hand.rate, hand.vibration_band,
                                                           hand.position_step, hand.torque_limit > 0);
    servo.emplace(settings);
    if (most_delay > 0) delay.emplace(settings, most_delay);
    loop.emplace(wiring, hand.rate);
  }
};

/// The servo's loop, turn by turn. Its thread calls turn() until that is false, then end(); a test calls them between
/// the turns of the others, in any order.
class ServoTurns {
 public:
  /// `clock`: ns, any steady clock.
  ServoTurns(LiveSession& s, haptics::HapticDevice& hand, Nanos (*clock)() noexcept = now);
  /// One tick: reads the hand, feels, cuts, writes the force, tells everyone. False when the session is over.
  bool turn() noexcept;
  /// Fades the force and lets the hand go.
  void end() noexcept;

 private:
  /// The tick's force and torque to the hand.
  void send() noexcept;

  LiveSession& s_;
  haptics::HapticDevice& hand_;
  Nanos (*clock_)() noexcept;
  const Nanos period_;
  haptics::HandSample sample_;
  SessionSettings settings_;
  PedalLock pedal_;
  ServoTick tick_;
  Cut cut_;
  std::uint64_t ticks_ = 0;
};

/// The carver's loop, turn by turn.
class CarverTurns {
 public:
  /// `between`: called between the steps of a turn; a test lets the servo go on there. Empty in a live session.
  explicit CarverTurns(LiveSession& s, std::function<void()> between = {});
  ~CarverTurns();
  struct Done {
    bool worked = false;   // there was something to do
    bool awaited = false;  // a patch is offered, and the servo has not taken it yet
  };
  /// Repeats the servo's cuts, obeys the user, offers a patch where one is due, meshes. Throws what OpenVDB throws.
  Done turn();
  /// Repeats the cuts that are left.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The recorder's loop, turn by turn.
class RecorderTurns {
 public:
  RecorderTurns(LiveSession& s, session::SessionWriter& writer) : s_(s), writer_(writer) {}
  /// Empties the rings into the file.
  void turn();

 private:
  LiveSession& s_;
  session::SessionWriter& writer_;
  render::View viewed_ = render::View::kLook;
  session::WriterStatus::State told_ = session::WriterStatus::State::kRecording;  // the last state that was logged
};

/// The stream's loop, turn by turn: what others are told of the session.
class StreamTurns {
 public:
  /// `rate`: states a second, Hz. Makes the ring from the servo: before that has begun.
  StreamTurns(LiveSession& s, StateStream& stream, double rate);
  /// Empties the ring, tells of what began since, and of the newest tick where one is due.
  void turn();
  /// The last tick, and the session's end.
  void end();

 private:
  LiveSession& s_;
  StateStream& stream_;
  const Nanos interval_;
  std::vector<std::string> tools_;
  bool begun_ = false;
  Nanos told_ = 0;  // time of the last state
  ServoTick tick_;  // the newest
};

/// Reads the hand, whose pace is the clock; feels, cuts, writes the force. Zero force when it returns.
void servo_thread(LiveSession& s, haptics::HapticDevice& hand);
/// Owns the tissue: repeats the servo's cuts on it, cuts patches out of it, meshes what changed, undoes. Where it
/// cannot go on, for want of memory, it ends the session.
void carver_thread(LiveSession& s);
/// Takes everything that is recorded out of its rings and to the file.
void recorder_thread(LiveSession& s, session::SessionWriter& writer);
/// Tells others of the session until all other threads have ended.
void stream_thread(LiveSession& s, StreamTurns& turns);

}  // namespace typodont
