// The events of a session, and the event logs to which its threads write them. Times are session times unless a comment
// states another clock.
#pragma once

#include <array>
#include <variant>

#include "engine/app/tissue/stroke_book.h"
#include "engine/base/event_log.h"
#include "engine/contract/contact.h"
#include "engine/contract/loop_timing.h"
#include "engine/display/hmd.h"
#include "engine/render/renderer.h"
#include "haptics/servo.h"
#include "haptics/soft_tissue.h"

namespace typodont {

/// An undo or redo of a stroke. For an exact replay, its position in the order of cuts and tissue patches is recorded.
struct StrokeEdit {
  Nanos t = 0;
  bool redo = false;
  std::uint64_t cuts = 0;     // number of cuts in the tissue before the edit
  std::uint32_t patches = 0;  // number of tissue patches (copies of the tissue for the servo) created before the edit
};

/// Points of the soft gum that have moved.
struct GumMoves {
  std::uint32_t count = 0;
  std::array<haptics::SoftMove, 56> points{};
};

/// Positions of the eyes in front of a screen, and the view that the picture shows.
struct SeenFrom {
  Nanos t = 0;
  dvec3 eye_W{0}, right_W{1, 0, 0};
  double ipd = 0;
  render::View view = render::View::kLook;
};

/// State of the handpiece's water and of the suction.
struct WaterSwitch {
  Nanos t = 0;
  bool spray = false, suction = false;
};

/// Measured times of a frame on a screen.
struct PictureTiming {
  Nanos t = 0;        // ns, time at which the frame began
  double period = 0;  // s, time since the previous frame
  double record = 0;  // s, time in which the CPU prepared and submitted the frame
  double gpu = 0;     // s, GPU time of the latest finished frame
  // Estimated latency from the hand's sample that the frame shows to the middle of the screen's next refresh, s.
  double motion_to_photon = 0;
  double redrawn = 1;  // fraction of the picture's area that this frame drew again
  int step = 0;        // index of the quality level; 0 is the best
};

/// Events of the servo. A Cut or PatchUse is written before the tick that contains the number of this cut or patch.
using ServoEvent = std::variant<ServoTick, Cut, PatchUse, GumMoves, haptics::SoftWound>;
/// Changes of the tissue other than cuts, and the state of the tissue after them. An undo or redo (StrokeEdit) is
/// written before the tissue patch that contains its effect.
using CarverEvent = std::variant<StrokeEdit, LoosePiece, TissueState>;
/// What the trainee sees; written after each change and frame.
using ViewEvent = std::variant<SeenFrom, WaterSwitch, PictureTiming, display::HmdTiming>;

/// A session's event logs, one for each thread that writes.
struct EventLogs {
  EventLog<ServoEvent> servo{1 << 16};  // holds eight seconds at 4 kHz, if every tick cuts
  EventLog<CarverEvent> carver{1 << 12};
  EventLog<ViewEvent> view{1 << 12};            // written by the thread that draws the trainee's picture
  EventLog<haptics::HandSample> left{1 << 13};  // samples of the second hand (mouth mirror or suction tip)
  EventLog<LoopReport> loop{8};                 // written by the servo thread, some times per second
};

}  // namespace typodont
