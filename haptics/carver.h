// The carver repeats the servo's cuts on the tissue, records strokes and edits for undo, and creates snapshots for the
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

/// Owns the tissue body (the tissue in the representation of the contact method). Used only by the carver thread (in a
/// deterministic run: by its only thread).
class Carver {
 public:
  /// Creates the carver of a tissue. `tools`: the tools of the session, to which the index Cut::tool refers. Throws
  /// Error if the contact method rejects the tissue.
  Carver(TissueVolume tissue, std::span<const Tool> tools, const SharedContactMethod& method = nullptr);
  /// Constructs the carver with the tools, the contact method and the version of the force laws in `settings`.
  Carver(TissueVolume tissue, const ServoSettings& settings);

  /// Repeats a cut of the servo. Cuts must arrive in order and without gaps. Cuts without a pause between them belong
  /// to one stroke. If a cut separates loose pieces, they are removed in the same stroke, and a new snapshot is due.
  /// The result is deterministic.
  void apply(const Cut& cut);
  /// Returns the loose pieces that were removed since the last call.
  std::vector<LoosePiece> take_pieces();

  /// Returns true if `cut` would be the first cut of a new stroke.
  bool begins_stroke(const Cut& cut) const;

  /// Undoes or redoes the last stroke; returns false if there is none. Afterwards a new snapshot is due. With this
  /// snapshot, the servo continues with the edited tissue; it does not repeat cuts that it made in older snapshots.
  bool undo();
  bool redo() { return edit(body_->redo()); }
  /// Ends the stroke: the next cut begins a new stroke. A stroke that changed nothing is discarded.
  void end_stroke();
  /// Informs the carver that all cuts up to time t (on the clock of the cuts) have been applied. If the pause since the
  /// last cut is long enough, this call ends the stroke and prepares its undo.
  void rest(Nanos t);

  /// Returns an empty snapshot whose buffers already have their full size.
  std::unique_ptr<Snapshot> make_snapshot() const { return body_->make_snapshot(); }
  /// Returns true if the servo needs a new snapshot, because it has none, because the tissue was edited, or because the
  /// tool has moved far from the centre of the last snapshot.
  bool snapshot_due(const ServoTick& tick) const;
  /// Returns the centre for the next snapshot in m, a point between the proxy and the hand.
  dvec3 snapshot_center(const ServoTick& tick) const;
  /// Fills a snapshot with the tissue around `center_W`. A replay passes the snapshot's recorded `number`, because a
  /// live servo may have skipped some numbers. 0: the next number is used.
  void take_snapshot(const dvec3& center_W, Snapshot& snapshot, std::uint32_t number = 0);
  /// Updates the newest snapshot to the present tissue: copies only the samples that were written since
  /// remember_writes() was called. If the tissue was edited by undo or redo, returns false and changes nothing; a new
  /// snapshot is then due.
  bool bring_up_to_date(Snapshot& snapshot);
  void remember_writes(bool wanted) { body_->remember_writes(wanted); }

  /// Returns the tissue as a distance field (TissueBody::rasterize).
  TissueVolume& volume() { return body_->rasterize(); }
  const TissueVolume& volume() const { return body_->rasterize(); }
  /// Returns the body's own triangles (TissueBody::surface); null: the renderer must draw volume() instead.
  TissueSurface* surface() { return body_->surface(); }
  TissueVolume::Strokes strokes() { return body_->strokes(); }
  /// Moves the tissue out of the carver: returns volume() with the body's triangles as its mesh. If the body has no
  /// triangles, a tissue that was cut is returned without a mesh. The carver must not be used afterwards.
  TissueVolume take_tissue();
  const TissueBody& body() const { return *body_; }
  std::uint64_t cuts() const { return cuts_; }
  std::uint32_t snapshots() const { return snapshots_; }

 private:
  bool edit(bool done);
  void collect_pieces();

  std::unique_ptr<TissueBody> body_;
  std::size_t tool_count_;
  // m, distance that the tool may move before a new snapshot is due; it comes from TissueBody::travel()
  double travel_;
  std::uint64_t cuts_ = 0;
  Pose end_;                    // pose at which the last cut ended
  std::uint32_t end_tool_ = 0;  // tool of the last cut
  Nanos cut_t_ = 0;             // ns, time of the last cut
  bool in_stroke_ = false;
  std::vector<LoosePiece> pieces_;  // loose pieces that take_pieces() has not returned yet
  PerTissue loose_volume_{};        // m³, volume of all loose pieces since construction
  // piece_count_: number of loose pieces that cuts have separated so far; pieces_in_snapshot_: their number when the
  // last snapshot was taken.
  std::uint32_t piece_count_ = 0, pieces_in_snapshot_ = 0;
  std::uint32_t edits_ = 0, edits_in_snapshot_ = 0;
  std::uint64_t edited_at_ = 0;  // number of cuts (cuts_) at the last edit
  std::uint32_t snapshots_ = 0;
  dvec3 center_W_{0};  // m, centre of the last snapshot
};

}  // namespace typodont::haptics
