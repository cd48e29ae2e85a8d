#include "engine/debris/debris.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "engine/base/units.h"
#include "engine/debris/film.h"
#include "engine/debris/motion/contact.h"
#include "engine/debris/motion/motion.h"
#include "engine/debris/motion/random.h"

namespace typodont::debris {
namespace {

constexpr std::uint32_t kNever = std::numeric_limits<std::uint32_t>::max();
// infinite drag rate (1/s), which marks a particle at rest
constexpr float kStuck = std::numeric_limits<float>::infinity();
// number of steps after which a resting particle checks whether the tissue below it still exists
constexpr std::uint32_t kRestSteps = 1024;
constexpr std::uint32_t kMaxSteps = 1024;  // largest number of steps between two full updates of a moving particle
// Number of particles per group. `first_due` stores the earliest update of each group.
constexpr std::size_t kGroup = 32;
constexpr double kRestSpeed = 0.05;  // m/s, speed after a bounce below which a particle comes to rest
// largest relative error of a stored drag rate until the next full update
constexpr double kDragError = 0.1;
constexpr double kStokesReynolds = 0.02;  // Reynolds number below which Stokes drag holds within 1 %

}  // namespace

// Particles lie in a ring buffer in the order of creation. All have the same lifetime, so the oldest disappears first,
// and the living ones fill one or two ranges.
struct Debris::State {
  DebrisOptions options;
  // Per particle. `rate`: drag rate, 1/s. `keep`: factor by which drag reduces the velocity in a step.
  std::vector<float> x, y, z, vx, vy, vz, rate, keep;
  std::vector<std::uint32_t> due;  // step of each particle's next full update (update_fully)
  // for each group of particles: no full update of the group is due before this step
  std::vector<std::uint32_t> first_due;
  struct Chip {      // data of a particle that the inner loop does not use
    double born_at;  // s, time at which the particle was created
    float mass0;     // kg, mass at creation; 0: suction has removed the particle
    float diameter;  // m, diameter of one chip
    float density;   // kg/m³, density of the chip
    float stokes;    // 1/s, drag rate of a slow particle (Stokes drag)
    Tissue tissue;
  };
  std::vector<Chip> chips;
  std::vector<NewParticle> new_particles;  // buffer for the new particles of one cut
  std::size_t first = 0, count = 0;
  double time = 0;
  float last_dt = 0;  // s, step length for which the velocity factors `keep` were computed
  // starts at kMaxSteps, so that set_due_within() computes no negative numbers
  std::uint32_t step = kMaxSteps;
  PerTissue born{};
  double decayed = 0, sucked = 0, dropped = 0, deposited = 0;
  double gravity = 0;               // m/s², magnitude of the acceleration of gravity
  double density_by_viscosity = 0;  // s/m², density of the air divided by its viscosity
  bool drawn = false;               // true if the suction was on in the last step
  glm::dvec3 nozzle_W{0};           // m, position of the nozzle in the last step
  double flow = 0;                  // m³/s, flow of the nozzle in the last step

  std::size_t slot(std::size_t i) const {
    const std::size_t s = first + i;
    return s < options.capacity ? s : s - options.capacity;
  }
  double left(std::size_t s) const {
    return chips[s].mass0 * std::exp(-(time - chips[s].born_at) / options.decay_time);
  }
  void set_rate(std::size_t s, float value) {
    rate[s] = value;
    keep[s] = 1.0f / (1.0f + value * last_dt);
  }
  glm::dvec3 position(std::size_t s) const { return {x[s], y[s], z[s]}; }
  glm::dvec3 velocity(std::size_t s) const { return {vx[s], vy[s], vz[s]}; }

