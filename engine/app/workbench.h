// A live session: every part on its own thread, joined by the channels of wiring.h. Which parts run is the scene's
// choice; a part that is not named costs nothing.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/picture/look.h"
#include "engine/app/scene.h"
#include "engine/app/task/task.h"
#include "engine/app/wiring.h"
#include "engine/app/work_counts.h"
#include "engine/contract/loop_timing.h"
#include "engine/debris/debris.h"
#include "engine/display/head_tracker.h"
#include "engine/display/output.h"
#include "engine/session/score.h"
#include "haptics/haptic_device.h"

namespace typodont {

struct WorkbenchOptions {
  std::string rig;                  // file or name; empty: a window where there is a desktop, otherwise no picture
  std::string hand;                 // address; empty: the rig's, else the mouse where there is a window
  std::string left_hand;            // address; empty: the rig's, else no second hand
  std::string pedal;                // "auto", "none", a path or a serial; empty: the rig's, else auto
  double rate = 1000;               // Hz, of hands whose rate is ours to choose
  std::string audio;                // address; empty: a sound card where there is one
  std::filesystem::path record;     // empty: not recorded
  std::vector<std::string> stream;  // addresses where others are told of it (stream/state_stream.h); empty: nowhere
  double stream_rate = 100;         // Hz, of what they are told
  std::filesystem::path touches;    // where pairs for `calibrate register` go, of a headset's controller and an arm
  double magnify = 0;               // the picture, instead of what the rig says; 0: as the rig says
  double seconds = 1e18;            // end by itself after so long
  bool no_real_time = false;        // a hand with motors is used even where the system refuses real time
  bool explain = false;             // say what is active, and why the rest is not
  std::filesystem::path save;       // the tissue goes there at the end, and when asked for; empty: nowhere
  bool save_at_end = true;          // else only when asked for
  std::string trainee;              // for the recording
  int monitor = -1;                 // full screen on this one; −1: a window on the desktop

  // An experiment (engine/app/experiment/).
  bool steered = false;   // status() has the newest tick, also where nothing is drawn; hint() says what say() was told
  double most_delay = 0;  // s that the force may be asked to reach the hand late (SessionSettings); 0: never

  // The operator's window (engine/app/operator/).
  bool operated = false;          // keeps the score and the timing at hand
  bool embedded = false;          // the picture is shown in the operator's window, not in one of its own
  gpu::Device* device = nullptr;  // the operator's; null: one of its own
};

/// What a report tells of the loop that feels, as LoopReport has it.
struct LoopGranted {
  bool fifo = false, pinned = false, memory_locked = false;
};

/// How a session stands, for who watches it.
/// Where an exercise in implant surgery stands.
struct ImplantStatus {
  std::size_t phase = 0;  // that is due; as many as there are where all are over
  session::ImplantNote note = session::ImplantNote::kNone;
  double depth = 0;         // m of the tip below the plan's entry
  double phase_depth = 0;   // m that this phase asks for
  double speed = 0;         // rad/s of the tool in the hand at full pedal
  double temperature = 37;  // °C of the bone, estimated
};

struct WorkbenchStatus {
  double seconds = 0;
  ServoTick tick;            // the newest
  std::uint32_t faults = 0;  // bits seen in the last second
  double caught = 0;         // m from the hand to a tool that has not come after it for a second; 0: it follows
  LoopTiming timing;
  double frame_ms = 0, frames_per_second = 0;  // of the picture, smoothed
  std::string_view quality;
  std::uint64_t frames = 0;
  RecordState record;
  TissueState tissue;
  std::uint32_t saved = 0, not_saved = 0;  // times the tissue was saved when asked for, and could not be
  std::uint64_t own_frames = 0;            // of the picture from a viewpoint of one's own
  double motor_heat = 0;                   // 1: all the device's motors bear
  double bearable_force = 0;               // N, while they are so warm; 0: the device does not say
  bool armed = true;                       // force may flow: the hand has been free of contact
  LoopGranted granted;                     // what the system granted the loop that feels
  std::string_view real_time;              // what it did not, in words; empty: all is granted
  std::optional<ImplantStatus> implant;    // of an exercise in implant surgery
};

struct WorkbenchSummary {
  double seconds = 0;
  std::uint64_t ticks = 0, frames = 0, cuts = 0;
  std::uint32_t faults = 0;                    // bits seen
  double first_tick_s = 0, first_frame_s = 0;  // since the command; 0: there was none
  std::uint64_t deadline_misses = 0;
  double tick_us_median = 0, tick_us_p999 = 0, worst_tick_us = 0;
  double jitter_us_p999 = 0, worst_jitter_us = 0;  // |time between two wake-ups - period|
  LoopReport loop;                                 // the same in full, what was granted, how warm the motors were
  PerTissue removed{};
  std::optional<display::HeadTracker::Stats> tracker;  // where a rig's tracker was listened to
  std::optional<debris::DebrisLedger> debris;          // where the scene has debris and something was drawn
  std::uint64_t debris_cuts_lost = 0;  // that its ring had no room for: their chips are in nobody's account
  std::vector<std::string> explanations;
  WorkCounts work;
};

class PictureStage;
class LiveViews;

/// One session. Its user's thread draws: constructed, started, stepped and stopped there. Every end, the destructor's
/// too, sends zero force.
class Workbench {
 public:
  /// Set-up: tissue, hand, sound, recording, picture. Nothing moves yet. Throws Error.
  Workbench(const Scene& scene, const WorkbenchOptions& options);
  ~Workbench();
  Workbench(const Workbench&) = delete;
  Workbench& operator=(const Workbench&) = delete;

