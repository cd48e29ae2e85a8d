// The part of a contact method that runs on the carver thread. It owns the tissue in the form that the method needs.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "engine/base/check.h"
#include "engine/contract/contact.h"
#include "haptics/contact/snapshot.h"
#include "haptics/mesh/tissue_surface.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics {

/// Owns the tissue in the form that a contact method needs. Carver thread only. Equal calls give bit-identical tissue.
/// The class Carver determines the order of cuts, strokes, undo and redo; this class executes them.
class TissueBody {
 public:
  virtual ~TissueBody() = default;

  // Functions for cuts and strokes.
  /// Removes the tissue that the head of `cut` covers on its path from A to B. `continues`: true if the previous cut
  /// ended at A with the same tool; only tissue ahead of the head can then change.
  virtual void carve(const Cut& cut, bool continues) = 0;
  /// Adds the filling of `cut`, whose fill_radius is above 0. Not called if the model refuses filling instruments.
  virtual void fill(const Cut& /*cut*/) { TYPODONT_CHECK(false); }
  /// Loose pieces that carve() removed since the last call.
  virtual std::vector<LoosePiece> take_pieces() = 0;

  // Starts a stroke, which can be undone as a whole.
  virtual void begin_stroke() = 0;
  /// Ends the stroke; later changes do not belong to it.
  virtual void end_stroke() = 0;
  /// undo() reverts the last stroke, and redo() repeats the stroke that was undone last. Each returns false if there is
  /// no such stroke. Never called during a stroke.
  virtual bool undo() = 0;
  virtual bool redo() = 0;
  /// Volume of each tissue that all undos have restored, minus the volume that redos have removed again, m³.
  virtual PerTissue taken_back() const = 0;
  /// Number of strokes that can be undone and redone, including the current stroke.
  virtual TissueVolume::Strokes strokes() { return rasterize().strokes(); }

  // Functions for snapshots.
  /// Returns an empty snapshot for the servo, whose buffers already have their full size.
  virtual std::unique_ptr<Snapshot> make_snapshot() const = 0;
  /// Distance in m that the tool may move before a new snapshot is due; infinity if a snapshot contains the whole
  /// tissue.
  virtual double travel() const { return std::numeric_limits<double>::infinity(); }
  /// Returns true if snapshots should be centred ahead of the moving tool.
  virtual bool leads() const { return false; }
  /// Returns true if a new snapshot is due at time t because of cuts. Only for methods whose servo does not apply its
  /// cuts to its own snapshot.
  virtual bool wants_snapshot(Nanos /*t*/) const { return false; }
  /// Copies the tissue around snapshot.center_W. If no copy can have this centre, uses the nearest possible centre and
  /// stores it in snapshot.center_W. `held`: number of the servo's snapshot; 0: unknown. The copy may contain only what
  /// the servo's snapshot lacks; then snapshot.from becomes `held`.
  virtual void cut_out(Snapshot& snapshot, std::uint32_t held) = 0;
  /// Starts (`wanted` is true) or stops to record which parts of the tissue change. bring_up_to_date() needs this
  /// record.
  virtual void remember_writes(bool wanted) = 0;
  /// Applies the recorded changes to `snapshot`, which is the newest snapshot.
  virtual void bring_up_to_date(Snapshot& snapshot) = 0;

  /// Returns the tissue as a distance field with labels, for rendering, scores, reports and files. A body with another
  /// form of the tissue first updates this field. If the caller paints into the field, the body adopts the changes.
  virtual TissueVolume& rasterize() = 0;
  /// The body's own triangles, which the renderer then shows instead of the field's surface; null if there are none.
  /// The first call creates the object; later calls return the same object.
  virtual TissueSurface* surface() { return nullptr; }
  /// Number of elements of the tissue: voxels with tissue, spheres, or vertices of the mesh.
  virtual std::uint64_t elements() const = 0;
};

/// For undo and redo in a body with its own lists of strokes: calls exchange(stroke) for the last stroke of `from`, and
/// moves it to the end of `to`. Returns false if there is none.
template <class Strokes, class Exchange>
bool move_last(Strokes& from, Strokes& to, Exchange exchange) {
  if (from.empty()) return false;
  exchange(from.back());
  to.push_back(std::move(from.back()));
  from.pop_back();
  return true;
}

}  // namespace typodont::haptics
