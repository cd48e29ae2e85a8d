// Heat conduction in tissue: finite volumes on a grid of cells. Faces beside air have heat transfer coefficients.
#pragma once

#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "engine/base/json.h"
#include "engine/base/voxels.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"

namespace typodont::session {

struct ThermalMaterial {
  double conductivity = 0.6;      // W/(m K)
  double heat_capacity = 4.18e6;  // J/(m³ K)
};
using ThermalTable = std::array<ThermalMaterial, kTissueCount>;

/// Constants in assets/materials/heat.json, which cites a source for each.
struct HeatConstants {
  ThermalTable tissue{};
  double fraction = 0;  // fraction of the cutting power that heats the tissue
  double dry_film = 0,
         wet_film = 0;   // W/(m² K), heat transfer coefficient of a face beside air: dry, and in the spray (wet)
  double wet_flow = 0;   // m³/s, flow to which wet_film refers; wet_film grows with the square root of the flow
  double wet_reach = 0;  // m, radius around the tool's head that the spray wets
};
/// Reads the constants from their file's content. Throws Error.
HeatConstants read_heat_constants(const Json& json);

/// The key "heat" of a scene.
struct HeatSettings {
  double coolant = 23;  // °C, temperature of the spray
};
/// Declares the keys of the block "heat". Throws Error.
void describe_heat(Keys& keys, HeatSettings& settings);

/// Medium to which a cell's face beside air loses heat.
struct HeatBath {
  double film = 0;          // W/(m² K), heat transfer coefficient
  double temperature = 37;  // °C, temperature of the medium
};

/// The cells and their temperatures. One thread at a time. Only the constructor allocates.
class HeatGrid {
 public:
  /// `tissue`: tissue of each cell, z changes fastest; kAir: empty cell. `frame.voxel`: edge of a cell, m.
  HeatGrid(const VoxelFrame& frame, const glm::ivec3& size, std::vector<Tissue> tissue, const ThermalTable& materials,
           double temperature);

  /// Advances by `dt` (s). Faces beside air meet the medium `wet` within `reach` (m) of `wet_W`, otherwise `dry`.
  void step(double dt, const HeatBath& dry, const HeatBath& wet, const dvec3& wet_W, double reach) noexcept;
  /// Adds `energy` (J) to the eight cells around p_W with trilinear weights. Energy for empty cells is lost.
  void heat(const dvec3& p_W, double energy) noexcept;
  void heat(std::size_t cell, double energy) noexcept;
  void remove(std::size_t cell) noexcept;

  const VoxelFrame& frame() const { return frame_; }
  const glm::ivec3& size() const { return size_; }
  std::size_t at(int x, int y, int z) const { return voxel_index({x, y, z}, size_); }
  Tissue tissue(std::size_t cell) const { return tissue_[cell]; }
  double temperature(std::size_t cell) const { return temperature_[cell]; }  // the cell's temperature, °C

 private:
  void connect(std::size_t cell, std::size_t next, int axis) noexcept;

  VoxelFrame frame_;
  glm::ivec3 size_;
  std::vector<Tissue> tissue_;
  ThermalTable materials_;
  std::vector<double> temperature_, next_;
  // W/K, conductance to the next cell along x, y, z; 0: no tissue there
  std::array<std::vector<double>, 3> conductance_;
  std::vector<std::size_t> solid_;
  double stable_ = 0;  // s, longest stable time step
};

}  // namespace typodont::session
