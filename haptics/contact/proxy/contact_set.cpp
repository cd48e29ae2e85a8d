#include "haptics/contact/proxy/contact_set.h"

#include <algorithm>

namespace typodont::haptics {

ContactPlane ContactSet::plane(int i) const noexcept {
  for (int k = 0; k < exact_count_; ++k) {
    if (exact_[static_cast<std::size_t>(k)].index == i) return exact_[static_cast<std::size_t>(k)].plane;
  }
  return {origin_ + dvec3(approximate_.x[i], approximate_.y[i], approximate_.z[i]),
          dvec3(approximate_.nx[i], approximate_.ny[i], approximate_.nz[i]), static_cast<double>(approximate_.gap[i]),
          static_cast<double>(approximate_.yields[i])};
}

ContactSet::Exact* ContactSet::exact(int i) noexcept {
  for (int k = 0; k < exact_count_; ++k) {
    if (exact_[static_cast<std::size_t>(k)].index == i) return &exact_[static_cast<std::size_t>(k)];
  }
  return nullptr;
}

void ContactSet::set_yields(int i, double yields) noexcept {
  approximate_.yields[i] = static_cast<float>(yields);
  if (Exact* known = exact(i)) known->plane.yields = yields;
}

/// Stores a plane, except `yields`, in single precision.
void ContactSet::store(int i, const ContactPlane& plane) noexcept {
  const glm::vec3 x(plane.x - origin_), n(plane.n);
  approximate_.x[i] = x.x, approximate_.y[i] = x.y, approximate_.z[i] = x.z;
  approximate_.nx[i] = n.x, approximate_.ny[i] = n.y, approximate_.nz[i] = n.z;
  approximate_.gap[i] = static_cast<float>(plane.gap);
}

/// Stores the exact plane of a refined contact. If the array is full, the new plane replaces the oldest.
void ContactSet::put(int i, const dvec3& c, const ContactPlane& plane) noexcept {
  Exact* slot = exact(i);
  if (!slot) {
    if (exact_count_ == kExact) std::move(exact_.begin() + 1, exact_.end(), exact_.begin()), --exact_count_;
    slot = &exact_[static_cast<std::size_t>(exact_count_++)];
  }
  *slot = {i, c, plane};
  store(i, plane);
  approximate_.yields[i] = static_cast<float>(plane.yields);
}

/// Adds a contact in single precision, without an exact plane. If the set is full, the last contact is replaced.
void ContactSet::put_own(const ContactPlane& plane) noexcept {
  const int i = count_ < kMax ? count_++ : kMax - 1;
  store(i, plane);
  approximate_.yields[i] = 1;
  deepest_ = std::max(deepest_, -plane.gap);
}

/// Adds the exact contact of a rim, in place of the approximate contacts near it.
void ContactSet::put_rim(const ContactPlane& plane, const dvec3& c, double within) noexcept {
  put_beside(plane, within);
  const int i = std::min(count_, kMax - 1);
  put_own(plane);
  put(i, c, plane);
}

/// Replaces the approximate contacts near a rim by the exact contact of the rim.
void ContactSet::put_beside(const ContactPlane& rim, double within) noexcept {
  const glm::vec3 x(rim.x - origin_);
  const auto near = static_cast<float>(within);
  for (int i = 0; i < own(); ++i) {
    if (glm::length(glm::vec3(approximate_.x[i], approximate_.y[i], approximate_.z[i]) - x) <= near) store(i, rim);
  }
}

bool ContactSet::add(const ContactPlane& plane) noexcept {
  if (count_ == ApproximatePlanes::kCapacity) return false;
  store(count_, plane);
  approximate_.yields[count_] = 0;
  ++count_, ++added_;
  return true;
}

void ContactSet::clear() noexcept {
  count_ = exact_count_ = added_ = 0;
  deep_penetration_ = flat_ = creases_ = projects_out_ = false;
  engaged_area_ = deepest_ = 0;
  engaged_normal_ = dvec3(0);
}

}  // namespace typodont::haptics
