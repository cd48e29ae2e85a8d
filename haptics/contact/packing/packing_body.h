// The part of the contact model "packing" that runs on the carver thread: the spheres, their strokes, and the field
// computed from them.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "haptics/contact/packing/loose_spheres.h"
#include "haptics/contact/packing/packing_parts.h"
#include "haptics/tissue_body.h"

namespace typodont::haptics::packing {

/// Carver thread. Cuts change only the spheres; the field is updated on request, as follows. Each cut sphere stores
/// the position of the tool's ball at its deepest overlap. Around the sphere, including the gaps beside it, the field
/// is raised to the depth of that ball. A sphere adds a note about the ball's position whenever the ball has moved by
/// 0.03 voxel. So the field depends only on the cuts, not on the times of the requests, and the error of the field is
/// at most 0.03 voxel.
class PackingBody final : public TissueBody {
 public:
  /// `packing` must have been made from `tissue`; otherwise throws Error.
  PackingBody(TissueVolume tissue, const SpherePacking& packing, std::span<const Tool> tools,
              const Parameters& parameters);

  void carve(const Cut& cut, bool continues) override;
  /// Is never called, because the model refuses filling instruments.
  void fill(const Cut& cut) override;
  std::vector<LoosePiece> take_pieces() override { return std::exchange(pieces_, {}); }
  void begin_stroke() override;
  void end_stroke() override;
  bool undo() override;
  bool redo() override;
  PerTissue taken_back() const override { return taken_back_; }
  void set_laws(std::uint32_t laws) override;
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
    CutSphere state;   // state before the stroke; after an undo: state after the stroke
    dvec3 last_noted;  // m, position of the tool's ball in the sphere's last note
  };
  struct Stroke {
    std::vector<Kept> kept;
    bool in_field = false;  // the stroke also exists in the volume
  };
  /// A ball of the tool that removed a part of a sphere; the removal is not yet applied to the field.
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
  void set_tools(std::uint32_t laws);
  std::size_t strokes_in_field() const;

  TissueVolume volume_;
  SpherePacking packing_;
  SphereTissue spheres_;
  Parameters parameters_;
  std::vector<Tool> tool_set_;
  std::vector<Tissue> label_;  // label of the field at each sphere's initial centre
  std::vector<ToolSpheres> tools_;
  CutBuffers buffers_;
  LooseSpheres loose_;
  std::vector<LoosePiece> pieces_;
  std::uint32_t laws_ = kServoLaws;  // version of the force laws of the servo whose cuts this body repeats
  std::vector<Stroke> done_, undone_;
  bool in_stroke_ = false;
  std::vector<std::uint64_t> kept_in_;  // for each sphere: number of the stroke that last stored its state
  std::uint64_t stroke_ = 0;
  std::vector<LooseSpheres::Changed> cut_now_;  // spheres changed by the present cut
  std::vector<std::uint64_t> changed_in_;       // for each sphere: number of the cut that last changed it
  std::uint64_t cut_number_ = 0;
  PerTissue taken_back_{};
  bool remembers_ = false;
  std::vector<int> written_;       // spheres changed since remember_writes(true)
  std::vector<dvec3> last_noted_;  // m, for each sphere: position of the tool's ball in the sphere's last note
  std::vector<Note> notes_;
  std::uint64_t paints_ = 0;  // number of the volume's brush strokes that the spheres already include
  bool repainted_ = false;    // the tissue was painted since the last snapshot
};

}  // namespace typodont::haptics::packing
