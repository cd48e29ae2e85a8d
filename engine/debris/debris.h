// Chips and dust that cuts create, as particles. The bur throws them, the air slows them, and they bounce off the
// tissue.
//
//   Debris debris({.seed = 7});
//   for (const Cut& cut : cuts) debris.emit(cut, head_radius, materials);
//   debris.step(1.0 / 60, field);
//   debris.write_points(points);
//
// For one thread. Only the constructor allocates memory, and step() returns at once if there are no particles. The same
// cuts, steps and seed give the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>

#include "engine/contract/contact.h"
#include "engine/contract/tissue.h"

namespace typodont::debris {

/// A coarse distance field of the tissue, off which particles bounce. The caller owns the array. Sample (x,y,z) lies at
/// origin + spacing·(x,y,z) and has the index (x·size.y + y)·size.z + z.
struct CoarseField {
  glm::dvec3 origin{0};             // m, position of sample (0,0,0) in frame W
  double spacing = 5e-4;            // m, distance between neighbouring samples
  glm::ivec3 size{0};               // number of samples per axis; 0 if there is no tissue
  const float* distance = nullptr;  // m, signed distances of the samples from the surface, negative in the tissue
};

/// A suction nozzle, which draws in air from all directions.
struct Suction {
  glm::dvec3 p_W{0};     // m, frame W, position of the suction nozzle
  double flow = 5e-3;    // m³/s, flow of air into the nozzle; a dental high-volume suction draws about 300 l/min
  double radius = 4e-3;  // m, radius of the nozzle; a particle that is nearer to `p_W` than this is removed
};

struct DebrisOptions {
  std::size_t capacity = 100'000;
  std::uint64_t seed = 1;
  // m³, largest volume of tissue that one particle represents. One particle represents more if `most_per_cut` or the
  // free entries of the buffer limit the number of particles.
  double parcel_volume = 1e-12;
  int most_per_cut = 32;
  // m, smallest and largest diameter of chips; the distribution is uniform in the logarithm
  double least_chip = 5e-6, greatest_chip = 50e-6;
  double decay_time = 2.0;  // s, time in which a particle's mass falls by a factor of e (Kim & Park 2006, sec. 4.6)
  double lifetime = 6.0;    // s, age at which a particle is removed
  glm::dvec3 gravity_W{0, 0, -9.81};  // m/s², frame W, acceleration of gravity
  double air_density = 1.2;           // kg/m³, density of the air
  double air_viscosity = 1.8e-5;      // Pa·s, viscosity of the air
  double restitution = 0.3;           // normal speed after a bounce divided by the speed before it
  double slide = 0.7;                 // tangential speed after a bounce divided by the speed before it
  double scatter = 0.25;              // standard deviation of a chip's initial velocity, divided by the rim's speed
};

/// Balance of the mass of all particles in kg: born = alive + decayed + sucked + dropped + deposited.
struct DebrisLedger {
  PerTissue born{};
  double alive = 0;
  double decayed = 0;
  double sucked = 0;
  double dropped = 0;    // kg, mass that was lost because the buffer was full
  double deposited = 0;  // kg, mass that became part of the film on the surface
};

/// Masses of water and of solids in kg.
struct Load {
  double water = 0;
  PerTissue solids{};
};
/// Adds the fraction `fraction` of `load` to `to`.
inline void add(Load& to, const Load& load, double fraction = 1) noexcept {
  to.water += fraction * load.water;
  for (std::size_t t = 0; t < kTissueCount; ++t) to.solids[t] += fraction * load.solids[t];
}

class Film;

/// A particle at the moment the bur throws it.
struct NewParticle {
  glm::dvec3 p_W{0}, v_W{0};  // position (m) and velocity (m/s) of the particle in frame W
  double chip = 0;            // m, diameter of one chip of the particle
  double density = 0;         // kg/m³, density of the particle
  float mass = 0;             // kg, mass of the particle
  Tissue tissue = Tissue::kAir;
};

/// Creates the particles of one cut. For each tissue their mass is density × removed volume. At most `room` particles
/// are created; the remaining mass is added to `dropped`. The function fills `out`, which must have kTissueCount ·
/// most_per_cut entries, and returns the number of filled entries. The CPU version and the GPU version use it.
std::size_t create_particles(const Cut& cut, double head_radius, const MaterialTable& materials,
                             const DebrisOptions& options, std::size_t room, std::span<NewParticle> out,
                             PerTissue& born, double& dropped) noexcept;

/// A particle as the renderer draws it.
struct DebrisPoint {
  glm::vec3 p_W{0};              // m, frame W, position of the particle
  float diameter = 0;            // m, diameter of a ball that has the particle's remaining mass
  Tissue tissue = Tissue::kAir;  // tissue of a chip; kAir for a droplet of water
  float chip = 0;                // m, diameter of one chip; the finest chips are drawn as mist
  // m, vector along which a droplet is drawn as a streak; it ends at p_W and has the length of the flight during the
  // exposure
  glm::vec3 streak_W{0};
};

class Debris {
 public:
  explicit Debris(const DebrisOptions& options = {});
  ~Debris();
  Debris(Debris&&) noexcept;
  Debris& operator=(Debris&&) noexcept;

  /// Creates the particles of one cut. For each tissue their mass is density × removed volume. `head_radius` is in m.
  void emit(const Cut& cut, double head_radius, const MaterialTable& materials) noexcept;
  /// Advances the particles by dt seconds. `suction` is nullptr if suction is off. If a film is given, chips that touch
  /// a wet surface or come to rest become part of the film. Without a film, chips bounce and come to rest as particles.
  void step(double dt, const CoarseField& field, const Suction* suction = nullptr, Film* film = nullptr) noexcept;

  std::size_t alive() const noexcept;
  double time() const noexcept;  // returns the sum (s) of all steps so far
  DebrisLedger ledger() const noexcept;
  /// Writes the living particles into `points`, oldest first, and returns their number. One thread.
  std::size_t write_points(std::span<DebrisPoint> points) const noexcept;
  /// Returns the velocity (m/s, frame W) of the particle that write_points() writes at index `i`. Valid only while
  /// suction has removed no particle.
  glm::vec3 velocity(std::size_t i) const noexcept;
  /// Returns the diameter (m) of one chip of particle i, on which its drag depends.
  double chip(std::size_t i) const noexcept;
  double mass(std::size_t i) const noexcept;  // returns the mass (kg) of particle i
  std::uint64_t hash() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace typodont::debris
