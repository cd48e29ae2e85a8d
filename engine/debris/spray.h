// Droplets: the water of a handpiece's spray, and the slurry that the turning bur throws off.
//
//   Spray spray({.seed = 7});
//   spray.step(1.0 / 60, source, field, film, &suction);   // source: null if there is no bur
//
// A droplet flies for a few milliseconds, whereas a chip flies for seconds. Therefore droplets are stored separately
// from chips, and most of them reach the surface within one step. For one thread. Without water and slurry, step()
// returns at once. The same calls and the same seed give the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "engine/base/pose.h"
#include "engine/contract/nozzles.h"
#include "engine/debris/debris.h"
#include "engine/debris/film.h"

namespace typodont::debris {

/// The state of the nozzles and of the bur during a step.
struct SpraySource {
  // pose of the tool; its origin is in the centre of the head, and its z axis points along the shank
  Pose X_WT;
  double head_radius = 0;  // m, radius of the tool's head
  double head_half = 0;    // m, distance from the head's centre to its free end
  double spindle = 0;      // rad/s, rotation speed about the tool's z, with sign
  double water = 0;        // flow of water as a fraction of the nozzles' full flow, 0 to 1
};

struct SprayOptions {
  std::size_t capacity = 4096;
  std::uint64_t seed = 1;
  // number of simulated droplets per second; each represents the water of several real droplets
  double parcels_per_second = 12'000;
  double longest_step = 2e-3;  // s; a droplet's curved path is computed as straight parts of at most this flight time
  double lifetime = 0.5;       // s; an older droplet is removed because it has left the scene
  glm::dvec3 gravity_W{0, 0, -9.81};
  double air_density = 1.2, air_viscosity = 1.8e-5;  // density of the air (kg/m³), and its viscosity (Pa·s)
  // density (kg/m³), viscosity (Pa·s) and surface tension (N/m) of the water
  double water_density = 1000, water_viscosity = 1e-3, surface_tension = 0.072;
  double scatter = 0.25;  // standard deviation of the velocity of a thrown-off droplet divided by the rim speed
  // A droplet splashes if We^½ Re^¼ (Weber and Reynolds number) exceeds this number (Mundo, Sommerfeld & Tropea 1995).
  // Then the fraction `splashed` of the droplet leaves as fine mist.
  double splash_number = 57.7;
  double splashed = 0.5;
  // 1/s, rate at which a bur with the rim speed `fling_speed` throws off the film that it touches
  double fling_rate = 5;
  double fling_speed = 20;   // m/s, rim speed of the bur at which `fling_rate` holds
  int most_flung = 24;       // largest number of droplets of slurry per step
  double exposure = 2.5e-4;  // s, exposure time of a picture, during which a flying droplet draws a streak
};

/// Balance of the droplets' mass in kg, for water and for every tissue: sprayed + flung = in_air + deposited + sucked +
/// left + dropped.
struct SprayLedger {
  Load sprayed, flung;  // kg, water that left the nozzles; slurry that the bur threw off the film
  Load in_air, deposited, sucked;
  Load left;     // kg, mass that flew past the tissue or left as mist
  Load dropped;  // kg, mass that was lost because the buffer was full
};

class Spray {
 public:
  explicit Spray(const Nozzles& nozzles, const SprayOptions& options = {});
  ~Spray();
  Spray(Spray&&) noexcept;
  Spray& operator=(Spray&&) noexcept;

  /// Advances the droplets by dt seconds. `source` is null if there is no bur.
  void step(double dt, const SpraySource* source, const CoarseField& field, Film& film,
            const Suction* suction = nullptr);

  std::size_t alive() const;
  // returns the number of moved droplets: a droplet that is moved in three steps counts three times
  std::uint64_t droplets_stepped() const;
  SprayLedger ledger() const;
  /// Writes the droplets in the air into `points` and returns their number.
  std::size_t write_points(std::span<DebrisPoint> points) const;
  std::uint64_t hash() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace typodont::debris
