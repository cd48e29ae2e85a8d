// The tissues that can be drilled, and their material properties.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "engine/base/pose.h"

namespace typodont {

/// Label of a voxel. File formats store these numbers (grid "tissue" of a .vdb, columns of the ticks). So a new tissue
/// may only be added at the end.
enum class Tissue : std::uint8_t {
  kAir,
  kEnamel,
  kDentin,
  kCaries,
  kPulp,
  kCorticalBone,
  kCancellousBone,
  kGingiva,
  kAmalgam,
  kComposite,
};
inline constexpr int kTissueCount = 10;

/// Returns the name of a tissue in all files, for example "enamel" or "cortical_bone".
std::string_view name_of(Tissue tissue) noexcept;
std::optional<Tissue> tissue_named(std::string_view name) noexcept;

/// Material properties in SI units. The values come from assets/materials/, which cites a source for each.
struct Material {
  // N/m, contact stiffness of this tissue if the coupling has a stiffness of 1000 N/m; for another coupling, the
  // contact stiffness changes in proportion
  double stiffness = 1e3;
  double specific_energy = 30e9;  // J/m³, energy needed to remove a volume
  double static_friction = 0.2;
  double dynamic_friction = 0.15;
  double density = 2900;  // kg/m³, density of the tissue
  dvec3 color{1, 1, 1};   // sRGB, 0..1, colour of the tissue
};
using MaterialTable = std::array<Material, kTissueCount>;

/// A quantity for each tissue, for example the removed volume in m³.
using PerTissue = std::array<double, kTissueCount>;

/// Returns the sum of the quantity over all tissues. The order of the additions is that of the tissues, so the bits are
/// always the same.
constexpr double total(const PerTissue& quantity) noexcept {
  double sum = 0;
  for (const double of_one : quantity) sum += of_one;
  return sum;
}

}  // namespace typodont
