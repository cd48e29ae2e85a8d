// The part of a contact method that runs on the carver thread: the tissue in the form that the method needs.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/contract/contact.h"
#include "haptics/snapshot.h"
#include "haptics/tissue_surface.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics {

/// Sole owner of the tissue. Carver thread only (or the only thread of a deterministic run). Equal calls give equal
/// bits. The Carver determines the order of cuts, strokes and edits; a body only executes them.
class TissueBody {
 public:
  virtual ~TissueBody() = default;

  /// `laws`: version of the force laws of the servo whose cuts this body repeats. Called before the first cut.
  virtual void set_laws(std::uint32_t /*laws*/) {}

  // Functions for strokes.
  /// Removes the tissue that the head of `cut` covers on its path from A to B. `continues`: the previous cut ended at A
  /// with the same tool, so only tissue ahead can change.
  virtual void carve(const Cut& cut, bool continues) = 0;
  /// Adds the filling of `cut` (fill_radius > 0).
  virtual void fill(const Cut& cut) = 0;
  /// Returns the pieces that carve() separated and removed since the last call.
  virtual std::vector<LoosePiece> take_pieces() = 0;

  // Begins a stroke: all changes by carve() and fill() from now on can be undone together.
  virtual void begin_stroke() = 0;
  /// Ends the stroke; later changes do not belong to it.
  virtual void end_stroke() = 0;
  /// undo() and redo() return false if there is no stroke to undo or redo.
  virtual bool undo() = 0;
  virtual bool redo() = 0;
  /// m³, volume that all undos brought back, minus what redos removed again.
  virtual PerTissue taken_back() const = 0;
  /// Number of strokes that can be undone and redone, the present stroke included.
  virtual TissueVolume::Strokes strokes() { return rasterize().strokes(); }

  // Functions for snapshots.
  /// Returns an empty snapshot for the servo, with buffers of full size.
  virtual std::unique_ptr<Snapshot> make_snapshot() const = 0;
  /// Distance that the tool may move before a new snapshot is due, m; infinity if a snapshot contains all of the
  /// tissue.
  virtual double travel() const = 0;
  /// Returns true if the removed tissue makes a new snapshot due at time t. Only for methods whose servo does not cut
  /// its own snapshot.
  virtual bool wants_snapshot(Nanos /*t*/) const { return false; }
  /// Fills `snapshot` with the tissue around snapshot.center_W. The carver sets the other members of `snapshot`.
  virtual void cut_out(Snapshot& snapshot) = 0;
  /// Starts or stops remembering writes, for bring_up_to_date().
  virtual void remember_writes(bool wanted) = 0;
  /// Updates the newest snapshot to the present tissue, from the remembered writes.
  virtual void bring_up_to_date(Snapshot& snapshot) = 0;

  /// The tissue as a distance field with labels: for pictures, scores, sections, reports, files. A body of another
  /// form first updates this field if its tissue changed. The caller may also write to the field (painting); the body
  /// adopts these changes.
  virtual TissueVolume& rasterize() = 0;
  /// Returns the body's own triangles, which pictures then show instead of the field's surface; null if the body has
  /// none. The first call makes the object; all calls return the same object.
  virtual TissueSurface* surface() { return nullptr; }
  /// Number of elements of the body: voxels with tissue, spheres or vertices.
  virtual std::uint64_t elements() const = 0;
};

}  // namespace typodont::haptics
