#include "haptics/soft_tissue.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace typodont::haptics {

namespace {

/// Parameters of the model that are independent of material.
struct SoftParameters {
  // Number of alternating updates of points and tool per tick; the viscosity lets them converge over several ticks.
  static constexpr int iterations = 3;
  static constexpr int newton_steps = 6;       // largest number of Newton steps for the tool's displacement
  static constexpr double strain_limit = 0.8;  // largest compression of the layer divided by its thickness
  static constexpr double stop = 20;           // factor on the stiffness of points compressed beyond strain_limit
  // Largest force of soft tissue on the tool, N; a hand that pushes more moves through the tissue.
  static constexpr double max_force = 3;
  // N, largest change of the force per tick in addition to the change that the tool's motion causes.
  static constexpr double free_step = 0.02;
  // Largest plausible speed of the hand, m/s. If a new overlap is deeper than this motion, the hand did not cause it.
  static constexpr double hand_speed = 0.6;
  // If an overlap was not caused by the hand, its force grows with this time constant, s.
  static constexpr double ignored_time = 0.2;
  // A point is pressed fully if the cosine of the angle between the head's and the tissue's normal is above this.
  static constexpr double full_weight = 0.5;
  static constexpr double min_cosine = 0.35;
  static constexpr double wakes = 10e-6;  // m, displacement above which a point activates its neighbours
  static constexpr double sleeps = 2e-6;  // m; a point displaced by less than this becomes inactive
  // m. A head is enlarged if its radius at this height above its end is less than the spacing of the tissue's points.
  static constexpr double tip = 0.15e-3;
  static constexpr double shank = 10e-3;  // m, length of the shank that can touch soft tissue
  // Largest half distance between neighbouring centres of the balls that enclose the tool, m.
  static constexpr double max_ball = 1e-3;
  // Largest depth that is cut at a point per tick, as a fraction of the point's elastic displacement.
  static constexpr double max_per_tick = 0.3;
  // Smallest distance between two wounds, m.
  static constexpr double wound_distance = 1.2e-3;
  static constexpr double hit = 0.2e-6;  // m, tolerance of the search for contact along a point's normal
  static constexpr int search_steps = 24;
};
using P = SoftParameters;

}  // namespace

double blood_radius(const SoftLaw& law, double age) noexcept {
  return age > 0 ? law.blood_radius * (1 - std::exp(-age / law.blood_time)) : 0;
}

double SoftTissue::Shape::distance(const dvec3& p_T) const noexcept {
  const double d = head.distance(p_T);
  return (has_shank ? std::min(d, shank.distance(p_T - dvec3(0, 0, shank_z))) : d) - blunt;
}

dvec3 SoftTissue::Shape::gradient(const dvec3& p_T) const noexcept {
  dvec3 n, n_shank;
  const double d = head.distance(p_T, n);
  if (has_shank && shank.distance(p_T - dvec3(0, 0, shank_z), n_shank) < d) return n_shank;
  return n;
}

SoftTissue::SoftTissue(std::shared_ptr<const SoftSurface> surface, std::span<const Tool> tools, double coupling)
    : surface_(std::move(surface)), coupling_(coupling) {
  const std::size_t count = surface_->points().size();
  for (const Tool& tool : tools) {
    Shape shape;
    shape.head = HeadField(tool, 1);
    shape.blunt = std::max(0.0, surface_->law().spacing - tool.profile(-tool.half() + P::tip));
    shape.low = -tool.half(), shape.high = tool.half(), shape.radius = tool.radius();
    if (std::optional<NonCuttingPart> part = shank_of(tool)) {
      const double end = part->z - part->shape.half();
      part->shape.length = std::min(part->shape.length, P::shank);
      shape.has_shank = true;
      shape.shank_z = end + part->shape.half();
      shape.shank = HeadField(part->shape, 1);
      shape.high = std::max(shape.high, shape.shank_z + part->shape.half());
      shape.radius = std::max(shape.radius, part->shape.radius());
    }
    const int balls = std::max(1, static_cast<int>(std::ceil((shape.high - shape.low) / (2 * P::max_ball))));
    const double half = (shape.high - shape.low) / (2 * balls);
    for (int i = 0; i < balls; ++i)
      shape.balls.push_back({shape.low + (2 * i + 1) * half, std::hypot(half, shape.radius)});
    shape.reach = std::hypot(std::max(shape.high, -shape.low), shape.radius);
    shapes_.push_back(std::move(shape));
  }
  active_.reserve(kMaxActive);
  slot_.assign(count, -1);
  cut_.assign(count, 0);
  sent_.assign(count, 0);
  waits_.assign(count, 0);
  to_send_.reserve(count);
}

