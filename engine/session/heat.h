// Conduction of heat in tissue: finite volumes on a grid of cells, with film coefficients at free faces.
#pragma once

#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "engine/base/json.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"

namespace typodont::session {

struct ThermalMaterial {
  double conductivity = 0.6;      // W/(m K)
  double heat_capacity = 4.18e6;  // J/(m³ K)
};
using ThermalTable = std::array<ThermalMaterial, kTissueCount>;

/// The file assets/materials/heat.json, which cites a source for each.
struct HeatConstants {
  ThermalTable tissue{};
  double fraction = 0;                // of the power of cutting, that stays in the tissue
  double dry_film = 0, wet_film = 0;  // W/(m² K), of free faces
  double wet_flow = 0;                // m³/s, at which wet_film holds; it grows with the square root
  double wet_reach = 0;               // m around the tool's head
};
/// Throws Error.
HeatConstants read_heat_constants(const Json& json);

/// Key "heat" of a scene.
struct HeatSettings {
  double coolant = 23;  // °C
};
/// Throws Error.
HeatSettings read_heat(const Json& json);

/// What a free face loses heat to.
struct HeatBath {
  double film = 0;          // W/(m² K)
  double temperature = 37;  // °C
};

/// One thread at a time. After construction, nothing allocates.
class HeatGrid {
 public:
  /// `tissue`: of each cell, kAir: empty; z fastest. `frame.voxel`: a cell's edge.
  HeatGrid(const VoxelFrame& frame, const glm::ivec3& size, std::vector<Tissue> tissue, const ThermalTable& materials,
           double temperature);

  /// Free faces within `reach` (m) of `wet_W` meet `wet`, the others `dry`.
  void step(double dt, const HeatBath& dry, const HeatBath& wet, const dvec3& wet_W, double reach) noexcept;
  /// Divided among the eight cells around p_W as in trilinear interpolation, as far as they are solid.
  void heat(const dvec3& p_W, double energy) noexcept;
  void heat(std::size_t cell, double energy) noexcept;
  void remove(std::size_t cell) noexcept;

  const VoxelFrame& frame() const { return frame_; }
  const glm::ivec3& size() const { return size_; }
  std::size_t at(int x, int y, int z) const {
    return (static_cast<std::size_t>(x) * static_cast<std::size_t>(size_.y) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size_.z) +
           static_cast<std::size_t>(z);
  }
  Tissue tissue(std::size_t cell) const { return tissue_[cell]; }
  double temperature(std::size_t cell) const { return temperature_[cell]; }  // °C

 private:
  void connect(std::size_t cell, std::size_t next, int axis) noexcept;

  VoxelFrame frame_;
  glm::ivec3 size_;
  std::vector<Tissue> tissue_;
  ThermalTable materials_;
  std::vector<double> temperature_, next_;
  // W/K, to the next cell along x, y, z; 0 at a free face
  std::array<std::vector<double>, 3> conductance_;
  std::vector<std::size_t> solid_;
  double stable_ = 0;  // s, longest stable step
};

}  // namespace typodont::session
