// Creates the data of a session file, except the ticks.
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

/// The header of a session: the complete scene and rig, hashes of their files, the hand, the initial volumes.
session::SessionHeader session_header(const Scene& scene, const std::filesystem::path& rig_file,
                                      const haptics::DeviceInfo& hand, const haptics::TissueVolume& tissue,
                                      double rate);

/// Stream of the second hand: pose and pedal, on the session's clock.
session::StreamSpec left_hand_stream();

/// Stream of the eyes in front of a screen, and of the view; one row per change.
session::StreamSpec head_stream();
/// Stream of the handpiece's water and of the suction (0 or 1); one row per change.
session::StreamSpec water_stream();
/// Name of a view: "look", "section", "xray", "difference".
std::string_view view_name(render::View view) noexcept;
/// Stream of the pictures on a screen; one row per frame.
session::StreamSpec picture_stream();
std::vector<double> picture_stream_row(const PictureTiming& timing);
/// Stream of the pictures in a headset; one row per frame.
session::StreamSpec xr_stream();
std::vector<double> xr_stream_row(const display::HmdTiming& timing);
/// Stream of the synthesizer's input, a hundred times per second.
session::StreamSpec sound_stream();

/// Derives events from the ticks: change of the tool, start of a fault, input of the sound. Must get every tick in
/// order. Used on the recorder's thread.
class TickNotes {
 public:
  /// `sound`: index of the sound's stream; empty if there is no sound.
  TickNotes(const Scene& scene, std::optional<std::size_t> sound);
  /// Adds a tick. `sound_latency`: s, time from a tick to its sound, NaN if unknown.
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

/// The result of a session: final volumes, distance to the pulp, hash of the distance field.
session::SessionResult session_result(const haptics::TissueVolume& tissue);

}  // namespace typodont
