#include <algorithm>
#include <chrono>
#include <exception>
#include <filesystem>
#include <iterator>
#include <memory>
#include <thread>
#include <utility>

#include "engine/app/live/session.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/tissue/paint_file.h"
#include "engine/base/log.h"
#include "engine/base/realtime.h"
#include "haptics/work.h"

namespace typodont {

namespace {

using namespace std::chrono_literals;

/// Writes a copy of tissue to a file during the session.
class TissueSaver {
 public:
  explicit TissueSaver(Wiring& wiring) : wiring_(wiring) {}

  void start(haptics::Carver& carver, const std::filesystem::path& file) {
    if (file.empty()) return log::warn("nowhere to save to: start with --save VOLUME.vdb");
    const auto try_to = [&wiring = wiring_](const auto& part) {
      try {
        part();
      } catch (const std::exception& e) {
        log::warn("not saved: {}", e.what());
        ++wiring.not_saved;
      }
    };
    // A new thread writes the copy. That thread, not the carver thread, first waits until the previous file is written.
    try_to([&] {
      thread_ = std::jthread(
          [&wiring = wiring_, try_to, tissue = copy_of(carver), file, earlier = std::move(thread_)]() mutable {
            if (earlier.joinable()) earlier.join();
            try_to([&] {
              save_tissue(tissue, file);
              log::info("saved {}", file.string());
              ++wiring.saved;
            });
          });
    });
  }

 private:
  Wiring& wiring_;
  std::jthread thread_;
};

/// Sends mesh bricks (blocks of the surface) to a picture, unless its GPU device is being created again. Bricks for
/// which the queue has no room stay here in their latest version; otherwise the picture would keep the old surface. The
/// first batch is sent even if it is empty.
class BrickQueue {
 public:
  explicit BrickQueue(Ring<MeshBatch*>& ring) : ring_(ring) {}

  void send(MeshBatch bricks) {
    for (const render::MeshUpdate& brick : bricks)
      std::erase_if(waiting_, [&](const render::MeshUpdate& older) { return older.brick == brick.brick; });
    waiting_.insert(waiting_.end(), std::make_move_iterator(bricks.begin()), std::make_move_iterator(bricks.end()));
    if ((waiting_.empty() && sent_) || !ring_.has_room()) return;
    ring_.push(new MeshBatch(std::exchange(waiting_, {})));
    sent_ = true;
  }

 private:
  Ring<MeshBatch*>& ring_;
  MeshBatch waiting_;
  bool sent_ = false;
};

void execute_command(LiveSession& s, TissueCommand command, TissueSaver& saver) {
  if (command == TissueCommand::kSave) return saver.start(s.carver, s.save);
  const bool redo = command == TissueCommand::kRedo;
  if (s.side.edit(redo)) s.book.edited(redo, s.carver.strokes());
}

/// Applies a part of a brush stroke, which the user can undo. `begins`: starts a new stroke. False if the brush touched
/// no tissue; such a part is not recorded.
bool brush(LiveSession& s, const BrushMove& move, bool begins) {
  if (begins) {
    s.carver.end_stroke();
    s.carver.volume().begin_stroke();
  }
  if (!paint(s.carver.volume(), {move.stroke})) return false;
  s.book.painted(move.stroke, s.carver.strokes());
  return true;
}

}  // namespace

struct CarverTurns::Impl {
  LiveSession& s;
  std::function<void()> between;
  TissueSaver saver{s.wiring};
  TissueView view{s.wiring.tolerance, s.scene.drawn_as};
  BrickQueue to_picture{s.wiring.bricks}, to_watch{s.wiring.bricks_to_watch};
  Nanos meshed = 0;
  bool first = true;
  bool brush_open = false;  // true while the newest stroke is a brush stroke; a cut or an undo ends it

