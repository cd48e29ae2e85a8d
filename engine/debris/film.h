// Water and slurry that lie on the tissue's surface: a thin film on the cells of a coarse grid. It flows downhill,
// fills cavities, dries, and is sucked off or flung off by the bur.
//
//   Film film(field, materials);
//   film.deposit(p_W, {.water = 1e-9});
//   film.step(1.0 / 60, &suction);
//
// One thread. A film without load costs nothing: step() returns at once. The same calls give the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/contract/tissue.h"
#include "engine/debris/debris.h"

namespace typodont::debris {

struct FilmOptions {
  glm::dvec3 up{0, 0, 1};         // unit, against gravity
  double gravity = 9.81;          // m/s²
  double water_density = 1000;    // kg/m³
  double water_viscosity = 1e-3;  // Pa·s, at 20 °C
  // Largest volume fraction of solids at which slurry flows: the random packing of rough grains. Towards this
  // fraction, the viscosity increases by the law of Krieger & Dougherty (1959).
  double most_solids = 0.6;
  double clinging = 10e-6;    // m, thickness that adheres to the surface and does not flow
  double hanging = 60e-6;     // m, greatest thickness below an overhang; additional water drips off
  double overhang = -0.25;    // cosine between normal and `up` below which a surface is an overhang
  double drying = 0.5e-6;     // m/s, loss of thickness by evaporation: a film of 30 µm dries in a minute
  double suction_rate = 20;   // 1/s, rate at which air of `suction_speed` carries the film away
  double suction_speed = 10;  // m/s
  // Cells with dot(drain, (p, 1)) < 0 lose their load, because there the tooth disappears in the gum. Zero: no such
  // cells.
  glm::dvec4 drain{0};
  // limit of the substeps, and so of the time of step(); if more substeps were needed, the film flows slower
  int most_substeps = 12;
};

/// Balance of the film's mass in kg: deposited = on_surface + sucked + run_off + dried + flung, for water and for
/// every tissue.
struct FilmLedger {
  Load deposited, on_surface, sucked;
  Load run_off;      // kg that dripped off, drained into the gum, or landed beside the surface
  double dried = 0;  // kg of water that evaporated
  Load flung;        // kg that the bur threw off
};

/// A cell of the film. `water` and `solids` are heights: volumes divided by the cell's area.
struct FilmCell {
  glm::ivec3 sample{0};  // the sample of the field to which the cell belongs
  glm::vec3 p_W{0};      // m, point of the surface
  glm::vec3 n_W{0};      // unit normal, pointing out of the tissue
  double area = 0;       // m²
  double water = 0;      // m
  PerTissue solids{};    // m
};

class Film {
 public:
  /// `field`: the tissue, in the grid of the film; its array must outlive the film. Samples at the border of the grid
  /// have no cell. `materials` provides the densities.
  Film(const CoarseField& field, const MaterialTable& materials, const FilmOptions& options = {});
  ~Film();
  Film(Film&&) noexcept;
  Film& operator=(Film&&) noexcept;

  /// Call this after the field's samples lo … hi (inclusive) changed. The load of cells that disappeared goes to the
  /// nearest cells.
  void update(const glm::ivec3& lo, const glm::ivec3& hi);
  /// Adds a load to the cell nearest to the point. If the nearest cell is farther away than two spacings, the load
  /// runs off.
  void deposit(const glm::dvec3& p_W, const Load& load);
  /// Height in m of the water at a point; 0 if the point has no cell.
  double water_at(const glm::dvec3& p_W) const;
  /// Removes and returns the fraction `share` of the load of all cells within `reach` of the point, which the bur
  /// throws off.
  Load fling(const glm::dvec3& p_W, double reach, double share);

  /// Advances by dt seconds. The flow between two cells is that of a viscous film, ρ g h³/(3 μ) times the slope of
  /// its free surface; solids move with the water. Suction removes the film at the rate
  /// suction_rate·(v/suction_speed)², where v is the speed of the air at the cell.
  void step(double dt, const Suction* suction = nullptr);

  std::size_t loaded() const;                     // number of cells with water or solids
  std::uint64_t cells_stepped() const;            // number of cells that were computed, summed over all substeps
  std::size_t cells() const;                      // number of cells
  FilmCell cell(const glm::ivec3& sample) const;  // the cell of a sample; its area is 0 if the sample has no cell
  bool has_cell(const glm::ivec3& sample) const;
  FilmLedger ledger() const;
  std::uint64_t hash() const;
  /// Appends to `out` the samples whose cell changed since the last call, in no particular order, without repetition.
  void take_changed(std::vector<glm::ivec3>& out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace typodont::debris
