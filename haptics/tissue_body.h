// The tissue in the form that a contact model needs, as the carver sees it.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/contract/contact.h"
#include "haptics/snapshot.h"
#include "haptics/tissue_surface.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics {

/// Carver thread only (or the one thread of a deterministic run). Sole owner of the tissue. Equal calls, equal bits.
/// The Carver keeps the order of cuts, strokes and edits; a body only does what it is told.
class TissueBody {
 public:
  virtual ~TissueBody() = default;

  /// Version of the servo's laws whose cuts this body repeats. Called before the first cut.
  virtual void set_laws(std::uint32_t /*laws*/) {}

  // Removal.
  /// Removes what the head of `cut` takes on its way from A to B. `continues`: the cut before ended at A with the same
  /// tool, so only what lies ahead can change.
  virtual void carve(const Cut& cut, bool continues) = 0;
  /// Adds the filling of `cut` (fill_radius > 0).
  virtual void fill(const Cut& cut) = 0;
  /// The pieces that carve() set loose and removed since the last call.
  virtual std::vector<LoosePiece> take_pieces() = 0;

  // Strokes: what carve() and fill() change from begin_stroke() on can be taken back as one.
  virtual void begin_stroke() = 0;
  /// The stroke is over: nothing more comes to it.
  virtual void end_stroke() = 0;
  /// False when there is none.
  virtual bool undo() = 0;
  virtual bool redo() = 0;
  /// m³ that undo brought back so far, less what redo removed again.
  virtual PerTissue taken_back() const = 0;
  /// Those that can be taken back and brought again; the one that is being made counts.
  virtual TissueVolume::Strokes strokes() { return rasterize().strokes(); }

  // Snapshots for the servo.
  /// An empty snapshot with all buffers sized.
  virtual std::unique_ptr<Snapshot> make_snapshot() const = 0;
  /// m that the tool may move before another snapshot is due; infinity where one holds all of the tissue.
  virtual double travel() const = 0;
  /// Whether what was removed calls for another snapshot at time t, of a method whose servo does not cut its own.
  virtual bool wants_snapshot(Nanos /*t*/) const { return false; }
  /// Fills `snapshot` with the tissue around snapshot.center_W. Its other members are set by the carver.
  virtual void cut_out(Snapshot& snapshot) = 0;
  /// From now on writes are remembered, or no longer, for bring_up_to_date().
  virtual void remember_writes(bool wanted) = 0;
  /// Brings the newest snapshot to what it would be if it were taken now, from the writes that are remembered.
  virtual void bring_up_to_date(Snapshot& snapshot) = 0;

  /// The tissue as a distance field with labels: for pictures, scores, sections, reports, files. A body of another form
  /// brings it up to date first, where it changed. What is written to it (painting) is taken over by the body.
  virtual TissueVolume& rasterize() = 0;
  /// The body's own triangles, which pictures then show instead of the field's surface; null where it has none. The
  /// same object in every call; the first one makes it.
  virtual TissueSurface* surface() { return nullptr; }
  /// How many elements (voxels with tissue, spheres, vertices) the body consists of.
  virtual std::uint64_t elements() const = 0;
};

}  // namespace typodont::haptics
