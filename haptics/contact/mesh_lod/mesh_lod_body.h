// The carver's half of "mesh_lod": the levels of the tissue's mesh.
#pragma once

#include "haptics/contact/mesh_lod/mesh_lod_parts.h"
#include "haptics/tissue_body.h"

namespace typodont::haptics::mesh_lod {

/// Carver thread. The tissue's mesh (surface_mesh) and its levels; nothing removes any of it.
class MeshLodBody final : public TissueBody {
 public:
  /// Throws Error where the tissue has no surface.
  MeshLodBody(TissueVolume tissue, const Parameters& parameters);

  /// carve() and fill() are never called: the model refuses tools that do either.
  void carve(const Cut& cut, bool continues) override;
  void fill(const Cut& cut) override;
  std::vector<LoosePiece> take_pieces() override { return {}; }
  void begin_stroke() override {}
  void end_stroke() override {}
  bool undo() override { return false; }
  bool redo() override { return false; }
  PerTissue taken_back() const override { return {}; }
  std::unique_ptr<Snapshot> make_snapshot() const override { return std::make_unique<MeshSnapshot>(); }
  double travel() const override;
  void cut_out(Snapshot& snapshot) override { static_cast<MeshSnapshot&>(snapshot).levels = levels_; }
  void remember_writes(bool) override {}
  void bring_up_to_date(Snapshot&) override {}
  TissueVolume& rasterize() override { return volume_; }
  std::uint64_t elements() const override { return levels_->vertices.front(); }

 private:
  TissueVolume volume_;
  std::shared_ptr<const Levels> levels_;
};

}  // namespace typodont::haptics::mesh_lod
