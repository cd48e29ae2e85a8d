// Fits to measured forces: densities of a packing from a force curve (S2 in docs/papers.md, eq. 14), slow; spring and
// damper of a coupling from a push into tissue (Wang et al. 2009, section 3.3.2 and its reference 21).
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

/// A machine feeds the rotating tool; a sensor records the force.
struct FeedSample {
  double t = 0;      // s, time
  Pose X_WT;         // pose of the tool
  double force = 0;  // N, measured force
};

struct FitOptions {
  /// η of eq. 14, density per newton. 0: per moment, so that a step removes `relaxation` of the force's difference.
  double eta = 0;
  // η g Σw² of eq. 14 (g: simulated force per mean density; w: the spheres' weights). Converges between 0 and 2.
  double relaxation = 0.3;
  int rounds = 60;    // number of iterations over the whole curve
  int moments = 300;  // intervals of the curve, each with its mean force
  std::function<void(double fraction)> progress;
};

struct MaterialFit {
  std::uint64_t seed = 0, tissue_hash = 0;  // of the packing, and of its tissue
  // Per sphere: fraction of its tissue's own hardness; 1 if never touched.
  std::vector<float> hardness;
  std::vector<bool> fitted;  // touched, per sphere
  // N²; mean of (simulated − measured)², before each iteration and after the last
  std::vector<double> error;
  // Per moment with contact, at the end: s, N measured, N simulated.
  std::vector<double> t, measured, simulated;
  double stability = 0;  // of stability_of(), largest over the curve
};

/// Eq. 14 for one moment: `overlap` is index and m³ per sphere, simulated force `gain` times the mean density by
/// overlap, `rho` all densities. Returns N before the change.
double adjust_densities(std::span<const std::pair<int, double>> overlap, double gain, double eta, double measured,
                        std::span<double> rho) noexcept;
/// η g Σw² of eq. 14 for one moment: `eta`, `gain` (force per mean density), weights w. The fraction that a step
/// removes; stable below 2.
double stability_of(std::span<const std::pair<int, double>> overlap, double gain, double eta) noexcept;

/// Along the recorded path; each moment's force is what the motor needs there (PackingModel). `settings`: tool,
/// spindle, materials, method "packing". Throws Error for another method, a curve without contact, or an unstable step.
/// `curve`: name for messages.
MaterialFit fit_material(const TissueVolume& tissue, const ServoSettings& settings, std::span<const FeedSample> samples,
                         const FitOptions& options, std::string_view curve);

/// Of a push into tissue.
struct PushSample {
  double t = 0;      // s, time; must increase
  double depth = 0;  // m in the tissue; 0 or less: no contact
  double force = 0;  // N, measured force
};

struct DampingFit {
  double stiffness = 0;  // N/m, fitted stiffness of the spring
  double damping = 0;    // N·s/m, fitted damping along the push
  double rms = 0;        // N, root mean square of the residuals
  int samples = 0;       // number of samples in contact
};

/// F = k d + b ḋ by least squares over all contact, ḋ by central differences. Throws Error below three samples, or if
/// the speed is constant or proportional to the depth.
DampingFit fit_damping(std::span<const PushSample> samples);

}  // namespace typodont::haptics