  void set_due(std::size_t s, std::uint32_t when) {
    due[s] = when;
    first_due[s / kGroup] = std::min(first_due[s / kGroup], when);
  }
  // Plans the particle's next full update after steps / 2 to `steps` steps. The step becomes a multiple of `grain`,
  // shifted by the group's `phase`: a group's particles are updated together, and different groups in different steps.
  void set_due_within(std::size_t s, std::uint32_t steps) {
    const std::uint32_t grain = std::bit_floor(std::max(1u, steps / 2));
    const std::uint32_t phase = static_cast<std::uint32_t>(s / kGroup) * 37 % kMaxSteps;
    set_due(s, std::max(step + 1, ((step + steps + phase) & ~(grain - 1)) - phase));
  }
  // Removes a particle and returns its remaining mass in kg.
  double take_out(std::size_t s) {
    const double mass = left(s);
    decayed += chips[s].mass0 - mass;
    chips[s].mass0 = 0;
    vx[s] = vy[s] = vz[s] = 0;
    set_rate(s, kStuck);
    set_due(s, kNever);
    return mass;
  }
  void stick(std::size_t s, const glm::dvec3& p, Film& film) {
    Load load;
    load.solids[static_cast<std::size_t>(chips[s].tissue)] = take_out(s);
    deposited += total(load.solids);
    film.deposit(p, load);
  }
  void update_fully(std::size_t s, double dt, const CoarseField& field, const Suction* suction, Film* film) noexcept;
};

// Computes a particle's contact, bounce, drag rate and the number of steps until its next full update.
void Debris::State::update_fully(std::size_t s, double dt, const CoarseField& field, const Suction* suction,
                                 Film* film) noexcept {
  const bool resting = rate[s] >= kStuck;
  glm::dvec3 p = position(s), v = velocity(s);
  const double nozzle = suction ? glm::length(suction->p_W - p) : 0;
  if (suction && (nozzle < suction->radius || passed_within(suction->radius, p - v * dt, p, suction->p_W))) {
    sucked += take_out(s);
    return;
  }
  const Contact contact(field, p);
  const double radius = 0.5 * chips[s].diameter;
  if (resting) {
    if (contact.inside && contact.distance < 0.5 * field.spacing) {
      set_due_within(s, kRestSteps);
      return;
    }
  } else if (contact.inside && contact.distance < radius) {
    const glm::dvec3 gradient = contact.gradient();
    const double length = glm::length(gradient);
    const glm::dvec3 n = length > 1e-12 ? gradient / length : glm::dvec3(0, 0, 1);
    p += (radius - contact.distance) * n;
    if (film && film->water_at(p) > 0) return stick(s, p, *film);
    const double approach = glm::dot(v, n);
    if (approach < 0) {
      const glm::dvec3 along = v - approach * n;
      v = options.slide * along - options.restitution * approach * n;
    }
    x[s] = static_cast<float>(p.x), y[s] = static_cast<float>(p.y), z[s] = static_cast<float>(p.z);
    if (glm::dot(v, v) < kRestSpeed * kRestSpeed) {
      if (film) return stick(s, p, *film);
      vx[s] = vy[s] = vz[s] = 0;
      set_rate(s, kStuck);
      set_due_within(s, kRestSteps);
      return;
    }
    vx[s] = static_cast<float>(v.x), vy[s] = static_cast<float>(v.y), vz[s] = static_cast<float>(v.z);
  }
  // Drag depends on the velocity relative to the air, which suction moves.
  const glm::dvec3 air = suction ? suction_velocity(*suction, p, dt) : glm::dvec3(0);
  const double speed = glm::length(v - air);
  const double stokes = chips[s].stokes;
  const double reynolds = speed * chips[s].diameter * density_by_viscosity;
  const double factor = reynolds < kStokesReynolds ? 1 : drag_factor(reynolds);
  set_rate(s, static_cast<float>(stokes * factor));

  // Lower bound of the time until the particle meets tissue or the nozzle, or needs a new drag rate. The particle's
  // speed stays below the larger of its current and its terminal speed. On the first half of the way to the nozzle, the
  // air's mean speed is less than twice its current speed.
  const double falls = gravity / stokes, drift = 2 * glm::length(air);
  const double own = suction ? speed + falls : std::max(speed, falls);
  const auto soon = [&](double clearance, const glm::dvec3& away) {
    const bool leaves = glm::dot(away, v) >= 0 && glm::dot(away, options.gravity_W) >= 0;
    return clearance / std::max((leaves ? drift : own + drift) * dt, 1e-12);
  };
  // smallest possible number of steps until the particle reaches tissue or the nozzle
  double undisturbed_steps = kMaxSteps;
  if (field.distance && contact.inside) {
    // Uses the larger of two lower bounds of the way to the tissue: the interpolated distance errs by at most half the
    // spacing, and changes by at most √3 m per metre of the particle's way.
    const double off = contact.distance - radius;
    undisturbed_steps = std::max(off - 0.5 * field.spacing, off / std::sqrt(3.0)) / ((own + drift) * dt);
  } else if (field.distance) {
    const glm::dvec3 low = field.origin, high = field.origin + field.spacing * glm::dvec3(field.size - 1);
    const glm::dvec3 away = p - glm::clamp(p, low, high);
    undisturbed_steps = std::min(undisturbed_steps, soon(glm::length(away), away));
  }
  if (suction)
    undisturbed_steps =
        std::min(undisturbed_steps, soon(std::min(0.5 * nozzle, nozzle - 0.5 * suction->radius), p - suction->p_W));
  auto steps = static_cast<std::uint32_t>(std::clamp(undisturbed_steps, 1.0, double{kMaxSteps}));
  if (reynolds > kStokesReynolds) {
    // Relative change of the drag rate divided by the relative change of the speed; `factor` = 1 + 0.15 Re^0.687.
    const double sensitivity = 0.687 * (factor - 1) / factor;
    // m/s, upper bound of the velocity's change per step
    const double change = glm::length(options.gravity_W - static_cast<double>(rate[s]) * (v - air)) * dt;
    steps = static_cast<std::uint32_t>(
        std::clamp(kDragError * speed / (sensitivity * change), 1.0, static_cast<double>(steps)));
  }
  set_due_within(s, steps);
}

Debris::Debris(const DebrisOptions& options) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.options = options;
  s.gravity = glm::length(options.gravity_W);
  s.density_by_viscosity = options.air_density / options.air_viscosity;
  for (auto* array : {&s.x, &s.y, &s.z, &s.vx, &s.vy, &s.vz, &s.rate, &s.keep}) {
    array->resize(options.capacity);
  }
  s.due.assign(options.capacity, kNever);
  s.first_due.assign(options.capacity / kGroup + 1, kNever);
  s.chips.resize(options.capacity);
  s.new_particles.resize(static_cast<std::size_t>(kTissueCount) * static_cast<std::size_t>(options.max_per_cut));
}
Debris::~Debris() = default;
Debris::Debris(Debris&&) noexcept = default;
Debris& Debris::operator=(Debris&&) noexcept = default;

