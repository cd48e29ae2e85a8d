// Fits of material parameters to measured forces: densities of a packing (S2 in docs/papers.md, eq. 14), and spring and
// damper of the coupling (Wang et al. 2009, section 3.3.2 and its reference 21).
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

/// One moment of a test in which a machine moves the rotating tool forward and a sensor records the force.
struct FeedSample {
  double t = 0;      // s, time
  Pose X_WT;         // pose of the tool
  double force = 0;  // N, measured force
};

struct FitOptions {
  /// Step size of the fit (η of paper S2, eq. 14), density per newton, for the whole curve. 0: chosen so that a step
  /// removes at most the fraction `relaxation` of the difference between simulated and measured force; halved, and the
  /// pass repeated, whenever a pass over the curve increases the error.
  double eta = 0;
  // Upper limit of η g Σw² (paper S2, eq. 14; g: simulated force per mean density; w: weights of the spheres). The fit
  // converges between 0 and 2. η is the same for all moments; otherwise moments of little contact would dominate.
  double relaxation = 0.3;
  int rounds = 60;    // number of iterations over the whole curve
  int moments = 300;  // number of parts into which the curve is divided; the fit uses the mean force of each part
  std::function<void(double fraction)> progress;
};

struct MaterialFit {
  std::uint64_t seed = 0, tissue_hash = 0;  // seed of the packing; hash of its tissue
  // For each sphere: hardness as a fraction of its tissue's own; 1 if the tool never touched it.
  std::vector<float> hardness;
  std::vector<bool> fitted;  // for each sphere: true if the tool touched it
  // Mean of (simulated − measured)², N², before each iteration and after the last one.
  std::vector<double> error;
  // For each moment with contact, after the fit: time (s), measured and simulated force (N).
  std::vector<double> t, measured, simulated;
  double stability = 0;  // largest result of stability_of() over the curve
};

/// One step of paper S2, eq. 14, for one moment. `overlap`: index and overlap (m³) of each touched sphere. Simulated
/// force = `gain` × mean of `rho`, weighted with the overlap. Returns the simulated force before the change, N.
double adjust_densities(std::span<const std::pair<int, double>> overlap, double gain, double eta, double measured,
                        std::span<double> rho) noexcept;
/// Returns the fraction of the force's error that a step removes: η g Σw² of paper S2, eq. 14, for one moment (η:
/// `eta`; g: `gain`, force per mean density; w: weights of the spheres). Stable below 2.
double stability_of(std::span<const std::pair<int, double>> overlap, double gain, double eta) noexcept;

/// Fits the densities along the recorded path. The simulated force is the force that the motor needs for the cut at
/// that moment (PackingModel). `curve`: name for messages. Throws Error for a curve without contact, an unstable step,
/// or a fit that gets worse.
MaterialFit fit_material(const TissueVolume& tissue, const ServoSettings& settings, std::span<const FeedSample> samples,
                         const FitOptions& options, std::string_view curve);

/// One moment of a recorded push into tissue.
struct PushSample {
  double t = 0;      // s, time; must increase
  double depth = 0;  // m, penetration depth; 0 or less: no contact
  double force = 0;  // N, measured force
};

struct DampingFit {
  double stiffness = 0;  // N/m, fitted stiffness of the spring
  double damping = 0;    // N·s/m, fitted damping along the push
  double rms = 0;        // N, root mean square of the residuals
  int samples = 0;       // number of samples in contact
};

/// Fits F = k d + b ḋ by least squares to all samples in contact, with ḋ from central differences. Throws Error for
/// fewer than three samples, and if the speed is constant or proportional to the depth.
DampingFit fit_damping(std::span<const PushSample> samples);

}  // namespace typodont::haptics
