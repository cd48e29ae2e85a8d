// Water and slurry on the tissue, in cells of a coarse grid: flows, fills cavities, dries, is sucked and flung.
//
//   Film film(field, materials);
//   film.deposit(p_W, {.water = 1e-9});
//   film.step(1.0 / 60, &suction);
//
// One thread. An empty film costs nothing. Equal calls give equal bits.
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
  // volume fraction of solids above which slurry does not flow (random packing of rough grains; Krieger & Dougherty
  // 1959)
  double most_solids = 0.6;
  double clinging = 10e-6;    // m, adheres and does not flow
  double hanging = 60e-6;     // m below an overhang; the rest drips
  double overhang = -0.25;    // cosine between normal and `up` below which a surface is an overhang
  double drying = 0.5e-6;     // m/s; 30 µm dry in a minute
  double suction_rate = 20;   // 1/s at `suction_speed`
  double suction_speed = 10;  // m/s, speed of the air at which `suction_rate` holds
  // Cells with dot(drain, (p, 1)) < 0 lose their load into the gum; zero: none.
  glm::dvec4 drain{0};
  // substeps of a step(); beyond, the film flows more slowly
  int most_substeps = 12;
};

/// kg, of water and each tissue: deposited = on_surface + sucked + run_off + dried + flung.
struct FilmLedger {
  Load deposited, on_surface, sucked;
  Load run_off;      // kg: dripped, drained into the gum, or beside the surface
  double dried = 0;  // kg, mass of water that evaporated
  Load flung;        // kg, mass that the bur threw off
};

/// `water`, `solids`: heights, volume / area.
struct FilmCell {
  glm::ivec3 sample{0};  // the sample of the field to which the cell belongs
  glm::vec3 p_W{0};      // m, on the tissue's surface
  glm::vec3 n_W{0};      // unit normal, pointing out of the tissue
  double area = 0;       // m², area of the surface that the cell represents
  double water = 0;      // m, height of the water on the cell
  PerTissue solids{};    // m, height of the solids of each tissue
};

class Film {
 public:
  /// Empty, on the field's grid; its array outlives the film. No cells at the border.
  Film(const CoarseField& field, const MaterialTable& materials, const FilmOptions& options = {});
  ~Film();
  Film(Film&&) noexcept;
  Film& operator=(Film&&) noexcept;

  /// After samples lo … hi changed. Loads of lost cells go to the nearest ones.
  void update(const glm::ivec3& lo, const glm::ivec3& hi);
  /// To the nearest cell; beyond two spacings it is run_off.
  void deposit(const glm::dvec3& p_W, const Load& load);
  /// m; 0 without a cell.
  double water_at(const glm::dvec3& p_W) const;
  /// Takes `fraction` of all cells within `reach` (m).
  Load fling(const glm::dvec3& p_W, double reach, double fraction);

  /// Flow ρ g h³/(3 μ) × slope of the free surface; solids move with the water; suction at
  /// suction_rate·(v/suction_speed)².
  void step(double dt, const Suction* suction = nullptr);

  std::size_t loaded() const;  // returns the number of cells with water or solids
  // cells, once per substep
  std::uint64_t cells_stepped() const;
  std::size_t cells() const;  // returns the number of cells of the film
  // area 0: no cell
  FilmCell cell(const glm::ivec3& sample) const;
  bool has_cell(const glm::ivec3& sample) const;
  FilmLedger ledger() const;
  std::uint64_t hash() const;
  /// Samples whose cells changed since the last call, once each.
  void take_changed(std::vector<glm::ivec3>& out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace typodont::debris
