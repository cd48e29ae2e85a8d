#include "haptics/contact/packing/depth_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "engine/base/voxels.h"

namespace typodont::haptics::packing {

namespace {
constexpr float kUnknown = 1e30f;
}

DepthField::DepthField(const DenseTissue& tissue)
    : frame_(tissue.frame),
      size_(tissue.size),
      stride_x_(static_cast<std::ptrdiff_t>(tissue.size.y + 2) * (tissue.size.z + 2)),
      stride_y_(tissue.size.z + 2) {
  copy(tissue);
  smooth_labels();
  find_closest_points(tissue.band / tissue.frame.voxel);
}

void DepthField::copy(const DenseTissue& tissue) {
  const std::size_t count = static_cast<std::size_t>(size_.x + 2) * static_cast<std::size_t>(stride_x_);
  const double h = frame_.voxel;
  depth_.assign(count, -1);
  label_.assign(count, Tissue::kAir);
  for_each_voxel(size_, [&](int x, int y, int z) {
    const std::size_t from = tissue.at(x, y, z), to = index({x, y, z});
    const Tissue label = tissue.tissue[from];
    const double depth = -static_cast<double>(tissue.distance[from]) / h;
    if (label == Tissue::kAir) {
      depth_[to] = static_cast<float>(std::min(depth, 0.0));
      return;
    }
    depth_[to] = static_cast<float>(depth);
    volume_[static_cast<std::size_t>(label)] += std::clamp(0.5 + depth, 0.0, 1.0) * h * h * h;
    if (depth <= 0) return;
    label_[to] = label;
    solid_.push_back(static_cast<std::ptrdiff_t>(to));
  });
}

// Labels at borders alternate irregularly (dithering), so that volumes are exact (solid.cpp). Packing needs smooth
// borders, so each voxel gets the most frequent label of its neighbours.
void DepthField::smooth_labels() {
  const std::vector<Tissue> before = label_;
  std::array<int, 256> count{};
  std::array<Tissue, 27> seen;
  std::array<std::ptrdiff_t, 27> around;
  for (int n = 0; n < 27; ++n) {
    around[static_cast<std::size_t>(n)] = (n / 9 - 1) * stride_x_ + (n / 3 % 3 - 1) * stride_y_ + n % 3 - 1;
  }
  for (const std::ptrdiff_t i : solid_) {
    // Skips a voxel if all its neighbours have its label.
    const Tissue own = before[static_cast<std::size_t>(i)];
    bool mixed = false;
    for (const std::ptrdiff_t n : around) {
      const Tissue t = before[static_cast<std::size_t>(i + n)];
      mixed |= (t != own) & (t != Tissue::kAir);
    }
    if (!mixed) continue;
    std::size_t kinds = 0;
    for (const std::ptrdiff_t n : around) {
      const Tissue t = before[static_cast<std::size_t>(i + n)];
      if (t != Tissue::kAir && count[static_cast<std::size_t>(t)]++ == 0) seen[kinds++] = t;
    }
    Tissue most = own;
    for (std::size_t k = 0; k < kinds; ++k) {
      if (count[static_cast<std::size_t>(seen[k])] > count[static_cast<std::size_t>(most)]) most = seen[k];
    }
    for (std::size_t k = 0; k < kinds; ++k) count[static_cast<std::size_t>(seen[k])] = 0;
    label_[static_cast<std::size_t>(i)] = most;
  }
}

// Passes the closest surface point of each voxel on to its neighbours (Danielsson 1980). Needed because the volume's
// distances are inexact far from the surface and near cuts.
void DepthField::find_closest_points(double band) {
  std::vector<glm::vec3> way(depth_.size());  // vector from each voxel to its closest point
  std::vector<float> far2(depth_.size(), kUnknown);
  const auto take = [&](std::ptrdiff_t i, const glm::vec3& to) {
    const float d2 = glm::dot(to, to);
    if (d2 >= far2[static_cast<std::size_t>(i)] * 0.99999f) return false;
    far2[static_cast<std::size_t>(i)] = d2;
    way[static_cast<std::size_t>(i)] = to;
    return true;
  };

  // First estimates of closest points: where the surface crosses between neighbouring voxels, and along the gradient.
  const std::array<std::ptrdiff_t, 3> strides = {stride_x_, stride_y_, 1};
  for (const std::ptrdiff_t i : solid_) {
    const float own = depth_[static_cast<std::size_t>(i)];
    bool at_surface = false;
    glm::vec3 slope(0);
    for (int a = 0; a < 3; ++a) {
      for (const int side : {-1, 1}) {
        const auto u = static_cast<std::size_t>(i + side * strides[static_cast<std::size_t>(a)]);
        slope[a] += 0.5f * static_cast<float>(side) * depth_[u];
        glm::vec3 to(0);
        if (depth_[u] <= 0) {
          at_surface = true;
          to[a] = static_cast<float>(side) * own / (own - depth_[u]);
        } else if (label_[u] != label_[static_cast<std::size_t>(i)]) {
          to[a] = 0.5f * static_cast<float>(side);
        } else {
          continue;
        }
        take(i, to);
      }
    }
    const float steep2 = glm::dot(slope, slope);
    if (at_surface && steep2 > 0.25f) take(i, -own / steep2 * slope);
  }

  // The 13 of 26 neighbours that a forward scan visits earlier; the others are opposite to them.
  std::array<std::ptrdiff_t, 13> before;
  std::array<glm::vec3, 13> step;
  for (std::size_t n = 0; n < 13; ++n) {
    const int k = static_cast<int>(n);
    step[n] = glm::vec3(k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1);
    before[n] = (k / 9 - 1) * stride_x_ + (k / 3 % 3 - 1) * stride_y_ + k % 3 - 1;
  }
  // Scans the voxels forward and backward until nothing changes. Examines only neighbours that changed in this scan or
  // the previous one. `changed_in`: for each voxel, number of the scan that last changed it; 0: none.
  std::vector<std::uint16_t> changed_in(depth_.size(), 0);
  const auto scan = [&](std::ptrdiff_t i, int sign, std::uint16_t number) {
    const std::uint16_t since = static_cast<std::uint16_t>(number <= 2 ? 0 : number - 1);
    bool changed = false;
    for (std::size_t n = 0; n < 13; ++n) {
      const auto u = static_cast<std::size_t>(i + sign * before[n]);
      if (changed_in[u] < since || label_[u] != label_[static_cast<std::size_t>(i)] || far2[u] >= kUnknown) continue;
      changed |= take(i, way[u] + static_cast<float>(sign) * step[n]);
    }
    if (changed) changed_in[static_cast<std::size_t>(i)] = number;
    return changed;
  };
  std::uint16_t number = 0;
  for (bool changed = true; changed;) {
    changed = false;
    ++number;
    for (const std::ptrdiff_t i : solid_) changed |= scan(i, 1, number);
    ++number;
    for (auto i = solid_.rbegin(); i != solid_.rend(); ++i) changed |= scan(*i, -1, number);
  }

  for (const std::ptrdiff_t i : solid_) {
    float& depth = depth_[static_cast<std::size_t>(i)];
    const float found = std::sqrt(far2[static_cast<std::size_t>(i)]);
    depth = static_cast<double>(depth) < 0.999 * band ? std::min(depth, found) : found;
  }
}

Tissue DepthField::tissue_at(const dvec3& p_V) const {
  const dvec3 top = dvec3(size_);
  if (!(p_V.x >= -1 && p_V.y >= -1 && p_V.z >= -1 && p_V.x < top.x && p_V.y < top.y && p_V.z < top.z))
    return Tissue::kAir;
  const glm::ivec3 i(glm::floor(p_V));
  const dvec3 f = p_V - dvec3(i);
  const std::size_t first = index(i);
  const int nearest = (f.x >= 0.5 ? 4 : 0) | (f.y >= 0.5 ? 2 : 0) | (f.z >= 0.5 ? 1 : 0);
  const auto label = [&](int k) {
    return label_[first + static_cast<std::size_t>((k >> 2) * stride_x_ + (k >> 1 & 1) * stride_y_ + (k & 1))];
  };
  if (const Tissue t = label(nearest); t != Tissue::kAir) return t;
  Tissue own = Tissue::kAir;
  double most = -1;
  for (int k = 0; k < 8; ++k) {
    const double weight = (k & 4 ? f.x : 1 - f.x) * (k & 2 ? f.y : 1 - f.y) * (k & 1 ? f.z : 1 - f.z);
    if (label(k) != Tissue::kAir && weight > most) most = weight, own = label(k);
  }
  return own;
}

double DepthField::in(Tissue tissue, const dvec3& p_V) const {
  const dvec3 top = dvec3(size_);
  if (tissue == Tissue::kAir) return -1;
  if (!(p_V.x >= -1 && p_V.y >= -1 && p_V.z >= -1 && p_V.x < top.x && p_V.y < top.y && p_V.z < top.z)) return -1;
  const glm::ivec3 i(glm::floor(p_V));
  const dvec3 f = p_V - dvec3(i);
  const std::size_t first = index(i);
  double sum = 0;
  for (int k = 0; k < 8; ++k) {
    const std::size_t at = first + static_cast<std::size_t>((k >> 2) * stride_x_ + (k >> 1 & 1) * stride_y_ + (k & 1));
    const double weight = (k & 4 ? f.x : 1 - f.x) * (k & 2 ? f.y : 1 - f.y) * (k & 1 ? f.z : 1 - f.z);
    const double d = static_cast<double>(depth_[at]);
    sum += weight * (label_[at] == tissue || label_[at] == Tissue::kAir ? d : -d);
  }
  return sum;
}

}  // namespace typodont::haptics::packing
