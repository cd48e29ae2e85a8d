// A live session. Every part runs on its own thread; the channels of wiring.h connect the threads. The scene selects
// the parts; an unused part costs nothing.
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
#include "engine/app/wiring.h"
#include "engine/app/work_counts.h"
#include "engine/contract/loop_timing.h"
#include "engine/display/head_tracker.h"
#include "engine/display/output.h"
#include "engine/session/score.h"
#include "engine/session/strings.h"
#include "haptics/haptic_device.h"

namespace typodont {

struct WorkbenchOptions {
  std::string rig;        // rig file or name; empty: a window if there is a desktop, otherwise no picture
  std::string hand;       // address of the hand; empty: the rig's value, otherwise the mouse if there is a window
  std::string left_hand;  // address of the second hand; empty: the rig's value, otherwise no second hand
  std::string pedal;      // "auto", "none", a path or a serial number; empty: the rig's value, otherwise "auto"
  double rate = 1000;     // Hz, servo rate for hands without a fixed rate
  std::string audio;      // address of the sound output; empty: a sound card if there is one
  bool binaural = false;  // two channels of sound for the trainee's ears, from where the tool is
  std::filesystem::path record;     // file of the recording; empty: no recording
  std::vector<std::string> stream;  // addresses at which the state is published (stream/state_stream.h); empty: none
  double stream_rate = 100;         // Hz, rate of the published states
  // output file of point pairs for `calibrate register`, taken with a controller and an arm
  std::filesystem::path touches;
  double magnify = 0;          // magnification of the picture; 0: the rig's value
  double seconds = 1e18;       // s, time after which the session ends
  bool no_real_time = false;   // allows a device with motors without real-time scheduling
  bool explain = false;        // prints which features are active, and why others are not
  std::filesystem::path save;  // file for the tissue, written at the end and on request; empty: none
  bool save_at_end = true;     // true: the tissue is saved at the end and on request; false: only on request
  std::string trainee;         // the trainee's name, for the recording
  int monitor = -1;            // monitor for full screen; −1: a window
  session::Language language = session::Language::kEnglish;  // language of the text over the picture

  // Options of an experiment (engine/app/experiment/).
  // status() has the newest tick even if nothing is drawn; hint() gives the text of say(); no picture shows the force
  bool steered = false;
  double most_delay = 0;  // s, upper limit of SessionSettings::force_delay; 0: the session does not delay forces

  // Options of the operator's window (engine/app/operator/).
  bool operated = false;          // provides score and timing during the session
  bool embedded = false;          // the picture is shown in the operator's window instead of its own
  gpu::Device* device = nullptr;  // the operator's device; null: create one
};

/// The real-time rights of the servo loop, as in LoopReport.
struct LoopGranted {
  bool fifo = false, pinned = false, memory_locked = false;
};

/// Progress of an exercise in implant surgery, for display.
struct ImplantStatus {
  std::size_t phase = 0;  // index of the present phase; when all phases are finished, the number of phases
  session::ImplantNote note = session::ImplantNote::kNone;
  double depth = 0;         // m, depth of the tip below the plan's entry
  double phase_depth = 0;   // m, required depth in this phase
  double speed = 0;         // rad/s, speed of the present tool at full pedal
  double temperature = 37;  // °C of the bone, estimated
};

struct WorkbenchStatus {
  double seconds = 0;
  ServoTick tick;            // the latest tick
  std::uint32_t faults = 0;  // fault bits that were set in the last second
  // m, distance between hand and tool if the tool has not followed the hand for a second; otherwise 0
  double caught = 0;
  LoopTiming timing;
  double frame_ms = 0, frames_per_second = 0;  // timing of the picture, smoothed
  std::string_view quality;
  std::uint64_t frames = 0;
  RecordState record;
  TissueState tissue;
  std::uint32_t saved = 0, not_saved = 0;  // number of requested saves that succeeded, and that failed
  std::uint64_t own_frames = 0;            // number of frames from a free viewpoint
  double motor_heat = 0;                   // heat of the device's motors; 1: their limit
  double bearable_force = 0;               // N, force limit at the present heat; 0: the device does not report it
  bool armed = true;                       // force is enabled, because the hand has been free of contact
  LoopGranted granted;                     // real-time rights that the system granted to the servo loop
  std::string_view real_time;              // names the rights that were refused; empty: all were granted
  std::optional<ImplantStatus> implant;    // progress of an exercise in implant surgery
};

struct WorkbenchSummary {
  double seconds = 0;
  std::uint64_t ticks = 0, frames = 0, cuts = 0;
  std::uint32_t faults = 0;  // s since the command was given: first tick, first frame; 0: there was none
  // s, times from the command to the first tick and frame; 0: there was none
  double first_tick_s = 0, first_frame_s = 0;
  std::uint64_t deadline_misses = 0;
  double tick_us_median = 0, tick_us_p999 = 0, worst_tick_us = 0;
  double jitter_us_p999 = 0, worst_jitter_us = 0;  // µs, |time between two wake-ups - period|
  LoopReport loop;                                 // the complete loop report
  PerTissue removed{};
  std::optional<display::HeadTracker::Stats> tracker;  // statistics of the head tracker; empty if there is none
  std::optional<DebrisBalance> debris;                 // balance of chips and water; empty without debris or picture
  std::uint64_t debris_cuts_lost = 0;                  // cuts whose chips are missing because the ring was full
  std::vector<std::string> explanations;
  WorkCounts work;
};

class PictureStage;
class LiveViews;

/// One session. A single thread of the caller constructs, starts, steps and stops the session, and draws. Every end,
/// including the destructor, sends zero force.
class Workbench {
 public:
  /// Sets up tissue, hand, sound, recording and picture. Nothing moves yet. Throws Error.
  Workbench(const Scene& scene, const WorkbenchOptions& options);
  ~Workbench();
  Workbench(const Workbench&) = delete;
  Workbench& operator=(const Workbench&) = delete;

