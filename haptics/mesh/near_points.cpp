#include "haptics/mesh/near_points.h"

#include <bit>
#include <cstring>
#include <limits>

#include "engine/base/dispatch.h"
#include "haptics/cutting/lanes.h"

namespace typodont::haptics::mesh {

namespace {

constexpr std::size_t kPointBatch = 8;
// m, rounding error of float coordinates within a centimetre of their origin
constexpr double kRounding = 1e-8;

/// Writes to `at` the indices of the points whose squared distance from `p` is at most `square`.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
std::size_t list_within(const float* x, const float* y, const float* z, std::size_t count, const float* p, float square,
                        std::uint32_t* at) {
  std::size_t found = 0;
  for (std::size_t k = 0; k < count; k += kPointBatch) {
    F8 px, py, pz;
    std::memcpy(&px, x + k, sizeof px);
    std::memcpy(&py, y + k, sizeof py);
    std::memcpy(&pz, z + k, sizeof pz);
    px -= p[0], py -= p[1], pz -= p[2];
    const I8 is_near = px * px + py * py + pz * pz <= square;
    for (unsigned bits = bits_of(is_near); bits; bits &= bits - 1) {
      at[found++] = static_cast<std::uint32_t>(k) + static_cast<std::uint32_t>(std::countr_zero(bits));
    }
  }
  // Removes indices that come from unused lanes of the last group of eight.
  while (found > 0 && at[found - 1] >= count) --found;
  return found;
}

/// Writes to `at` the indices of the points whose stored distance is at most `far`.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
std::size_t list_at_most(const float* distance, std::size_t count, float far, std::uint32_t* at) {
  std::size_t found = 0;
  for (std::size_t k = 0; k < count; k += kPointBatch) {
    F8 d;
    std::memcpy(&d, distance + k, sizeof d);
    const I8 is_near = d <= far;
    for (unsigned bits = bits_of(is_near); bits; bits &= bits - 1) {
      at[found++] = static_cast<std::uint32_t>(k) + static_cast<std::uint32_t>(std::countr_zero(bits));
    }
  }
  while (found > 0 && at[found - 1] >= count) --found;
  return found;
}

}  // namespace

NearPoints::NearPoints(std::size_t most)
    : most_(most),
      x_(most + kPointBatch),
      y_(most + kPointBatch),
      z_(most + kPointBatch),
      distance_(most + kPointBatch),
      at_(most + kPointBatch) {
  points_.reserve(most);
}

void NearPoints::clear(const Pose& head) noexcept {
  ++number_;
  points_.clear();
  listed_at_ = head;
}

bool NearPoints::add(const dvec3& p) noexcept {
  if (full()) return false;
  const glm::vec3 off(p - listed_at_.p);
  const std::size_t i = points_.size();
  x_[i] = off.x, y_[i] = off.y, z_[i] = off.z;
  distance_[i] = std::numeric_limits<float>::lowest();
  points_.push_back(p);
  return true;
}

bool NearPoints::add(const dvec3& p, double distance) noexcept {
  if (!add(p)) return false;
  distance_[points_.size() - 1] = static_cast<float>(distance);
  return true;
}

void NearPoints::keep(std::size_t first, std::span<const std::uint32_t> kept,
                      std::span<const double> distances) noexcept {
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const std::uint32_t i = kept[k];
    points_[first] = points_[i];
    x_[first] = x_[i], y_[first] = y_[i], z_[first] = z_[i];
    distance_[first] = static_cast<float>(distances[k]);
    ++first;
  }
  points_.resize(first);
}

std::span<const std::uint32_t> NearPoints::within(const dvec3& p, double reach) noexcept {
  const glm::vec3 off(p - listed_at_.p);
  const auto far = static_cast<float>(reach + kRounding);
  return {at_.data(), list_within(x_.data(), y_.data(), z_.data(), points_.size(), &off.x, far * far, at_.data())};
}

std::span<const std::uint32_t> NearPoints::listed_within(double far) noexcept {
  return {at_.data(), list_at_most(distance_.data(), points_.size(), static_cast<float>(far + kRounding), at_.data())};
}

}  // namespace typodont::haptics::mesh
