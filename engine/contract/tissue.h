// Tissues and their material properties.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "engine/base/pose.h"

namespace typodont {

/// File formats store these numbers (grid "tissue" of a .vdb, ticks): add at the end only.
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

/// In all files, for example "enamel", "cortical_bone".
std::string_view name_of(Tissue tissue) noexcept;
std::optional<Tissue> tissue_named(std::string_view name) noexcept;

/// Energy per volume of one kind of edge by the thickness h of its chips: u = specific energy · energy_ratio ·
/// (h / chip)^−exponent.
struct EdgeLaw {
  double energy_ratio = 1;  // u / specific energy, at h = chip
  double chip = 10e-6;      // m
  double exponent = 0;
  double force_ratio = 0;  // tangential / normal force; 0: the tool's cutting_coefficient
};

/// SI, from assets/materials/, which cites a source for each.
struct Material {
  // N/m, at a coupling of 1000 N/m, in proportion for others
  double stiffness = 1e3;
  double specific_energy = 30e9;  // J/m³, energy needed to remove a volume
  double static_friction = 0.2;
  double dynamic_friction = 0.15;
  double density = 2900;    // kg/m³, density of the tissue
  dvec3 color{1, 1, 1};     // sRGB, 0..1, colour of the tissue
  EdgeLaw blade{}, grit{};  // of drills; of diamonds
};
using MaterialTable = std::array<Material, kTissueCount>;

/// For example m³ removed.
using PerTissue = std::array<double, kTissueCount>;

/// In the tissues' order, so always the same bits.
constexpr double total(const PerTissue& quantity) noexcept {
  double sum = 0;
  for (const double of_one : quantity) sum += of_one;
  return sum;
}

}  // namespace typodont
