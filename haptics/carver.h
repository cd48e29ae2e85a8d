// The carver: repeats the servo's cuts on the tissue, keeps strokes and edits in order, takes snapshots for the servo.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "engine/contract/contact.h"
#include "haptics/contact_method.h"
#include "haptics/servo.h"
#include "haptics/tissue_body.h"

namespace typodont::haptics {

/// Carver thread only (or the one thread of a deterministic run). Owner of the tissue body.
class Carver {
 public:
  /// `tools` as Cut::tool numbers them. Throws Error where the method refuses the tissue.
  Carver(TissueVolume tissue, std::span<const Tool> tools, const SharedContactMethod& method = nullptr);
  /// Tools, method and laws of the settings.
  Carver(TissueVolume tissue, const ServoSettings& settings);

  /// Cuts arrive in order and without gaps. Those with no pause between them are one stroke. Pieces that a cut sets
  /// loose are removed with it, in its stroke; a snapshot is then due. Equal cuts, equal pieces.
  void apply(const Cut& cut);
  /// The pieces that were removed since the last call.
  std::vector<LoosePiece> take_pieces();

  /// Whether this cut, as the next one, would begin another stroke.
  bool begins_stroke(const Cut& cut) const;

  /// Takes the last stroke back, or brings it again; false when there is none. A snapshot is due then, and the servo
  /// starts again from that: what it cut out of older ones does not count.
  bool undo();
  bool redo() { return edit(body_->redo()); }
  /// The stroke is over, and the next cut begins another one; a stroke that changed nothing is forgotten.
  void end_stroke();
  /// All cuts up to t, on their clock, have been applied: if the last stroke is over by then, what its undoing needs is
  /// computed now, so that it need not be when it is asked for.
  void rest(Nanos t);

  /// An empty snapshot with all buffers sized.
  std::unique_ptr<Snapshot> make_snapshot() const { return body_->make_snapshot(); }
  /// True when the servo needs a fresh snapshot: it has none, or the tool moved far from the last one's centre.
  bool snapshot_due(const ServoTick& tick) const;
  /// Where that snapshot should lie: between the tool and the hand that pulls it. m.
  dvec3 snapshot_center(const ServoTick& tick) const;
  /// Fills a snapshot with the tissue around `center_W`. `number`: of a replay, the recorded one (a live servo may have
  /// passed over some); 0: the next one.
  void take_snapshot(const dvec3& center_W, Snapshot& snapshot, std::uint32_t number = 0);
  /// Brings the newest snapshot to what it would be if it were taken now, touching only what cuts and fillings have
  /// written since remember_writes(). False, and nothing done, where more has happened and another one is due.
  bool bring_up_to_date(Snapshot& snapshot);
  void remember_writes(bool wanted) { body_->remember_writes(wanted); }

  /// The tissue as a field (TissueBody::rasterize).
  TissueVolume& volume() { return body_->rasterize(); }
  const TissueVolume& volume() const { return body_->rasterize(); }
  /// The tissue's own triangles, where the body has them (TissueBody::surface); null: pictures show volume().
  TissueSurface* surface() { return body_->surface(); }
  TissueVolume::Strokes strokes() { return body_->strokes(); }
  /// The tissue as it was left, to go on with: volume(), and as its mesh the body's own triangles; none where it has no
  /// triangles and something was cut. The carver is of no use afterwards.
  TissueVolume take_tissue();
  const TissueBody& body() const { return *body_; }
  std::uint64_t cuts() const { return cuts_; }
  std::uint32_t snapshots() const { return snapshots_; }

 private:
  bool edit(bool done);
  void collect_pieces();

  std::unique_ptr<TissueBody> body_;
  std::size_t tool_count_;
  double travel_;  // m, the body's
  std::uint64_t cuts_ = 0;
  Pose end_;                    // where the last cut ended …
  std::uint32_t end_tool_ = 0;  // … and of which tool
  Nanos cut_t_ = 0;             // of the last cut
  bool in_stroke_ = false;
  std::vector<LoosePiece> pieces_;  // removed, not yet taken
  PerTissue loose_volume_{};        // m³ of all so far
  // How many there were, and how many when the last snapshot was taken.
  std::uint32_t piece_count_ = 0, pieces_in_snapshot_ = 0;
  std::uint32_t edits_ = 0, edits_in_snapshot_ = 0;
  std::uint64_t edited_at_ = 0;  // cuts_ at the last edit
  std::uint32_t snapshots_ = 0;
  dvec3 center_W_{0};  // m, of the last snapshot
};

}  // namespace typodont::haptics
