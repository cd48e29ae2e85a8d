// What the program writes into a session beside the ticks.
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

/// Scene and rig in full, hashes of the files they were made from, the hand, the volumes at the start.
session::SessionHeader session_header(const Scene& scene, const std::filesystem::path& rig_file,
                                      const haptics::DeviceInfo& hand, const haptics::TissueVolume& tissue,
                                      double rate);

/// Samples of the second hand: its pose as held and its pedal, on the session's clock.
session::StreamSpec left_hand_stream();

/// The eyes before a screen, and how the scene is shown; a row whenever that changed.
session::StreamSpec head_stream();
/// "look", "section", "xray", "difference".
std::string_view view_name(render::View view) noexcept;
/// The picture of a session on a screen: one row a frame.
session::StreamSpec picture_stream();
std::vector<double> picture_stream_row(const PictureTiming& timing);
/// The pictures in a headset: one row a frame.
session::StreamSpec xr_stream();
std::vector<double> xr_stream_row(const display::HmdTiming& timing);
/// What the synthesizer was given, a hundred times a second.
session::StreamSpec sound_stream();

/// What a recording says beside its ticks, and read from them: tools taken up, faults that begin, what the sound was
/// made of. Feed it every tick in order. The recorder's thread.
class TickNotes {
 public:
  /// `sound`: the stream it goes to; nothing where there is no sound.
  TickNotes(const Scene& scene, std::optional<std::size_t> sound);
  /// `sound_latency`: s from a tick to its sound, NaN where unknown.
  void add(const ServoTick& tick, session::SessionWriter& writer,
           double sound_latency = std::numeric_limits<double>::quiet_NaN()) noexcept;

 private:
  std::vector<std::string> tools_;
  std::optional<std::size_t> sound_;
  audio::TickVoice voice_;
  Nanos sounded_ = 0;
  bool first_ = true;
  std::uint32_t tool_ = 0;
  std::array<Nanos, 32> fault_seen_{};  // when each bit was last set
};

/// Volumes, pulp distance and field hash at the end.
session::SessionResult session_result(const haptics::TissueVolume& tissue);

}  // namespace typodont
