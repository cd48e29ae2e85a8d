#include "engine/app/sides.h"

#include "engine/base/error.h"

namespace typodont {

void ServoSide::take_patch(haptics::PatchExchange& patches, Nanos t) noexcept {
  haptics::Snapshot* const fresh = patches.take(servo_.snapshot(), cuts_, t);
  if (!fresh) return;
  const PatchUse use{fresh->number, ticks_, fresh->cuts, fresh->center_W};
  servo_.adopt(*fresh);
  write(use);
}

void ServoSide::write(const ServoTick& tick, const Cut* cut) noexcept {
  ++ticks_;
  cuts_ = tick.cuts;
  gum_.tick();
  if (cut) event_log_.write(*cut);
  event_log_.write(tick);
}

void GumWriter::tick() noexcept {
  if (!gum_ || ++ticks_ % interval_ != 0) return;
  GumMoves moves;
  gum_->send_moves([&](const haptics::SoftMove& move) {
    moves.points[moves.count++] = move;
    if (moves.count == moves.points.size()) event_log_.write(moves), moves.count = 0;
    return true;
  });
  if (moves.count > 0) event_log_.write(moves);
  for (; wounds_ < gum_->wounds().size(); ++wounds_) event_log_.write(gum_->wounds()[wounds_]);
}

bool CarverSide::keep_up() {
  // All cuts up to this time are applied, so the carver can end a stroke after a pause. A tick without a valid pose is
  // ignored.
  if (!(tick_.faults & haptics::kNoPose)) carver_.rest(tick_.t);
  const bool awaited = patches_.keep_up(carver_, tick_.patch);
  write_pieces();
  return awaited;
}

void CarverSide::write_pieces() {
  for (const LoosePiece& piece : carver_.take_pieces()) event_log_.write(piece);
}

bool CarverSide::offer(bool due_only) {
  if (!is_finite(tick_.X_WG.p) || (due_only && !carver_.snapshot_due(tick_))) return false;
  patches_.offer(carver_, carver_.snapshot_center(tick_));
  return true;
}

bool CarverSide::edit(bool redo) {
  if (!edit_stroke(carver_, redo, tick_.t, &event_log_)) return false;
  offer(/*due_only=*/false);
  return true;
}

void CarverSide::require_whole() const {
  if (servo_.lost() > 0) throw RunFailure("the carver was so late that a cut was lost");
}

bool edit_stroke(haptics::Carver& carver, bool redo, Nanos t, EventLog<CarverEvent>* event_log) {
  const StrokeEdit edit{t, redo, carver.cuts(), carver.snapshots()};
  if (!(redo ? carver.redo() : carver.undo())) return false;
  if (event_log) event_log->write(edit);
  return true;
}

}  // namespace typodont
