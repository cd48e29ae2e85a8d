// The carver owns the tissue. It repeats the servo's cuts, stores strokes and edits for undo, and creates snapshots of
// the tissue for the servo.
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

/// Owns the tissue body (the tissue as the contact method stores it). Carver thread only.
class Carver {
 public:
  /// Creates the carver of a tissue. `tools`: tools of the session, indexed by Cut::tool. Throws Error if the contact
  /// method rejects the tissue.
  Carver(TissueVolume tissue, std::span<const Tool> tools, const SharedContactMethod& method = nullptr);
  /// Creates the carver with the tools and the contact method of `settings`.
  Carver(TissueVolume tissue, const ServoSettings& settings);

  /// Repeats a cut of the servo; cuts must arrive in order and without gaps. Cuts with only short pauses form one
  /// stroke. Pieces that a cut separates are removed; the servo then needs a new snapshot. Deterministic.
  void apply(const Cut& cut);
  /// Returns the pieces of tissue that cuts have separated and removed since the last call.
  std::vector<LoosePiece> take_pieces();

  /// Returns true if `cut` would be the first cut of a new stroke.
  bool begins_stroke(const Cut& cut) const;

  /// Ends the current stroke and undoes the last one; false: there is none. Then a new snapshot is due; until it
  /// arrives, the servo uses its old one. In the new one, the servo repeats only cuts that the carver has not made yet.
  bool undo();
  /// Redoes the stroke that was undone last. Returns false during a stroke, because its first cut has discarded the
  /// undone strokes.
  bool redo();
  /// Ends the stroke: the next cut begins a new stroke. A stroke that changed nothing is discarded.
  void end_stroke();
  /// Tells the carver that all cuts up to time t (clock of the cuts) have been applied. Ends the stroke if more time
  /// than the pause between strokes has passed since the last cut.
  void rest(Nanos t);

  /// Returns an empty snapshot whose buffers are allocated, for take_snapshot().
  std::unique_ptr<Snapshot> make_snapshot() const { return body_->make_snapshot(); }
  /// Returns true if the last undo, redo or loose piece is not in a snapshot yet. The carver must then take a snapshot
  /// before it applies the next cut; otherwise the servo would not count this cut's volume.
  bool edited() const {
    return snapshots_ > 0 && (edits_in_snapshot_ != edits_ || pieces_in_snapshot_ != piece_count_);
  }
  /// Returns true if the servo needs a new snapshot: after a change, or if the tool is far from the last snapshot's
  /// centre. Call it with every tick, because it also estimates the tool's velocity.
  bool snapshot_due(const ServoTick& tick);
  /// Returns the centre for the next snapshot, m: between proxy and hand, and moved ahead of the tool if
  /// TissueBody::leads() is true.
  dvec3 snapshot_center(const ServoTick& tick) const;
  /// Fills a snapshot with the tissue around `center_W`. `number`: its number; 0: the next number. `held`: number of
  /// the servo's snapshot; 0: unknown. `snapshot` may contain only what snapshot `held` lacks (Snapshot::from).
  void take_snapshot(const dvec3& center_W, Snapshot& snapshot, std::uint32_t number = 0, std::uint32_t held = 0);
  /// Updates the newest snapshot to the current tissue, and makes it complete. After an undo or redo, returns false and
  /// changes nothing; a new snapshot is then due.
  bool bring_up_to_date(Snapshot& snapshot);
  void remember_writes(bool wanted) { body_->remember_writes(wanted); }

  /// Returns the tissue as a distance field (TissueBody::rasterize).
  TissueVolume& volume() { return body_->rasterize(); }
  const TissueVolume& volume() const { return body_->rasterize(); }
  /// Returns the body's own triangles (TissueBody::surface). If null, the renderer must draw volume().
  TissueSurface* surface() { return body_->surface(); }
  TissueVolume::Strokes strokes() { return body_->strokes(); }
  /// Moves volume() out of the carver. Its mesh: the triangles of surface() if there are any; otherwise the mesh from
  /// the file, or none after a cut. Afterwards the carver must not be used.
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
  // Distance that the tool may move before a new snapshot is due, m (TissueBody::travel).
  double travel_;
  std::uint64_t cuts_ = 0;
  Pose end_;                    // pose of the tool at which the last cut ended
  std::uint32_t end_tool_ = 0;  // tool of the last cut
  Nanos cut_t_ = 0;             // ns, time of the last cut
  bool in_stroke_ = false;
  std::vector<LoosePiece> pieces_;  // pieces that cuts separated and take_pieces() has not returned yet
  PerTissue loose_volume_{};        // m³, volume of all pieces that cuts separated since construction
  // piece_count_: number of loose pieces since construction. pieces_in_snapshot_: piece_count_ at the last snapshot.
  std::uint32_t piece_count_ = 0, pieces_in_snapshot_ = 0;
  std::uint32_t edits_ = 0, edits_in_snapshot_ = 0;
  std::uint64_t edited_at_ = 0;  // number of cuts (cuts_) at the last undo or redo
  std::uint32_t snapshots_ = 0;
  dvec3 center_W_{0};  // m, centre of the last snapshot
  // Motion of the proxy: time and position of the last tick in snapshot_due(), and low-pass filtered velocity, m/s.
  Nanos seen_t_ = std::numeric_limits<Nanos>::min() / 2;
  dvec3 seen_p_W_{0}, velocity_W_{0};
};

}  // namespace typodont::haptics
