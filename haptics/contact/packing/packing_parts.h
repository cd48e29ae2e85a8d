// Data types shared by the two parts of the contact model "packing" (servo thread and carver thread): the parameters,
// the snapshot, and the function that makes a cut.
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
  std::size_t spheres = 36000;  // number of spheres in the tissue's packing
  std::uint64_t seed = 1;       // random seed for the packings of the tissue and of a tool's mesh
  std::filesystem::path file;   // file with a packing to read; empty: a packing is computed
  // Head of the first tool as spheres made from a closed mesh; empty: the head has the shape in the tool table.
  std::optional<ToolSpheres> tool_mesh;
  std::size_t tool_spheres = 60;  // number of spheres of a head that is not a ball
  /// m/s, base speed v_b in eq. 4 of paper S2: the cutting speed at density 1. As in the paper, it is a constant, which
  /// does not depend on the force. 0: v_b is computed from the motor's power (see class PackingModel).
  double base_speed = 0;
  double free_speed = 0.02;  // m/s, largest cutting speed; it limits eq. 4 of paper S2 in tissue of very low density
  // Used only if base_speed is not 0. Density by which the cutting speed is divided. true: the density ρ of eq. 3 in
  // paper S2, which grows with the contact area (for reaming); false: the normalised density ρ̂.
  bool by_contact = false;
  double epsilon = 0.05e-3;  // m, enlargement of the tool's spheres for the estimate of the tissue's surface
  // density of each tissue relative to dentin; if it is negative, the ratio of the tissue's specific energy to that of
  // dentin is used
  PerTissue density = given();
  std::filesystem::path material;              // file with the result of a material fit (paper S2, eq. 14)
  std::optional<std::uint64_t> material_hash;  // hash of the tissue for which the material was fitted
  std::vector<float> fitted;                   // fitted hardness of every sphere; empty: no material was fitted
  Removal removal = Removal::kMended;

  static constexpr PerTissue given() {
    PerTissue none{};
    for (double& d : none) d = -1;
    return none;
  }
};

/// Returns the sphere model of one tool of the set.
inline ToolSpheres spheres_of(std::span<const Tool> tools, std::size_t index, const Parameters& parameters) {
  if (index == 0 && parameters.tool_mesh) return *parameters.tool_mesh;
  return tool_spheres(tools[index], parameters.tool_spheres);
}

/// Returns the density of each tissue relative to dentin: the value in the scene file, or else the ratio of the
/// specific energies.
inline PerTissue densities(const Parameters& parameters, const MaterialTable& materials) {
  PerTissue density = parameters.density;
  const double dentin = materials[static_cast<std::size_t>(Tissue::kDentin)].specific_energy;
  for (std::size_t t = 0; t < density.size(); ++t) {
    if (density[t] < 0) density[t] = materials[t].specific_energy / dentin;
  }
  return density;
}

/// A snapshot that contains all spheres of the tissue in their present state.
struct PackingSnapshot final : Snapshot {
  SphereTissue spheres;
};

/// Buffers for one cut, allocated at set-up.
struct CutBuffers {
  explicit CutBuffers(std::size_t spheres) : changed(spheres), before(spheres) {}
  std::vector<Place> changed;
  std::vector<CutSphere> before;
};

/// Removes the tissue that the tool's head covers on its motion from A to B. Servo and carver both call this function,
/// so their tissues stay equal bit by bit. Calls keep(index, sphere before the cut) for each sphere that changes.
/// near(t, places) must list in `places` the tissue spheres that head sphere t can touch on its motion, as indices in
/// the tree's order, and return their number.
template <class Near, class Keep>
Removed carve(SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WA, const Pose& X_WB, CutBuffers& buffers,
              Near&& near, Keep&& keep) noexcept(noexcept(keep(Place{}, CutSphere{}))) {
  Removed removed;
  for (std::size_t t = 0; t < tool.head; ++t) {
    const std::size_t found = std::min(near(t, std::span(buffers.changed)), buffers.changed.size());
    const std::size_t count = tissue.cut_near(found, X_WA * tool.center_T[t], X_WB * tool.center_T[t], tool.radius[t],
                                              buffers.changed, buffers.before, removed);
    for (std::size_t k = 0; k < count; ++k) keep(buffers.changed[k], buffers.before[k]);
  }
  return removed;
}
/// Removes the same tissue as the other carve() function, but finds the near spheres by a search in the tissue's tree.
template <class Keep>
Removed carve(SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WA, const Pose& X_WB, CutBuffers& buffers,
              Keep&& keep) noexcept(noexcept(keep(Place{}, CutSphere{}))) {
  const auto near = [&](std::size_t t, std::span<Place> found) {
    return tissue.tree().near_segment(X_WA * tool.center_T[t], X_WB * tool.center_T[t], tool.radius[t], found);
  };
  return carve(tissue, tool, X_WA, X_WB, buffers, near, keep);
}

}  // namespace typodont::haptics::packing
