// What the two halves of the packing model share: parameters, the snapshot, the cut.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "engine/contract/contact.h"
#include "haptics/contact/packing/sphere_tissue.h"
#include "haptics/contact/packing/tool_spheres.h"
#include "haptics/snapshot.h"

namespace typodont::haptics::packing {

/// Densities of S2, sec. IV A: enamel about 1.5 times as hard as dentin, caries 0.6 to 0.8 of that, pulp no resistance.
/// Bone, gingiva and fillings by comparison.
constexpr PerTissue default_densities() {
  PerTissue d{};
  const auto set = [&](Tissue t, double value) { d[static_cast<std::size_t>(t)] = value; };
  set(Tissue::kEnamel, 1.5), set(Tissue::kDentin, 1), set(Tissue::kCaries, 0.7), set(Tissue::kPulp, 0);
  set(Tissue::kCorticalBone, 1), set(Tissue::kCancellousBone, 0.4), set(Tissue::kGingiva, 0.1);
  set(Tissue::kAmalgam, 1), set(Tissue::kComposite, 1);
  return d;
}

struct Parameters {
  std::size_t spheres = 36000;    // of the tissue
  std::uint64_t seed = 1;         // of the packings of tissue and tools
  std::filesystem::path file;     // a packing to use instead; empty: none
  std::size_t tool_spheres = 60;  // of a head that is no ball
  double base_speed = 1e-3;       // m/s at density 1, v_b of eq. 4
  double free_speed = 0.1;        // m/s, where the density is so low that eq. 4 would give more
  bool by_contact = false;        // ρ of eq. 3, which grows with the contact (reaming), instead of ρ̂ (drilling)
  double epsilon = 0.05e-3;       // m, by which the tool is larger where the surface is estimated
  PerTissue density = default_densities();
  Removal removal = Removal::kMended;
};

/// All spheres as they are: this model's snapshots hold the whole tissue.
struct PackingSnapshot final : Snapshot {
  SphereTissue spheres;
};

/// Buffers for one cut, sized at set-up.
struct CutBuffers {
  explicit CutBuffers(std::size_t spheres) : changed(spheres), before(spheres) {}
  std::vector<int> changed;
  std::vector<CutSphere> before;
};

/// Takes away what the tool covers on its way from A to B; servo and carver both call it and hold the same bits. Calls
/// keep(number, sphere before) for each sphere that changes, if given. Returns the volume, m³.
template <class Keep>
PerTissue carve(SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WA, const Pose& X_WB, CutBuffers& buffers,
                Keep&& keep) noexcept(noexcept(keep(0, CutSphere{}))) {
  PerTissue removed{};
  for (std::size_t t = 0; t < tool.radius.size(); ++t) {
    const std::size_t count = tissue.cut(X_WA * tool.center_T[t], X_WB * tool.center_T[t], tool.radius[t],
                                         buffers.changed, buffers.before, removed);
    for (std::size_t k = 0; k < count; ++k) keep(buffers.changed[k], buffers.before[k]);
  }
  return removed;
}

}  // namespace typodont::haptics::packing
