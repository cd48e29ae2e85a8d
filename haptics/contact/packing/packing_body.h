// "packing" on the carver thread: spheres, undo, and the field computed from them.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "haptics/contact/packing/loose_spheres.h"
#include "haptics/contact/packing/packing_parts.h"
#include "haptics/contact/tissue_body.h"

namespace typodont::haptics::packing {

/// Carver thread. A cut changes spheres only; the field follows on request: where the cutting ball lay deepest, its
/// part in the sphere and the gaps around becomes air. A note is kept whenever that place has moved by 0.03 voxel, so
/// the field depends on the cuts, not on the requests, within 0.03 voxel.
class PackingBody final : public TissueBody {
 public:
  /// Throws Error if `packing` is not of `tissue`.
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
    CutSphere state;  // before the stroke; undone: after it
    // m, of the cutting ball in the last Note
    dvec3 last_noted;
  };
  struct Stroke {
    std::vector<Kept> kept;
    // also changed volume_, for example a brush
    bool in_field = false;
  };
  /// Removed part of a sphere; waits for the field's update.
  struct Note {
    int sphere;
    dvec3 p_W;  // m, centre of the cutting ball
    double r;   // m, its radius
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
  std::vector<Tissue> label_;  // at each sphere's first centre
  std::vector<ToolSpheres> tools_;
  CutBuffers buffers_;
  LooseSpheres loose_;
  std::vector<LoosePiece> pieces_;
  std::vector<Stroke> done_, undone_;
  bool in_stroke_ = false;
  std::vector<std::uint64_t> kept_in_;  // stroke that last stored its state
  std::uint64_t stroke_ = 0;
  std::vector<LooseSpheres::Changed> cut_now_;  // spheres that the present cut has changed
  std::vector<std::uint64_t> changed_in_;       // cut that last changed it
  std::uint64_t cut_number_ = 0;
  PerTissue taken_back_{};
  bool remembers_ = false;
  std::vector<int> written_;  // spheres that changed since remember_writes(true) was called
  // m, per sphere, of the cutting ball in its last Note
  std::vector<dvec3> last_noted_;
  std::vector<Note> notes_;
  std::uint64_t paints_ = 0;  // of volume_, applied to the spheres
  bool repainted_ = false;    // since the last snapshot
};

}  // namespace typodont::haptics::packing
