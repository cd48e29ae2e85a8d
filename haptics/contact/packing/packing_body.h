// The carver's half of "packing": the spheres, their strokes, and the field that is made of them.
#pragma once

#include <span>
#include <vector>

#include "haptics/contact/packing/packing_parts.h"
#include "haptics/tissue_body.h"

namespace typodont::haptics::packing {

/// Carver thread. Cuts are made in the spheres alone; the field follows when it is asked for.
class PackingBody final : public TissueBody {
 public:
  /// `packing` must have been made from `tissue`. Throws Error where it was not.
  PackingBody(TissueVolume tissue, const SpherePacking& packing, std::span<const Tool> tools,
              const Parameters& parameters);

  void carve(const Cut& cut, bool continues) override;
  /// Never called: the model refuses tools that fill.
  void fill(const Cut& cut) override;
  std::vector<LoosePiece> take_pieces() override { return {}; }
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

 private:
  struct Stroke {
    std::vector<std::pair<int, CutSphere>> changes;  // numbers, and what each was before; after an undo: is afterwards
  };
  void set(int i, const CutSphere& sphere);
  void touch(int i);

  TissueVolume volume_, untouched_;
  SpherePacking packing_;
  SphereTissue spheres_;
  SphereTree original_;
  std::vector<ToolSpheres> tools_;
  CutBuffers buffers_;
  std::vector<Stroke> done_, undone_;
  bool in_stroke_ = false;
  PerTissue taken_back_{};
  bool remembers_ = false;
  std::vector<int> written_;  // since remember_writes(true)
  std::vector<int> unseen_;   // changed since the field was made
};

}  // namespace typodont::haptics::packing
