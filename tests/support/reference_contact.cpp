#include "tests/support/reference_contact.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace typodont::test {

namespace mesh_lod = haptics::mesh_lod;

ExactShape ExactShape::ball(double radius) {
  ExactShape shape;
  shape.kind_ = Kind::kBall, shape.minor_ = radius;
  return shape;
}

ExactShape ExactShape::torus(double major, double minor) {
  ExactShape shape;
  shape.kind_ = Kind::kTorus, shape.major_ = major, shape.minor_ = minor;
  return shape;
}

ExactShape ExactShape::triangles(const TissueMesh& mesh) {
  ExactShape shape;
  shape.kind_ = Kind::kTriangles;
  shape.grid_ = std::make_shared<const mesh_lod::TriangleGrid>(mesh);
  return shape;
}

ExactShape::Nearest ExactShape::nearest(const dvec3& p, double most) const {
  if (kind_ == Kind::kTriangles) {
    const auto found = grid_->nearest(p, most);
    if (!found.found) return {p, most};
    return {found.p, grid_->inside(p) ? -found.distance : found.distance};
  }
  // For a torus, `middle` is the nearest point of its centre circle. For a ball, it is the centre.
  dvec3 middle(0);
  if (kind_ == Kind::kTorus) {
    const double across = std::hypot(p.x, p.y);
    middle = across > 0 ? dvec3(p.x, p.y, 0) * (major_ / across) : dvec3(major_, 0, 0);
  }
  const dvec3 off = p - middle;
  const double length = glm::length(off);
  if (length - minor_ > most) return {p, most};
  return {middle + off * (minor_ / length), length - minor_};
}

void ExactShape::all_near(const dvec3& p, double reach, std::vector<dvec3>& points) const {
  points.clear();
  if (kind_ != Kind::kTriangles) {
    const Nearest found = nearest(p, reach);
    if (found.distance < reach) points.push_back(found.p);
    return;
  }
  grid_->for_near(p - reach, p + reach, [&](std::uint32_t i) {
    const dvec3 q = mesh_lod::nearest_on(grid_->face(i), p).p;
    if (glm::distance(p, q) < reach) points.push_back(q);
  });
}

namespace {

// m, convergence tolerance: the iteration ends if the ball's position changes by less than this
constexpr double kTolerance = 1e-10;

struct HalfSpace {
  dvec3 n;       // unit normal; the ball's centre x must satisfy n·x >= least
  double least;  // m, smallest allowed value of n·x
};

/// Moves `x` to the point nearest to the goal in the intersection of the half spaces `used`. It uses Hildreth's method,
/// which is coordinate ascent of the dual problem. `push`: m, displacement along the normal of each half space. The
/// function starts from these displacements and improves them; x is the goal plus all displacements.
void project(const std::vector<HalfSpace>& used, std::vector<double>& push, dvec3& x) {
  constexpr int kSweeps = 2000;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double moved = 0;
    for (std::size_t i = 0; i < used.size(); ++i) {
      const double wanted = std::max(push[i] + used[i].least - glm::dot(used[i].n, x), 0.0);
      x += (wanted - push[i]) * used[i].n;
      moved = std::max(moved, std::abs(wanted - push[i]));
      push[i] = wanted;
    }
    if (moved < 1e-2 * kTolerance) break;
  }
}

/// Returns the point nearest to `goal` in the intersection of all half spaces. A dense mesh has thousands of faces near
/// the ball, but only few of them stop it. So the function solves the problem for a small set of half spaces, adds the
/// half space that the solution violates most, and repeats this. A solution that violates no half space is the solution
/// for all of them.
dvec3 nearest_in(const std::vector<HalfSpace>& spaces, const dvec3& goal) {
  constexpr int kMaxUsed = 400;
  std::vector<HalfSpace> used;
  std::vector<double> push;
  dvec3 x = goal;
  for (int i = 0; i < kMaxUsed; ++i) {
    double most = 1e-2 * kTolerance;
    const HalfSpace* violated = nullptr;
    for (const HalfSpace& space : spaces) {
      const double depth = space.least - glm::dot(space.n, x);
      if (depth > most) most = depth, violated = &space;
    }
    if (!violated) break;
    used.push_back(*violated);
    push.push_back(0);
    project(used, push, x);
  }
  return x;
}

}  // namespace

/// Makes one step of sequential quadratic programming. For each face near the ball, takes the plane through the face's
/// nearest point. The ball's centre must stay in front of all these planes. Faces are convex, so the ball then stays
/// outside all examined faces. Returns true if the position has converged.
bool ReferenceContact::step(const dvec3& hand) {
  // Largest displacement of the ball's centre in this step. Only faces within this distance plus the ball's radius can
  // stop the ball.
  const double way = std::min(glm::distance(hand, center_), 0.5 * radius_);
  const dvec3 goal = glm::distance(hand, center_) > way ? center_ + glm::normalize(hand - center_) * way : hand;
  shape_.all_near(center_, radius_ + 2 * way + kTolerance, near_);
  std::vector<HalfSpace> spaces;
  spaces.reserve(near_.size());
  for (const dvec3& q : near_) {
    const dvec3 n = glm::normalize(center_ - q);
    spaces.push_back({n, glm::dot(n, q) + radius_});
  }
  const dvec3 next = nearest_in(spaces, goal);
  const bool done = goal == hand && glm::distance(next, center_) < kTolerance;
  center_ = next;
  return done;
}

const dvec3& ReferenceContact::follow(const dvec3& hand) {
  // If only one face stops the ball, a formula gives its position without iteration.
  const double to_hand = glm::distance(hand, center_);
  if (to_hand < radius_) {
    const ExactShape::Nearest at = shape_.nearest(hand, 2 * radius_);
    if (at.distance >= radius_) return center_ = hand;
    if (at.distance > 1e-3 * radius_) {
      const dvec3 out = at.p + radius_ * glm::normalize(hand - at.p);
      if (shape_.nearest(out, 2 * radius_).distance >= radius_ - kTolerance) return center_ = out;
    }
  }
  constexpr int kMaxSteps = 400;
  for (int i = 0; i < kMaxSteps; ++i) {
    if (step(hand)) break;
  }
  return center_;
}

}  // namespace typodont::test
