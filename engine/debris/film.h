// Film of water and slurry on the tissue, in cells of a coarse grid. It flows, dries, and is removed by suction and
// bur.
//
//   Film film(field, materials);
//   film.deposit(p_W, {.water = 1e-9});
//   film.step(1.0 / 60, &suction);
//
// One thread. An empty film costs nothing.
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
  double clinging = 10e-6;        // m, thickness of the film that sticks to the surface and does not flow
  double hanging = 60e-6;         // m, largest thickness below an overhang; the rest drips off
  double overhang = -0.25;        // cosine between normal and `up` below which a surface is an overhang
  double drying = 0.5e-6;         // m/s, loss of thickness by drying: 30 µm per minute
  double suction_rate = 20;       // 1/s, fraction of the film that suction removes per time at `suction_speed`
  double suction_speed = 10;      // m/s, speed of the air at which `suction_rate` holds
  // Cells with dot(drain, (p, 1)) < 0 are in the gum and lose their content. All zero: no cell drains.
  glm::dvec4 drain{0};
  // largest number of substeps of a step(); if more were needed, the film flows more slowly
  int max_substeps = 24;
};

/// Masses of water and of each tissue in kg: deposited = on_surface + sucked + run_off + dried + flung.
struct FilmLedger {
  Load deposited, on_surface, sucked;
  Load run_off;      // kg, mass that dripped, drained into the gum or fell beside the surface
  double dried = 0;  // kg, mass of water that evaporated
  Load flung;        // kg, mass that the bur threw off
};

/// A cell of the film. The heights `water` and `solids` are volumes divided by the cell's area.
struct FilmCell {
  glm::ivec3 sample{0};  // the sample of the field to which the cell belongs
  glm::vec3 p_W{0};      // m, frame W, cell's point on the tissue's surface
  glm::vec3 n_W{0};      // unit normal, pointing out of the tissue
  double area = 0;       // m², area of the surface that the cell represents
  double water = 0;      // m, height of the water on the cell
  PerTissue solids{};    // m, height of the solids of each tissue
};

class Film {
 public:
  /// Creates an empty film on the field's grid. The field's array must outlive the film. Samples at the grid's border
  /// have no cells.
  Film(const CoarseField& field, const MaterialTable& materials, const FilmOptions& options = {});
  ~Film();
  Film(Film&&) noexcept;
  Film& operator=(Film&&) noexcept;

  /// Call after samples lo … hi of the distance field have changed. The content of removed cells goes to the nearest
  /// remaining cells.
  void update(const glm::ivec3& lo, const glm::ivec3& hi);
  /// Adds `load` to the nearest cell. Without a cell within two spacings it counts as run_off.
  void deposit(const glm::dvec3& p_W, const Load& load);
  /// Returns the height (m) of the water at a point, or 0 if there is no cell.
  double water_at(const glm::dvec3& p_W) const;
  /// Removes the fraction `fraction` of the content of all cells within `reach` (m) of a point, and returns it.
  Load fling(const glm::dvec3& p_W, double reach, double fraction);

  /// Moves the film by `dt` (s). Flow per width = ρ g h³/(3 μ) × slope of the free surface; solids move with the water.
  /// Where the sucked air has the speed v, suction removes the fraction suction_rate·(v/suction_speed)² per second.
  void step(double dt, const Suction* suction = nullptr);

  std::size_t loaded() const;  // returns the number of cells with water or solids
  // returns how many cells all substeps together have computed so far
  std::uint64_t cells_stepped() const;
  std::size_t cells() const;  // returns the number of cells of the film
  // returns the cell at a sample; area 0: there is no cell
  FilmCell cell(const glm::ivec3& sample) const;
  bool has_cell(const glm::ivec3& sample) const;
  FilmLedger ledger() const;
  /// Returns the samples whose cells changed since the last call, each one once.
  void take_changed(std::vector<glm::ivec3>& out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace typodont::debris
