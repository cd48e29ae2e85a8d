// The carver owns the tissue. It repeats the servo's cuts on the tissue, records strokes and edits for undo, and
// creates snapshots of the tissue for the servo.
#pragma once

#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "engine/contract/contact.h"
#include "haptics/contact/tissue_body.h"
#include "haptics/contact_method.h"
#include "haptics/servo.h"

namespace typodont::haptics {

/// Owns the tissue body (the tissue in the representation of the contact method). Used only by the carver thread (in a
/// deterministic run: by its only thread).
class Carver {
 public:
  /// Creates the carver of a tissue. `tools`: the tools of the session, to which the index Cut::tool refers. Throws
  /// Error if the contact method rejects the tissue.
  Carver(TissueVolume tissue, std::span<const Tool> tools, const SharedContactMethod& method = nullptr);
  /// Constructs the carver with the tools and the contact method in `settings`.
  Carver(TissueVolume tissue, const ServoSettings& settings);

  /// Repeats a cut of the servo. Cuts must arrive in order and without gaps. Consecutive cuts with only short pauses
  /// between them belong to one stroke. If a cut separates pieces of tissue, these loose pieces are removed in the same
  /// stroke, and a new snapshot is due. The result is deterministic.
  void apply(const Cut& cut);
  /// Returns the loose pieces that were removed since the last call.
  std::vector<LoosePiece> take_pieces();

  /// Returns true if `cut` would be the first cut of a new stroke.
  bool begins_stroke(const Cut& cut) const;

  /// Ends the present stroke and undoes the last one. Returns false if there is none. Afterwards a new snapshot is due.
  /// When the servo begins to use this snapshot, it continues with the edited tissue, and does not repeat the cuts that
  /// it made before the edit.
  bool undo();
  /// Redoes the stroke that was undone last, as undo() undoes. Returns false during a stroke: its first cut has
  /// discarded the undone strokes.
  bool redo();
  /// Ends the stroke: the next cut begins a new stroke. A stroke that changed nothing is discarded.
  void end_stroke();
  /// Informs the carver that all cuts up to time t (on the clock of the cuts) have been applied. If the time from the
  /// last cut to t is longer than the pause that ends a stroke, ends the stroke and prepares its undo.
  void rest(Nanos t);

  /// Returns an empty snapshot whose buffers already have their full size.
  std::unique_ptr<Snapshot> make_snapshot() const { return body_->make_snapshot(); }
  /// An undo, redo or loose piece is in no snapshot yet. The servo counts the volume of later cuts only if none of them
  /// is applied before that snapshot.
  bool edited() const {
    return snapshots_ > 0 && (edits_in_snapshot_ != edits_ || pieces_in_snapshot_ != piece_count_);
  }
  /// Returns true if the servo needs a new snapshot: it has none, the tissue was edited, a loose piece was removed, the
  /// tissue body asks for a snapshot, or the tool has moved far from the centre of the last snapshot. The function also
  /// estimates the tool's velocity, so it should be called with every tick that the carver receives.
  bool snapshot_due(const ServoTick& tick);
  /// Returns the centre for the next snapshot in m: a point between the proxy and the hand, moved ahead in the
  /// direction of the tool's motion if TissueBody::leads() is true.
  dvec3 snapshot_center(const ServoTick& tick) const;
  /// Fills a snapshot with the tissue around `center_W`. `number`: number of the snapshot; 0: the next number is used.
  /// A replay passes the recorded number, because the live servo may have skipped some numbers. `held`: number of the
  /// snapshot that the servo will hold when it adopts this one. If it is the number of the last snapshot, the new one
  /// may be a step from it (Snapshot::from), which is faster to copy. 0: the new snapshot is complete.
  void take_snapshot(const dvec3& center_W, Snapshot& snapshot, std::uint32_t number = 0, std::uint32_t held = 0);
  /// Updates the newest snapshot to the present tissue; it is then complete. If the tissue was edited (undo or redo),
  /// returns false and changes nothing; a new snapshot is then due.
  bool bring_up_to_date(Snapshot& snapshot);
  void remember_writes(bool wanted) { body_->remember_writes(wanted); }

  /// Returns the tissue as a distance field (TissueBody::rasterize).
  TissueVolume& volume() { return body_->rasterize(); }
  const TissueVolume& volume() const { return body_->rasterize(); }
  /// Returns the body's own triangles (TissueBody::surface); null: the renderer must draw volume() instead.
  TissueSurface* surface() { return body_->surface(); }
  TissueVolume::Strokes strokes() { return body_->strokes(); }
  /// Moves the tissue out of the carver: returns volume(), and adds the body's own triangles as its mesh. If the body
  /// has no own triangles and the tissue was cut, the volume has no mesh. The carver must not be used afterwards.
  TissueVolume take_tissue();
  const TissueBody& body() const { return *body_; }
  std::uint64_t cuts() const { return cuts_; }
  std::uint32_t snapshots() const { return snapshots_; }

 private:
  bool edit(bool done);
  void collect_pieces();
  void follow(const ServoTick& tick);

  std::unique_ptr<TissueBody> body_;
  std::size_t tool_count_;
  // m, distance that the tool may move before a new snapshot is due; result of TissueBody::travel()
  double travel_;
  std::uint64_t cuts_ = 0;
  Pose end_;                    // pose at which the last cut ended
  std::uint32_t end_tool_ = 0;  // tool of the last cut
  Nanos cut_t_ = 0;             // ns, time of the last cut
  bool in_stroke_ = false;
  std::vector<LoosePiece> pieces_;  // loose pieces that take_pieces() has not returned yet
  PerTissue loose_volume_{};        // m³, volume of all loose pieces since construction
  // piece_count_: number of loose pieces that cuts have separated so far; pieces_in_snapshot_: value of piece_count_
  // when the last snapshot was taken
  std::uint32_t piece_count_ = 0, pieces_in_snapshot_ = 0;
  std::uint32_t edits_ = 0, edits_in_snapshot_ = 0;
  std::uint64_t edited_at_ = 0;  // number of cuts (cuts_) at the last edit
  std::uint32_t snapshots_ = 0;
  dvec3 center_W_{0};  // m, centre of the last snapshot
  // The next members describe the motion of the proxy: the time and the position of the last tick that snapshot_due()
  // received, and the velocity (m/s) after a low-pass filter.
  Nanos seen_t_ = std::numeric_limits<Nanos>::min() / 2;
  dvec3 seen_p_W_{0}, velocity_W_{0};
};

}  // namespace typodont::haptics