namespace {

/// Radius of the contact area divided by the head's radius; a usual value if the area is unknown.
double spread_of(const CutContact& contact) {
  constexpr double kUnknown = 0.8, kMin = 0.1;
  return contact.area > 0 ? std::clamp(std::sqrt(contact.area / kPi) / contact.head_radius, kMin, 1.0) : kUnknown;
}

/// Factor on the chips' diameter for this cut; 1 if removed volume = `layer` × contact area × path length.
double chip_scale(const Cut& cut, const CutContact& contact, double layer) {
  constexpr double kMin = 0.4, kMax = 4;
  const double path = std::abs(cut.spindle) * contact.head_radius * contact.duration;
  double volume = 0;
  for (const double removed : cut.removed) volume += std::max(removed, 0.0);
  if (!(contact.area > 0) || !(path > 0)) return 1;
  return std::clamp(std::cbrt(volume / (contact.area * path) / layer), kMin, kMax);
}

}  // namespace

std::size_t create_particles(const Cut& cut, const CutContact& contact, const MaterialTable& materials,
                             const DebrisOptions& options, std::size_t room, std::span<NewParticle> out,
                             PerTissue& born, double& dropped) noexcept {
  RandomStream random(options.seed, cut.index);
  const dvec3 axis = cut.X_WB.rotate({0, 0, 1});
  // Chips leave on the cutting side of the head, or all around it if the cut has no contact normal.
  const double normal_length = glm::length(cut.n_C_W), head_radius = contact.head_radius;
  const double spread = spread_of(contact), scale = chip_scale(cut, contact, options.chip_layer);
  std::size_t count = 0;
  for (int t = 0; t < kTissueCount; ++t) {
    const auto tissue = static_cast<std::size_t>(t);
    const double volume = cut.removed[tissue], density = materials[tissue].density;
    if (!(volume > 0)) continue;
    const double mass = density * volume;
    born[tissue] += mass;
    const auto wanted = static_cast<std::size_t>(
        std::clamp(std::ceil(volume / options.parcel_volume), 1.0, static_cast<double>(options.max_per_cut)));
    const std::size_t number = std::min(wanted, std::min(room, out.size()) - count);
    if (number == 0) {
      dropped += mass;
      continue;
    }
    double given = 0;
    for (std::size_t k = 0; k < number; ++k) {
      // The last particle gets the rest of the mass, so rounding loses nothing.
      const float fraction = static_cast<float>(k + 1 < number ? mass / static_cast<double>(number) : mass - given);
      given += fraction;
      const dvec3 place = random.in_ball();
      dvec3 side = (normal_length > 0 ? -cut.n_C_W / normal_length : dvec3(0)) + spread * place;
      const double length = glm::length(side);
      side = length > 1e-6 ? side / length : axis;
      const dvec3 centre = glm::mix(cut.X_WA.p, cut.X_WB.p, random.uniform());
      const dvec3 rim = glm::cross(cut.spindle * axis, head_radius * side);  // velocity of the head's rim: ω × r
      const double speed = glm::length(rim);
      // A chip starts with the rim's velocity plus random scatter, and never moves into the tissue.
      dvec3 v = rim + options.scatter * speed * random.in_ball();
      if (normal_length > 0) {
        const dvec3 n = cut.n_C_W / normal_length;
        const double into = glm::dot(v, n);
        if (into < 0) v -= 2 * into * n;
      }
      const double chip = scale * options.min_chip * std::pow(options.max_chip / options.min_chip, random.uniform());
      out[count++] = {centre + head_radius * side, v, chip, density, fraction, static_cast<Tissue>(t)};
    }
  }
  return count;
}

