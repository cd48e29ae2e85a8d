// What the bur takes away: energy from the push and the spindle, the cut it buys, and how fresh patches learn of it.
#include <algorithm>
#include <cmath>

#include "haptics/fill.h"
#include "haptics/servo/state.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

namespace {

constexpr double kBudgetTime =
    0.5;  // s, cutting energy that may wait for a voxel to yield or a bur that came free to land again,
constexpr double kHeldTime = 0.05;  // … before a wall, or under an edge that the hand draws
constexpr double kOwedVolume =
    8e-12;  // … or m³ of tissue that a motor works for, however weak, where a tip or a flank broke in so far at once
constexpr double kOwedVoxels = 8;  // … and these many voxels at least
constexpr double kWideStep = 0.2;  // samples of the wide patch that a head moves between two cuts in it

}  // namespace

void Servo::State::earn(Now& now) noexcept {
  const Tool& bur = tool();
  now.scrapes = bur.cuts && bur.scrapes > 0;
  now.may_cut = settings.cutting && bur.cuts && (now.scrapes || speed > 0);
  now.spindle = {speed, 0};
  now.specific_energy = now.may_cut ? mean_hardened(&Material::specific_energy) : 0;
  double power = 0;
  if (now.scrapes && now.may_cut && head_force > 0) {
    // An edge drawn over the surface cuts with the hand's own work: push × way along the surface.
    const double way = glm::length(now.moved - glm::dot(now.moved, normal) * normal);
    power = bur.scrapes * head_force * way / now.dt;
  } else if (now.may_cut && pressing > 0) {
    // Tangential force μ_c F_n at the rim, limited by the motor.
    const double along = glm::dot(pressed, now.X_WT.R * dvec3(0, 0, 1));
    const double efficiency = bur.side_efficiency + (bur.end_efficiency - bur.side_efficiency) * along * along;
    const double load = bur.cutting_coefficient * efficiency * pressing * bur.radius();
    now.tangential = bur.cutting_coefficient * efficiency;
    now.spindle = load_spindle(settings.spindle, speed, now.out.pedal, load);
    power = now.spindle.power;
  }
  if (now.may_cut && head_force > 0) {
    const double most = now.scrapes || wall > 0 ? power * kHeldTime : std::max(budget, power * kBudgetTime);
    budget = std::min(budget + power * now.dt, most);
    if (!now.scrapes) {  // a bur that was put into tissue is not held for it
      const double h = settings.frame.voxel, owed = std::max(kOwedVolume, kOwedVoxels * h * h * h);
      budget = std::max(budget, -std::max(power * kHeldTime, owed * now.specific_energy));
    }
  } else if (normal_force <=
             0) {  // where only the shank holds, the head has what it earned, and need not earn it again
    budget = std::min(budget, 0.0);
  }
  wall_budget = wall > 0 ? std::min(wall_budget + wall * power * now.dt, wall * power * kHeldTime) : 0.0;
  // An edge that the hand draws earns little: what hard tissue gave way without being paid for, it waits for.
  now.in_debt = now.scrapes && budget <= 0;
}

bool Servo::State::take_away(Touch& now) noexcept {
  carved = now.may_cut && now.touching && contacts.own() > 0 && !now.deep && !now.in_debt;
  if (!carved) return false;
  const double h = settings.frame.voxel;
  const Pose X_WB{now.p_WG, now.X_WT.R};
  const bool edited = patch.edits > 0 && sums.cuts == patch.edited_at;  // see Carver::apply
  const bool continues = sums.cuts > 0 && !edited && cut_tool == in_hand && same(X_WG, cut_end);
  const Sweep sweep(tool(), X_WG, X_WB, settings.frame, continues);
  bool changed;
  PerTissue hardened;  // voxels³ times hardness: what is paid for
  const PerTissue removed = carve(patch, sweep, &changed, &front, &hardened);
  double energy = 0;
  for (std::size_t i = 1; i < removed.size(); ++i) {
    const double v = removed[i] * h * h * h;
    sums.removed[i] += v;
    energy += hardened[i] * h * h * h * settings.materials[i].specific_energy;
  }
  if (!changed) return false;
  ++sums.cuts;
  cut_end = X_WB;
  cut_tool = in_hand;
  log.add(sums.cuts, sweep.lo(), sweep.hi(), {X_WG, X_WB, in_hand, continues, 0, removed});
  now.cut = {sums.cuts, now.out.index, now.hand.t, X_WG, X_WB, in_hand, {}, {}, now.spindle.speed};
  for (std::size_t i = 0; i < removed.size(); ++i) now.cut.removed[i] = removed[i] * h * h * h;
  carve_wide(X_WG, X_WB, continues);
  now.out.cutting_power = energy / now.dt;
  budget -= energy;
  wall_budget -= energy;
  spindle_work += now.out.cutting_power * now.dt;
  return true;
}

