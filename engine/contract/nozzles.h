// A handpiece's water nozzles, from a motor's file, for drawing.
#pragma once

namespace typodont {

/// Nozzles in a ring around the bur's axis, aimed at the bur's free end (its tip). Trivially copyable.
struct Nozzles {
  double flow = 0;            // m³/s, water flow; 0: no spray
  int count = 1;              // number of nozzles
  double ring_radius = 3e-3;  // m, distance of the nozzles from the bur's axis
  double setback = 9e-3;      // m, distance of the nozzles from the bur's free end, along the bur's axis
  // Spread of the spray, rad: standard deviation about the direction to the free end.
  double cone = 0.1;
  double speed = 6;  // m/s, speed of a droplet at the nozzle
  // Smallest and largest diameter of a droplet, m. The diameters are uniform in their logarithm.
  double min_drop = 80e-6, max_drop = 250e-6;
};

}  // namespace typodont
