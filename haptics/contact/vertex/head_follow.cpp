#include "haptics/contact/vertex/head_follow.h"

#include <algorithm>

namespace typodont::haptics::vertex {

using P = FollowParameters;

bool HeadFollower::approach(const VertexHead& head, mesh::NearPoints& points, dvec3& at, const Pose& X_WT,
                            double allowed_depth, bool give, double most) noexcept {
  constexpr double kUnbounded = 1e300;  // m, gap of unused elements; it never limits a step
  const double radius = head.radius();
  const dvec3 rest = X_WT.p - at;
  const double left = glm::length(rest);
  distances_.find(head, points, {at, X_WT.R}, most);
  const HeadDistances::Columns near = distances_.columns();
  double least = 0;
  for (std::size_t i = 0; i < near.count; ++i) {
    const double d = near.distance[i];
    least = std::min(least, d);
    gaps_[i] = allowed_motion(d, allowed_depth, give);
  }
  for (std::size_t i = near.count; i < near.count + HeadDistances::kBatch; ++i) gaps_[i] = kUnbounded;
  if (least < -P::led_out * radius) led_out_ = true;
  bounded_ = near.count > 0;
  dvec3 step = nearest_step({near.n_x, near.n_y, near.n_z, gaps_.data(), near.count},
                            left > most ? most / left * rest : rest, active_);
  for (int i = 0; i < active_.count; ++i) {
    const auto k = static_cast<std::size_t>(active_.index[i]);
    holds_[i] = {distances_.point(k), -distances_.normal_W(k), active_.push[i]};
  }
  const double length = glm::length(step);
  if (length > most) step *= most / length;
  at += step;
  return left > most && length >= P::settled * most;
}

}  // namespace typodont::haptics::vertex
