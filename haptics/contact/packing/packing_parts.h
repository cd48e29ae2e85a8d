// What the two halves of the packing model share: parameters, the snapshot, the cut.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "engine/contract/contact.h"
#include "haptics/contact/packing/sphere_tissue.h"
#include "haptics/contact/packing/tool_spheres.h"
#include "haptics/snapshot.h"

namespace typodont::haptics::packing {

struct Parameters {
  std::size_t spheres = 36000;           // of the tissue
  std::uint64_t seed = 1;                // of the packings of tissue and tools
  std::filesystem::path file;            // a packing to use instead; empty: none
  std::optional<ToolSpheres> tool_mesh;  // the head of the first tool, from a closed mesh; empty: by the tool table
  std::size_t tool_spheres = 60;         // of a head that is no ball
  /// m/s at density 1, v_b of eq. 4, whatever the push, as in the paper; 0: v_b follows from the motor's power, see
  /// PackingModel::cut().
  double base_speed = 0;
  double free_speed = 0.02;     // m/s, where the density is so low that eq. 4 would give more
  bool by_contact = false;      // of a fixed v_b: ρ of eq. 3, which grows with the contact (reaming), instead of ρ̂
  double epsilon = 0.05e-3;     // m, by which the tool is larger where the surface is estimated
  PerTissue density = given();  // over dentin's; negative: the tissue's specific energy over dentin's
  std::filesystem::path material;              // a fit to a measurement (eq. 14) …
  std::optional<std::uint64_t> material_hash;  // … of the tissue with this hash …
  std::vector<float> fitted;                   // … and the hardness of every sphere that it found; empty: none
  Removal removal = Removal::kMended;

  static constexpr PerTissue given() {
    PerTissue none{};
    for (double& d : none) d = -1;
    return none;
  }
};

/// A tool of the tray as this model has it.
inline ToolSpheres spheres_of(std::span<const Tool> tools, std::size_t index, const Parameters& parameters) {
  if (index == 0 && parameters.tool_mesh) return *parameters.tool_mesh;
  return tool_spheres(tools[index], parameters.tool_spheres, parameters.seed);
}

/// Density of every tissue over dentin's: what the scene says, else the ratio of the specific energies.
inline PerTissue densities(const Parameters& parameters, const MaterialTable& materials) {
  PerTissue density = parameters.density;
  const double dentin = materials[static_cast<std::size_t>(Tissue::kDentin)].specific_energy;
  for (std::size_t t = 0; t < density.size(); ++t) {
    if (density[t] < 0) density[t] = materials[t].specific_energy / dentin;
  }
  return density;
}

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

/// Takes away what the tool's head covers on its way from A to B; servo and carver both call it and hold the same bits.
/// Calls keep(number, sphere before) for each sphere that changes. near(t, numbers) writes the numbers of the spheres
/// that sphere t of the head can touch on its way, in the tree's order, and returns how many there are.
template <class Near, class Keep>
Removed carve(SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WA, const Pose& X_WB, CutBuffers& buffers,
              Near&& near, Keep&& keep) noexcept(noexcept(keep(0, CutSphere{}))) {
  Removed removed;
  for (std::size_t t = 0; t < tool.head; ++t) {
    const std::size_t found = std::min(near(t, std::span(buffers.changed)), buffers.changed.size());
    const std::size_t count = tissue.cut_near(found, X_WA * tool.center_T[t], X_WB * tool.center_T[t], tool.radius[t],
                                              buffers.changed, buffers.before, removed);
    for (std::size_t k = 0; k < count; ++k) keep(buffers.changed[k], buffers.before[k]);
  }
  return removed;
}
/// The same by the tissue's own tree.
template <class Keep>
Removed carve(SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WA, const Pose& X_WB, CutBuffers& buffers,
              Keep&& keep) noexcept(noexcept(keep(0, CutSphere{}))) {
  const auto near = [&](std::size_t t, std::span<int> found) {
    return tissue.tree().near_segment(X_WA * tool.center_T[t], X_WB * tool.center_T[t], tool.radius[t], found);
  };
  return carve(tissue, tool, X_WA, X_WB, buffers, near, keep);
}

}  // namespace typodont::haptics::packing
