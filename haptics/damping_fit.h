// A measurement records the force while a tool is pushed into tissue. These functions fit the spring and the damper of
// a coupling to this measurement (Wang et al. 2009, section 3.3.2, and reference 21 of that paper).
#pragma once

#include <span>

namespace typodont::haptics {

/// One sample of a measurement in which a tool is pushed into tissue.
struct PushSample {
  double t = 0;      // s, time; must increase
  double depth = 0;  // m, depth of the tool in the tissue; 0 or less: no contact
  double force = 0;  // N, measured force
};

struct DampingFit {
  double stiffness = 0;  // N/m, fitted stiffness of the spring
  double damping = 0;    // N·s/m, fitted damping along the push
  double rms = 0;        // N, root mean square of the residuals
  int samples = 0;       // number of samples in contact
};

/// Fits k and b in F = k d + b ḋ by least squares to all samples in contact. d is the depth; its rate ḋ is computed by
/// central differences. Throws Error if fewer than three samples are in contact, or if the samples cannot distinguish k
/// from b (the speed is constant or proportional to the depth).
DampingFit fit_damping(std::span<const PushSample> samples);

}  // namespace typodont::haptics
