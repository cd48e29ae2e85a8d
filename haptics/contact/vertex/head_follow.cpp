#include "haptics/contact/vertex/head_follow.h"

#include <algorithm>

namespace typodont::haptics::vertex {

using P = FollowParameters;

bool HeadFollower::approach(const VertexHead& head, mesh::NearPoints& points, dvec3& at, const Pose& X_WT, double slack,
                            bool give) noexcept {
  const double radius = head.radius();
  const dvec3 rest = X_WT.p - at;
  const double left = glm::length(rest);
  const double most = P::longest_step(radius, left);
  bounds_.clear(), points_.clear();
  distances_.find(head, points, {at, X_WT.R}, most);
  for (std::size_t i = 0; i < distances_.size(); ++i) {
    const double d = distances_.distance(i);
    if (d < -P::led_out * radius) led_out_ = true;
    bounds_.push_back({-distances_.normal_W(i), give ? std::max(d, 0.0) : d + slack});
    points_.push_back(distances_.point(i));
  }
  dvec3 step = nearest_step(bounds_, left > most ? most / left * rest : rest, active_);
  const double length = glm::length(step);
  if (length > most) step *= most / length;
  at += step;
  return left > most && length >= P::settled * most;
}

}  // namespace typodont::haptics::vertex
