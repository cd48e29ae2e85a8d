// Chips and dust of cuts as particles: thrown by the bur, slowed by air, bouncing off the tissue.
//
//   Debris debris({.seed = 7});
//   for (const Cut& cut : cuts) debris.emit(cut, {.head_radius = r}, materials);
//   debris.step(1.0 / 60, field);
//
// One thread. Only the constructor allocates. Equal calls and seed give bit-identical results.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>

#include "engine/contract/contact.h"
#include "engine/contract/tissue.h"

namespace typodont::debris {

/// Coarse distance field that the caller owns. Sample (x,y,z) lies at origin + spacing·(x,y,z) and has the index
/// (x·size.y + y)·size.z + z.
struct CoarseField {
  glm::dvec3 origin{0};             // m, position of sample (0,0,0) in frame W
  double spacing = 5e-4;            // m, distance between neighbouring samples
  glm::ivec3 size{0};               // number of samples per axis; 0: there is no tissue
  const float* distance = nullptr;  // m, signed distance of each sample to the surface, negative inside the tissue
};

/// A suction nozzle, which draws in air from all directions.
struct Suction {
  glm::dvec3 p_W{0};     // m, frame W, position of the suction nozzle
  double flow = 5e-3;    // m³/s; a high-volume suction draws about 300 l/min
  double radius = 4e-3;  // m, radius around `p_W` within which particles are removed
};

struct DebrisOptions {
  std::size_t capacity = 100'000;
  std::uint64_t seed = 1;
  // m³ of tissue per particle; larger if `max_per_cut` or the buffer limits the number of particles
  double parcel_volume = 1e-12;
  int max_per_cut = 32;
  // m, smallest and largest diameter of a chip at `chip_layer`; the diameter's logarithm is uniformly distributed
  double min_chip = 5e-6, max_chip = 50e-6;
  // Thickness of the removed layer per length of the rim's path (m per m), at which chips have min_chip to max_chip.
  double chip_layer = 5e-6;
  double decay_time = 2.0;            // s, time in which a particle's mass falls to 1/e (Kim & Park 2006, sec. 4.6)
  double lifetime = 6.0;              // s, age at which a particle is removed
  glm::dvec3 gravity_W{0, 0, -9.81};  // m/s², frame W, acceleration of gravity
  double air_density = 1.2;           // kg/m³, density of the air
  double air_viscosity = 1.8e-5;      // Pa·s, viscosity of the air
  double restitution = 0.3;           // normal speed after a bounce, divided by that before it
  double slide = 0.7;                 // tangential speed after a bounce, divided by that before it
  double scatter = 0.25;              // random part of a chip's initial speed, divided by the rim's speed
};

/// Masses of all chips in kg: born = alive + decayed + sucked + dropped + deposited.
struct DebrisLedger {
  PerTissue born{};
  double alive = 0;
  double decayed = 0;
  double sucked = 0;
  double dropped = 0;    // kg, mass that was lost because the buffer was full
  double deposited = 0;  // kg, mass that joined the film on the surface
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
  glm::dvec3 p_W{0}, v_W{0};  // position (m) and velocity (m/s) in frame W
  double chip = 0;            // m, diameter of one chip of the particle
  double density = 0;         // kg/m³, density of the particle
  float mass = 0;             // kg, mass of the particle
  Tissue tissue = Tissue::kAir;
};

/// How the bur made a cut.
struct CutContact {
  double head_radius = 0;  // m
  double area = 0;         // m², contact area; 0: unknown
  double duration = 0;     // s, time in which the cut was made; 0: unknown
};

/// Creates at most `room` particles of one cut and returns their number. Mass = density × removed volume; mass without
/// a particle is added to `dropped`. Particles start on the head's surface, in the contact area. A chip's volume is
/// proportional to removed volume / (contact area · cutting speed · duration): thickness per cutting length. `out`
/// needs kTissueCount · max_per_cut entries.
std::size_t create_particles(const Cut& cut, const CutContact& contact, const MaterialTable& materials,
                             const DebrisOptions& options, std::size_t room, std::span<NewParticle> out,
                             PerTissue& born, double& dropped) noexcept;

/// A particle as the renderer draws it.
struct DebrisPoint {
  glm::vec3 p_W{0};              // m, frame W, position of the particle
  float diameter = 0;            // m, diameter of a ball with the particle's remaining mass
  Tissue tissue = Tissue::kAir;  // tissue of a chip; kAir for a droplet of water
  float chip = 0;                // m, diameter of a chip; the finest chips are drawn as mist
  // m, streak of a droplet: its path during the picture's exposure, which ends at p_W
  glm::vec3 streak_W{0};
};

class Debris {
 public:
  explicit Debris(const DebrisOptions& options = {});
  ~Debris();
  Debris(Debris&&) noexcept;
  Debris& operator=(Debris&&) noexcept;

  /// Adds the chips of one cut.
  void emit(const Cut& cut, const CutContact& contact, const MaterialTable& materials) noexcept;
  /// Moves all particles. `suction`: null if off. If there is a film, chips that touch wet tissue or come to rest join
  /// it.
  void step(double dt, const CoarseField& field, const Suction* suction = nullptr, Film* film = nullptr) noexcept;

  std::size_t alive() const noexcept;
  double time() const noexcept;  // returns the sum (s) of all steps so far
  DebrisLedger ledger() const noexcept;
  /// Writes the particles, oldest first, and returns their number.
  std::size_t write_points(std::span<DebrisPoint> points) const noexcept;
  /// Returns the velocity (m/s, frame W) of the particle that write_points() wrote at `i`. Indices are valid until
  /// suction removes a particle.
  glm::vec3 velocity(std::size_t i) const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace typodont::debris
