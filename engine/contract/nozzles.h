// The water nozzles of a handpiece. A motor's file describes them; the spray uses them.
#pragma once

namespace typodont {

/// A ring of nozzles around the bur's axis. The nozzles are aimed at the free end of the bur. Trivially copyable.
struct Nozzles {
  double flow = 0;            // m³/s of water; 0: no spray
  int count = 1;              // number of nozzles
  double ring_radius = 3e-3;  // m, distance of the nozzles from the axis
  double setback = 9e-3;      // m, distance from the bur's free end to the nozzles, along the axis
  double cone = 0.1;          // rad, standard deviation of the angle between the droplets' directions and the aim
  double speed = 6;           // m/s, speed of a droplet at the nozzle
  double least_drop = 80e-6, greatest_drop = 250e-6;  // m, diameters; uniform in the logarithm
};

}  // namespace typodont