  void pause() const {
    if (between) between();
  }
  CarverSide::Read follow_servo(bool to_end = false);
  Done turn();
  void mesh();
};

CarverSide::Read CarverTurns::Impl::follow_servo(bool to_end) {
  return s.side.follow(
      [&](const Cut& cut) {
        brush_open = false;
        if (s.operated) s.book.cut(cut, s.carver.strokes());
      },
      to_end);
}

CarverTurns::Done CarverTurns::Impl::turn() {
  Wiring& wiring = s.wiring;
  Done done;
  const CarverSide::Read before = follow_servo();
  done.worked = before.cut;
  pause();
  done.awaited = s.side.keep_up();
  pause();
  TissueCommand command;
  while (wiring.tissue_commands.pop(command)) {
    execute_command(s, command, saver);
    brush_open = false;
    done.worked = true;
    pause();
  }
  BrushMove move;
  bool painted = false;
  while (wiring.paint_to_carver.pop(move)) {
    painted |= brush(s, move, move.begins || !brush_open);
    brush_open = true;
  }
  // The next tissue patch for the servo must contain the servo's newest cuts.
  const CarverSide::Read after = follow_servo();
  done.worked |= after.cut;
  if (done.worked || painted) {
    const TissueState state = s.book.state(s.carver.strokes());
    wiring.event_logs.carver.write(state);
    wiring.tissue_version.store(state.version, std::memory_order_relaxed);
  }
  pause();
  if (before.tick || after.tick || painted) done.worked |= s.side.offer(/*due_only=*/!painted);
  mesh();
  if (wiring.copy_wanted.exchange(false)) {
    auto copy = std::make_unique<haptics::TissueVolume>(s.carver.volume().clone());
    if (wiring.copies_to_watch.push(copy.get())) (void)copy.release();
  }
  // The expert (planned motion) has made its last cut and then requested a copy of the tissue, which must contain this
  // cut. The cut may have arrived during this call of turn(), so waiting cuts are applied first.
  if (wiring.expert_wants_copy.load()) {
    follow_servo();
    if (!s.side.edit_waits()) {
      wiring.expert_wants_copy = false;
      auto copy = std::make_unique<haptics::TissueVolume>(s.carver.volume().clone());
      if (wiring.copies_to_expert.push(copy.get())) (void)copy.release();
    }
  }
  return done;
}

/// Meshes the changed mesh bricks that a picture shows. The volume stores which voxels have changed, so the other
/// bricks can be meshed later.
void CarverTurns::Impl::mesh() {
  const auto& seen = s.wiring.tissue_in_sight;
  const bool in_sight =
      std::any_of(seen.begin(), seen.end(), [](const auto& eyes) { return eyes.load(std::memory_order_relaxed); });
  if (!s.draw || !in_sight || !(first || now() - meshed > s.mesh_interval)) return;
  meshed = now();
  first = false;
  view.set_tolerance(s.wiring.tolerance);
  MeshBatch bricks = view.update(s.carver);
  s.bricks_meshed += bricks.size();
  for (const render::MeshUpdate& brick : bricks) s.triangles_made += brick.indices.size() / 3;
  if (s.watched) to_watch.send(bricks);
  to_picture.send(std::move(bricks));
}

CarverTurns::CarverTurns(LiveSession& s, std::function<void()> between)
    : impl_(std::make_unique<Impl>(s, std::move(between))) {}
CarverTurns::~CarverTurns() = default;
CarverTurns::Done CarverTurns::turn() {
  return impl_->turn();
}
void CarverTurns::finish() {
  impl_->follow_servo(/*to_end=*/true);
  impl_->s.side.write_pieces();
}

namespace {

void carve(LiveSession& s) {
  CarverTurns turns(s);
  int idle = 0;  // number of consecutive calls of turn() without work
  while (!s.wiring.stop.load(std::memory_order_relaxed)) {
    const CarverTurns::Done done = turns.turn();
    // Chooses the pause until the next check for work. During a pause, a hand moves at most 0.2 mm; the servo's copy of
    // the tissue is 0.22 mm larger than needed. Long pauses reduce an idle session's load from 3 % to 1 % of a core.
    idle = done.worked ? 0 : std::min(idle + 1, 400);
    if (!done.worked)
      std::this_thread::sleep_for(done.awaited ? 20us : idle < 100 ? 300us : idle < 400 ? 3000us : 6000us);
  }
  turns.finish();
}

}  // namespace

void carver_thread(LiveSession& s) {
  use_ieee_arithmetic();
  try {
    carve(s);
  } catch (const std::exception& e) {
    s.carver_failure = e.what();
    s.wiring.stop = true;
  }
  s.voxels_cut = haptics::voxels_cut_by_this_thread();
}

}  // namespace typodont
