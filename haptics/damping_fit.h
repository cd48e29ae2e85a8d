// Fits spring and damper of a coupling to a measured push (Wang et al. 2009, section 3.3.2, and its reference 21).
#pragma once

#include <span>

namespace typodont::haptics {

/// One measured sample of a tool that is pushed into tissue.
struct PushSample {
  double t = 0;      // s, increasing
  double depth = 0;  // m, depth of the tool in the tissue; 0 or less: no contact
  double force = 0;  // N
};

struct DampingFit {
  double stiffness = 0;  // N/m
  double damping = 0;    // N·s/m, damping along the push
  double rms = 0;        // N, root mean square of the residuals
  int samples = 0;       // number of samples in contact
};

/// Least squares of F = k d + b ḋ over all samples in contact, with ḋ from central differences. Throws Error if fewer
/// than three samples are in contact, or if k and b cannot be separated (constant speed, or speed proportional to
/// depth).
DampingFit fit_damping(std::span<const PushSample> samples);

}  // namespace typodont::haptics
