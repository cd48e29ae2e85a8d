// Droplets of the spray's water, and of slurry that the bur throws off.
//
//   Spray spray({.seed = 7});
//   spray.step(1.0 / 60, source, field, film, &suction);   // source: null if there is no bur
//
// One thread. Without water it costs nothing. Equal calls and seed give bit-identical results.
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

/// State of the nozzles and the bur during a step.
struct SpraySource {
  // pose of the tool: origin in the head's centre, z along the shank
  Pose X_WT;
  double head_radius = 0;  // m, radius of the tool's head
  double head_half = 0;    // m, distance from the head's centre to its free end
  double spindle = 0;      // rad/s, rotation speed about the tool's z, with sign
  double water = 0;        // flow of water as a fraction of the full flow, 0 to 1
};

struct SprayOptions {
  std::size_t capacity = 4096;
  std::uint64_t seed = 1;
  // simulated droplets per second; each represents several real ones
  double parcels_per_second = 12'000;
  double longest_step = 2e-3;  // s, longest time in which a droplet moves along a straight line
  double lifetime = 0.5;       // s, age at which a droplet has left the scene
  glm::dvec3 gravity_W{0, 0, -9.81};
  double air_density = 1.2, air_viscosity = 1.8e-5;  // density of the air (kg/m³), and its viscosity (Pa·s)
  // water: density (kg/m³), viscosity (Pa·s), surface tension (N/m)
  double water_density = 1000, water_viscosity = 1e-3, surface_tension = 0.072;
  double scatter = 0.25;  // random part of a thrown droplet's speed divided by the rim's speed
  // A droplet splashes if We^½ Re^¼ is larger than this (Mundo, Sommerfeld & Tropea 1995; We: Weber number). The
  // fraction `splashed` of the droplet leaves as mist.
  double splash_number = 57.7;
  double splashed = 0.5;
  // 1/s, fraction of the touched film that the bur throws off per time at the rim speed `fling_speed`
  double fling_rate = 5;
  double fling_speed = 20;   // m/s, rim speed of the bur at which `fling_rate` holds
  int max_flung = 24;        // number of droplets of slurry that the bur throws off per step
  double exposure = 2.5e-4;  // s, exposure of a picture, which gives the length of a droplet's streak
};

/// Masses of water and of each tissue in kg: sprayed + flung = in_air + deposited + sucked + left + dropped.
struct SprayLedger {
  Load sprayed, flung;  // kg, from the nozzles (sprayed), from the film (flung)
  Load in_air, deposited, sucked;
  Load left;     // kg, mass that missed the tissue or left as mist
  Load dropped;  // kg, mass that was lost because the buffer was full
};

class Spray {
 public:
  explicit Spray(const Nozzles& nozzles, const SprayOptions& options = {});
  ~Spray();
  Spray(Spray&&) noexcept;
  Spray& operator=(Spray&&) noexcept;

  /// Advances all droplets by `dt` (s). `source`: null if there is no bur.
  void step(double dt, const SpraySource* source, const CoarseField& field, Film& film,
            const Suction* suction = nullptr);

  std::size_t alive() const;
  // returns the number of droplets computed so far, counted once per step
  std::uint64_t droplets_stepped() const;
  SprayLedger ledger() const;
  /// Writes the droplets and returns their number.
  std::size_t write_points(std::span<DebrisPoint> points) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace typodont::debris
