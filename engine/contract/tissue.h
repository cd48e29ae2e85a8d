// Tissues and their material properties.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "engine/base/pose.h"

namespace typodont {

/// Numbers of the tissues. Files store them (grid "tissue" of a .vdb, ticks), so append new ones at the end only.
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

/// The tissue's name in files, e.g. "enamel", "cortical_bone".
std::string_view name_of(Tissue tissue) noexcept;
std::optional<Tissue> tissue_named(std::string_view name) noexcept;

/// Colour of a voxel, sRGB: 5 bits red, 6 bits green, 5 bits blue. kTissueColor: the colour of its tissue.
using VoxelColor = std::uint16_t;
inline constexpr VoxelColor kTissueColor = 0;
/// `srgb`: 0 to 1. Black becomes the darkest blue.
VoxelColor voxel_color(const dvec3& srgb) noexcept;
dvec3 srgb_of(VoxelColor color) noexcept;

/// Energy per removed volume that one kind of cutting edge needs for chips of thickness h: specific_energy ·
/// energy_ratio · (h / chip)^−exponent.
struct EdgeLaw {
  double energy_ratio = 1;  // energy per volume at the thickness `chip`, divided by specific_energy
  double chip = 10e-6;      // m, chip thickness to which energy_ratio refers
  double exponent = 0;
  double force_ratio = 0;  // tangential force divided by the normal force; 0: use the tool's cutting_coefficient
  // G: after removing G × the volume of its grains, a diamond cuts half as fast as a new one; 0: no wear
  double grinding_ratio = 0;
};

/// Properties of a tissue in SI units, from assets/materials/, which cites a source for each value.
struct Material {
  // N/m, stiffness that the hand feels through a coupling of 1000 N/m. It is proportional to the coupling's stiffness.
  double stiffness = 1e3;
  double specific_energy = 30e9;  // J/m³, energy needed per removed volume
  double static_friction = 0.2;
  double dynamic_friction = 0.15;
  double density = 2900;    // kg/m³, density of the tissue
  dvec3 color{1, 1, 1};     // sRGB, 0 to 1, colour of the tissue
  EdgeLaw blade{}, grit{};  // blade: for edges of drills; grit: for grains of diamonds
};
using MaterialTable = std::array<Material, kTissueCount>;

/// One quantity per tissue, e.g. the removed volume, m³.
using PerTissue = std::array<double, kTissueCount>;

/// Sum over all tissues, always in the same order, so that equal quantities give bit-identical sums.
constexpr double total(const PerTissue& quantity) noexcept {
  double sum = 0;
  for (const double of_one : quantity) sum += of_one;
  return sum;
}

}  // namespace typodont
