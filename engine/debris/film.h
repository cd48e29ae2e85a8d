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
  // Largest volume fraction of solids at which slurry flows: random packing of rough grains. The viscosity rises
  // towards it by Krieger & Dougherty (1959).
  double most_solids = 0.6;
  double clinging = 10e-6;    // m, thickness that adheres to the surface and does not flow
  double hanging = 60e-6;     // m, greatest thickness below an overhang; the rest drips off
  double overhang = -0.25;    // cosine between normal and `up` below which a surface is an overhang
  double drying = 0.5e-6;     // m/s, loss of thickness by evaporation: a film of 30 µm dries in a minute
  double suction_rate = 20;   // 1/s, rate at which air of `suction_speed` carries the film away
  double suction_speed = 10;  // m/s
  // Cells with dot(drain, (p, 1)) < 0 keep nothing: the tooth disappears in the gum there. Zero: no such cells.
  glm::dvec4 drain{0};
  int most_substeps = 12;  // bounds the cost of step(); where more were needed, the film flows slower
};

/// Where the film's mass went, kg: deposited = on_surface + sucked + run_off + dried + flung, for water and for every
/// tissue.
struct FilmLedger {
  Load deposited, on_surface, sucked;
  Load run_off;      // dripped off, drained into the gum, or landed beside the surface
  double dried = 0;  // water only
  Load flung;        // thrown off by the bur
};

/// A cell of the film. Heights are volumes divided by the cell's area.
struct FilmCell {
  glm::ivec3 sample{0};  // the sample of the field to which the cell belongs
  glm::vec3 p_W{0};      // m, point of the surface
  glm::vec3 n_W{0};      // unit, out of the tissue
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

  /// The field's samples lo … hi (inclusive) changed. The load of cells that vanished goes to the nearest cells.
  void update(const glm::ivec3& lo, const glm::ivec3& hi);
  /// Adds a load to the cell nearest to the point. A load farther than two spacings from every cell runs off.
  void deposit(const glm::dvec3& p_W, const Load& load);
  /// Height in m of the water at a point; 0 if there is no cell.
  double water_at(const glm::dvec3& p_W) const;
  /// Takes the fraction `share` of the load of all cells within `reach` of the point: the bur flings it off.
  Load fling(const glm::dvec3& p_W, double reach, double share);

  /// Advances by dt seconds. The flux between two cells is that of a viscous film, ρ g h³/(3 μ) times the slope of its
  /// free surface; solids move with the water. Suction takes the film at the rate suction_rate·(v/suction_speed)²,
  /// where v is the speed of the air at the cell.
  void step(double dt, const Suction* suction = nullptr);

  std::size_t loaded() const;                     // number of cells with water or solids
  std::uint64_t cells_stepped() const;            // sum over all substeps of the cells that were computed
  std::size_t cells() const;                      // number of cells
  FilmCell cell(const glm::ivec3& sample) const;  // area 0: the sample has no cell
  bool has_cell(const glm::ivec3& sample) const;
  FilmLedger ledger() const;
  std::uint64_t hash() const;
  /// Samples whose cell changed since the last call, appended to `out` in no particular order, without repetition.
  void take_changed(std::vector<glm::ivec3>& out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace typodont::debris
