#include <bit>
#include <chrono>
#include <thread>

#include "engine/app/live/session.h"
#include "engine/session/session_data.h"

namespace typodont {

namespace {

using namespace std::chrono_literals;

constexpr auto kSendingPause = 2ms;

}  // namespace

StreamTurns::StreamTurns(LiveSession& s, StateStream& stream, double rate)
    : s_(s),
      stream_(stream),
      interval_(from_seconds(1 / rate)),
      tools_(tool_names(s.scene)),
      servo_(s.wiring.event_logs.servo) {}

void StreamTurns::turn() {
  for (ServoEvent event; servo_.next(event);) {
    const auto* const tick = std::get_if<ServoTick>(&event);
    if (!tick) continue;
    if (!begun_) stream_.begin(s_.wiring.session_zero.load());
    if (!begun_ || tick->tool != tick_.tool) stream_.event(tick->t, "tool", tools_[tick->tool]);
    for (std::uint32_t began = tick->faults & ~tick_.faults; began != 0; began &= began - 1)
      stream_.event(tick->t, "fault", std::string(session::fault_name(1u << std::countr_zero(began))));
    const bool due = !begun_ || tick->t - told_ >= interval_;
    begun_ = true;
    lost_ += tick->index - std::exchange(next_, tick->index + 1);
    tick_ = *tick;
    if (!due) continue;
    told_ = tick_.t;
    stream_.state(tick_, lost_);
  }
  stream_.turn();
}

void StreamTurns::end() {
  turn();
  if (begun_) stream_.state(tick_, lost_);
  stream_.event(tick_.t, "end", "");
  stream_.turn();
}

void stream_thread(LiveSession& s, StreamTurns& turns) {
  while (!s.wiring.nothing_more.load()) {
    turns.turn();
    std::this_thread::sleep_for(kSendingPause);
  }
  turns.end();
}

}  // namespace typodont
