// The carver: repeats the servo's cuts on the tissue, keeps the order of strokes and edits, takes snapshots for the
// servo.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "engine/contract/contact.h"
#include "haptics/contact_method.h"
#include "haptics/servo.h"
#include "haptics/tissue_body.h"

namespace typodont::haptics {

/// Owner of the tissue body. Carver thread only (or the only thread of a deterministic run).
class Carver {
 public:
  /// Cut::tool is an index into `tools`. Throws Error if the method rejects the tissue.
  Carver(TissueVolume tissue, std::span<const Tool> tools, const SharedContactMethod& method = nullptr);
  /// Constructs the carver with the tools, the method and the laws of `settings`.
  Carver(TissueVolume tissue, const ServoSettings& settings);

  /// Repeats a cut. Cuts must arrive in order and without gaps. Cuts without a pause between them are one stroke. Loose
  /// pieces are removed together with the cut that separated them, in the same stroke; then a new snapshot is due.
  /// Equal cuts give equal pieces.
  void apply(const Cut& cut);
  /// Returns the pieces that were removed since the last call.
  std::vector<LoosePiece> take_pieces();

  /// Returns true if this cut, as the next cut, would begin a new stroke.
  bool begins_stroke(const Cut& cut) const;

  /// Undoes or redoes the last stroke; returns false if there is none. Then a new snapshot is due, and the servo
  /// continues with the edited tissue, without the cuts that it made in older snapshots.
  bool undo();
  bool redo() { return edit(body_->redo()); }
  /// Ends the stroke: the next cut begins a new stroke. A stroke that changed nothing is discarded.
  void end_stroke();
  /// Tells the carver that all cuts up to time t (on the clock of the cuts) have been applied. If the last stroke is
  /// over at time t, this call ends it and prepares its undo.
  void rest(Nanos t);

  /// Returns an empty snapshot with buffers of full size.
  std::unique_ptr<Snapshot> make_snapshot() const { return body_->make_snapshot(); }
  /// Returns true if the servo needs a new snapshot: it has none, the tissue was edited, or the tool moved far from the
  /// centre of the last snapshot.
  bool snapshot_due(const ServoTick& tick) const;
  /// Returns the centre for the next snapshot, m: between the proxy and the hand.
  dvec3 snapshot_center(const ServoTick& tick) const;
  /// Fills a snapshot with the tissue around `center_W`. `number`: the recorded number in a replay (a live servo may
  /// have skipped some numbers); 0: the next number.
  void take_snapshot(const dvec3& center_W, Snapshot& snapshot, std::uint32_t number = 0);
  /// Updates the newest snapshot to the present tissue, and copies only the samples written since remember_writes().
  /// Returns false and changes nothing if the tissue was edited by undo or redo; then a new snapshot is due.
  bool bring_up_to_date(Snapshot& snapshot);
  void remember_writes(bool wanted) { body_->remember_writes(wanted); }

  /// The tissue as a distance field (TissueBody::rasterize).
  TissueVolume& volume() { return body_->rasterize(); }
  const TissueVolume& volume() const { return body_->rasterize(); }
  /// Returns the body's own triangles (TissueBody::surface); null: pictures show volume().
  TissueSurface* surface() { return body_->surface(); }
  TissueVolume::Strokes strokes() { return body_->strokes(); }
  /// Moves the tissue out, for further use: returns volume(), with the body's triangles as its mesh. If the body has
  /// no triangles, a cut tissue has no mesh. Afterwards the carver must not be used.
  TissueVolume take_tissue();
  const TissueBody& body() const { return *body_; }
  std::uint64_t cuts() const { return cuts_; }
  std::uint32_t snapshots() const { return snapshots_; }

 private:
  bool edit(bool done);
  void collect_pieces();

  std::unique_ptr<TissueBody> body_;
  std::size_t tool_count_;
  double travel_;  // m, distance that the tool may move before a new snapshot is due: travel() of the body
  std::uint64_t cuts_ = 0;
  Pose end_;                    // pose at which the last cut ended
  std::uint32_t end_tool_ = 0;  // tool of the last cut
  Nanos cut_t_ = 0;             // time of the last cut
  bool in_stroke_ = false;
  std::vector<LoosePiece> pieces_;  // removed pieces, not yet taken
  PerTissue loose_volume_{};        // m³, volume of all loose pieces up to now
  // Number of loose pieces, now and when the last snapshot was taken.
  std::uint32_t piece_count_ = 0, pieces_in_snapshot_ = 0;
  std::uint32_t edits_ = 0, edits_in_snapshot_ = 0;
  std::uint64_t edited_at_ = 0;  // number of cuts (cuts_) at the last edit
  std::uint32_t snapshots_ = 0;
  dvec3 center_W_{0};  // m, centre of the last snapshot
};

}  // namespace typodont::haptics
