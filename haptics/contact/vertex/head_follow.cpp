#include "haptics/contact/vertex/head_follow.h"

#include <algorithm>

namespace typodont::haptics::vertex {

using P = FollowParameters;

bool HeadFollower::approach(const VertexHead& head, mesh::NearPoints& points, dvec3& at, const Pose& X_WT, double slack,
                            bool give) noexcept {
  const double radius = head.radius();
  const glm::dmat3 R_WT(glm::mat3_cast(X_WT.R)), R_TW = glm::transpose(R_WT);
  const bool is_ball = head.is_ball();
  const glm::vec3 axis(R_WT[2]);
  for (int look = 0; look < P::looks; ++look) {
    const dvec3 rest = X_WT.p - at;
    const double left = glm::length(rest);
    const double most = std::clamp(left, 0.01 * radius, P::step * radius), near = head.reach() + most;
    bounds_.clear(), points_.clear();
    for (const std::uint32_t i : points.within(at, near)) {
      const dvec3 off = points[i] - at;
      if (glm::dot(off, off) > near * near || !head.may_be_within(glm::vec3(off), axis, static_cast<float>(most)))
        continue;
      dvec3 n;
      const double d = head.distance(is_ball ? off : R_TW * off, n);
      if (d > most) continue;
      if (d < -P::led_out * radius) led_out_ = true;
      bounds_.push_back({-(is_ball ? n : R_WT * n), give ? std::max(d, 0.0) : d + slack});
      points_.push_back(i);
    }
    dvec3 step = nearest_step(bounds_, left > most ? most / left * rest : rest, active_);
    const double length = glm::length(step);
    if (length > most) step *= most / length;
    at += step;
    if (left <= most || length < P::settled * most) return false;
  }
  return true;
}

}  // namespace typodont::haptics::vertex
