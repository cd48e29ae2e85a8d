// The part of the contact model "packing" that runs on the carver thread. It owns the spheres, the strokes for undo,
// and the distance field that is computed from the spheres.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "haptics/contact/packing/loose_spheres.h"
#include "haptics/contact/packing/packing_parts.h"
#include "haptics/tissue_body.h"

namespace typodont::haptics::packing {

/// The tissue as spheres, and the distance field that is computed from them. Carver thread only. A cut changes only the
/// spheres; the field is updated on request. Each cut sphere stores the position that the tool's ball (a sphere of the
/// tool) had at the deepest overlap. In the field, the part of this ball that lies in the sphere and in the gaps around
/// it becomes air. Whenever this position has moved by 0.03 voxel, a note with the position is stored for the update.
/// So the field depends only on the cuts and not on the times of the requests, and its error is at most 0.03 voxel.
class PackingBody final : public TissueBody {
 public:
  /// Throws Error if `packing` was not made from `tissue`.
  PackingBody(TissueVolume tissue, const SpherePacking& packing, std::span<const Tool> tools,
              const Parameters& parameters);

  void carve(const Cut& cut, bool continues) override;
  /// Never called, because the model refuses filling instruments.
  void fill(const Cut& cut) override;
  std::vector<LoosePiece> take_pieces() override { return std::exchange(pieces_, {}); }
  void begin_stroke() override;
  void end_stroke() override;
  bool undo() override;
  bool redo() override;
  PerTissue taken_back() const override { return taken_back_; }
  std::unique_ptr<Snapshot> make_snapshot() const override;
  double travel() const override;
  void cut_out(Snapshot& snapshot, std::uint32_t held) override;
  void remember_writes(bool wanted) override;
  void bring_up_to_date(Snapshot& snapshot) override;
  TissueVolume& rasterize() override;
  std::uint64_t elements() const override { return spheres_.size(); }
  const SphereTissue& spheres() const { return spheres_; }

 private:
  struct Kept {
    int sphere;
    CutSphere state;  // state of the sphere before the stroke; after an undo: its state after the stroke
    // m, position of the cutting tool sphere in the last Note (a change that waits for the field's update)
    dvec3 last_noted;
  };
  struct Stroke {
    std::vector<Kept> kept;
    // true if the stroke also changed the distance field and the labels (volume_), for example a brush stroke
    bool in_field = false;
  };
  /// A ball (sphere of the tool) that removed a part of a tissue sphere. The note waits until the field is updated.
  struct Note {
    int sphere;
    dvec3 p_W;  // m, centre of the ball (sphere of the tool) that cut
    double r;   // m, radius of the ball (sphere of the tool) that cut
  };
  void changed(int i, const CutSphere& before);
  void note(int i, const CutSphere& state);
  void exchange(Stroke& stroke);
  void take_out_pieces(const Cut& cut);
  void take_over_paint();
  void take_back_paint();
  void read_materials();
  std::size_t strokes_in_field() const;

  TissueVolume volume_;
  SpherePacking packing_;
  SphereTissue spheres_;
  Parameters parameters_;
  std::vector<Tissue> label_;  // for each sphere: label of the field at its initial centre
  std::vector<ToolSpheres> tools_;
  CutBuffers buffers_;
  LooseSpheres loose_;
  std::vector<LoosePiece> pieces_;
  std::vector<Stroke> done_, undone_;
  bool in_stroke_ = false;
  std::vector<std::uint64_t> kept_in_;  // for each sphere: number of the stroke that last stored its state
  std::uint64_t stroke_ = 0;
  std::vector<LooseSpheres::Changed> cut_now_;  // spheres that the present cut has changed
  std::vector<std::uint64_t> changed_in_;       // for each sphere: number of the last cut that changed it
  std::uint64_t cut_number_ = 0;
  PerTissue taken_back_{};
  bool remembers_ = false;
  std::vector<int> written_;  // spheres that changed since remember_writes(true) was called
  // m, for each tissue sphere: position of the cutting tool sphere in its last Note (a change that waits for the
  // field's update)
  std::vector<dvec3> last_noted_;
  std::vector<Note> notes_;
  std::uint64_t paints_ = 0;  // number of brush strokes in volume_ that have already been applied to the spheres
  bool repainted_ = false;    // true if the tissue was painted since the last snapshot
};

}  // namespace typodont::haptics::packing