void Debris::emit(const Cut& cut, const CutContact& contact, const MaterialTable& materials) noexcept {
  State& s = *state_;
  const std::size_t number = create_particles(cut, contact, materials, s.options, s.options.capacity - s.count,
                                              s.new_particles, s.born, s.dropped);
  for (const NewParticle& n : std::span(s.new_particles).first(number)) {
    const std::size_t i = s.slot(s.count++);
    s.x[i] = static_cast<float>(n.p_W.x), s.y[i] = static_cast<float>(n.p_W.y), s.z[i] = static_cast<float>(n.p_W.z);
    s.vx[i] = static_cast<float>(n.v_W.x), s.vy[i] = static_cast<float>(n.v_W.y), s.vz[i] = static_cast<float>(n.v_W.z);
    s.chips[i] = {s.time,
                  n.mass,
                  static_cast<float>(n.chip),
                  static_cast<float>(n.density),
                  static_cast<float>(drag_rate(0, n.chip, n.density, s.options.air_density, s.options.air_viscosity)),
                  n.tissue};
    s.set_rate(i, static_cast<float>(drag_rate(glm::length(n.v_W), n.chip, n.density, s.options.air_density,
                                               s.options.air_viscosity)));
    s.set_due(i, s.step + 1);
  }
}

void Debris::step(double dt, const CoarseField& field, const Suction* suction, Film* film) noexcept {
  State& s = *state_;
  s.time += dt;
  if (s.count == 0) return;
  ++s.step;

  // Removes the particles that reached the end of their lifetime.
  while (s.count > 0 && s.time - s.chips[s.first].born_at >= s.options.lifetime) {
    s.decayed += s.chips[s.first].mass0;
    s.due[s.first] = kNever;
    s.first = s.slot(1);
    --s.count;
  }
  // If the nozzle is new or has changed, each moving particle gets its full update in this step, not when planned.
  const bool drawn = suction != nullptr;
  if (drawn && (!s.drawn || suction->p_W != s.nozzle_W || suction->flow != s.flow)) {
    for (std::size_t i = 0; i < s.count; ++i) {
      const std::size_t at = s.slot(i);
      if (s.rate[at] < kStuck) s.set_due(at, s.step);
    }
    s.nozzle_W = suction->p_W;
    s.flow = suction->flow;
  }
  s.drawn = drawn;

  const auto step_length = static_cast<float>(dt);
  if (step_length != s.last_dt) {
    s.last_dt = step_length;
    set_keep(s.rate.data(), s.keep.data(), s.options.capacity, step_length);
  }
  const Motion motion{s.x.data(), s.y.data(), s.z.data(), s.vx.data(), s.vy.data(), s.vz.data(), s.keep.data()};
  Surroundings around{};
  for (int a = 0; a < 3; ++a) around.gravity[a] = static_cast<float>(s.options.gravity_W[a]);
  if (suction) {
    for (int a = 0; a < 3; ++a) around.sink[a] = static_cast<float>(suction->p_W[a]);
    around.strength = static_cast<float>(suction->flow / (4 * kPi));
  }
  const std::size_t end = std::min(s.first + s.count, s.options.capacity), wrapped = s.first + s.count - end;
  move(motion, s.first, end, step_length, around);
  move(motion, 0, wrapped, step_length, around);

  for (std::size_t at = 0; at < s.options.capacity; at += kGroup) {
    std::uint32_t& first_due = s.first_due[at / kGroup];
    if (first_due > s.step) continue;
    first_due = kNever;
    for (std::size_t i = at; i < std::min(at + kGroup, s.options.capacity); ++i) {
      if (s.due[i] <= s.step)
        s.update_fully(i, dt, field, suction, film);
      else
        first_due = std::min(first_due, s.due[i]);
    }
  }
}

