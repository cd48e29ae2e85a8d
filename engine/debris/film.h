// The film: a thin layer of water and slurry on the tissue's surface. It is stored in the cells of a coarse grid. It
// flows downhill, fills cavities, dries, and is removed by suction and by the turning bur.
//
//   Film film(field, materials);
//   film.deposit(p_W, {.water = 1e-9});
//   film.step(1.0 / 60, &suction);
//
// For one thread. If the film is empty, step() returns at once. The same calls give the same bits.
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
  glm::dvec3 up{0, 0, 1};         // unit vector, opposite to gravity
  double gravity = 9.81;          // m/s², acceleration of gravity
  double water_density = 1000;    // kg/m³, density of the water
  double water_viscosity = 1e-3;  // Pa·s, viscosity of the water at 20 °C
  // Slurry flows only if its volume fraction of solids is below this value, which is the volume fraction of randomly
  // packed rough grains. Near this value, the viscosity rises towards infinity (Krieger & Dougherty 1959).
  double most_solids = 0.6;
  double clinging = 10e-6;    // m, thickness of the layer that adheres to the surface and does not flow
  double hanging = 60e-6;     // m, largest thickness of the film below an overhang; excess water drips off
  double overhang = -0.25;    // a surface is an overhang if the cosine between its normal and `up` is less than this
  double drying = 0.5e-6;     // m/s, thickness that evaporates per second; a film of 30 µm dries in a minute
  double suction_rate = 20;   // 1/s, rate at which the film is carried away by air with the speed `suction_speed`
  double suction_speed = 10;  // m/s, speed of the air at which `suction_rate` holds
  // A plane below which the tooth lies inside the gum. Cells at points p with dot(drain, (p, 1)) < 0 lose their water
  // and solids. If `drain` is zero, no cell loses them.
  glm::dvec4 drain{0};
  // Largest number of substeps in one step(); it limits the computing time. If the film needs more substeps, it flows
  // more slowly instead.
  int most_substeps = 12;
};

/// Balance of the film's mass in kg, for water and for every tissue: deposited = on_surface + sucked + run_off + dried
/// + flung.
struct FilmLedger {
  Load deposited, on_surface, sucked;
  Load run_off;      // kg, mass that dripped off, drained into the gum, or landed beside the surface
  double dried = 0;  // kg, mass of water that evaporated
  Load flung;        // kg, mass that the bur threw off
};

/// A cell of the film. `water` and `solids` are heights, that is, volumes divided by the cell's area.
struct FilmCell {
  glm::ivec3 sample{0};  // the sample of the field to which the cell belongs
  glm::vec3 p_W{0};      // m, frame W: point on the tissue's surface at which the cell lies
  glm::vec3 n_W{0};      // unit normal, pointing out of the tissue
  double area = 0;       // m², area of the surface that the cell represents
  double water = 0;      // m, height of the water on the cell
  PerTissue solids{};    // m, height of the solids of each tissue
};

class Film {
 public:
  /// Makes an empty film on the tissue with this distance field. The film has the grid of the field, and the field's
  /// array must outlive the film. Samples at the border of the grid have no cell. `materials` provides the densities.
  Film(const CoarseField& field, const MaterialTable& materials, const FilmOptions& options = {});
  ~Film();
  Film(Film&&) noexcept;
  Film& operator=(Film&&) noexcept;

  /// Call this after the field's samples from lo to hi (inclusive) changed. If cells disappear, their load goes to the
  /// nearest cells.
  void update(const glm::ivec3& lo, const glm::ivec3& hi);
  /// Adds a load to the cell nearest to the point. If the nearest cell is farther away than two spacings, the load is
  /// counted as run_off.
  void deposit(const glm::dvec3& p_W, const Load& load);
  /// Returns the height in m of the water at a point; 0 if there is no cell at the point.
  double water_at(const glm::dvec3& p_W) const;
  /// Removes the film that the bur throws off: the fraction `fraction` of the load of all cells within `reach` (m) of
  /// the point. Returns the removed load.
  Load fling(const glm::dvec3& p_W, double reach, double fraction);

  /// Advances the film by dt seconds. Water flows as a viscous film of height h; the flow is ρ g h³/(3 μ) times the
  /// slope of the free surface (ρ: density, g: gravity, μ: viscosity). Solids move with the water. Suction removes the
  /// film at the rate suction_rate·(v/suction_speed)², where v is the air's speed at the cell.
  void step(double dt, const Suction* suction = nullptr);

  std::size_t loaded() const;  // returns the number of cells with water or solids
  // returns the number of computed cells: a cell that is computed in three substeps counts three times
  std::uint64_t cells_stepped() const;
  std::size_t cells() const;  // returns the number of cells of the film
  // returns the cell of a sample; its area is 0 if the sample has no cell
  FilmCell cell(const glm::ivec3& sample) const;
  bool has_cell(const glm::ivec3& sample) const;
  FilmLedger ledger() const;
  std::uint64_t hash() const;
  /// Appends to `out` the samples whose cells changed since the last call. Each sample appears once, in no particular
  /// order.
  void take_changed(std::vector<glm::ivec3>& out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace typodont::debris