bool SoftTissue::at_rest(const Pose& X_WG, std::uint32_t tool) noexcept {
  if (!active_.empty() || u_ != dvec3(0)) return false;
  if (tool == tool_) {
    const dvec3 motion = X_WG.p - seen_.p;
    if (X_WG.R == seen_.R) {
      if (gap_ > 0 && glm::dot(motion, motion) < gap_ * gap_) return true;
    } else if (displacement_bound(seen_, X_WG, shapes_[tool].reach) < gap_) {
      return true;
    }
  }
  tool_ = tool, seen_ = X_WG;
  const Shape& shape = shapes_[tool];
  const dvec3 axis = X_WG.R * dvec3(0, 0, 1);
  double gap = 1;
  for (const Shape::Ball& ball : shape.balls) {
    gap = std::min(gap, surface_->clearance(X_WG.p + ball.z * axis) - ball.r);
  }
  gap_ = gap;
  if (!(gap > 0)) return false;
  placed_ = false;
  return true;
}

void SoftTissue::release() noexcept {
  for (Active& a : active_) a.contact = false, a.force = a.stop = 0;
  u_ = u_before_ = dvec3(0);
  touching_ = placed_ = false;
}

double SoftTissue::inward(std::uint32_t point) const noexcept {
  return cut_[point] + (slot_[point] < 0 ? 0.0 : active_[static_cast<std::size_t>(slot_[point])].v);
}

bool SoftTissue::activate(std::uint32_t point) noexcept {
  if (slot_[point] >= 0) return true;
  if (active_.size() == kMaxActive) return false;
  const SoftSurface::Point& at = surface_->points()[point];
  Active a;
  a.point = point;
  a.stiffness = surface_->law().elastic_modulus * at.area / at.thickness;
  a.springs = a.stiffness;
  for (const SoftSurface::Link& link : surface_->links(point)) a.springs += link.tension;
  a.limit = P::strain_limit * at.thickness;
  slot_[point] = static_cast<std::int32_t>(active_.size());
  active_.push_back(a);
  if (!waits_[point]) {
    waits_[point] = 1;
    to_send_.push_back(point);
  }
  return true;
}

SoftTissue::Output SoftTissue::tick(const Input& in) noexcept {
  if (in.tool != tool_) release(), tool_ = in.tool;
  gap_ = -1;
  const Shape& shape = shapes_[in.tool];
  const double moved = placed_ ? displacement_bound(last_, in.X_WG, shape.reach) : 0.0;
  const double hand = P::hand_speed * in.dt;  // m, largest plausible motion of the hand in a tick
  last_ = in.X_WG, placed_ = true;
  u_before_ = u_;

  find_contacts(in, {in.X_WG.p + u_, in.X_WG.R}, shape, std::min(moved, hand));
  const SoftLaw& law = surface_->law();
  for (Active& a : active_) {
    a.before = a.v;
    // Damper parallel to the layer's spring, with the constant stiffness × return_time, N·s/m.
    a.yield = 1 / (a.stiffness * law.return_time / in.dt + a.springs);
  }
  const double most = moved + P::free_step / coupling_;
  for (int i = 0; i < P::iterations; ++i) {
    relax();
    place_tool(most);
  }
  if (in.cutting > 0) cut(in);
  spread_and_sleep();

  Output out;
  out.touching = touching_ || u_ != dvec3(0);
  out.yielded = u_;
  out.force = coupling_ * u_;
  out.stored = coupling_ * glm::dot(u_, u_) / 2;
  return out;
}

