#include "engine/debris/spray.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/base/units.h"
#include "engine/debris/motion/contact.h"
#include "engine/debris/motion/motion.h"
#include "engine/debris/motion/random.h"

namespace typodont::debris {
namespace {

// m, margin around the field's box; a droplet beyond it has missed the tissue
constexpr double kMargin = 4e-3;
constexpr double kTouch = 0.1e-3;  // m, distance from the head's surface up to which the head throws off the film
constexpr double kSlowRim = 0.05;  // m/s, a bur with a slower rim throws nothing off

struct Droplet {
  dvec3 p, v;  // position (m) and velocity (m/s) in frame W
  double diameter = 0;
  double age = 0;  // s, time since the droplet left the nozzle
  Load load;
  bool flung = false;  // true if the bur has thrown the droplet off; this happens only once
};

/// Returns any unit vector perpendicular to `axis`.
dvec3 across(const dvec3& axis) {
  return glm::normalize(glm::cross(axis, std::abs(axis.x) < 0.8 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
}

}  // namespace

struct Spray::State {
  Nozzles nozzles;
  SprayOptions options;
  std::vector<Droplet> droplets;
  // number of droplets that are due; its fractional part waits for the next step
  double owed = 0;
  double owed_water = 0;  // kg, water that has been sprayed, but is not yet in a droplet
  std::uint64_t number = 0, stepped = 0;
  SprayLedger ledger;

  void launch(const Droplet& drop) {
    if (droplets.size() >= options.capacity)
      add(ledger.dropped, drop.load);
    else
      droplets.push_back(drop);
  }
  void emit(double dt, const SpraySource& source, RandomStream& random);
  void fling(double dt, const SpraySource& source, Film& film, RandomStream& random);
  bool move_droplet(Droplet& drop, double dt, const SpraySource* source, const CoarseField& field, Film& film,
                    const Suction* suction, RandomStream& random);
  void land(const Droplet& drop, const dvec3& p, const dvec3& n, Film& film);
};

/// Creates droplets that leave the nozzles at random times within the step.
void Spray::State::emit(double dt, const SpraySource& source, RandomStream& random) {
  if (!(source.water > 0) || !(nozzles.flow > 0)) return;
  owed += options.parcels_per_second * source.water * dt;
  const double water = nozzles.flow * options.water_density * source.water * dt;
  ledger.sprayed.water += water;
  owed_water += water;
  const auto count = static_cast<std::size_t>(owed);
  if (count == 0) return;
  owed -= static_cast<double>(count);
  const double each = owed_water / static_cast<double>(count);
  owed_water = 0;
  const dvec3 tip_T(0, 0, -source.head_half);
  for (std::size_t k = 0; k < count; ++k) {
    const double turn = 2 * kPi * std::floor(random.uniform() * nozzles.count) / nozzles.count;
    const dvec3 at_T(nozzles.ring_radius * std::cos(turn), nozzles.ring_radius * std::sin(turn),
                     nozzles.setback - source.head_half);
    const dvec3 aim = glm::normalize(tip_T - at_T);
    // in_ball() returns a point in the unit ball, each component of which has the standard deviation 1/√5.
    const dvec3 direction = glm::normalize(aim + std::sqrt(5.0) * nozzles.cone * random.in_ball());
    const double diameter = nozzles.min_drop * std::pow(nozzles.max_drop / nozzles.min_drop, random.uniform());
    Droplet drop{.p = source.X_WT * at_T,
                 .v = source.X_WT.rotate(nozzles.speed * direction),
                 .diameter = diameter,
                 // s; a negative age means that the droplet leaves later in this step
                 .age = -dt * random.uniform(),
                 .load = {}};
    drop.load.water = each;
    launch(drop);
  }
}

/// Throws off, as slurry, the film that the bur touches.
void Spray::State::fling(double dt, const SpraySource& source, Film& film, RandomStream& random) {
  const double rim = std::abs(source.spindle) * source.head_radius;
  if (rim < kSlowRim || film.loaded() == 0) return;
  const double fraction = -std::expm1(-options.fling_rate * rim / options.fling_speed * dt);
  const Load load = film.fling(source.X_WT.p, std::max(source.head_radius, source.head_half) + kTouch, fraction);
  if (!(load.water > 0)) return;
  add(ledger.flung, load);
  const dvec3 axis = source.X_WT.rotate({0, 0, 1}), side = across(axis), third = glm::cross(axis, side);
  for (int k = 0; k < options.max_flung; ++k) {
    const double angle = 2 * kPi * random.uniform();
    const dvec3 out = std::cos(angle) * side + std::sin(angle) * third;
    const dvec3 speed = glm::cross(source.spindle * axis, source.head_radius * out);
    Droplet drop{.p = source.X_WT.p + source.head_radius * out,
                 .v = speed + options.scatter * rim * random.in_ball() + 0.3 * rim * axis,
                 .diameter = nozzles.min_drop,
                 .age = -dt * random.uniform(),
                 .load = {},
                 .flung = true};
    add(drop.load, load, 1.0 / options.max_flung);
    launch(drop);
  }
}

/// Slow droplets stay on the surface. Fast ones splash and lose a part as mist.
void Spray::State::land(const Droplet& drop, const dvec3& p, const dvec3& n, Film& film) {
  const double speed = std::abs(glm::dot(drop.v, n)) * drop.diameter * options.water_density;
  const double weber = speed * std::abs(glm::dot(drop.v, n)) / options.surface_tension,
               reynolds = speed / options.water_viscosity;
  const bool splashes = std::sqrt(weber) * std::pow(reynolds, 0.25) > options.splash_number;
  Load stays;
  add(stays, drop.load, splashes ? 1 - options.splashed : 1);
  if (splashes) add(ledger.left, drop.load, options.splashed);
  add(ledger.deposited, stays);
  film.deposit(p, stays);
}

/// Returns false if the droplet has landed, was sucked off or has left the scene.
bool Spray::State::move_droplet(Droplet& drop, double dt, const SpraySource* source, const CoarseField& field,
                                Film& film, const Suction* suction, RandomStream& random) {
  double left = drop.age < 0 ? dt + drop.age : dt;
  drop.age = std::max(drop.age, 0.0);
  const dvec3 low = field.origin - kMargin, high = field.origin + field.spacing * dvec3(field.size - 1) + kMargin;
  while (left > 0) {
    const double part = std::min(left, options.longest_step);
    left -= part;
    drop.age += part;
    const dvec3 air = suction ? suction_velocity(*suction, drop.p, part) : dvec3(0);
    const double drag = drag_rate(glm::length(drop.v - air), drop.diameter, options.water_density, options.air_density,
                                  options.air_viscosity);
    const double keep = 1 / (1 + drag * part);
    drop.v = keep * (drop.v + options.gravity_W * part) + (1 - keep) * air;
    const dvec3 from = drop.p, offset = drop.v * part;
    const double length = glm::length(offset);
    if (suction && passed_within(suction->radius, from, from + offset, suction->p_W)) {
      add(ledger.sucked, drop.load);
      return false;
    }
    // Follows the path by sphere tracing until it meets the surface or the bur.
    double at = 0;
    bool flung_now = false;
    for (int k = 0; k < 64 && at < length; ++k) {
      const dvec3 p = from + offset * (at / std::max(length, 1e-12));
      const Contact contact(field, p);
      if (contact.inside && contact.distance <= 0.5 * drop.diameter) {
        const dvec3 g = contact.gradient();
        const double steep = glm::length(g);
        const dvec3 n = steep > 1e-12 ? g / steep : dvec3(0, 0, 1);
        land(drop, p - (contact.distance) * n, n, film);
        return false;
      }
      double free = contact.inside ? std::max(contact.distance - 0.5 * drop.diameter, 0.1 * field.spacing) : 1e-3;
      if (source && !drop.flung) {
        const dvec3 q = inverse(source->X_WT) * p;
        const double over = std::max(std::abs(q.z) - source->head_half, 0.0), off = std::hypot(q.x, q.y);
        const double to_bur = std::hypot(over, std::max(off - source->head_radius, 0.0));
        if (to_bur <= 0.5 * drop.diameter && off > 1e-9) {
          // The bur throws the droplet off with the velocity of its rim.
          drop.flung = flung_now = true;
          const dvec3 out = source->X_WT.rotate({q.x / off, q.y / off, 0}), axis = source->X_WT.rotate({0, 0, 1});
          const dvec3 rim = glm::cross(source->spindle * axis, source->head_radius * out);
          drop.v = rim + options.scatter * glm::length(rim) * random.in_ball() + 0.2 * drop.v;
          drop.p = p;
          left += part * (1 - at / std::max(length, 1e-12));
          break;
        }
        free = std::min(free, std::max(to_bur - 0.5 * drop.diameter, 0.05e-3));
      }
      at += free;
    }
    if (flung_now) continue;
    drop.p = from + offset;
    const bool outside = glm::any(glm::lessThan(drop.p, low)) || glm::any(glm::greaterThan(drop.p, high));
    // A droplet outside the box has missed only if it moves away from the box.
    const dvec3 middle = 0.5 * (low + high);
    if (drop.age > options.lifetime || (outside && glm::dot(drop.p - middle, drop.v) > 0)) {
      add(ledger.left, drop.load);
      return false;
    }
  }
  return true;
}

Spray::Spray(const Nozzles& nozzles, const SprayOptions& options) : state_(std::make_unique<State>()) {
  state_->nozzles = nozzles;
  state_->options = options;
}
Spray::~Spray() = default;
Spray::Spray(Spray&&) noexcept = default;
Spray& Spray::operator=(Spray&&) noexcept = default;

void Spray::step(double dt, const SpraySource* source, const CoarseField& field, Film& film, const Suction* suction) {
  State& s = *state_;
  const bool water = source && source->water > 0 && s.nozzles.flow > 0;
  if (!(dt > 0) || (!water && s.droplets.empty() && film.loaded() == 0)) return;
  RandomStream random(s.options.seed, ++s.number);
  if (source) {
    s.emit(dt, *source, random);
    s.fling(dt, *source, film, random);
  }
  s.stepped += s.droplets.size();
  std::erase_if(s.droplets,
                [&](Droplet& drop) { return !s.move_droplet(drop, dt, source, field, film, suction, random); });
}

std::size_t Spray::alive() const {
  return state_->droplets.size();
}
std::uint64_t Spray::droplets_stepped() const {
  return state_->stepped;
}

SprayLedger Spray::ledger() const {
  SprayLedger out = state_->ledger;
  out.in_air.water += state_->owed_water;
  for (const Droplet& drop : state_->droplets) add(out.in_air, drop.load);
  return out;
}

std::size_t Spray::write_points(std::span<DebrisPoint> points) const {
  std::size_t written = 0;
  for (const Droplet& drop : state_->droplets) {
    if (written == points.size()) break;
    // Slurry has the colour of its most frequent solid.
    const auto& solids = drop.load.solids;
    const auto most = std::max_element(solids.begin(), solids.end());
    const bool slurry = *most > 0.02 * drop.load.water;
    points[written++] = {.p_W = glm::vec3(drop.p),
                         .diameter = static_cast<float>(drop.diameter),
                         .tissue = slurry ? static_cast<Tissue>(most - solids.begin()) : Tissue::kAir,
                         .chip = 0,
                         .streak_W = glm::vec3(drop.v * std::min(state_->options.exposure, drop.age))};
  }
  return written;
}

}  // namespace typodont::debris