std::size_t Debris::alive() const noexcept {
  return state_->count;
}
double Debris::time() const noexcept {
  return state_->time;
}

DebrisLedger Debris::ledger() const noexcept {
  const State& s = *state_;
  DebrisLedger out;
  out.born = s.born;
  out.decayed = s.decayed;
  out.sucked = s.sucked;
  out.dropped = s.dropped;
  out.deposited = s.deposited;
  for (std::size_t i = 0; i < s.count; ++i) {
    const std::size_t at = s.slot(i);
    const double left = s.left(at);
    out.alive += left;
    out.decayed += s.chips[at].mass0 - left;
  }
  return out;
}

std::size_t Debris::write_points(std::span<DebrisPoint> points) const noexcept {
  const State& s = *state_;
  std::size_t written = 0;
  for (std::size_t i = 0; i < s.count && written < points.size(); ++i) {
    const std::size_t at = s.slot(i);
    if (s.chips[at].mass0 <= 0) continue;
    const double volume = s.left(at) / s.chips[at].density;
    points[written++] = {{s.x[at], s.y[at], s.z[at]},
                         static_cast<float>(std::cbrt(6 / kPi * volume)),
                         s.chips[at].tissue,
                         s.chips[at].diameter};
  }
  return written;
}

glm::vec3 Debris::velocity(std::size_t i) const noexcept {
  return state_->velocity(state_->slot(i));
}

}  // namespace typodont::debris
