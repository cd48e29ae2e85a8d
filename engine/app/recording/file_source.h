// Reads a recorded session, and writes its events to event logs. The soft gum is not recorded: at each tick, the tool
// is placed at its drawn pose, where it presses and cuts the gum.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/app/event_logs.h"
#include "engine/app/scene.h"
#include "engine/app/sides.h"
#include "engine/session/session_file.h"
#include "haptics/soft_tissue.h"

namespace typodont {

class FileSource {
 public:
  /// Session and scene must outlive this object.
  FileSource(const session::SessionReader& session, const Scene& scene);

  /// Writes the next events up to the time t, at most one second of them, so that no reader misses events. Returns
  /// false if there are none. Use: while (source.advance(t)) reader.read();
  bool advance(Nanos t);
  /// Starts again: the next advance() begins with the first tick.
  void rewind();

  const EventLogs& event_logs() const { return *event_logs_; }
  /// The soft gum at rest; null: the gum is rigid.
  const std::shared_ptr<const haptics::SoftSurface>& gum() const { return surface_; }

 private:
  const ServoTick* next_tick();
  void write_before(Nanos t);
  void press(const ServoTick& tick);

  const session::SessionReader& session_;
  const Scene& scene_;
  const std::unique_ptr<EventLogs> event_logs_ = std::make_unique<EventLogs>();
  const std::shared_ptr<const haptics::SoftSurface> surface_;
  std::optional<haptics::SoftTissue> gum_;
  std::optional<GumWriter> gum_writer_;
  std::vector<LoosePiece> pieces_;
  const session::StreamData *water_ = nullptr, *left_hand_ = nullptr;
  // Indices of the next events in the file.
  std::uint64_t tick_ = 0;
  std::size_t cut_ = 0, piece_ = 0, switch_ = 0, left_ = 0;
  std::vector<ServoTick> block_;  // ticks of the file, beginning with index block_first_
  std::uint64_t block_first_ = 0;
};

}  // namespace typodont