  void start();
  /// What the user did, and a frame; or a short wait where there is no picture. False when the session is over: the
  /// window was closed, the hand's script has ended, the time is up, the process was asked to stop.
  bool step();
  /// The same, where the picture is embedded: what the user does over it, and its size.
  bool step(const display::UserInput& input, glm::ivec2 picture_size);
  /// Takes effect in the next tick.
  void set(const SessionSettings& settings);
  const SessionSettings& settings() const;
  /// Its place in the tray; taken up as soon as pedal, drill and tissue allow.
  void choose_tool(int place);
  /// In an implant exercise: the instrument of the phase that is due, at its speed, forwards.
  void choose_phase_tool();
  /// Only where not recorded: a recording holds cuts, not paint.
  void paint(const BrushMove& move);
  /// After stop(): what was painted and not taken back.
  std::vector<PaintStroke> painted() const;
  /// Another colour of a tissue, sRGB, in all pictures. They are made anew.
  void color(Tissue tissue, const dvec3& color);

  /// What may be looked at while the session runs; null where not operated.
  LiveViews* views();
  /// A second picture from a viewpoint of one's own, on the operator's device: that is shown instead of the trainee's
  /// where both would lie in one window. Pixels of 0: no more.
  void look_from(const Viewpoint& from, glm::ivec2 pixels);
  /// That picture; null while there is none.
  const gpu::Image* own_picture() const;
  /// After stop(), once: the tissue as it was left.
  haptics::TissueVolume take_tissue();
  /// The device of an embedded picture is about to go, or is lost: the session goes on without one …
  void drop_picture();
  /// … until there is another.
  void make_picture(gpu::Device& device);
  /// The keys that were pressed in the last step(), as display::UserInput has them.
  const std::vector<int>& pressed() const;
  /// Where steered: the line below the picture, instead of what the keys do.
  void say(const std::string& line);
  /// No force and no session from the next tick on, whatever the tool touches; where the servo does not answer within
  /// 50 ms, every device is released from here. stop() still completes the recording.
  void emergency_stop();

  /// By SIGINT, SIGTERM or SIGHUP: whoever runs the session should end too.
  static bool asked_to_stop();

  WorkbenchStatus status();
  /// By the scene's rules, from what was measured up to now. Only where operated.
  session::Score score_so_far();
  /// After stop(), once, where operated: what its score needs beside the tissue.
  FinishedHand take_hand();
  const haptics::DeviceInfo& hand() const;
  bool recording() const;
  /// The picture's device, left eye's picture and look; null where nothing is drawn.
  PictureStage* stage();

  /// The emergency key: no drill and no force until it is let go on again (hands.h).
  void hold(bool on) noexcept;
  /// A stroke back or again, or the tissue saved as it is; done by the carver within its next turn. From the drawing
  /// thread.
  void ask(TissueCommand command);
  /// Strokes that can be taken back and brought again.
  haptics::TissueVolume::Strokes strokes();
  bool held() const;
  /// Zero force, all threads joined, the recording complete. Throws RunFailure when the run failed.
  WorkbenchSummary stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A whole session: runs until the window closes, the hand's script ends, the time is over or the process is asked to
/// stop (SIGINT, SIGTERM, SIGHUP). Every end sends zero force. Throws Error at set-up, RunFailure when the run fails.
WorkbenchSummary run_workbench(const Scene& scene, const WorkbenchOptions& options);

}  // namespace typodont
