// The carver's half of "packing": the spheres, their strokes, and the field that is made of them.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "haptics/contact/packing/loose_spheres.h"
#include "haptics/contact/packing/packing_parts.h"
#include "haptics/tissue_body.h"

namespace typodont::haptics::packing {

/// Carver thread. Cuts are made in the spheres alone; the field follows when it is asked for.
///
/// The field: each sphere that is cut knows where the tool's ball was when it reached deepest into the sphere. Around
/// the sphere, as far as the gaps beside it reach, the field is raised to that ball's depth. Spheres note where the
/// ball was once it has moved on by three hundredths of a voxel, so the field depends on the cuts alone, not on when it
/// is asked for, and is true to that much.
class PackingBody final : public TissueBody {
 public:
  /// `packing` must have been made from `tissue`. Throws Error where it was not.
  PackingBody(TissueVolume tissue, const SpherePacking& packing, std::span<const Tool> tools,
              const Parameters& parameters);

  void carve(const Cut& cut, bool continues) override;
  /// Never called: the model refuses tools that fill.
  void fill(const Cut& cut) override;
  std::vector<LoosePiece> take_pieces() override { return std::exchange(pieces_, {}); }
  void begin_stroke() override;
  void end_stroke() override;
  bool undo() override;
  bool redo() override;
  PerTissue taken_back() const override { return taken_back_; }
  std::unique_ptr<Snapshot> make_snapshot() const override;
  double travel() const override;
  void cut_out(Snapshot& snapshot) override;
  void remember_writes(bool wanted) override;
  void bring_up_to_date(Snapshot& snapshot) override;
  TissueVolume& rasterize() override;
  std::uint64_t elements() const override { return spheres_.size(); }
  const SphereTissue& spheres() const { return spheres_; }

 private:
  struct Kept {
    int sphere;
    CutSphere state;   // before the stroke; after an undo: after the stroke
    dvec3 last_noted;  // m
  };
  struct Stroke {
    std::vector<Kept> kept;
    bool in_field = false;  // the volume has it, too
  };
  /// A ball of the tool that took something of a sphere, not yet in the field.
  struct Note {
    int sphere;
    dvec3 p_W;  // m
    double r;   // m
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
  std::vector<float> fitted_;
  std::vector<Tissue> label_;  // of the field, at each sphere's centre at the start
  std::vector<ToolSpheres> tools_;
  CutBuffers buffers_;
  LooseSpheres loose_;
  std::vector<LoosePiece> pieces_;
  std::vector<Stroke> done_, undone_;
  bool in_stroke_ = false;
  std::vector<std::uint64_t> kept_in_;  // the stroke that last kept each sphere's state
  std::uint64_t stroke_ = 0;
  std::vector<LooseSpheres::Changed> cut_now_;  // by the cut that is being made
  std::vector<std::uint64_t> changed_in_;       // the cut that last changed each sphere
  std::uint64_t cut_number_ = 0;
  PerTissue taken_back_{};
  bool remembers_ = false;
  std::vector<int> written_;       // since remember_writes(true)
  std::vector<dvec3> last_noted_;  // m, of each sphere: where the tool's ball was
  std::vector<Note> notes_;
  std::uint64_t paints_ = 0;  // of the volume, as far as the spheres know
  bool repainted_ = false;    // since the last snapshot
};

}  // namespace typodont::haptics::packing
