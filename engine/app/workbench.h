// A live session. Each part runs on its own thread; the channels of wiring.h connect the threads. The scene selects the
// parts. An unused part takes no time.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/picture/debris_view.h"
#include "engine/app/picture/look.h"
#include "engine/app/scene.h"
#include "engine/app/task/task.h"
#include "engine/app/task/warnings.h"
#include "engine/app/wiring.h"
#include "engine/app/work_counts.h"
#include "engine/base/progress.h"
#include "engine/contract/loop_timing.h"
#include "engine/display/head_tracker.h"
#include "engine/display/output.h"
#include "engine/session/score.h"
#include "engine/session/session_data.h"
#include "engine/session/strings.h"
#include "haptics/haptic_device.h"

namespace typodont {

struct WorkbenchOptions {
  std::string rig;  // rig file or name of a rig; empty: a window if there is a desktop, otherwise no picture
  /// Address of the hand's device; empty: the rig file's hand, otherwise a window's mouse.
  std::string hand;
  /// Address of the second hand's device; empty: the rig file's second hand, if it names one.
  std::string left_hand;
  /// Foot pedal: "auto", "none", a path or a serial number; empty: the pedal in the rig file, otherwise "auto".
  std::string pedal;
  double rate = 1000;            // Hz, servo rate for hands without a fixed rate
  std::string audio;             // address of the sound output; empty: a sound card, if any
  bool binaural = false;         // true: two sound channels for headphones; the tool is the position of the source
  std::filesystem::path record;  // file of the recording; empty: no recording
  /// Addresses at which the session's state is published (live/state_stream.h); empty: it is not published.
  std::vector<std::string> stream;
  double stream_rate = 100;  // Hz, rate at which states are published
  // File for point pairs, measured with a controller and an arm, for `calibrate register`.
  std::filesystem::path touches;
  std::string quality;         // name of the picture's quality level; empty: chosen from the drawing times of frames
  double magnify = 0;          // magnification of the picture; 0: the rig file's value
  double seconds = 1e18;       // s, time after which the session ends
  bool no_real_time = false;   // true: allows a device with motors without real-time scheduling
  bool explain = false;        // true: prints why features are or are not active
  std::filesystem::path save;  // file for the tissue; empty: not saved
  bool save_at_end = true;     // true: the tissue is saved at the end and on request; false: only on request
  std::string trainee;         // the trainee's name, which the recording contains
  int monitor = -1;            // monitor number for full screen; −1: no full screen
  session::Language language = session::Language::kEnglish;  // language of the text over the picture
  session::WarningLevels warnings;                           // levels of the trainee's warnings; empty: none

  // For experiments (engine/app/experiment/). True: status() contains the newest tick even if nothing is drawn; the
  // picture shows the text of say() instead of the keys, and does not show the force.
  bool steered = false;
  double max_delay = 0;  // s, maximum of SessionSettings::force_delay; 0: the session cannot delay forces

  // The next options are for the operator's window (engine/app/operator/).
  bool operated = false;  // true: score and timing are computed during the session
  /// True: the operator's window shows the picture. False: the picture has its own window.
  bool embedded = false;
  gpu::Device* device = nullptr;  // GPU device of the operator's window; null: the session creates a device
};

/// Real-time rights granted to the servo loop (see LoopReport).
struct LoopGranted {
  bool fifo = false, pinned = false, memory_locked = false;
};

/// Progress of an implant exercise, for display.
struct ImplantStatus {
  std::size_t phase = 0;  // index of the current phase; after the last phase: the number of phases
  session::ImplantNote note = session::ImplantNote::kNone;
  double depth = 0;         // m, depth of the tool's tip below the planned entry
  double phase_depth = 0;   // m, depth that this phase requires
  double speed = 0;         // rad/s, speed of the current tool at full pedal
  double temperature = 37;  // °C, estimated temperature of the bone
};

struct WorkbenchStatus {
  double seconds = 0;
  ServoTick tick;            // the latest tick of the servo
  std::uint32_t faults = 0;  // faults of the last second, as bits (enum Fault)
  // Distance between hand and tool if the tool has not followed the hand for one second, m; otherwise 0.
  double caught = 0;
  LoopTiming timing;
  /// Smoothed drawing time of a frame, ms; smoothed number of frames per second.
  double frame_ms = 0, frames_per_second = 0;
  std::string_view quality;
  /// Text about the quality level and what would improve the picture; empty: nothing to say.
  std::string quality_notice;
  std::uint64_t frames = 0;
  RecordState record;
  TissueState tissue;
  std::uint32_t saved = 0, not_saved = 0;  // number of requested saves that succeeded, and that failed
  std::uint64_t own_frames = 0;            // number of frames that were drawn from the free viewpoint
  double motor_heat = 0;                   // heat of the device's motors, as a fraction of the largest allowed heat
  /// Force limit at the current heat of the motors, N; 0: the device does not report it.
  double bearable_force = 0;
  bool armed = true;    // true: the device may push the hand, because the hand has been free of contact
  LoopGranted granted;  // real-time rights that the system granted to the servo loop
  /// Names of refused real-time rights; empty: all were granted.
  std::string_view real_time;
  std::int32_t chosen_tool = -1;         // index of the tool that was chosen last; negative: none
  Warning warning = Warning::kNone;      // the warning over the picture
  std::optional<ImplantStatus> implant;  // progress of an implant exercise; empty in other exercises
};

struct WorkbenchSummary {
  double seconds = 0;
  std::uint64_t ticks = 0, frames = 0, cuts = 0;
  std::uint32_t faults = 0;  // all faults of the session, as bits (enum Fault)
  // Time from the start of the program to the first tick, and to the first frame, s; 0: no tick, or no frame.
  double first_tick_s = 0, first_frame_s = 0;
  std::uint64_t deadline_misses = 0;
  double tick_us_median = 0, tick_us_p999 = 0, worst_tick_us = 0;
  /// Deviation of the time between two wake-ups of the servo from its period, µs: 99.9 % quantile, and largest.
  double jitter_us_p999 = 0, worst_jitter_us = 0;
  LoopReport loop;  // complete report about the servo loop
  PerTissue removed{};
  std::optional<display::HeadTracker::Stats> tracker;  // statistics of the head tracker; empty: none
  /// Mass balance of chips and water; empty without debris or picture.
  std::optional<DebrisBalance> debris;
  std::vector<std::string> explanations;
  WorkCounts work;
};

class PictureStage;
class LiveViews;

/// A live session. One thread of the caller starts, steps and stops it, and draws. However the session ends, even by
/// the destructor, the force is set to zero.
class Workbench {
 public:
  /// Sets up tissue, hand, sound and recording, without the GPU. No servo runs yet. `progress`: receives the progress
  /// of this work, and can cancel it; may be null. An emergency stop stays in force. Any thread. Throws Error, and
  /// Cancelled.
  Workbench(const Scene& scene, const WorkbenchOptions& options, Progress* progress = nullptr);
  ~Workbench();
  Workbench(const Workbench&) = delete;
  Workbench& operator=(const Workbench&) = delete;

