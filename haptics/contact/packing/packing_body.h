// The carver's part of the contact model "packing": spheres, undo, and the distance field computed from the spheres.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "haptics/contact/packing/loose_spheres.h"
#include "haptics/contact/packing/packing_parts.h"
#include "haptics/contact/tissue_body.h"

namespace typodont::haptics::packing {

/// Carver thread only. Cuts change only spheres. After each 0.03 voxel of motion, a cut notes the removed parts of the
/// spheres. rasterize() updates the distance field from these notes, so the field does not depend on when it is called.
class PackingBody final : public TissueBody {
 public:
  /// Throws Error if `packing` does not belong to `tissue`.
  PackingBody(TissueVolume tissue, const SpherePacking& packing, std::span<const Tool> tools,
              const Parameters& parameters);

  void carve(const Cut& cut, bool continues) override;
  std::vector<LoosePiece> take_pieces() override { return std::exchange(pieces_, {}); }
  void begin_stroke() override;
  void end_stroke() override;
  bool undo() override;
  bool redo() override;
  PerTissue taken_back() const override { return taken_back_; }
  std::unique_ptr<Snapshot> make_snapshot() const override;
  void cut_out(Snapshot& snapshot, std::uint32_t held) override;
  void remember_writes(bool wanted) override;
  void bring_up_to_date(Snapshot& snapshot) override;
  TissueVolume& rasterize() override;
  std::uint64_t elements() const override { return spheres_.size(); }
  const SphereTissue& spheres() const { return spheres_; }

 private:
  struct Kept {
    int sphere;
    CutSphere state;  // sphere before the stroke; for an undone stroke: after the stroke
    // m, centre of the cutting ball in the sphere's newest Note (record of a removed part)
    dvec3 last_noted;
  };
  struct Stroke {
    std::vector<Kept> kept;
    // true: the stroke also changed volume_, as a brush does
    bool in_field = false;
  };
  /// Part of a sphere that was removed, but is still contained in the distance field.
  struct Note {
    int sphere;
    dvec3 p_W;  // m, centre of the cutting ball
    double r;   // m, radius of the cutting ball
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
  std::vector<Tissue> label_;  // for each sphere: tissue label at its initial centre
  std::vector<ToolSpheres> tools_;
  CutBuffers buffers_;
  LooseSpheres loose_;
  std::vector<LoosePiece> pieces_;
  std::vector<Stroke> done_, undone_;
  bool in_stroke_ = false;
  std::vector<std::uint64_t> kept_in_;  // for each sphere: the stroke that stored its state
  std::uint64_t stroke_ = 0;
  std::vector<LooseSpheres::Changed> cut_now_;  // spheres that the current cut has changed
  std::vector<std::uint64_t> changed_in_;       // for each sphere: the cut that last changed it
  std::uint64_t cut_number_ = 0;
  PerTissue taken_back_{};
  bool remembers_ = false;
  std::vector<int> written_;  // spheres that changed since remember_writes(true) was called
  // m, for each sphere: centre of the cutting ball in its newest Note (record of a removed part)
  std::vector<dvec3> last_noted_;
  std::vector<Note> notes_;
  std::uint64_t paints_ = 0;  // number of calls of paint() on volume_ that the spheres have adopted
  bool repainted_ = false;    // true: painting has changed spheres since the last snapshot
};

}  // namespace typodont::haptics::packing
