// The carver: sole owner of the tissue volume. Repeats the servo's cuts on it and cuts out fresh patches.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "engine/contract/contact.h"
#include "haptics/surface_patch.h"
#include "haptics/tissue_volume.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// Carver thread only (or the one thread of a deterministic run).
class Carver {
 public:
  /// `tools` as Cut::tool numbers them.
  Carver(TissueVolume volume, std::span<const Tool> tools);

  /// Cuts arrive in order and without gaps. Those with no pause between them are one stroke. Pieces that a cut sets
  /// loose are taken out with it, in its stroke; a patch is then due. Equal cuts, equal pieces.
  void apply(const Cut& cut);
  /// The pieces taken out since the last call.
  std::vector<LoosePiece> take_pieces() { return std::exchange(loose_, {}); }

  /// Whether this cut, as the next one, would begin another stroke.
  bool begins_stroke(const Cut& cut) const;

  /// Takes the last stroke back, or brings it again; false when there is none. A patch is due then, and the servo
  /// starts again from that: what it cut out of older ones does not count.
  bool undo();
  bool redo() { return edit(volume_.redo()); }
  /// The next cut begins another stroke.
  void end_stroke() { in_stroke_ = false; }
  /// All cuts up to then have been applied, t on their clock: where the last stroke is over by then, what its undoing
  /// needs is worked out now, so that it need not be when it is asked for.
  void rest(Nanos t);

  /// True when the servo needs a fresh patch: it has none, or the tool moved far from the last one's centre.
  bool patch_due(const ServoTick& tick) const;
  /// Where that patch should lie: between the tool and the hand that pulls it. m.
  dvec3 patch_center(const ServoTick& tick) const;
  /// Fills a patch around `center_W`. The patch keeps its size.
  void cut_out(const dvec3& center_W, SurfacePatch& patch);
  /// Brings the patch that was cut out last to what it would be if it were cut out now, touching only what cuts and
  /// fillings have written to since remember_writes(). False, and nothing done, where more has happened and another one
  /// is due.
  bool bring_up_to_date(SurfacePatch& patch);
  void remember_writes(bool wanted) { volume_.remember_writes(wanted); }

  TissueVolume& volume() { return volume_; }
  const TissueVolume& volume() const { return volume_; }
  std::uint64_t cuts() const { return cuts_; }
  std::uint32_t patches() const { return patches_; }

 private:
  TissueVolume volume_;
  std::vector<Tool> tools_;
  std::uint64_t cuts_ = 0;
  Pose end_;                    // where the last cut ended …
  std::uint32_t end_tool_ = 0;  // … and of which tool
  bool edit(bool done);
  void take_out_pieces(const Cut& cut, const VoxelBox& written);
  void say_where_cut(SurfacePatch& patch) const;

  LoosePieces watch_;
  std::vector<LoosePiece> loose_;                // taken out, not yet told of
  PerTissue loose_volume_{};                     // m³, of all so far
  std::uint32_t pieces_ = 0, patch_pieces_ = 0;  // taken out; the same when the last patch was cut out

  Nanos cut_t_ = 0;  // of the last cut
  bool in_stroke_ = false;
  std::uint32_t edits_ = 0, patch_edits_ = 0;  // undone or brought again; the same when the last patch was cut out
  std::uint64_t edited_at_ = 0;                // cuts_ at the last edit
  std::uint32_t patches_ = 0;
  dvec3 center_W_{0};
  double travel_ = 0;                   // m
  int wide_every_ = 0, wide_edge_ = 0;  // of the wide patch, where a tool has a shank
};

}  // namespace typodont::haptics
