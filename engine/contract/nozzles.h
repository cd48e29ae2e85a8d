// The water nozzles of a handpiece. A motor's file describes them; the spray uses them.
#pragma once

namespace typodont {

/// A ring of nozzles around the bur's axis. The nozzles are aimed at the free end of the bur. Trivially copyable.
struct Nozzles {
  double flow = 0;            // m³/s, flow of water; 0 if there is no spray
  int count = 1;              // number of nozzles
  double ring_radius = 3e-3;  // m, distance of the nozzles from the bur's axis
  double setback = 9e-3;      // m, distance from the bur's free end to the nozzles, along its axis
  // rad, standard deviation of the angle between a droplet's direction and the direction to the bur's free end
  double cone = 0.1;
  double speed = 6;  // m/s, speed of a droplet at the nozzle
  // m, smallest and largest diameter of droplets; the distribution is uniform in the logarithm
  double least_drop = 80e-6, greatest_drop = 250e-6;
};

}  // namespace typodont
