// The part of a contact method that runs on the carver thread. It owns the tissue in the form that the method needs.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/contract/contact.h"
#include "haptics/contact/snapshot.h"
#include "haptics/mesh/tissue_surface.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics {

/// The tissue in the form that a contact method needs. A body is the only owner of the tissue. Used only by the carver
/// thread (in a deterministic run: by its only thread). Equal calls give the same bits. The class Carver determines the
/// order of cuts, strokes and edits; a body only executes them.
class TissueBody {
 public:
  virtual ~TissueBody() = default;

  // Functions for cuts and strokes.
  /// Removes the tissue that the head of `cut` covers on its path from A to B. `continues`: true if the previous cut
  /// ended at A with the same tool; only tissue ahead of the head can then change.
  virtual void carve(const Cut& cut, bool continues) = 0;
  /// Adds the filling of `cut`, whose fill_radius is above 0.
  virtual void fill(const Cut& cut) = 0;
  /// Returns the loose pieces that carve() removed since the last call.
  virtual std::vector<LoosePiece> take_pieces() = 0;

  // Starts a stroke: all following changes by carve() and fill() can be undone together.
  virtual void begin_stroke() = 0;
  /// Ends the stroke; later changes do not belong to it any more.
  virtual void end_stroke() = 0;
  /// undo() reverts the last stroke, and redo() repeats the stroke that was undone last. Each returns false if there is
  /// no such stroke. Never called during a stroke.
  virtual bool undo() = 0;
  virtual bool redo() = 0;
  /// Returns the volume that all undos have restored, minus the volume that redos have removed again, m³.
  virtual PerTissue taken_back() const = 0;
  /// Returns the number of strokes that can be undone and redone, including the present stroke.
  virtual TissueVolume::Strokes strokes() { return rasterize().strokes(); }

  // Functions for snapshots.
  /// Returns an empty snapshot for the servo, whose buffers already have their full size.
  virtual std::unique_ptr<Snapshot> make_snapshot() const = 0;
  /// Returns the distance in m that the tool may move before a new snapshot is due; infinity if a snapshot contains the
  /// whole tissue.
  virtual double travel() const = 0;
  /// Returns true if the carver centres snapshots ahead of the moving tool.
  virtual bool leads() const { return false; }
  /// Returns true if a new snapshot is due at time t because of cuts. Only for methods whose servo does not apply its
  /// cuts to its own snapshot.
  virtual bool wants_snapshot(Nanos /*t*/) const { return false; }
  /// Copies the tissue around snapshot.center_W to `snapshot`. The carver itself sets the members of the base class
  /// Snapshot. If the body can only copy around certain points, it changes snapshot.center_W to the nearest one.
  /// `held`: number of the snapshot that the servo will hold when it adopts this one; 0: unknown. If it is known, the
  /// body may copy only what that snapshot lacks, and then sets snapshot.from to `held`.
  virtual void cut_out(Snapshot& snapshot, std::uint32_t held) = 0;
  /// Starts (`wanted` is true) or stops to record which parts of the tissue change. bring_up_to_date() needs this
  /// record.
  virtual void remember_writes(bool wanted) = 0;
  /// Updates the newest snapshot to the present tissue, using the recorded changes.
  virtual void bring_up_to_date(Snapshot& snapshot) = 0;

  /// Returns the tissue as a distance field with labels, for rendering, scores, sections, reports and files. If the
  /// body stores the tissue in another form, it first updates this field. The caller may write to the field (painting);
  /// the body then changes its own form of the tissue accordingly.
  virtual TissueVolume& rasterize() = 0;
  /// Returns the body's own triangles, which the renderer then shows instead of the field's surface; null if there are
  /// none. The first call creates the object; later calls return the same object.
  virtual TissueSurface* surface() { return nullptr; }
  /// Returns the number of elements of the body: voxels with tissue, spheres, or vertices.
  virtual std::uint64_t elements() const = 0;
};

}  // namespace typodont::haptics
