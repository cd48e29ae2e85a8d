// Densities of a sphere packing from a recorded force curve (S2, eq. 14). Set-up time.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "engine/contract/sphere_packing.h"
#include "haptics/contact_method.h"
#include "haptics/servo.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics {

/// One moment of a measurement: a machine feeds the turning tool and records what it takes.
struct FeedSample {
  double t = 0;      // s
  Pose X_WT;         // the tool
  double force = 0;  // N
};

struct FitOptions {
  /// η of eq. 14, density per newton; 0: each moment takes `relaxation` of the step that would settle it at once.
  double eta = 0;
  double relaxation = 0.3;  // η g Σw²; eq. 14 converges for 0 to 2
  int rounds = 60;          // through the whole curve
  int moments = 300;        // into which the curve is divided; the force of each is its mean
  std::function<void(double share)> progress;
};

struct MaterialFit {
  std::uint64_t seed = 0, tissue_hash = 0;  // of the packing
  std::vector<float> hardness;              // of every sphere, over its tissue's own; 1 where the tool never was
  std::vector<bool> fitted;                 // whether the tool was there
  std::vector<double> error;                // N², mean square over the moments, before each round and after the last
  std::vector<double> t, measured, simulated;  // s, N, of every moment with contact; after the last round
  double stability = 0;                        // the largest η g Σw² of all moments
};

/// Eq. 14 for one moment: changes the densities of the spheres that the tool overlaps by `overlap` (m³ each) so that
/// the simulated force, `gain` times the mean density weighted by overlap, comes nearer to the measured one. Returns
/// the force before that, N. `rho`: of all spheres.
double adjust_densities(std::span<const std::pair<int, double>> overlap, double gain, double eta, double measured,
                        std::span<double> rho) noexcept;
/// η g Σw² of such a moment, which must lie below 2.
double stability_of(std::span<const std::pair<int, double>> overlap, double gain, double eta) noexcept;

/// The virtual recreation of the measurement: the tool goes the recorded way through the tissue, and the force of each
/// moment is what the motor needs to remove what it removes there (see PackingModel). `settings`: tool, spindle,
/// materials and a method "packing". Throws Error where the method is another, the curve has no contact or the step
/// size is unstable; `curve` names the measurement in messages.
MaterialFit fit_material(const TissueVolume& tissue, const ServoSettings& settings, std::span<const FeedSample> samples,
                         const FitOptions& options, std::string_view curve);

}  // namespace typodont::haptics
