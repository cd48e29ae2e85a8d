// Water nozzles of a handpiece, from a motor's file, for the spray.
#pragma once

namespace typodont {

/// A ring around the bur's axis, aimed at its free end. Trivially copyable.
struct Nozzles {
  double flow = 0;            // m³/s; 0: no spray
  int count = 1;              // number of nozzles
  double ring_radius = 3e-3;  // m from the bur's axis
  double setback = 9e-3;      // m along the axis from the free end
  // rad, standard deviation around the way to the free end
  double cone = 0.1;
  double speed = 6;  // m/s, speed of a droplet at the nozzle
  // m, bounds of diameters, uniform in the logarithm
  double least_drop = 80e-6, greatest_drop = 250e-6;
};

}  // namespace typodont
