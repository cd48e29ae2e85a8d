// Spring and damper of a coupling, fitted to the force of a push into tissue (Wang et al. 2009, section 3.3.2 and its
// reference 21).
#pragma once

#include <span>

namespace typodont::haptics {

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
