#include "engine/session/heat.h"

#include <algorithm>
#include <cmath>

#include "engine/base/keys.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"

namespace typodont::session {

HeatConstants read_heat_constants(const Json& json) {
  json.allow_only({"tissues", "work", "films"});
  HeatConstants c;
  const Json tissues = json["tissues"];
  for (const std::string& key : tissues.keys()) {
    const auto tissue = tissue_named(key);
    const Json of = tissues[key];
    if (!tissue || *tissue == Tissue::kAir) of.fail("\"" + key + "\"", "the name of a tissue");
    of.allow_only({"conductivity_W_per_mK", "heat_capacity_J_per_cm3K", "source"});
    c.tissue[static_cast<std::size_t>(*tissue)] = {of["conductivity_W_per_mK"].number(0.01, 500),
                                                   of["heat_capacity_J_per_cm3K"].number(0.1, 20) * 1e6};
  }
  const Json work = json["work"], films = json["films"];
  work.allow_only({"in_tissue_percent", "source"});
  c.fraction = work["in_tissue_percent"].number(0, 100) / 100;
  films.allow_only({"dry_W_per_m2K", "wet_W_per_m2K", "at_ml_per_min", "reach_mm", "source"});
  c.dry_film = films["dry_W_per_m2K"].number(0, 1e6);
  c.wet_film = films["wet_W_per_m2K"].number(0, 1e6);
  c.wet_flow = films["at_ml_per_min"].number(0.1, 500) * kMillilitrePerMinute;
  c.wet_reach = films["reach_mm"].number(0, 100) * kMillimetre;
  return c;
}

void describe_heat(Keys& keys, HeatSettings& settings) {
  keys("coolant_C", settings.coolant, {0, 60}, "temperature of the water");
}

HeatGrid::HeatGrid(const VoxelFrame& frame, const glm::ivec3& size, std::vector<Tissue> tissue,
                   const ThermalTable& materials, double temperature)
    : frame_(frame), size_(size), tissue_(std::move(tissue)), materials_(materials) {
  temperature_.assign(tissue_.size(), temperature);
  next_ = temperature_;
  for (std::vector<double>& along : conductance_) along.assign(tissue_.size(), 0);
  double least = 1e300;
  for_each_voxel(size, [&](int x, int y, int z) {
    const std::size_t i = at(x, y, z);
    if (tissue_[i] == Tissue::kAir) return;
    solid_.push_back(i);
    const ThermalMaterial& m = materials_[static_cast<std::size_t>(tissue_[i])];
    least = std::min(least, m.heat_capacity / m.conductivity);
    if (x + 1 < size.x) connect(i, at(x + 1, y, z), 0);
    if (y + 1 < size.y) connect(i, at(x, y + 1, z), 1);
    if (z + 1 < size.z) connect(i, at(x, y, z + 1), 2);
  });
  // The conductance between two tissues is at most twice that of the worse conductor, so the step is half of the
  // stability limit h² / (6 α).
  stable_ = frame.voxel * frame.voxel * least / 12;
}

void HeatGrid::connect(std::size_t cell, std::size_t next, int axis) noexcept {
  if (tissue_[next] == Tissue::kAir) return;
  const double a = materials_[static_cast<std::size_t>(tissue_[cell])].conductivity,
               b = materials_[static_cast<std::size_t>(tissue_[next])].conductivity;
  conductance_[static_cast<std::size_t>(axis)][cell] = 2 * a * b / (a + b) * frame_.voxel;
}

void HeatGrid::step(double dt, const HeatBath& dry, const HeatBath& wet, const dvec3& wet_W, double reach) noexcept {
  const int steps = std::max(1, static_cast<int>(std::ceil(dt / stable_)));
  const double part = dt / steps, h = frame_.voxel, volume = h * h * h;
  const std::size_t strides[] = {at(1, 0, 0), at(0, 1, 0), 1};
  const dvec3 c = frame_.to_voxels(wet_W);
  const double r2 = reach * reach / (h * h);
  for (int k = 0; k < steps; ++k) {
    for (const std::size_t i : solid_) {
      if (tissue_[i] == Tissue::kAir) continue;
      const ThermalMaterial& m = materials_[static_cast<std::size_t>(tissue_[i])];
      const double here = temperature_[i];
      double power = 0;
      int free = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double up = conductance_[axis][i];
        power += up * (temperature_[up > 0 ? i + strides[axis] : i] - here);
        free += up == 0;
        const double down = i >= strides[axis] ? conductance_[axis][i - strides[axis]] : 0.0;
        power += down * (temperature_[down > 0 ? i - strides[axis] : i] - here);
        free += down == 0;
      }
      if (free > 0) {
        const std::size_t yz = strides[0], z = strides[1];
        const dvec3 p(static_cast<double>(i / yz), static_cast<double>(i % yz / z), static_cast<double>(i % z));
        const HeatBath& bath = glm::dot(p - c, p - c) < r2 ? wet : dry;
        if (bath.film > 0)
          power += free * h * h / (1 / bath.film + h / (2 * m.conductivity)) * (bath.temperature - here);
      }
      next_[i] = here + part * power / (m.heat_capacity * volume);
    }
    temperature_.swap(next_);
  }
}

void HeatGrid::heat(std::size_t cell, double energy) noexcept {
  if (tissue_[cell] == Tissue::kAir) return;
  const double volume = frame_.voxel * frame_.voxel * frame_.voxel;
  temperature_[cell] += energy / (materials_[static_cast<std::size_t>(tissue_[cell])].heat_capacity * volume);
}

void HeatGrid::heat(const dvec3& p_W, double energy) noexcept {
  const dvec3 p = frame_.to_voxels(p_W), low = glm::floor(p), fraction = p - low;
  const glm::ivec3 lo(low);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::ivec3 d(corner & 1, corner >> 1 & 1, corner >> 2), q = lo + d;
    if (!in_grid(q, size_)) continue;
    const dvec3 w = glm::mix(dvec3(1) - fraction, fraction, dvec3(d));
    heat(at(q.x, q.y, q.z), energy * w.x * w.y * w.z);
  }
}

void HeatGrid::remove(std::size_t cell) noexcept {
  if (tissue_[cell] == Tissue::kAir) return;
  tissue_[cell] = Tissue::kAir;
  const std::size_t strides[] = {at(1, 0, 0), at(0, 1, 0), 1};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    conductance_[axis][cell] = 0;
    if (cell >= strides[axis]) conductance_[axis][cell - strides[axis]] = 0;
  }
}

}  // namespace typodont::session
