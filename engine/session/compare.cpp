#include "engine/session/compare.h"

#include <array>
#include <cstring>
#include <vector>

#include "engine/session/format/columns.h"

namespace typodont::session {

namespace {

constexpr std::uint32_t kLoopsFaults =
    bits(Fault::kDeviceLost) | bits(Fault::kOverrun) | bits(Fault::kLetGo) | bits(Fault::kHeld);

template <class Message>
std::string_view first_difference(const std::vector<Column<Message>>& columns, const Message& replayed,
                                  const Message& recorded) {
  using Cell = std::array<std::byte, 8>;
  // Copy of the replayed message. Each value is rounded as if it had been written to a session file and read back, like
  // the recorded values.
  Message as_read;
  for (const Column<Message>& column : columns) {
    if (!column.in_file || !column.set) continue;
    Cell written{}, read{}, expected{};
    column.get(replayed, written.data());
    column.set(as_read, written.data());
    column.get(as_read, read.data());
    column.get(recorded, expected.data());
    if (read != expected) return column.name;
  }
  return {};
}

}  // namespace

std::string_view differing_column(const ServoTick& replayed, const ServoTick& recorded) {
  ServoTick comparable = replayed;
  comparable.cpu_time = recorded.cpu_time;
  comparable.X_WT = recorded.X_WT;  // the pose is the replay's input, so it's not compared
  comparable.pedal = recorded.pedal;
  // These fault bits are not compared, because they depend on the force limits of the recorded device. A replay runs
  // without the device, so it cannot set these bits.
  constexpr std::uint32_t kDevices = bits(Fault::kForceLimit) | bits(Fault::kSlewLimit);
  comparable.faults = (replayed.faults & ~kLoopsFaults) | (recorded.faults & (kLoopsFaults | kDevices));
  return first_difference(tick_columns(), comparable, recorded);
}

std::string_view differing_column(const Cut& replayed, const Cut& recorded) {
  return first_difference(cut_columns(), replayed, recorded);
}

}  // namespace typodont::session