/// Updates the contacts of all active points, and activates points that the head begins to press.
void SoftTissue::find_contacts(const Input& in, const Pose& X_WT, const Shape& shape, double moved) noexcept {
  const double fade = std::exp(-in.dt / P::ignored_time);
  // Examines only points within the head's radius plus the thickness of the layer.
  const double margin = shape.radius + shape.blunt + surface_->law().thickness;
  const dvec3 axis = X_WT.R * dvec3(0, 0, 1);
  const dvec3 low = X_WT.p + shape.low * axis, high = X_WT.p + shape.high * axis;
  surface_->each_near(glm::min(low, high) - margin, glm::max(low, high) + margin, [&](std::uint32_t point) {
    if (slot_[point] >= 0) return;
    const SoftSurface::Point& at = surface_->points()[point];
    const double z = std::clamp(glm::dot(at.p_W - X_WT.p, axis), shape.low, shape.high);
    const dvec3 off = at.p_W - (X_WT.p + z * axis);
    if (glm::dot(off, off) > margin * margin) return;
    const double limit = P::strain_limit * at.thickness;
    // Smallest ball around all possible positions of the point.
    const double middle = (limit + cut_[point]) / 2 + shape.blunt, half = (limit - cut_[point]) / 2;
    if (shape.distance(glm::conjugate(X_WT.R) * (at.p_W - middle * at.n_W - X_WT.p)) > half) return;
    Active probe;
    probe.point = point;
    probe.limit = limit;
    touch(probe, X_WT, shape, moved, fade);
    if (!probe.contact || !activate(point)) return;
    Active& a = active_.back();
    a.contact = true, a.exit = probe.exit, a.weight = probe.weight, a.slope = probe.slope, a.ignored = probe.ignored;
  });
  for (Active& a : active_) touch(a, X_WT, shape, moved, fade);
}

/// Finds the contact of a point by sphere tracing outwards along its normal, from the deepest position. For an enlarged
/// head (`blunt`), the search starts deeper by `blunt`.
void SoftTissue::touch(Active& a, const Pose& X_WT, const Shape& shape, double moved, double fade) noexcept {
  const SoftSurface::Point& at = surface_->points()[a.point];
  const dquat R_TW = glm::conjugate(X_WT.R);
  const dvec3 p_T = R_TW * (at.p_W - X_WT.p), n_T = R_TW * at.n_W;
  const double cut = cut_[a.point];
  double depth = a.limit + shape.blunt;
  const double deepest = shape.distance(p_T - depth * n_T);
  bool found = deepest <= 0;
  double d = deepest;
  const double least = cut + shape.blunt;
  for (int i = 0; i < P::search_steps && !found && depth > least; ++i) {
    depth -= d;
    d = shape.distance(p_T - depth * n_T);
    found = d < P::hit;
  }
  const bool was = a.contact;
  a.contact = false;
  if (!found || !(depth > least)) {
    a.force = a.stop = 0;
    return;
  }
  const dvec3 out_T = shape.gradient(p_T - depth * n_T);
  const double cosine = -glm::dot(out_T, n_T);
  a.weight = std::clamp(cosine / P::full_weight, 0.0, 1.0);
  if (!(a.weight > 0)) {
    a.force = a.stop = 0;
    return;
  }
  a.contact = true;
  a.exit = depth - shape.blunt - std::min(deepest, 0.0);
  a.slope = X_WT.R * out_T / std::max(cosine, P::min_cosine);
  const double overlap = a.exit - cut - a.v;
  a.ignored = was ? std::clamp(a.ignored * fade, 0.0, std::max(a.exit - cut, 0.0)) : std::max(0.0, overlap - moved);
}

/// Gauss–Seidel pass over the points with fixed neighbours: implicit XPBD step (Macklin et al. 2016, eq. 18) of all
/// constraints of a point.
void SoftTissue::relax() noexcept {
  for (Active& a : active_) {
    double push = a.before * (1 / a.yield - a.springs) + a.force;
    for (const SoftSurface::Link& link : surface_->links(a.point)) {
      if (const std::int32_t other = slot_[link.point]; other >= 0) {
        push += link.tension * active_[static_cast<std::size_t>(other)].v;
      }
    }
    a.v = std::clamp(push * a.yield, 0.0, std::max(a.limit - cut_[a.point], 0.0));
  }
}