  /// Opens the pictures and the session's own window, if any, and starts the carver. Call once. Throws Error.
  void open();
  /// Call after open(), until it returns true. Draws a first picture; starts the session's time as soon as the pictures
  /// show the tissue, and then returns true. `picture_size`: pixels, size of the picture in the operator's window. If a
  /// call of open() or begin() throws, only the destructor may be called.
  bool begin(glm::ivec2 picture_size = {0, 0});
  /// Calls open(), and begin() until the session's time runs.
  void start();
  /// Processes input and draws a frame; without a picture, waits for a short time. Returns false at the session's end:
  /// window closed, hand's script ended, time over, or the process asked to stop.
  bool step();
  /// Does the same as step() above for a picture in the operator's window. `input`: input over the picture.
  /// `picture_size`: pixels.
  bool step(const display::UserInput& input, glm::ivec2 picture_size);
  /// Sets new settings, which apply from the next tick on.
  void set(const SessionSettings& settings);
  const SessionSettings& settings() const;
  /// Requests the tool with the index `place` in the tool set. The servo changes the tool when the pedal is released,
  /// the drill stands still and the tool touches nothing.
  void choose_tool(int place);
  /// Requests the instrument of the current phase of an implant exercise, and sets its speed and forward rotation.
  void choose_phase_tool();
  /// Paints tissue with a part of a brush stroke. Ignored if the session is recorded: recordings contain no paint.
  void paint(const BrushMove& move);
  /// The instructor's brush strokes in order, without undone ones. Call after stop().
  std::vector<PaintStroke> painted() const;

  /// Sections, inner tissues and score, for pictures of the running session; null: no window shows the session.
  LiveViews* views();
  /// Draws a second picture from a free viewpoint, on the GPU device of WorkbenchOptions::device. If `embedded` is
  /// true, only this picture is drawn, without the trainee's. A size of 0 switches the second picture off.
  void look_from(const Viewpoint& from, glm::ivec2 pixels);
  /// Picture from the free viewpoint; null: not drawn.
  const gpu::Image* own_picture() const;
  /// The final tissue. Call once, after stop().
  haptics::TissueVolume take_tissue();
  /// Frees the picture in the operator's window. Call before its GPU device is destroyed, or when the device is lost.
  /// The session continues without a picture.
  void drop_picture();
  /// Creates the pictures again on a new GPU device.
  void make_picture(gpu::Device& device);
  /// The keys that were pressed in the last step(), with the codes of display::UserInput.
  const std::vector<int>& pressed() const;
  /// Sets the line of text below the picture during an experiment. It replaces the help about the keys.
  void say(const std::string& line);
  /// Sets the force to zero from the next tick on and ends the session, regardless of contact. If the servo does not
  /// answer within 50 ms, releases all devices. stop() must still be called to complete the recording.
  void emergency_stop();

  /// Returns true after the process received SIGINT, SIGTERM or SIGHUP. The caller should then end.
  static bool asked_to_stop();

  WorkbenchStatus status();
  /// Computes the score so far by the rules of the scene. Valid only if WorkbenchOptions::operated is true.
  session::Score score_so_far();
  /// The measured data of the hand, for the final score of a session in the operator's window. Call once, after stop().
  FinishedHand take_hand();
  const haptics::DeviceInfo& hand() const;
  bool recording() const;
  /// The PictureStage that draws the picture, with its GPU device and the left eye's picture; null if nothing is drawn.
  PictureStage* stage();

  /// Switches the emergency stop on or off. While it is on, drill and force are off (haptics/device_safety.h).
  void hold(bool on) noexcept;
  /// Requests undo, redo or saving of the tissue. The carver thread executes the request in the next pass of its loop.
  /// Render thread only.
  void ask(TissueCommand command);
  /// How many strokes can be undone, and how many redone.
  haptics::TissueVolume::Strokes strokes();
  bool held() const;
  /// Sends zero force, joins all threads and completes the recording. Throws RunFailure if the session failed.
  WorkbenchSummary stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Runs a whole session, until the window is closed, the hand's script has ended, the time is over, or the process is
/// asked to stop (SIGINT, SIGTERM, SIGHUP). At every end, the force is set to zero. Throws Error at set-up, RunFailure
/// if the session fails.
WorkbenchSummary run_workbench(const Scene& scene, const WorkbenchOptions& options);

}  // namespace typodont