  void start();
  /// Processes the input and draws a frame; if there is no picture, waits briefly. Returns false at the end of the
  /// session: the window was closed, the hand's script has ended, the time is over, or the process was asked to stop.
  bool step();
  /// Same as step(), for an embedded picture: the caller passes the input over the picture and the picture's size.
  bool step(const display::UserInput& input, glm::ivec2 picture_size);
  /// Applies the settings from the next tick on.
  void set(const SessionSettings& settings);
  const SessionSettings& settings() const;
  /// Requests a tool by its index in the set; the tool changes as soon as pedal, drill and tissue allow it.
  void choose_tool(int place);
  /// Requests the instrument of the present phase of an implant exercise, with its speed and forward rotation.
  void choose_phase_tool();
  /// Paints tissue. Only without recording, because a recording contains cuts but no paint.
  void paint(const BrushMove& move);
  /// Returns the brush strokes that are not undone. Call this function after stop().
  std::vector<PaintStroke> painted() const;
  /// Changes the colour (sRGB) of a tissue in all pictures and draws them again.
  void color(Tissue tissue, const dvec3& color);

  /// The views of the running session; null if the session is not operated.
  LiveViews* views();
  /// Shows a second picture from a free viewpoint, on the operator's device. It replaces the trainee's picture if both
  /// would be in one window. A size of 0 switches the picture off.
  void look_from(const Viewpoint& from, glm::ivec2 pixels);
  /// The picture from the free viewpoint; null if it is not drawn.
  const gpu::Image* own_picture() const;
  /// Returns the final tissue. Call this function once, after stop().
  haptics::TissueVolume take_tissue();
  /// Call this function before the device of an embedded picture is destroyed, or when it is lost. The session
  /// continues without a picture.
  void drop_picture();
  /// Creates the pictures again on a new device.
  void make_picture(gpu::Device& device);
  /// The keys that were pressed in the last step(), numbered as in display::UserInput.
  const std::vector<int>& pressed() const;
  /// Sets the line below the picture in a steered session; it replaces the help text about the keys.
  void say(const std::string& line);
  /// Sends no force from the next tick on and ends the session, regardless of contact. If the servo does not answer
  /// within 50 ms, this function releases all devices. stop() still completes the recording.
  void emergency_stop();

  /// True after SIGINT, SIGTERM or SIGHUP; the caller should then end, too.
  static bool asked_to_stop();

  WorkbenchStatus status();
  /// Score by the scene's rules from the measures so far. Only valid if WorkbenchOptions::operated is set.
  session::Score score_so_far();
  /// Returns the data that the score of a session in the operator's window needs, except the tissue. Call this
  /// function once, after stop().
  FinishedHand take_hand();
  const haptics::DeviceInfo& hand() const;
  bool recording() const;
  /// The stage of the picture: device, left eye, frame; null if nothing is drawn.
  PictureStage* stage();

  /// Switches the emergency stop on or off. While it is on, drill and force are off (hands.h).
  void hold(bool on) noexcept;
  /// Requests undo, redo or saving of the tissue; the carver executes it in its next turn. Drawing thread.
  void ask(TissueCommand command);
  /// Numbers of strokes that can be undone and redone.
  haptics::TissueVolume::Strokes strokes();
  bool held() const;
  /// Sends zero force, joins all threads, and completes the recording. Throws RunFailure if the run failed.
  WorkbenchSummary stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Runs a whole session until the window is closed, the hand's script ends, the time is over or the process is asked to
/// stop (SIGINT, SIGTERM, SIGHUP). Every end sends zero force. Throws Error at set-up, RunFailure if the run fails.
WorkbenchSummary run_workbench(const Scene& scene, const WorkbenchOptions& options);

}  // namespace typodont
