// Spring and damper of a coupling, fitted to a measured push (Wang et al. 2009, section 3.3.2, and its reference 21).
#pragma once

#include <span>

namespace typodont::haptics {

/// One sample of a tool that was pushed into tissue.
struct PushSample {
  double t = 0;      // s, rising
  double depth = 0;  // m; 0 or less: it touched nothing
  double force = 0;  // N
};

struct DampingFit {
  double stiffness = 0;  // N/m
  double damping = 0;    // N·s/m, along the push
  double rms = 0;        // N, of what is left
  int samples = 0;       // that touched
};

/// Least squares of F = k d + b ḋ over all samples in contact, ḋ by central differences. Throws Error where fewer than
/// three are, or where they do not tell k from b (one speed and depth in proportion).
DampingFit fit_damping(std::span<const PushSample> samples);

}  // namespace typodont::haptics
