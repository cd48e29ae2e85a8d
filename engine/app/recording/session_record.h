// Creates all data of a session file except the ticks.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "audio/tick_voice.h"
#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "engine/display/hmd.h"
#include "engine/render/renderer.h"
#include "engine/session/recorder.h"
#include "engine/session/session_data.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// Makes the header of a session: the complete scene and display rig, hashes of their files, the hand, and the volume
/// of each tissue at the start.
session::SessionHeader session_header(const Scene& scene, const std::filesystem::path& rig_file,
                                      const haptics::DeviceInfo& hand, const haptics::TissueVolume& tissue,
                                      double rate);

/// Describes the stream with pose and pedal of the second hand. Its times are those of the session's clock.
session::StreamSpec left_hand_stream();

/// Describes the stream with the position of the eyes in front of a screen, and with the view. It has one row per
/// change.
session::StreamSpec head_stream();
/// Describes the stream with the state (0 or 1) of the handpiece's water and of the suction. It has one row per change.
session::StreamSpec water_stream();
/// Returns the name of a view: "look" (normal), "section", "xray" or "difference".
std::string_view view_name(render::View view) noexcept;
/// Describes the stream with the frames on a screen. It has one row per frame.
session::StreamSpec picture_stream();
std::vector<double> picture_stream_row(const PictureTiming& timing);
/// Describes the stream with the frames in a headset. It has one row per frame.
session::StreamSpec xr_stream();
std::vector<double> xr_stream_row(const display::HmdTiming& timing);
/// Describes the stream with the input of the sound synthesizer. It has a hundred rows per second.
session::StreamSpec sound_stream();

/// Finds data in the ticks and writes them to the recording: changes of the tool, beginnings of faults, and the input
/// of the sound. It must receive every tick, in order. Recorder thread only.
class TickNotes {
 public:
  /// `sound`: index of the recorded stream for the sound; empty if there is no sound.
  TickNotes(const Scene& scene, std::optional<std::size_t> sound);
  /// Adds a tick. `sound_latency`: s, time from a tick to its sound; NaN if it is unknown.
  void add(const ServoTick& tick, session::SessionWriter& writer,
           double sound_latency = std::numeric_limits<double>::quiet_NaN()) noexcept;

 private:
  std::vector<std::string> tools_;
  std::optional<std::size_t> sound_;
  audio::TickVoice voice_;
  Nanos sounded_ = 0;
  bool first_ = true;
  std::uint32_t tool_ = 0;
  std::array<Nanos, 32> fault_seen_{};  // last time at which each fault bit was set
};

/// Makes the result of a session: volume of each tissue at the end, distance to the pulp, hash of the distance field.
session::SessionResult session_result(const haptics::TissueVolume& tissue);

}  // namespace typodont
