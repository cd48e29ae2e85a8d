// Writes a session to a file (.h5): its header, the events in its event logs, and its result.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "audio/tick_voice.h"
#include "engine/app/event_logs.h"
#include "engine/app/scene.h"
#include "engine/session/recorder.h"
#include "engine/session/session_data.h"
#include "engine/session/session_file.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// Makes the header of a session: the complete scene and display rig, hashes of their files, the hand, and the volume
/// of each tissue at the start.
session::SessionHeader session_header(const Scene& scene, const std::filesystem::path& rig_file,
                                      const haptics::DeviceInfo& hand, const haptics::TissueVolume& tissue,
                                      double rate);

/// Stream with pose and pedal of the second hand, with times of the session's clock.
session::StreamSpec left_hand_stream();

/// Stream with the eyes' positions in front of a screen, and the view. One row per change.
session::StreamSpec head_stream();
/// Stream with the state (0 or 1) of the handpiece's water and of the suction. One row per change.
session::StreamSpec water_stream();
/// A view's name: "look" (normal), "section", "xray", "difference" or "temperature".
std::string_view view_name(render::View view) noexcept;
/// Stream of frames on a screen. One row per frame.
session::StreamSpec picture_stream();
std::vector<double> picture_stream_row(const PictureTiming& timing);
/// Stream of frames in a headset. One row per frame.
session::StreamSpec xr_stream();
std::vector<double> xr_stream_row(const display::HmdTiming& timing);
/// Stream with the input of the sound synthesizer. A hundred rows per second.
session::StreamSpec sound_stream();

/// Makes the result of a session: final volume of each tissue, smallest distance from the cut to the pulp, field hash.
session::SessionResult session_result(const haptics::TissueVolume& tissue);

/// Converts an undo or redo to an event of the recording, and back. For other kinds of events, edit_of() returns an
/// empty optional. Throws Error if the event's text is damaged.
session::SessionEvent event_of(const StrokeEdit& edit);
std::optional<StrokeEdit> edit_of(const session::SessionEvent& event);

/// All undos and redos of a recording, in order.
std::vector<StrokeEdit> edits_of(const session::SessionReader& session);

/// Converts a separated piece of tissue to an event, and back, for pictures and reports; a replay computes the piece
/// again. For other kinds of events, piece_of() returns an empty optional. Throws Error if the event's text is damaged.
session::SessionEvent event_of(const LoosePiece& piece);
std::optional<LoosePiece> piece_of(const session::SessionEvent& event);

/// Reads all event logs of a session and writes its file. Only one thread at a time may use it.
class SessionRecorder {
 public:
  /// Records the second hand and the eyes' positions only if `header.streams` lists them. `sound_latency`: returns the
  /// time from a tick to its sound, s; empty: unknown. Throws Error.
  SessionRecorder(const std::filesystem::path& file, const Scene& scene, const session::SessionHeader& header,
                  const EventLogs& event_logs, const session::WriterOptions& options = {},
                  std::function<double()> sound_latency = {});
  /// For sessions without a clock. Equal input gives files with equal bytes. The file exists only after finish().
  /// Throws Error.
  SessionRecorder(const std::filesystem::path& file, const Scene& scene, const haptics::DeviceInfo& hand,
                  const haptics::TissueVolume& tissue, const EventLogs& event_logs, const std::string& trainee = {});

  /// Writes all new events.
  void turn();
  /// Completes the file and returns the hash of the tissue. Throws RunFailure if the file is not complete.
  std::uint64_t finish(const haptics::TissueVolume& tissue);

  /// The file's writer, for notes, and for finishing the file with more results. Call turn() before finishing.
  session::SessionWriter& writer() { return writer_; }

 private:
  /// Index of a stream in the header; empty if the header does not name it.
  using Stream = std::optional<std::size_t>;

  void store(const ServoTick& tick);
  /// Records changes of the tool and beginnings of faults as events, and stores the input of the sound synthesizer.
  void note(const ServoTick& tick);
  void store(const Cut& cut);
  void store(const PatchUse& use);
  void store(const StrokeEdit& edit);
  void store(const LoosePiece& piece);
  void store(const SeenFrom& seen);
  void store(const WaterSwitch& water);
  void store(const PictureTiming& timing);
  void store(const display::HmdTiming& timing);
  template <class Other>
  void store(const Other&) {}

  session::SessionWriter writer_;
  const std::vector<std::string> tools_;
  audio::TickVoice voice_;
  std::function<double()> sound_latency_;
  Stream sound_, left_, head_, water_, picture_, headset_;
  EventLog<ServoEvent>::Reader servo_;
  EventLog<CarverEvent>::Reader carver_;
  EventLog<ViewEvent>::Reader view_;
  EventLog<haptics::HandSample>::Reader hand_;
  EventLog<LoopReport>::Reader loop_;
  render::View viewed_ = render::View::kLook;
  bool noted_ = false;  // true after the first tick was recorded
  std::uint32_t tool_ = 0;
  Nanos sounded_ = 0;
  std::array<Nanos, 32> fault_seen_{};          // last time at which each fault bit was set
  std::uint64_t next_tick_ = 0, next_cut_ = 1;  // 1 + index of the last stored tick, and of the last stored cut
  std::uint64_t lost_ticks_ = 0, lost_cuts_ = 0;
};

}  // namespace typodont
