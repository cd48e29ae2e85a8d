// Fits the densities of a sphere packing to a recorded force curve (paper S2 in docs/papers.md, eq. 14). Set-up time.
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

/// One sample of a measurement: a machine feeds the turning tool and records the force.
struct FeedSample {
  double t = 0;      // s
  Pose X_WT;         // pose of the tool
  double force = 0;  // N, measured force
};

struct FitOptions {
  /// η of eq. 14, density per newton; 0: in each moment, η is chosen so that a step removes the fraction `relaxation`
  /// of the error
  double eta = 0;
  double relaxation = 0.3;  // fraction of the error that one step removes, η g Σw²; eq. 14 converges between 0 and 2
  int rounds = 60;          // number of iterations over the whole curve
  int moments = 300;        // number of moments into which the curve is divided; the force of a moment is its mean
  std::function<void(double share)> progress;
};

struct MaterialFit {
  std::uint64_t seed = 0, tissue_hash = 0;  // identity of the packing and its tissue
  // for every sphere: fraction of the tissue's own hardness; 1 if the tool never touched it
  std::vector<float> hardness;
  std::vector<bool> fitted;   // true for the spheres that the tool touched
  std::vector<double> error;  // N², mean square error over the moments, before each iteration and after the last one
  // s, N, N: time, measured and simulated force of every moment with contact; after the last iteration
  std::vector<double> t, measured, simulated;
  double stability = 0;  // largest stability_of() of all moments
};

/// Eq. 14 for one moment: changes the densities of the spheres that the tool overlaps by `overlap` (m³ each). The
/// simulated force, `gain` times the mean density weighted by overlap, comes closer to the measured force. `rho`:
/// densities of all spheres. Returns the simulated force before the change, N.
double adjust_densities(std::span<const std::pair<int, double>> overlap, double gain, double eta, double measured,
                        std::span<double> rho) noexcept;
/// Factor η g Σw² of eq. 14 for one moment: the fraction of the error that one step removes. Must be less than 2.
double stability_of(std::span<const std::pair<int, double>> overlap, double gain, double eta) noexcept;

/// Simulates the measurement: the tool moves through the tissue on the recorded path, and the force of each moment is
/// the force that the motor needs to remove the tissue at that moment (see PackingModel). `settings`: tool, spindle,
/// materials and a method "packing". Throws Error if the method is another one, the curve has no contact or the step
/// size is unstable; `curve` names the measurement in messages.
MaterialFit fit_material(const TissueVolume& tissue, const ServoSettings& settings, std::span<const FeedSample> samples,
                         const FitOptions& options, std::string_view curve);

}  // namespace typodont::haptics