/// Equilibrium of coupling and contacts: Newton steps for piecewise linear equations. The displacement changes by at
/// most `most`, m.
void SoftTissue::place_tool(double most) noexcept {
  struct Force {
    double moves = 0, stops = 0, slope = 0;
  };
  // Forces of a point on the tool if the tool is displaced by u. `free`: displacement of the point without contact, m.
  const auto press = [&](const Active& a, double free, const dvec3& u) {
    const double over = a.exit - a.ignored - cut_[a.point] - free + glm::dot(a.slope, u - u_before_);
    if (!(over > 0)) return Force{};
    const double gap = std::max(a.limit - cut_[a.point] - free, 0.0), motion = a.weight * over;
    Force f{std::min(motion, gap) / a.yield, std::max(motion - gap, 0.0) * P::stop / a.yield, a.weight / a.yield};
    if (motion > gap) f.slope *= P::stop;
    return f;
  };
  dvec3 u = u_;
  bool any = false;
  for (int step = 0; step < P::newton_steps; ++step) {
    dvec3 rest = coupling_ * u;
    glm::dmat3 slope(coupling_);
    for (const Active& a : active_) {
      if (!a.contact) continue;
      any = true;
      const Force f = press(a, a.v - a.yield * a.force, u);
      if (f.slope == 0) continue;
      rest += (f.moves + f.stops) * a.slope;
      slope += glm::outerProduct(f.slope * a.slope, a.slope);
    }
    if (!any) {
      u = dvec3(0);
      break;
    }
    const dvec3 change = glm::inverse(slope) * rest;
    u -= change;
    if (glm::dot(change, change) < 1e-20) break;  // a change below 0.1 nm counts as converged
  }
  if (const double size = glm::length(u), bound = P::max_force / coupling_; size > bound) u *= bound / size;
  if (const double size = glm::length(u - u_before_); size > most) u = u_before_ + (u - u_before_) * (most / size);
  u_ = u;
  touching_ = false;
  for (Active& a : active_) {
    if (!a.contact) continue;
    const double free = a.v - a.yield * a.force;
    const Force f = press(a, free, u);
    a.force = f.moves, a.stop = f.stops;
    a.v = free + a.yield * a.force;
    touching_ |= a.force + a.stop > 0;
  }
}

/// Force × cutting speed = specific energy × volume rate (Preston, Archard). Cutting converts elastic displacement of a
/// point to cut depth; the sum of both stays constant.
void SoftTissue::cut(const Input& in) noexcept {
  for (Active& a : active_) {
    if (!a.contact || !(a.force + a.stop > 0)) continue;
    const SoftSurface::Point& at = surface_->points()[a.point];
    const double power = (a.force + a.stop) * in.cutting;  // W, power that cuts at this point
    const double deeper = std::min(power * in.dt / (surface_->law().specific_energy * at.area), P::max_per_tick * a.v);
    const auto before = cut_[a.point];
    cut_[a.point] = static_cast<float>(std::min(cut_[a.point] + deeper, a.limit));
    a.v = std::max(a.v - (cut_[a.point] - before), 0.0);
    if (cut_[a.point] >= surface_->law().bleeding_depth && before < surface_->law().bleeding_depth)
      bleed(a.point, in.t);
  }
}

void SoftTissue::bleed(std::uint32_t point, Nanos t) noexcept {
  const dvec3 p_W = surface_->points()[point].p_W;
  for (const SoftWound& wound : wounds()) {
    if (glm::length(wound.p_W - p_W) < P::wound_distance) return;
  }
  if (wound_count_ < kMaxWounds) wounds_[wound_count_++] = {t, p_W};
}

void SoftTissue::spread_and_sleep() noexcept {
  // Points that are activated here are computed from the next tick on.
  const std::size_t count = active_.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (active_[i].v < P::wakes) continue;
    for (const SoftSurface::Link& link : surface_->links(active_[i].point)) activate(link.point);
  }
  for (std::size_t i = 0; i < active_.size();) {
    const Active& a = active_[i];
    // A new point has displacement v = 0, but stays active while a neighbour is displaced.
    bool pulled = false;
    for (const SoftSurface::Link& link : surface_->links(a.point)) {
      const std::int32_t other = slot_[link.point];
      pulled |= other >= 0 && active_[static_cast<std::size_t>(other)].v >= P::wakes;
    }
    if (a.contact || pulled || a.v >= P::sleeps) {
      ++i;
      continue;
    }
    slot_[a.point] = -1;
    if (i + 1 < active_.size()) {
      active_[i] = active_.back();
      slot_[active_[i].point] = static_cast<std::int32_t>(i);
    }
    active_.pop_back();
  }
}

}  // namespace typodont::haptics
