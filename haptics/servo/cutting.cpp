// Power at the edges, from force and speed. The volume that may be removed is energy per tick / specific energy.
#include <algorithm>
#include <cmath>

#include "haptics/servo/state.h"

namespace typodont::haptics {

void Servo::State::earn(ContactTick& now) noexcept {
  using P = CuttingParameters;
  const Tool& bur = tool();
  ContactInput& in = now.in;
  in.removal.scrapes = bur.cuts && bur.scrapes > 0;
  in.removal.cuts = settings.cutting && bur.cuts && !motion.inside && (in.removal.scrapes || cutting.speed > 0);
  // Values that are used again are kept in local variables, which stay in registers.
  const EdgeMeans edges = in.removal.cuts ? edge_means() : EdgeMeans{};
  in.removal.specific_energy = edges.specific_energy;
  now.energy_ratio = edges.energy_ratio;
  // Converts the stored energy: budgets are motor work / energy_ratio, and energy_ratio changes from tick to tick.
  const double worth = cutting.energy_ratio / now.energy_ratio;
  cutting.energy_ratio = now.energy_ratio;
  cutting.budget *= worth;
  cutting.wall_budget *= worth;
  // Power (watts) divided by energy_ratio, so that models need only the material's own specific energy.
  double power = in.removal.power = 0;
  if (in.removal.scrapes && in.removal.cuts && coupling.head_force > 0) {
    // An edge that the hand moves cuts with the hand's work: force × displacement along the surface.
    const double distance = glm::length(now.moved - glm::dot(now.moved, coupling.normal) * coupling.normal);
    power = bur.scrapes * coupling.head_force * distance / now.dt / now.energy_ratio;
  } else if (in.removal.cuts && coupling.pressing > 0) {
    // Tangential force μ_c F_n (laws of Preston and Archard), limited by the motor.
    const double along = glm::dot(coupling.pressed, now.X_WT.R * dvec3(0, 0, 1));
    const double efficiency = bur.side_efficiency + (bur.end_efficiency - bur.side_efficiency) * along * along;
    now.tangential = edges.force_ratio * efficiency;
    const double load = now.tangential * coupling.pressing * bur.radius();
    const double lost = free_speed() * settings.spindle.lost_fraction(load, now.out.pedal);
    if (lost > 0) cutting.speed = std::max(0.0, cutting.speed - (1 - settings.spindle.lag(now.dt)) * lost);
    power = in.removal.power = load * cutting.speed / now.energy_ratio;
  }
  double& budget = cutting.budget;
  const double wall = cutting.wall;
  if (in.removal.cuts && coupling.head_force > 0) {
    const double most =
        in.removal.scrapes || wall > 0 ? power * P::held_time : std::max(budget, power * P::budget_time);
    budget = std::min(budget + power * now.dt, most);
    // Limits the debt: a bur that started in tissue may have used more energy than it received. With a large debt, it
    // could not cut for a long time.
    if (!in.removal.scrapes) {
      const double h = settings.frame.voxel, owed = std::max(P::owed_volume, P::owed_voxels * h * h * h);
      budget = std::max(budget, -std::max(power * P::held_time, owed * in.removal.specific_energy));
    }
  } else if (coupling.normal_force <= 0) {
    // Without contact, stored energy is lost. If only the shank has contact, the stored energy is kept.
    budget = std::min(budget, 0.0);
  }
  cutting.wall_budget =
      wall > 0 ? std::min(cutting.wall_budget + wall * power * now.dt, wall * power * P::held_time) : 0.0;
  // A scraping edge receives little energy. If its budget is used up, it cuts again only after more work of the hand.
  in.removal.must_earn = in.removal.scrapes && budget <= 0;
  in.removal.budget = budget;
  in.removal.wall_budget = cutting.wall_budget;
  in.removal.spindle = cutting.speed;
}

void Servo::State::spend(ContactTick& now, double energy) noexcept {
  now.out.cutting_power = energy * now.energy_ratio / now.dt;
  cutting.budget -= energy;
  cutting.wall_budget -= energy;
  cutting.spindle_work += now.out.cutting_power * now.dt;
}

void Servo::State::wear_grains(ContactTick& now) noexcept {
  double worn = 0;  // m³, volume worn off the tool's abrasive grains in this tick
  for (std::size_t i = 1; i < now.cut.removed.size(); ++i) {
    const double ratio = settings.materials[i].grit.grinding_ratio;
    if (ratio > 0) worn += now.cut.removed[i] / ratio;
  }
  if (worn > 0) now.out.wear = sums.wear = wear[in_hand] += worn / tool().grain_volume();
}

}  // namespace typodont::haptics