/// What was cut, in the wide patch too: in longer steps, which its coarser samples cannot tell.
void Servo::State::carve_wide(const Pose& X_WA, const Pose& X_WB, bool continues) noexcept {
  if (patch.wide.empty()) return;
  const VoxelFrame frame{settings.frame.origin, settings.frame.voxel * patch.wide.front().every};
  const bool goes_on = continues && wide_cut + 1 >= sums.cuts;
  if (!goes_on) wide_end = X_WA;
  const double turned = 2.3 * std::sqrt(std::max(0.0, 2 - 2 * std::abs(glm::dot(X_WB.R, wide_end.R))));
  const double moved = glm::length(X_WB.p - wide_end.p) + turned * tool().reach();
  if (goes_on && moved < kWideStep * frame.voxel) {
    wide_cut = sums.cuts;
    return;
  }
  carve(patch.wide.front(), Sweep(tool(), wide_end, X_WB, frame, goes_on));
  wide_end = X_WB;
  wide_cut = sums.cuts;
}

void Servo::State::catch_up(SurfacePatch& fresh) noexcept {
  const bool loose = fresh.pieces != patch.pieces;
  const bool edited = loose || fresh.edits != patch.edits;
  if (fresh.edits != patch.edits) carved = false;
  for (std::size_t i = 0; i < fresh.loose.size(); ++i) sums.removed[i] += fresh.loose[i] - patch.loose[i];
  glm::ivec3 lo, hi;
  bool filled = false;
  if (patch.number != 0 && edited) {
    repeat_cuts(fresh);
  } else if (patch.number != 0 && log.since(fresh.cuts, lo, hi, filled)) {
    merge(fresh, patch, lo, hi, filled);
    update_wide(fresh, false);
  }
  if (edited || patch.number == 0) front.forget();
}

/// A stroke was taken back or brought again, or a piece taken out: the old patch knows nothing of that, so the cuts
/// made since are repeated, as the carver repeats them. What they had taken from such a piece before it was gone counts
/// once.
void Servo::State::repeat_cuts(SurfacePatch& fresh) noexcept {
  const double voxel = settings.frame.voxel;
  for (std::uint64_t i = log.first_after(fresh.cuts); i <= log.last(); ++i) {
    const CutLog::Made& made = log.made(i);
    const Tool& with = tools[made.tool].tool;
    PerTissue removed;  // in tissue that came back, more than it was where that was gone
    if (made.fill_radius > 0) {
      bool changed;
      removed = haptics::fill(fresh, Fill(with, made.X_WA.p, made.fill_radius, made.X_WB, settings.frame), &changed);
      for (double& v : removed) v = -v;
    } else {
      const bool continues = made.continues && i != fresh.edited_at + 1;
      removed = carve(fresh, Sweep(with, made.X_WA, made.X_WB, settings.frame, continues));
    }
    for (std::size_t t = 0; t < removed.size(); ++t) {
      sums.removed[t] += (removed[t] - made.removed[t]) * voxel * voxel * voxel;
    }
  }
  for (std::size_t i = 0; i < sums.removed.size(); ++i) sums.removed[i] -= fresh.taken_back[i] - patch.taken_back[i];
  update_wide(fresh, true);
}

/// Brings a fresh wide patch up to date with the cuts it lacks.
void Servo::State::update_wide(SurfacePatch& fresh, bool repeat) noexcept {
  if (fresh.wide.empty()) return;
  SurfacePatch& wide = fresh.wide.front();
  const VoxelFrame frame{settings.frame.origin, settings.frame.voxel * wide.every};
  if (repeat) {
    for (std::uint64_t i = log.first_after(fresh.cuts); i <= log.last(); ++i) {
      const CutLog::Made& made = log.made(i);
      if (!(made.fill_radius > 0)) carve(wide, Sweep(tools[made.tool].tool, made.X_WA, made.X_WB, frame));
    }
    return;
  }
  glm::ivec3 lo, hi;
  bool filled = false;
  if (patch.wide.empty() || !log.since(fresh.cuts, lo, hi, filled) || filled) return;
  const int n = wide.every, margin = static_cast<int>(Sweep::kMargin) + 1;
  lo = glm::max(lo, glm::ivec3(-1'000'000)) / n - margin;
  hi = glm::min(hi, glm::ivec3(1'000'000)) / n + margin;
  merge(wide, patch.wide.front(), lo, hi);
}

}  // namespace typodont::haptics
