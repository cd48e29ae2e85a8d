// Chips for the picture: born from cuts, bouncing off a coarse copy of the tissue. Render thread.
#pragma once

#include <span>
#include <vector>

#include "engine/debris/debris.h"
#include "engine/render/renderer.h"
#include "haptics/tissue_volume.h"

namespace typodont {

class DebrisView {
 public:
  DebrisView(const MaterialTable& materials, const haptics::TissueVolume& tissue);

  void add(const Cut& cut, const haptics::Tool& tool) noexcept {
    if (cut.fill_radius == 0) debris_.emit(cut, tool.radius(), materials_);
  }
  /// A loose piece falls apart where it was.
  void add(const LoosePiece& piece) noexcept {
    Cut cut;
    cut.index = piece.cut;
    cut.X_WA.p = cut.X_WB.p = piece.center_W;
    cut.removed = piece.removed;
    debris_.emit(cut, piece.radius, materials_);
  }
  void step(double dt) noexcept { debris_.step(dt, field_); }
  /// As the renderer draws them; valid until the next call.
  std::span<const render::Particle> particles();
  const debris::Debris& debris() const { return debris_; }

 private:
  MaterialTable materials_;
  debris::Debris debris_;
  std::vector<float> distance_;
  debris::CoarseField field_;
  std::vector<debris::DebrisPoint> points_;
  std::vector<render::Particle> particles_;
};

}  // namespace typodont
