// Chips and dust: particles born from what was cut, thrown by the bur, slowed by air, bouncing off the tissue.
//
//   Debris debris({.seed = 7});
//   for (const Cut& cut : cuts) debris.emit(cut, head_radius, materials);
//   debris.step(1.0 / 60, field);
//   debris.write_points(points);
//
// One thread. Nothing allocates after construction; nothing alive, nothing done. The same cuts, steps and seed give the
// same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>

#include "engine/contract/contact.h"
#include "engine/contract/tissue.h"

namespace typodont::debris {

/// The tissue as a coarse dense distance field: what particles bounce off. The arrays belong to the caller.
/// Sample (x,y,z) lies at origin + spacing·(x,y,z) and at index (x·size.y + y)·size.z + z.
struct CoarseField {
  glm::dvec3 origin{0};             // m, in W
  double spacing = 5e-4;            // m
  glm::ivec3 size{0};               // samples; none: nothing to bounce off
  const float* distance = nullptr;  // m, negative in the tissue
};

/// A nozzle that draws air in from all around.
struct Suction {
  glm::dvec3 p_W{0};     // m
  double flow = 5e-3;    // m³/s: a high-volume dental aspirator draws about 300 l/min
  double radius = 4e-3;  // m: what comes nearer is gone
};

struct DebrisOptions {
  std::size_t capacity = 100'000;
  std::uint64_t seed = 1;
  double parcel_volume = 1e-12;  // m³ of tissue that one particle stands for, as long as there is room
  int most_per_cut = 32;
  double least_chip = 5e-6, greatest_chip = 50e-6;  // m, diameters; between them evenly in the logarithm
  double decay_time = 2.0;            // s: a particle's mass falls by e in this time (Kim & Park 2006, sec. 4.6) …
  double lifetime = 6.0;              // s: … and what is left of it vanishes after this
  glm::dvec3 gravity_W{0, 0, -9.81};  // m/s²
  double air_density = 1.2;           // kg/m³
  double air_viscosity = 1.8e-5;      // Pa·s
  double restitution = 0.3;           // of the speed along the normal
  double slide = 0.7;                 // share of the tangential speed kept in a bounce
  double scatter = 0.25;              // of the rim speed: spread of the launch velocity
};

/// Where all mass went: born = alive + decayed + sucked + dropped. kg.
struct DebrisLedger {
  PerTissue born{};
  double alive = 0;
  double decayed = 0;
  double sucked = 0;
  double dropped = 0;  // there was no room
};

/// A particle as it leaves the bur.
struct Newborn {
  glm::dvec3 p_W{0}, v_W{0};  // m, m/s
  double chip = 0;            // m, diameter of its single chips
  double density = 0;         // kg/m³
  float mass = 0;             // kg
  Tissue tissue = Tissue::kAir;
};

/// Particles from one cut: their mass is density × removed volume, tissue by tissue; what finds no `room` is dropped.
/// Returns how many of `out` were filled; it must hold kTissueCount · most_per_cut. The same for whoever moves them.
std::size_t throw_chips(const Cut& cut, double head_radius, const MaterialTable& materials,
                        const DebrisOptions& options, std::size_t room, std::span<Newborn> out, PerTissue& born,
                        double& dropped) noexcept;

/// As a renderer draws it.
struct DebrisPoint {
  glm::vec3 p_W{0};    // m
  float diameter = 0;  // m, of a ball of the mass that is left
  Tissue tissue = Tissue::kAir;
  float chip = 0;  // m, diameter of its single chips: the finest are mist
};

class Debris {
 public:
  explicit Debris(const DebrisOptions& options = {});
  ~Debris();
  Debris(Debris&&) noexcept;
  Debris& operator=(Debris&&) noexcept;

  /// Particles from one cut: their mass is density × removed volume, tissue by tissue. `head_radius` in m.
  void emit(const Cut& cut, double head_radius, const MaterialTable& materials) noexcept;
  /// dt in s. `suction` nullptr: switched off.
  void step(double dt, const CoarseField& field, const Suction* suction = nullptr) noexcept;

  std::size_t alive() const noexcept;
  double time() const noexcept;  // s stepped so far
  DebrisLedger ledger() const noexcept;
  /// Fills `points` from the front with the particles still there, oldest first; returns how many.
  std::size_t write_points(std::span<DebrisPoint> points) const noexcept;
  /// m/s of the particle that write_points gives as number `i` when nothing was sucked away.
  glm::vec3 velocity(std::size_t i) const noexcept;
  /// m, diameter of its single chips, which drag goes by.
  double chip(std::size_t i) const noexcept;
  double mass(std::size_t i) const noexcept;  // kg
  std::uint64_t hash() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace typodont::debris
