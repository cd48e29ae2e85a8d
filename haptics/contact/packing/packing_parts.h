// Data types that both parts of the contact model "packing" use (servo thread and carver thread): parameters, the
// snapshot, the cut.
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
  std::size_t spheres = 36000;  // number of spheres of the tissue
  std::uint64_t seed = 1;       // seed of the packings of tissue and tools
  std::filesystem::path file;   // file with a packing that is used instead; empty: none
  // head of the first tool, made from a closed mesh; empty: the head is made from the tool table
  std::optional<ToolSpheres> tool_mesh;
  std::size_t tool_spheres = 60;  // number of spheres of a head that is not a ball
  /// Fixed v_b of eq. 4, m/s, at density 1 and independent of the force, as in the paper; 0: v_b follows from the
  /// motor's power, see PackingModel::cut().
  double base_speed = 0;
  double free_speed = 0.02;  // m/s, upper limit of the cutting speed of eq. 4, at very low density
  // with a fixed v_b: true uses ρ of eq. 3, which grows with the contact (reaming); false uses ρ̂
  bool by_contact = false;
  double epsilon = 0.05e-3;        // m, enlargement of the tool for estimating the surface
  PerTissue density = given();     // density relative to dentin; negative: the ratio of the specific energies is used
  std::filesystem::path material;  // file of a fit to a measurement (eq. 14)
  std::optional<std::uint64_t> material_hash;  // hash of the tissue for which the fit was made
  std::vector<float> fitted;                   // fitted hardness of every sphere; empty: none
  Removal removal = Removal::kMended;

  static constexpr PerTissue given() {
    PerTissue none{};
    for (double& d : none) d = -1;
    return none;
  }
};

/// The first version of the force laws in which heads are rings of spheres. Where these spheres overlap, the energy for
/// a cut is spent only once.
inline constexpr std::uint32_t kLawsOfRings = 7;

/// A tool of the set as spheres.
inline ToolSpheres spheres_of(std::span<const Tool> tools, std::size_t index, const Parameters& parameters,
                              std::uint32_t laws) {
  if (index == 0 && parameters.tool_mesh) return *parameters.tool_mesh;
  return tool_spheres(tools[index], parameters.tool_spheres, parameters.seed,
                      laws >= kLawsOfRings ? HeadSpheres::kRings : HeadSpheres::kPacked);
}

/// Density of every tissue relative to dentin: the scene's value, otherwise the ratio of the specific energies.
inline PerTissue densities(const Parameters& parameters, const MaterialTable& materials) {
  PerTissue density = parameters.density;
  const double dentin = materials[static_cast<std::size_t>(Tissue::kDentin)].specific_energy;
  for (std::size_t t = 0; t < density.size(); ++t) {
    if (density[t] < 0) density[t] = materials[t].specific_energy / dentin;
  }
  return density;
}

/// A snapshot with all spheres in their present state, so it contains the whole tissue.
struct PackingSnapshot final : Snapshot {
  SphereTissue spheres;
};

/// Buffers for one cut, allocated at set-up.
struct CutBuffers {
  explicit CutBuffers(std::size_t spheres) : changed(spheres), before(spheres) {}
  std::vector<int> changed;
  std::vector<CutSphere> before;
};

/// Removes the tissue that the tool's head covers on its motion from A to B. Servo and carver call this function, so
/// both get the same bits. Calls keep(number, sphere before) for each sphere that changes. near(t, numbers) writes
/// the indices of the spheres that sphere t of the head can touch on its motion, in the tree's order, and returns
/// their number.
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
/// carve() with a search in the tissue's own tree.
template <class Keep>
Removed carve(SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WA, const Pose& X_WB, CutBuffers& buffers,
              Keep&& keep) noexcept(noexcept(keep(0, CutSphere{}))) {
  const auto near = [&](std::size_t t, std::span<int> found) {
    return tissue.tree().near_segment(X_WA * tool.center_T[t], X_WB * tool.center_T[t], tool.radius[t], found);
  };
  return carve(tissue, tool, X_WA, X_WB, buffers, near, keep);
}

}  // namespace typodont::haptics::packing
