// Fits the densities of a sphere packing to a measured force curve (paper S2 in docs/papers.md, eq. 14). Slow.
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

/// One sample of a measurement: a machine feeds the rotating tool into tissue, and a sensor records the force.
struct FeedSample {
  double t = 0;      // s, time
  Pose X_WT;         // pose of the tool
  double force = 0;  // N, measured force
};

struct FitOptions {
  /// Step size η of eq. 14 in paper S2, in density per newton. 0: for each moment (interval of the curve), η is chosen
  /// such that one step removes the fraction `relaxation` of the difference between simulated and measured force.
  double eta = 0;
  // Fraction of the difference between simulated and measured force that one step removes. In eq. 14 of paper S2, it is
  // η g Σw² (η: step size; g: simulated force per mean density; w: weights of the spheres in the mean). The iteration
  // converges for values between 0 and 2.
  double relaxation = 0.3;
  int rounds = 60;    // number of iterations over the whole curve
  int moments = 300;  // number of intervals (moments) into which the curve is divided; each has its mean force
  std::function<void(double fraction)> progress;
};

struct MaterialFit {
  std::uint64_t seed = 0, tissue_hash = 0;  // seed: random seed of the fitted packing; tissue_hash: hash of its tissue
  // For every sphere: fitted hardness as a fraction of its tissue's own hardness; 1 if the tool never touched the
  // sphere.
  std::vector<float> hardness;
  std::vector<bool> fitted;  // for every sphere: true if the tool touched it
  // N²; mean over all moments of (simulated force − measured force)², before each iteration and after the last one
  std::vector<double> error;
  // For every moment with contact, after the last iteration: time (s), measured force (N), simulated force (N).
  std::vector<double> t, measured, simulated;
  double stability = 0;  // largest value of stability_of() over all samples of the curve
};

/// Applies eq. 14 of paper S2 to one moment (interval of the curve): changes the densities of the spheres that the tool
/// overlaps, so that the simulated force approaches the measured force. `overlap`: index and overlapping volume (m³) of
/// each sphere. The simulated force is `gain` times the mean density, weighted by overlap. `rho`: densities of all
/// spheres. Returns the simulated force before the change, N.
double adjust_densities(std::span<const std::pair<int, double>> overlap, double gain, double eta, double measured,
                        std::span<double> rho) noexcept;
/// Returns η g Σw² of eq. 14 in paper S2, for one moment (interval of the curve). η: step size `eta`; g: simulated
/// force per mean density, `gain`; w: weights of the spheres in the mean. One step removes this fraction of the
/// difference between simulated and measured force. The iteration is stable if the value is below 2.
double stability_of(std::span<const std::pair<int, double>> overlap, double gain, double eta) noexcept;

/// Fits the densities. The tool moves through the tissue on the recorded path; the simulated force of each moment is
/// the force that the motor needs to remove the tissue there (see class PackingModel). `settings`: tool, spindle,
/// materials and a method "packing". Throws Error if the method is another one, if the curve has no contact, or if the
/// step size is unstable. `curve`: name of the measurement for messages.
MaterialFit fit_material(const TissueVolume& tissue, const ServoSettings& settings, std::span<const FeedSample> samples,
                         const FitOptions& options, std::string_view curve);

}  // namespace typodont::haptics
