#include <chrono>
#include <thread>

#include "engine/app/live/session.h"
#include "engine/base/log.h"

namespace typodont {

using namespace std::chrono_literals;

namespace {

using State = session::WriterStatus::State;

// Period of the recorder's loop. If the program is killed, at most the data of the last 20 periods (half a second) is
// missing. The servo's event log has room for eight seconds at 4 kHz.
constexpr auto kRecorderPeriod = 25ms;

/// Tells the user about the state of the recording. `told`: the state in the last message. Returns the new value of
/// `told`.
State tell(Wiring& wiring, const session::WriterStatus& status, State told) {
  if (status.state != told) {
    if (status.state != State::kRecording) {
      log::warn("{}", status.message);
    } else {
      log::info("the disk has room again; recording goes on");
    }
  }
  wiring.record_to_render.publish({status.ticks, status.cuts, !status.lost.any(),
                                   status.state == State::kDiskLow || status.state == State::kDiskFull,
                                   status.state == State::kFailed});
  return status.state;
}

}  // namespace

void recorder_thread(LiveSession& s, SessionRecorder& recorder) {
  State told = State::kRecording;
  for (bool more = true; more;) {
    more = !s.wiring.nothing_more.load();
    recorder.turn();
    recorder.writer().heartbeat();
    told = tell(s.wiring, recorder.writer().status(), told);
    if (more) std::this_thread::sleep_for(kRecorderPeriod);
  }
}

}  // namespace typodont
