#include "haptics/contact/implant/end_voxels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "engine/base/dispatch.h"
#include "haptics/hardness.h"
#include "haptics/label.h"
#include "haptics/lanes.h"
#include "haptics/work.h"

namespace typodont::haptics::implant {

namespace {

// voxels, distance ahead of a tool voxel at which the field is compared with its value at this voxel
constexpr double kAhead = 1.5;
constexpr double kFalls = 0.5;     // voxels, least decrease of the field over kAhead voxels that indicates an obstacle
constexpr double kTouches = 0.25;  // voxels, distance from bone up to which an obstacle blocks the advance
constexpr std::size_t kBlock = EndVoxels::kBlock;

/// The arguments of look_at_end() as plain data.
struct Task {
  const EndVoxels& voxels;
  const EndLaw& law;
  const float* distance;
  const Tissue* tissue;
  const std::uint8_t* hardness;  // null if the tissue has no hardness per voxel
  std::int32_t n, lo_x, lo_y, lo_z;
  dvec3 center;  // voxels
  glm::dmat3 R;  // from T (m) to V (voxels), without the translation
  // voxels, vector of length kAhead from a tool voxel to a point ahead of it; an obstacle contains this point
  dvec3 beyond;
  double slowness;  // s/rad, 1 divided by the spindle's speed; 0 for a stopped spindle
};

/// State of one block of voxels, one array per property. Flags are 0 or 1 and as wide as a double, so that the
/// compiler can vectorise loops that use both.
struct alignas(64) Block {
  double x[kBlock], y[kBlock], z[kBlock];  // voxels, positions in V
  double field[kBlock];                    // voxels, distance from bone at the voxel's centre
  double gap[kBlock];                      // m, distance of the voxel's surface from bone
  std::int64_t touches[kBlock];            // the voxel is in contact with bone
  std::int64_t stops[kBlock];              // the voxel cannot cut the bone that it touches
  double ahead[kBlock];                    // voxels, field value at `beyond`
  std::int32_t at[kBlock];                 // index of the sample to read
  std::int64_t label[kBlock];              // tissue at `beyond`
  std::int32_t byte[kBlock];               // hardness at `beyond`, as in hardness.h
  double energy[kBlock], grey[kBlock], grey_per_hardness[kBlock];
  double area[kBlock], hard_area[kBlock], cut[kBlock], thrust[kBlock];  // each voxel's terms of the sums in EndLook
};

/// Samples the field trilinearly at the voxels, with the same bits as sample_linear(). Returns true if any voxel is
/// less than one patch voxel away from bone.
TYPODONT_KERNEL bool sample(const Task& task, std::size_t first, Block& b) {
  const float* const vx = task.voxels.x.data() + first;
  const float* const vy = task.voxels.y.data() + first;
  const float* const vz = task.voxels.z.data() + first;
  const float* const outside = task.voxels.outside.data() + first;
  const glm::dmat3 R = task.R;
  const dvec3 center = task.center;
  const double lo_x = task.lo_x, lo_y = task.lo_y, lo_z = task.lo_z, h = task.law.voxel;
  const std::int32_t n = task.n;
  alignas(64) double u[kBlock], v[kBlock], w[kBlock];
  for (std::size_t i = 0; i < kBlock; ++i) {
    const double x = static_cast<double>(vx[i]), y = static_cast<double>(vy[i]), z = static_cast<double>(vz[i]);
    const double px = center.x + (R[0].x * x + R[1].x * y + R[2].x * z);
    const double py = center.y + (R[0].y * x + R[1].y * y + R[2].y * z);
    const double pz = center.z + (R[0].z * x + R[1].z * y + R[2].z * z);
    b.x[i] = px, b.y[i] = py, b.z[i] = pz;
    const double qx = px - lo_x, qy = py - lo_y, qz = pz - lo_z;
    const auto ix = static_cast<std::int32_t>(qx), iy = static_cast<std::int32_t>(qy),
               iz = static_cast<std::int32_t>(qz);
    u[i] = qx - ix, v[i] = qy - iy, w[i] = qz - iz;
    b.at[i] = (ix * n + iy) * n + iz;
  }
  // The eight corners of each cell as four pairs along z, because a pair is one load.
  alignas(64) float pairs[4][2 * kBlock];
  const std::ptrdiff_t sy = n, sx = sy * sy;
  for (std::size_t i = 0; i < kBlock; ++i) {
    const float* const corner = task.distance + b.at[i];
    std::memcpy(&pairs[0][2 * i], corner, 2 * sizeof(float));
    std::memcpy(&pairs[1][2 * i], corner + sy, 2 * sizeof(float));
    std::memcpy(&pairs[2][2 * i], corner + sx, 2 * sizeof(float));
    std::memcpy(&pairs[3][2 * i], corner + sx + sy, 2 * sizeof(float));
  }
  for (std::size_t i = 0; i < kBlock; ++i) {
    double along_z[4];
    for (int k = 0; k < 4; ++k) {
      const float low = pairs[k][2 * i], high = pairs[k][2 * i + 1];
      along_z[k] = static_cast<double>(low) + w[i] * static_cast<double>(high - low);
    }
    const double near = along_z[0] + v[i] * (along_z[1] - along_z[0]),
                 far = along_z[2] + v[i] * (along_z[3] - along_z[2]);
    b.field[i] = near + u[i] * (far - near);
  }
  std::int64_t any = 0;
  for (std::size_t i = 0; i < kBlock; ++i) {
    b.gap[i] = b.field[i] * h + static_cast<double>(outside[i]);
    b.touches[i] = b.gap[i] < h ? 1 : 0;
    any |= b.touches[i];
  }
  return any != 0;
}

/// std::round() without a function call.
TYPODONT_KERNEL double rounded(double v) {
  const double whole = static_cast<std::int32_t>(v), rest = v - whole;
  return whole + (rest >= 0.5 ? 1.0 : 0.0) - (rest <= -0.5 ? 1.0 : 0.0);
}

/// Finds the bone in front of the voxels that touch bone. An obstacle must continue ahead of the tool; bone beside
/// the tool is not an obstacle. Returns the labels of the bone ahead of these voxels, as a set of bits.
TYPODONT_KERNEL std::uint64_t look_beyond(const Task& task, Block& b) {
  const double n = task.n, lo_x = task.lo_x, lo_y = task.lo_y, lo_z = task.lo_z;
  const dvec3 beyond = task.beyond;
  for (std::size_t i = 0; i < kBlock; ++i) {
    const double x = rounded(b.x[i] + beyond.x) - lo_x, y = rounded(b.y[i] + beyond.y) - lo_y,
                 z = rounded(b.z[i] + beyond.z) - lo_z;
    const double at = (x * n + y) * n + z;  // an integer, which a double stores exactly
    b.at[i] = static_cast<std::int32_t>(b.touches[i] != 0 ? at : 0.0);
  }
  for (std::size_t i = 0; i < kBlock; ++i) {
    const std::int32_t at = b.at[i];
    const Tissue tissue = task.tissue[at];
    b.ahead[i] = static_cast<double>(task.distance[at]);
    b.label[i] = static_cast<std::int64_t>(shown(tissue));
    b.byte[i] = task.hardness != nullptr && !is_filled(tissue) ? task.hardness[at] : kOwnHardness;
  }
  std::int64_t labels = 0;  // one bit for each label
  for (std::size_t i = 0; i < kBlock; ++i) {
    const std::int64_t falls = b.field[i] - b.ahead[i] < kFalls ? 0 : 1, solid = b.label[i] != 0 ? 1 : 0;
    b.touches[i] &= falls & solid;
    labels |= b.touches[i] << b.label[i];
  }
  return static_cast<std::uint64_t>(labels);
}

/// The summands of eq. (2) for a feed along -z, as add_cutting() computes it for any direction; the sums of the other
/// components around the axis are zero. A voxel that does not touch bone adds 0. Returns true if any voxel stops the
/// tool.
TYPODONT_KERNEL bool evaluate(const Task& task, std::size_t first, std::uint64_t labels, Block& b) {
  const EndLaw& law = task.law;
  const std::int64_t only = std::has_single_bit(labels) ? std::countr_zero(labels) : -1;
  for (std::size_t i = 0; i < kBlock; ++i) {
    const auto t = static_cast<std::size_t>(only >= 0 ? only : b.label[i]);
    b.energy[i] = law.energy[t], b.grey[i] = law.grey[t], b.grey_per_hardness[i] = law.grey_per_hardness[t];
  }
  const float* const area = task.voxels.area.data() + first;
  const float* const facing = task.voxels.facing.data() + first;
  const float* const inverse_r = task.voxels.inverse_r.data() + first;
  const float* const ability = task.voxels.ability.data() + first;
  const double per_voxel = 1 / law.voxel, share = task.voxels.share, slowness = task.slowness;
  const double unit = task.hardness != nullptr ? 1.0 / kOwnHardness : 0, own = task.hardness != nullptr ? 0 : 1;
  const double most = law.greatest_grey;
  const std::int64_t cuts = law.cuts ? 1 : 0;
  for (std::size_t i = 0; i < kBlock; ++i) {
    const double close = 1 - b.gap[i] * per_voxel, weight = close < 1.0 ? close : 1.0;
    const double hardness = b.byte[i] * unit + own, able = static_cast<double>(ability[i]);
    const double grey = b.grey[i] + b.grey_per_hardness[i] * hardness;
    const double contact = static_cast<double>(area[i]) * share * weight;
    const double front = static_cast<double>(facing[i]);
    const double cut = b.energy[i] * hardness / able * front * contact * slowness;
    const double thrust = cut * front * static_cast<double>(inverse_r[i]), hard_contact = contact * hardness;
    const std::int64_t able_to = able > 0 ? cuts : 0, soft = grey <= most ? 1 : 0;
    const std::int64_t touches = b.touches[i], cutting = touches & able_to & soft;
    b.stops[i] = touches - cutting;
    b.grey[i] = touches != 0 ? grey : 0;
    b.area[i] = touches != 0 ? contact : 0;
    b.hard_area[i] = touches != 0 ? hard_contact : 0;
    b.cut[i] = cutting != 0 ? cut : 0;
    b.thrust[i] = cutting != 0 ? thrust : 0;
  }
  std::int64_t any = 0;
  for (std::size_t i = 0; i < kBlock; ++i) any |= b.stops[i];
  return any != 0;
}

TYPODONT_KERNEL void add_stops(const Task& task, std::size_t first, const Block& b, EndLook& look) {
  const double h = task.law.voxel;
  const auto width = static_cast<float>(task.law.width);
  for (std::size_t i = 0; i < kBlock; ++i) {
    if (b.stops[i] == 0 || task.voxels.r[first + i] > width) continue;
    look.free = std::min(look.free, std::max(b.gap[i], 0.0));
    if (b.gap[i] <= kTouches * h) look.collided += b.area[i];
  }
}

TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void look_at_blocks(const Task* task, EndLook* result) {
  EndLook& look = *result;
  double engaged = 0, drag = 0, turning = 0;
  Block b;
  alignas(64) double grey[kBlock] = {};
  for (std::size_t first = 0; first < task->voxels.x.size(); first += kBlock) {
    if (!sample(*task, first, b)) continue;
    const std::uint64_t labels = look_beyond(*task, b);
    if (labels == 0) continue;
    if (evaluate(*task, first, labels, b)) add_stops(*task, first, b, look);
    for (std::size_t i = 0; i < kBlock; ++i) grey[i] = grey[i] < b.grey[i] ? b.grey[i] : grey[i];
    if (std::has_single_bit(labels)) {
      const auto t = static_cast<std::size_t>(std::countr_zero(labels));
      double tissue = look.tissue[t], hardness = look.hardness[t];
      for (std::size_t i = 0; i < kBlock; ++i) {
        engaged += b.area[i], drag += b.thrust[i], turning += b.cut[i];
        tissue += b.area[i], hardness += b.hard_area[i];
      }
      look.tissue[t] = tissue, look.hardness[t] = hardness;
    } else {
      for (std::size_t i = 0; i < kBlock; ++i) {
        engaged += b.area[i], drag += b.thrust[i], turning += b.cut[i];
        const auto t = static_cast<std::size_t>(b.label[i]);
        look.tissue[t] += b.area[i], look.hardness[t] += b.hard_area[i];
      }
    }
  }
  look.engaged = engaged;
  look.greatest_grey = *std::max_element(grey, grey + kBlock);
  look.wrench.force.z = drag / task->law.thrust_ratio;
  look.wrench.torque.z = task->law.speed < 0 ? turning : -turning;
}

}  // namespace

EndVoxels::EndVoxels(const ToolVoxels& voxels) : count(voxels.ahead), share(1 / voxels.ahead_share) {
  constexpr float kNever = 1e9f;  // m, distance of the padding voxels from the head's surface; they never touch bone
  const std::size_t padded = (count + kBlock - 1) / kBlock * kBlock;
  for (std::size_t i = 0; i < padded; ++i) {
    const ToolVoxel& v = voxels.outer[std::min(i, count - 1)];
    x.push_back(v.p.x), y.push_back(v.p.y), z.push_back(v.p.z);
    outside.push_back(i < count ? v.outside : kNever);
    area.push_back(v.area);
    facing.push_back(-v.n.z);
    inverse_r.push_back(v.inverse_r);
    ability.push_back(v.ability);
    r.push_back(std::hypot(v.p.x, v.p.y));
  }
}

EndLook look_at_end(const EndVoxels& voxels, const SurfacePatch& patch, const EndLaw& law, const dvec3& center_V,
                    const dquat& R_WT) noexcept {
  EndLook look;
  const Task task{.voxels = voxels,
                  .law = law,
                  .distance = patch.distance.data(),
                  .tissue = patch.tissue.data(),
                  .hardness = patch.hardness.empty() ? nullptr : patch.hardness.data(),
                  .n = patch.n,
                  .lo_x = patch.lo.x,
                  .lo_y = patch.lo.y,
                  .lo_z = patch.lo.z,
                  .center = center_V,
                  .R = glm::mat3_cast(R_WT) * (1 / law.voxel),
                  .beyond = kAhead * (R_WT * dvec3(0, 0, -1)),
                  .slowness = law.speed != 0 ? 1 / std::abs(law.speed) : 0};
  look_at_blocks(&task, &look);
  count_queries(voxels.count);
  return look;
}

}  // namespace typodont::haptics::implant
