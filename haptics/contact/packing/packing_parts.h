// Parts of the contact model "packing" for servo and carver thread. Paper S2: Kaluschke et al. 2020 (docs/papers.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "engine/contract/contact.h"
#include "haptics/contact/packing/sphere_tissue.h"
#include "haptics/contact/packing/tool_spheres.h"
#include "haptics/contact/snapshot.h"

namespace typodont::haptics::packing {

struct Parameters {
  std::size_t spheres = 36000;  // number of spheres in the tissue's packing
  std::uint64_t seed = 1;       // random seed for packing tissue and a tool's mesh
  std::filesystem::path file;   // file with the packing; empty: it is computed
  // head of the first tool, as spheres from a closed mesh; empty: spheres from the tool's shape
  std::optional<ToolSpheres> tool_mesh;
  std::size_t tool_spheres = 60;  // number of spheres of a head that is not a ball
  /// m/s, speed of cutting dentin (v_b in eq. 4 of Kaluschke 2020); 0: computed from the motor's power (PackingModel)
  double base_speed = 0;
  double free_speed = 0.02;  // m/s, largest speed of cutting, reached at very low density
  // If base_speed > 0, cutting speed follows from a density: the contact's sum (true) or mean (false; paper S2, eq. 3).
  bool by_contact = false;
  double epsilon = 0.05e-3;  // m; for the estimate of the touched tissue, the tool's spheres are enlarged by this
  // density of each tissue divided by the density of dentin; negative: computed from the tissue's specific energy
  PerTissue density = given();
  std::filesystem::path material;              // file of fitted densities (Kaluschke 2020, eq. 14)
  std::optional<std::uint64_t> material_hash;  // hash of the tissue for which the densities were fitted
  std::vector<float> fitted;                   // fitted hardness of each sphere; empty: none
  Removal removal = Removal::kMended;

  static constexpr PerTissue given() {
    PerTissue none{};
    for (double& d : none) d = -1;
    return none;
  }
};

/// Spheres of one tool.
inline ToolSpheres spheres_of(std::span<const Tool> tools, std::size_t index, const Parameters& parameters) {
  if (index == 0 && parameters.tool_mesh) return *parameters.tool_mesh;
  return tool_spheres(tools[index], parameters.tool_spheres);
}

/// Density of each tissue divided by that of dentin: from the scene, or from the ratio of their specific energies.
inline PerTissue densities(const Parameters& parameters, const MaterialTable& materials) {
  PerTissue density = parameters.density;
  const double dentin = materials[static_cast<std::size_t>(Tissue::kDentin)].specific_energy;
  for (std::size_t t = 0; t < density.size(); ++t) {
    if (density[t] < 0) density[t] = materials[t].specific_energy / dentin;
  }
  return density;
}

/// Contains all spheres in their current state.
struct PackingSnapshot final : Snapshot {
  SphereTissue spheres;
};

/// Buffers for one cut, allocated at set-up.
struct CutBuffers {
  explicit CutBuffers(std::size_t spheres) : changed(spheres), before(spheres) {}
  std::vector<Place> changed;
  std::vector<CutSphere> before;
};

/// Cuts with the head from A to B, bit-identically on servo and carver. Calls keep(index, old sphere) for each changed
/// sphere. near(t, places) lists the tissue spheres that head sphere t can touch, in the order of the sphere tree.
template <class Near, class Keep>
Removed carve(SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WA, const Pose& X_WB, CutBuffers& buffers,
              Near&& near, Keep&& keep) noexcept(noexcept(keep(Place{}, CutSphere{}))) {
  Removed removed;
  for (std::size_t t = 0; t < tool.head; ++t) {
    const std::size_t found = std::min(near(t, std::span(buffers.changed)), buffers.changed.size());
    const std::size_t count = tissue.cut_near(found, X_WA * tool.center_T[t], X_WB * tool.center_T[t], tool.radius[t],
                                              tool.curve[t], buffers.changed, buffers.before, removed);
    for (std::size_t k = 0; k < count; ++k) keep(buffers.changed[k], buffers.before[k]);
  }
  return removed;
}
/// Like carve() above, but searches the tissue spheres near the head itself.
template <class Keep>
Removed carve(SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WA, const Pose& X_WB, CutBuffers& buffers,
              Keep&& keep) noexcept(noexcept(keep(Place{}, CutSphere{}))) {
  const auto near = [&](std::size_t t, std::span<Place> found) {
    return tissue.tree().near_segment(X_WA * tool.center_T[t], X_WB * tool.center_T[t], tool.radius[t], found);
  };
  return carve(tissue, tool, X_WA, X_WB, buffers, near, keep);
}

}  // namespace typodont::haptics::packing
