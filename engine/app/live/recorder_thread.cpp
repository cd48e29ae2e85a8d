#include <array>
#include <chrono>
#include <cmath>
#include <thread>

#include "engine/app/live/session.h"
#include "engine/app/recording/resume.h"
#include "engine/app/recording/session_record.h"
#include "engine/base/log.h"

namespace typodont {

using namespace std::chrono_literals;

namespace {

// Period of the recorder's loop. If the program is killed, the recording lacks at most the data of the last 20 periods
// (half a second). The ring of ticks has room for eight seconds at 4 kHz.
constexpr auto kTurn = 25ms;

}  // namespace

void RecorderTurns::turn() {
  LiveSession& s = s_;
  Wiring& wiring = s.wiring;
  session::SessionWriter& writer = writer_;
  ServoTick tick;
  Cut cut;
  PatchUse use;
  StrokeEdit edit;
  // Counts the waiting ticks first, and stores only these ticks in this call of turn(). The servo puts the patches
  // (copies of the tissue) and cuts of a tick into their rings before the tick. So a tick is never stored without its
  // patches and cuts.
  const std::size_t ticks = wiring.ticks_to_recorder.ready();
  while (wiring.patches_to_recorder.pop(use)) writer.append({&use, 1});
  // The carver sends an edit (undo or redo) before the patch (copy of the tissue) in which the edit is visible. The
  // patches were read above. So the edits that belong to these patches have arrived, and are stored in the same call of
  // turn().
  while (wiring.edits_to_recorder.pop(edit)) writer.append(event_of(edit));
  LoosePiece piece;
  while (wiring.pieces_to_recorder.pop(piece)) writer.append(event_of(piece));
  while (wiring.cuts_to_recorder.pop(cut)) writer.append({&cut, 1});
  for (std::size_t i = 0; i < ticks && wiring.ticks_to_recorder.pop(tick); ++i) {
    writer.append({&tick, 1});
    s.notes->add(tick, writer, s.sound ? s.sound->latency() : std::nan(""));
  }
  SeenFrom seen;
  while (wiring.seen_to_recorder.pop(seen)) {
    if (seen.view != viewed_) writer.event(seen.t, session::EventKind::kView, view_name(seen.view));
    viewed_ = seen.view;
    const dvec3 &eye = seen.eye_W, &right = seen.right_W;
    writer.append(*s.head_stream, seen.t,
                  std::array{eye.x, eye.y, eye.z, right.x, right.y, right.z, seen.ipd, static_cast<double>(seen.view)});
  }
  WaterSwitch water;
  while (wiring.water_to_recorder.pop(water))
    writer.append(*s.water_stream, water.t, std::array{water.spray ? 1.0 : 0.0, water.suction ? 1.0 : 0.0});
  haptics::HandSample left;
  while (wiring.left_to_recorder.pop(left)) {
    const Pose& X = left.X_WT;
    writer.append(s.left_stream, left.t, std::array{X.p.x, X.p.y, X.p.z, X.R.w, X.R.x, X.R.y, X.R.z, left.pedal});
  }
  if (wiring.loop_to_recorder.fetch()) writer.loop(wiring.loop_to_recorder.front());
  // Pictures before the first tick do not belong to the session, so they are not stored.
  const Nanos zero = wiring.session_zero.load(std::memory_order_relaxed);
  display::HmdTiming frame;
  while (wiring.xr_frames_to_recorder.pop(frame))
    if (zero != 0 && frame.t >= zero) writer.append(s.xr_stream, frame.t - zero, xr_stream_row(frame));
  PictureTiming picture;
  while (wiring.pictures_to_recorder.pop(picture))
    if (zero != 0 && picture.t >= zero) writer.append(s.picture_stream, picture.t - zero, picture_stream_row(picture));
  const std::uint64_t other = wiring.patches_to_recorder.dropped() + wiring.edits_to_recorder.dropped() +
                              wiring.pieces_to_recorder.dropped() + wiring.seen_to_recorder.dropped() +
                              wiring.left_to_recorder.dropped() + wiring.water_to_recorder.dropped() +
                              wiring.xr_frames_to_recorder.dropped() + wiring.pictures_to_recorder.dropped();
  writer.count_ring_losses(wiring.ticks_to_recorder.dropped(), wiring.cuts_to_recorder.dropped(), other);
  writer.heartbeat();
  const session::WriterStatus& status = writer.status();
  using State = session::WriterStatus::State;
  if (status.state != told_) {
    if (status.state != State::kRecording) {
      log::warn("{}", status.message);
    } else {
      log::info("the disk has room again; recording goes on");
    }
    told_ = status.state;
  }
  wiring.record_to_render.publish({status.ticks, status.cuts, !status.lost.any(),
                                   status.state == State::kDiskLow || status.state == State::kDiskFull,
                                   status.state == State::kFailed});
}

void recorder_thread(LiveSession& s, session::SessionWriter& writer) {
  RecorderTurns turns(s, writer);
  while (!s.wiring.nothing_more.load()) {
    turns.turn();
    std::this_thread::sleep_for(kTurn);
  }
  turns.turn();
}

}  // namespace typodont
