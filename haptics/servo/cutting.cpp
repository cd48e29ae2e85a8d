// Energy of cutting. Force and spindle speed determine the power at the cutting edges. In each tick, the energy of this
// power divided by the tissue's specific energy is the volume that the cut may remove.
#include <algorithm>
#include <cmath>

#include "haptics/servo/state.h"

namespace typodont::haptics {

void Servo::State::earn(ContactTick& now) noexcept {
  using P = CuttingParameters;
  const Tool& bur = tool();
  ContactInput& in = now.in;
  in.scrapes = bur.cuts && bur.scrapes > 0;
  in.cuts = settings.cutting && bur.cuts && (in.scrapes || cutting.speed > 0);
  // A local copy of the spindle's state stays in registers. Reading the stored value back from memory would have to
  // wait for the store.
  SpindleLoad spindle{cutting.speed, 0};
  in.specific_energy = in.cuts ? mean_specific_energy() : 0;
  // W, power that removes tissue, divided by the tool's energy_ratio: the cutting energy that the tissue needs with
  // this tool, relative to the material's own cutting energy. Because of this division, the contact models can compute
  // with the material's own cutting energy and need not know the ratio.
  double power = in.power = 0;
  if (in.scrapes && in.cuts && coupling.head_force > 0) {
    // An edge (hand instrument) that is drawn over the surface cuts with the hand's work: force × displacement along
    // the surface.
    const double way = glm::length(now.moved - glm::dot(now.moved, coupling.normal) * coupling.normal);
    power = bur.scrapes * coupling.head_force * way / now.dt / bur.energy_ratio;
  } else if (in.cuts && coupling.pressing > 0) {
    // The tangential force of the cutting edges is μ_c F_n (laws of Preston and Archard), with the cutting coefficient
    // μ_c and the normal force F_n. The motor's torque limits this force.
    const double along = glm::dot(coupling.pressed, now.X_WT.R * dvec3(0, 0, 1));
    const double efficiency = bur.side_efficiency + (bur.end_efficiency - bur.side_efficiency) * along * along;
    const double load = bur.cutting_coefficient * efficiency * coupling.pressing * bur.radius();
    now.tangential = bur.cutting_coefficient * efficiency;
    spindle = load_spindle(settings.spindle, cutting.speed, now.out.pedal, load);
    power = in.power = spindle.power / bur.energy_ratio;
  }
  double& budget = cutting.budget;
  const double wall = cutting.wall;
  if (in.cuts && coupling.head_force > 0) {
    const double most = in.scrapes || wall > 0 ? power * P::held_time : std::max(budget, power * P::budget_time);
    budget = std::min(budget + power * now.dt, most);
    // Limits the energy debt (negative budget) of a bur that started in tissue. With a large debt, the bur could not
    // cut for a long time.
    if (!in.scrapes) {
      const double h = settings.frame.voxel, owed = std::max(P::owed_volume, P::owed_voxels * h * h * h);
      budget = std::max(budget, -std::max(power * P::held_time, owed * in.specific_energy));
    }
  } else if (coupling.normal_force <= 0) {
    // If no part of the tool touches tissue, the energy that was stored for cutting is lost. If only the shank touches
    // tissue, the head keeps its stored energy.
    budget = std::min(budget, 0.0);
  }
  cutting.wall_budget =
      wall > 0 ? std::min(cutting.wall_budget + wall * power * now.dt, wall * power * P::held_time) : 0.0;
  // An edge (hand instrument) that the hand draws over the surface gets little energy. If the edge removed more tissue
  // than its energy paid for, it must not cut until the hand's work has paid the difference.
  in.must_earn = in.scrapes && budget <= 0;
  in.budget = budget;
  in.wall_budget = cutting.wall_budget;
  in.spindle = spindle.speed;
  now.spindle = spindle;
}

void Servo::State::spend(ContactTick& now, double energy) noexcept {
  now.out.cutting_power = energy * tool().energy_ratio / now.dt;
  cutting.budget -= energy;
  cutting.wall_budget -= energy;
  cutting.spindle_work += now.out.cutting_power * now.dt;
}

}  // namespace typodont::haptics
