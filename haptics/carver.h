// The carver: sole owner of the tissue volume. Repeats the servo's cuts on it and cuts out fresh patches.
#pragma once

#include <span>
#include <vector>

#include "engine/contract/contact.h"
#include "haptics/surface_patch.h"
#include "haptics/tissue_volume.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// Carver thread only (or the one thread of a deterministic run).
class Carver {
 public:
  /// `tools` as Cut::tool numbers them.
  Carver(TissueVolume volume, std::span<const Tool> tools);

  /// Cuts arrive in order and without gaps.
  void apply(const Cut& cut);

  /// True when the servo needs a fresh patch: it has none, or the tool moved far from the last one's centre.
  bool patch_due(const ServoTick& tick) const;
  /// Where that patch should lie: between the tool and the hand that pulls it. m.
  dvec3 patch_center(const ServoTick& tick) const;
  /// Fills a patch around `center_W`. The patch keeps its size.
  void cut_out(const dvec3& center_W, SurfacePatch& patch);

  TissueVolume& volume() { return volume_; }
  const TissueVolume& volume() const { return volume_; }
  std::uint64_t cuts() const { return cuts_; }

 private:
  TissueVolume volume_;
  std::vector<Tool> tools_;
  std::uint64_t cuts_ = 0;
  Pose end_;                   // where the last cut ended …
  std::uint32_t end_tool_ = 0;  // … and of which tool
  std::uint32_t patches_ = 0;
  dvec3 center_W_{0};
  double travel_ = 0;  // m
};

}  // namespace typodont::haptics
