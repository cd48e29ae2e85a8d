// Chips and dust: particles that a cut creates. The bur throws them, air slows them, and they bounce off the tissue.
//
//   Debris debris({.seed = 7});
//   for (const Cut& cut : cuts) debris.emit(cut, head_radius, materials);
//   debris.step(1.0 / 60, field);
//   debris.write_points(points);
//
// One thread. Allocates only in the constructor, and does no work without particles. The same cuts, steps and seed give
// the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>

#include "engine/contract/contact.h"
#include "engine/contract/tissue.h"

namespace typodont::debris {

/// A coarse distance field of the tissue for bouncing. The caller owns the array. Sample (x,y,z) lies at origin +
/// spacing·(x,y,z) and at index (x·size.y + y)·size.z + z.
struct CoarseField {
  glm::dvec3 origin{0};             // m, in W
  double spacing = 5e-4;            // m
  glm::ivec3 size{0};               // number of samples; 0: no tissue to bounce off
  const float* distance = nullptr;  // m, negative in the tissue
};

/// A suction nozzle, which draws in air from all directions.
struct Suction {
  glm::dvec3 p_W{0};     // m, position of the nozzle
  double flow = 5e-3;    // m³/s; a high-volume dental aspirator draws about 300 l/min
  double radius = 4e-3;  // m, radius of the nozzle; closer particles are removed
};

struct DebrisOptions {
  std::size_t capacity = 100'000;
  std::uint64_t seed = 1;
  double parcel_volume = 1e-12;  // m³ of tissue per particle, while the buffer has free entries
  int most_per_cut = 32;
  double least_chip = 5e-6, greatest_chip = 50e-6;  // m, limits of the chip diameters; uniform in the logarithm
  double decay_time = 2.0;  // s, time in which a particle's mass falls by a factor of e (Kim & Park 2006, sec. 4.6)
  double lifetime = 6.0;    // s, age at which a particle is removed
  glm::dvec3 gravity_W{0, 0, -9.81};  // m/s²
  double air_density = 1.2;           // kg/m³
  double air_viscosity = 1.8e-5;      // Pa·s
  double restitution = 0.3;           // ratio of the normal speeds after and before a bounce
  double slide = 0.7;                 // ratio of the tangential speeds after and before a bounce
  double scatter = 0.25;              // standard deviation of the launch velocity divided by the rim speed
};

/// Balance of mass in kg: born = alive + decayed + sucked + dropped + deposited.
struct DebrisLedger {
  PerTissue born{};
  double alive = 0;
  double decayed = 0;
  double sucked = 0;
  double dropped = 0;    // mass that was lost because the buffer was full
  double deposited = 0;  // kg, mass that became part of the film on the surface
};

/// Masses of water and of solids, kg.
struct Load {
  double water = 0;
  PerTissue solids{};
};
/// Adds the fraction `share` of `load` to `to`.
inline void add(Load& to, const Load& load, double share = 1) noexcept {
  to.water += share * load.water;
  for (std::size_t t = 0; t < kTissueCount; ++t) to.solids[t] += share * load.solids[t];
}

class Film;

/// A particle at the moment the bur throws it.
struct NewParticle {
  glm::dvec3 p_W{0}, v_W{0};  // m, m/s
  double chip = 0;            // m, diameter of one chip of the particle
  double density = 0;         // kg/m³
  float mass = 0;             // kg
  Tissue tissue = Tissue::kAir;
};

/// Creates the particles of one cut. Their mass is density × removed volume for each tissue. At most `room` particles
/// are created; the mass of the other particles is added to `dropped`. Fills `out`, which must have kTissueCount ·
/// most_per_cut entries, and returns the number of filled entries. Used by the CPU version and the GPU version.
std::size_t create_particles(const Cut& cut, double head_radius, const MaterialTable& materials,
                             const DebrisOptions& options, std::size_t room, std::span<NewParticle> out,
                             PerTissue& born, double& dropped) noexcept;

/// A particle as the renderer draws it.
struct DebrisPoint {
  glm::vec3 p_W{0};              // m
  float diameter = 0;            // m, diameter of a ball with the remaining mass
  Tissue tissue = Tissue::kAir;  // kAir: water
  float chip = 0;                // m, diameter of one chip; the finest chips are drawn as mist
  glm::vec3 streak_W{0};         // m, the path on which a droplet is visible during the exposure; it ends at p_W
};

class Debris {
 public:
  explicit Debris(const DebrisOptions& options = {});
  ~Debris();
  Debris(Debris&&) noexcept;
  Debris& operator=(Debris&&) noexcept;

  /// Creates the particles of one cut: their mass is density × removed volume for each tissue. `head_radius` in m.
  void emit(const Cut& cut, double head_radius, const MaterialTable& materials) noexcept;
  /// Advances by dt seconds. `suction` is nullptr if suction is off. With a film, chips that touch a wet surface or
  /// come to rest become part of the film; without a film they bounce and come to rest as particles.
  void step(double dt, const CoarseField& field, const Suction* suction = nullptr, Film* film = nullptr) noexcept;

  std::size_t alive() const noexcept;
  double time() const noexcept;  // s, sum of all steps so far
  DebrisLedger ledger() const noexcept;
  /// Writes the living particles into `points`, oldest first, and returns their number.
  std::size_t write_points(std::span<DebrisPoint> points) const noexcept;
  /// Velocity in m/s of the particle that write_points() writes at index `i`, provided that suction removed no
  /// particle.
  glm::vec3 velocity(std::size_t i) const noexcept;
  /// m, diameter of one chip of the particle; drag depends on it.
  double chip(std::size_t i) const noexcept;
  double mass(std::size_t i) const noexcept;  // kg
  std::uint64_t hash() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace typodont::debris
