#include "haptics/contact/implant/end_voxels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>

#include "engine/base/dispatch.h"
#include "haptics/cutting/lanes.h"
#include "haptics/dense_tissue.h"
#include "haptics/volume/label.h"
#include "haptics/work.h"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define TYPODONT_GATHERS 1
#include <immintrin.h>
#endif

namespace typodont::haptics::implant {

namespace {

// voxels of the tissue; the distance from bone is also read at a point this far ahead of each tool voxel
constexpr double kAhead = 1.5;
// voxels; the wall of the tool's own bed is wavy by less than this
constexpr double kWaves = 0.05;
// voxels; bone nearer to a tool voxel than this, which the tool cannot cut, stops the tool
constexpr double kTouches = 0.25;
constexpr std::size_t kBlock = EndVoxels::kBlock;

/// Functions that read samples at kBlock indices per call.
struct Reader {
  /// For each index in `at`, reads two samples that are neighbours along z, into `low` and `high`.
  void (*pairs)(const float* from, const std::int32_t* at, float* low, float* high);
  void (*samples)(const float* from, const std::int32_t* at, float* to);
  void (*bytes)(const std::uint8_t* from, const std::int32_t* at, std::int32_t* to);
};

namespace plain {
void pairs(const float* from, const std::int32_t* at, float* low, float* high) {
  for (std::size_t i = 0; i < kBlock; ++i) low[i] = from[at[i]], high[i] = from[at[i] + 1];
}
void samples(const float* from, const std::int32_t* at, float* to) {
  for (std::size_t i = 0; i < kBlock; ++i) to[i] = from[at[i]];
}
void bytes(const std::uint8_t* from, const std::int32_t* at, std::int32_t* to) {
  for (std::size_t i = 0; i < kBlock; ++i) to[i] = from[at[i]];
}
}  // namespace plain

#ifdef TYPODONT_GATHERS
#pragma GCC push_options
#pragma GCC target("arch=x86-64-v4")
// Masked instructions, because GCC 12 warns wrongly about unmasked ones.
namespace gathered {
void pairs(const float* from, const std::int32_t* at, float* low, float* high) {
  const __m512i none = _mm512_setzero_si512();
  const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30),
                odd = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
  for (std::size_t i = 0; i < kBlock; i += 16) {
    const __m256i first = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(at + i)),
                  second = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(at + i + 8));
    const __m512i a = _mm512_mask_i32gather_epi64(none, 0xff, first, from, sizeof(float)),
                  b = _mm512_mask_i32gather_epi64(none, 0xff, second, from, sizeof(float));
    _mm512_storeu_si512(low + i, _mm512_permutex2var_epi32(a, even, b));
    _mm512_storeu_si512(high + i, _mm512_permutex2var_epi32(a, odd, b));
  }
}
void samples(const float* from, const std::int32_t* at, float* to) {
  for (std::size_t i = 0; i < kBlock; i += 16) {
    const __m512i index = _mm512_loadu_si512(at + i);
    _mm512_storeu_ps(to + i, _mm512_mask_i32gather_ps(_mm512_setzero_ps(), 0xffff, index, from, sizeof(float)));
  }
}
/// Also reads up to three bytes after each wanted byte. The array has them: no tool voxel is at the patch's border.
void bytes(const std::uint8_t* from, const std::int32_t* at, std::int32_t* to) {
  const __m512i none = _mm512_setzero_si512(), byte = _mm512_set1_epi32(0xff);
  for (std::size_t i = 0; i < kBlock; i += 16) {
    const __m512i index = _mm512_loadu_si512(at + i);
    const __m512i four = _mm512_mask_i32gather_epi32(none, 0xffff, index, from, 1);
    _mm512_storeu_si512(to + i, _mm512_and_si512(four, byte));
  }
}
}  // namespace gathered
#pragma GCC pop_options
#endif

Reader fastest_reader() {
#ifdef TYPODONT_GATHERS
  if (__builtin_cpu_supports("x86-64-v4")) return {gathered::pairs, gathered::samples, gathered::bytes};
#endif
  return {plain::pairs, plain::samples, plain::bytes};
}

const Reader kReader = fastest_reader();

/// Arguments of scan_end() as plain data. Positions are relative to a near voxel, so that floats are precise.
struct Task {
  const EndVoxels& voxels;
  const EndLaw& law;
  Reader reader;
  const float* distance;
  const Tissue* tissue;
  const std::uint8_t* hardness;  // null: the tissue has no hardness per voxel
  std::int32_t n, lo_x, lo_y, lo_z;
  glm::vec3 center;  // voxels, centre of the head
  glm::mat3 R;       // rotation and scale from T (m) to V (voxels)
  // voxels, vector of length kAhead along the feed
  glm::vec3 beyond;
  float slowness;  // s/rad, 1 / spindle speed; 0: at rest
};

/// Data of kBlock tool voxels, an array per property. Flags are 0 or 1, as wide as floats, so loops are vectorised.
struct alignas(64) Block {
  using Flag = std::int32_t;

  // voxels, positions of the tool voxels in frame V (tissue grid)
  float x[kBlock], y[kBlock], z[kBlock];
  float field[kBlock];        // voxels, distance from bone
  float gap[kBlock];          // m, distance from the bone to the tool's surface
  Flag touches[kBlock];       // 1: the tool voxel is in contact with bone
  Flag stops[kBlock];         // 1: touches bone that it cannot cut
  float ahead[kBlock];        // voxels, distance from bone at a point ahead of the tool voxel (Task::beyond)
  std::int32_t at[kBlock];    // index of the tissue patch's sample to read
  Flag label[kBlock];         // tissue label ahead of the tool voxel (Task::beyond)
  std::int32_t byte[kBlock];  // hardness byte (dense_tissue.h)
  float energy[kBlock], grey[kBlock], grey_per_hardness[kBlock];
  // area: area in contact (m²); hard_area: area × hardness (m²). By eq. 2 of Zhao 2020, cut: torque about the axis
  // divided by the feed speed (N·s); thrust: axial force × EndLaw::thrust_ratio, divided by the feed speed (N·s/m).
  float area[kBlock], hard_area[kBlock], cut[kBlock], thrust[kBlock];
};

/// Interpolates the distance from bone trilinearly at the positions x, y, z (voxels), like sample_linear().
TYPODONT_INLINE void interpolate(const Task& task, const float* x, const float* y, const float* z, std::int32_t* at,
                                 float* field) {
  const float lo_x = static_cast<float>(task.lo_x), lo_y = static_cast<float>(task.lo_y),
              lo_z = static_cast<float>(task.lo_z);
  const std::int32_t n = task.n;
  alignas(64) float u[kBlock], v[kBlock], w[kBlock];
  for (std::size_t i = 0; i < kBlock; ++i) {
    const float qx = x[i] - lo_x, qy = y[i] - lo_y, qz = z[i] - lo_z;
    const auto ix = static_cast<std::int32_t>(qx), iy = static_cast<std::int32_t>(qy),
               iz = static_cast<std::int32_t>(qz);
    u[i] = qx - static_cast<float>(ix), v[i] = qy - static_cast<float>(iy), w[i] = qz - static_cast<float>(iz);
    at[i] = (ix * n + iy) * n + iz;
  }
  // Four pairs of samples along z, one load each.
  alignas(64) float low[4][kBlock], high[4][kBlock];
  const std::ptrdiff_t sy = n, sx = sy * sy;
  task.reader.pairs(task.distance, at, low[0], high[0]);
  task.reader.pairs(task.distance + sy, at, low[1], high[1]);
  task.reader.pairs(task.distance + sx, at, low[2], high[2]);
  task.reader.pairs(task.distance + sx + sy, at, low[3], high[3]);
  for (std::size_t i = 0; i < kBlock; ++i) {
    float along_z[4];
    for (int k = 0; k < 4; ++k) along_z[k] = low[k][i] + w[i] * (high[k][i] - low[k][i]);
    const float near = along_z[0] + v[i] * (along_z[1] - along_z[0]),
                far = along_z[2] + v[i] * (along_z[3] - along_z[2]);
    field[i] = near + u[i] * (far - near);
  }
}

/// Computes the positions of the tool voxels and their distances from bone. Returns true if some gap is below 1 voxel.
TYPODONT_INLINE bool sample(const Task& task, std::size_t first, Block& b) {
  const float* const vx = task.voxels.x.data() + first;
  const float* const vy = task.voxels.y.data() + first;
  const float* const vz = task.voxels.z.data() + first;
  const float* const outside = task.voxels.outside.data() + first;
  const auto R = task.R;
  const auto center = task.center;
  const float h = static_cast<float>(task.law.voxel);
  for (std::size_t i = 0; i < kBlock; ++i) {
    const float x = vx[i], y = vy[i], z = vz[i];
    b.x[i] = center.x + (R[0].x * x + R[1].x * y + R[2].x * z);
    b.y[i] = center.y + (R[0].y * x + R[1].y * y + R[2].y * z);
    b.z[i] = center.z + (R[0].z * x + R[1].z * y + R[2].z * z);
  }
  interpolate(task, b.x, b.y, b.z, b.at, b.field);
  Block::Flag any = 0;
  for (std::size_t i = 0; i < kBlock; ++i) {
    b.gap[i] = b.field[i] * h + outside[i];
    b.touches[i] = b.gap[i] < h ? 1 : 0;
    any |= b.touches[i];
  }
  return any != 0;
}

/// Rounds like std::round(), but without a function call.
TYPODONT_INLINE std::int32_t rounded(float v) {
  const float whole = static_cast<float>(static_cast<std::int32_t>(v)), rest = v - whole;
  const float up = rest >= 0.5f ? 1.0f : 0.0f, down = rest <= -0.5f ? 1.0f : 0.0f;
  return static_cast<std::int32_t>(whole + up - down);
}

/// Removes the contact of tool voxels that only touch bone beside them: the point ahead of the tool must be in bone.
/// Returns a bit mask of the labels in contact.
TYPODONT_INLINE std::uint64_t scan_beyond(const Task& task, std::size_t first, Block& b) {
  using Flag = Block::Flag;
  const float* const in_bone = task.voxels.in_bone.data() + first;
  const std::int32_t n = task.n, lo_x = task.lo_x, lo_y = task.lo_y, lo_z = task.lo_z;
  // For tool voxels without contact, the field is read at the voxel itself instead of ahead of it.
  for (std::size_t i = 0; i < kBlock; ++i) {
    const float on = static_cast<float>(b.touches[i]);
    b.x[i] += on * task.beyond.x, b.y[i] += on * task.beyond.y, b.z[i] += on * task.beyond.z;
  }
  interpolate(task, b.x, b.y, b.z, b.at, b.ahead);
  for (std::size_t i = 0; i < kBlock; ++i) {
    const std::int32_t x = rounded(b.x[i]) - lo_x, y = rounded(b.y[i]) - lo_y, z = rounded(b.z[i]) - lo_z;
    b.at[i] = (x * n + y) * n + z;
  }
  alignas(64) std::int32_t tissue[kBlock], hardness[kBlock];
  task.reader.bytes(reinterpret_cast<const std::uint8_t*>(task.tissue), b.at, tissue);
  if (task.hardness != nullptr) task.reader.bytes(task.hardness, b.at, hardness);
  for (std::size_t i = 0; i < kBlock; ++i) {
    b.label[i] = tissue[i] & kShown;
    b.byte[i] = task.hardness == nullptr || tissue[i] > kShown ? kOwnHardness : hardness[i];
  }
  Flag labels = 0;  // one bit per label
  for (std::size_t i = 0; i < kBlock; ++i) {
    const Flag obstacle = b.ahead[i] < in_bone[i] ? 1 : 0, solid = b.label[i] != 0 ? 1 : 0;
    b.touches[i] &= obstacle & solid;
    labels |= b.touches[i] << b.label[i];
  }
  return static_cast<std::uint64_t>(labels);
}

/// Eq. 2 of Zhao 2020 for a feed along -z. Components perpendicular to the tool's axis cancel, so they are left out
/// (unlike in add_cutting()). Returns true if a tool voxel stops the tool.
TYPODONT_INLINE bool evaluate(const Task& task, std::size_t first, std::uint64_t labels, Block& b) {
  using Flag = Block::Flag;
  const EndLaw& law = task.law;
  if (std::has_single_bit(labels)) {
    const auto t = static_cast<std::size_t>(std::countr_zero(labels));
    const float energy = static_cast<float>(law.energy[t]), grey = static_cast<float>(law.grey[t]),
                grey_per_hardness = static_cast<float>(law.grey_per_hardness[t]);
    for (std::size_t i = 0; i < kBlock; ++i)
      b.energy[i] = energy, b.grey[i] = grey, b.grey_per_hardness[i] = grey_per_hardness;
  } else {
    for (std::size_t i = 0; i < kBlock; ++i) {
      const auto t = static_cast<std::size_t>(b.label[i]);
      b.energy[i] = static_cast<float>(law.energy[t]), b.grey[i] = static_cast<float>(law.grey[t]);
      b.grey_per_hardness[i] = static_cast<float>(law.grey_per_hardness[t]);
    }
  }
  const float* const area = task.voxels.area.data() + first;
  const float* const facing = task.voxels.facing.data() + first;
  const float* const inverse_r = task.voxels.inverse_r.data() + first;
  const float* const ability = task.voxels.ability.data() + first;
  const float* const inverse_ability = task.voxels.inverse_ability.data() + first;
  const float per_voxel = static_cast<float>(1 / law.voxel), slowness = task.slowness;
  const float unit = task.hardness != nullptr ? static_cast<float>(1.0 / kOwnHardness) : 0,
              own = task.hardness != nullptr ? 0 : 1;
  const float most = static_cast<float>(law.max_grey);
  const Flag cuts = law.cuts ? 1 : 0;
  for (std::size_t i = 0; i < kBlock; ++i) {
    const float away = b.gap[i] > 0 ? b.gap[i] * per_voxel : 0, weight = 1 - away * away;
    const float hardness = static_cast<float>(b.byte[i]) * unit + own, able = ability[i];
    const float grey = b.grey[i] + b.grey_per_hardness[i] * hardness;
    const float contact = area[i] * weight;
    const float front = facing[i];
    const float specific = b.energy[i] * hardness * inverse_ability[i];  // J/m³, specific cutting energy of the bone
    const float cut = specific * front * contact * slowness;
    const float thrust = cut * front * inverse_r[i], hard_contact = contact * hardness;
    const Flag able_to = able > 0 ? cuts : 0, soft = grey <= most ? 1 : 0;
    const Flag touches = b.touches[i], cutting = touches & able_to & soft;
    b.stops[i] = touches - cutting;
    b.grey[i] = touches != 0 ? grey : 0;
    b.area[i] = touches != 0 ? contact : 0;
    b.hard_area[i] = touches != 0 ? hard_contact : 0;
    b.cut[i] = cutting != 0 ? cut : 0;
    b.thrust[i] = cutting != 0 ? thrust : 0;
  }
  Flag any = 0;
  for (std::size_t i = 0; i < kBlock; ++i) any |= b.stops[i];
  return any != 0;
}

TYPODONT_INLINE void add_stops(const Task& task, std::size_t first, const Block& b, EndScan& scan) {
  const double h = task.law.voxel;
  const auto width = static_cast<float>(task.law.width);
  for (std::size_t i = 0; i < kBlock; ++i) {
    if (b.stops[i] == 0 || task.voxels.r[first + i] > width) continue;
    const auto gap = static_cast<double>(b.gap[i]);
    scan.free = std::min(scan.free, std::max(gap, 0.0));
    if (gap <= kTouches * h) scan.collided += static_cast<double>(b.area[i]);
  }
}

/// A sum that is kept as kBlock partial sums, so that the additions are vectorised.
struct Sum {
  alignas(64) float parts[kBlock] = {};
  TYPODONT_INLINE void add(const float* summands) {
    for (std::size_t i = 0; i < kBlock; ++i) parts[i] += summands[i];
  }
  TYPODONT_INLINE void add(std::size_t i, float summand) { parts[i] += summand; }
  TYPODONT_INLINE double total() const {
    double sum = 0;
    for (const float part : parts) sum += static_cast<double>(part);
    return sum;
  }
};

TYPODONT_INLINE void scan_all(const Task& task, EndScan& scan) {
  Sum engaged, drag, turning, tissue[kTissueCount], hardness[kTissueCount];
  Block b;
  alignas(64) float grey[kBlock] = {};
  for (std::size_t first = 0; first < task.voxels.x.size(); first += kBlock) {
    if (!sample(task, first, b)) continue;
    const std::uint64_t labels = scan_beyond(task, first, b);
    if (labels == 0) continue;
    if (evaluate(task, first, labels, b)) add_stops(task, first, b, scan);
    for (std::size_t i = 0; i < kBlock; ++i) grey[i] = grey[i] < b.grey[i] ? b.grey[i] : grey[i];
    engaged.add(b.area), drag.add(b.thrust), turning.add(b.cut);
    if (std::has_single_bit(labels)) {
      const auto t = static_cast<std::size_t>(std::countr_zero(labels));
      tissue[t].add(b.area), hardness[t].add(b.hard_area);
    } else {
      for (std::size_t i = 0; i < kBlock; ++i) {
        const auto t = static_cast<std::size_t>(b.label[i]);
        tissue[t].add(i, b.area[i]), hardness[t].add(i, b.hard_area[i]);
      }
    }
  }
  for (std::size_t t = 0; t < kTissueCount; ++t) {
    scan.tissue[t] = tissue[t].total(), scan.hardness[t] = hardness[t].total();
  }
  scan.engaged = engaged.total();
  scan.max_grey = static_cast<double>(*std::max_element(grey, grey + kBlock));
  scan.wrench.force.z = drag.total() / task.law.thrust_ratio;
  scan.wrench.torque.z = task.law.speed < 0 ? turning.total() : -turning.total();
}

TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void scan_blocks(const Task* task, EndScan* scan) {
  scan_all(*task, *scan);
}

/// Copies the arguments of scan_end() into plain data.
Task task_of(const EndVoxels& voxels, const TissuePatch& patch, const EndLaw& law, const dvec3& center_V,
             const dquat& R_WT) {
  const glm::ivec3 origin(glm::floor(center_V));
  return {.voxels = voxels,
          .law = law,
          .reader = kReader,
          .distance = patch.distance.data(),
          .tissue = patch.tissue.data(),
          .hardness = patch.hardness.empty() ? nullptr : patch.hardness.data(),
          .n = patch.n,
          .lo_x = patch.lo.x - origin.x,
          .lo_y = patch.lo.y - origin.y,
          .lo_z = patch.lo.z - origin.z,
          .center = glm::vec3(center_V - dvec3(origin)),
          .R = glm::mat3(glm::mat3_cast(R_WT) * (1 / law.voxel)),
          .beyond = glm::vec3(kAhead * (R_WT * dvec3(0, 0, -1))),
          .slowness = static_cast<float>(law.speed != 0 ? 1 / std::abs(law.speed) : 0)};
}

}  // namespace

namespace {

/// Merges 2 × 2 equal tool voxels, side by side at equal depth, into one; not near the axis, where 1/r changes quickly.
std::vector<ToolVoxel> merged(std::span<const ToolVoxel> voxels, double edge) {
  constexpr float kEqual = 1e-3f;
  constexpr double kNearAxis = 8;  // voxels from the axis; nearer voxels are not merged
  const auto index = [&](float v) { return std::lround(static_cast<double>(v) / edge); };
  std::map<std::array<long, 3>, std::vector<const ToolVoxel*>> squares;
  for (const ToolVoxel& v : voxels) {
    const auto half = [&](float at) { return index(at) >> 1; };
    squares[{half(v.p.x), half(v.p.y), std::lround(2 * static_cast<double>(v.p.z) / edge)}].push_back(&v);
  }
  std::vector<ToolVoxel> all;
  for (const auto& [key, square] : squares) {
    const ToolVoxel& one = *square.front();
    const bool equal = std::all_of(square.begin(), square.end(), [&](const ToolVoxel* v) {
      return std::hypot(v->p.x, v->p.y) > kNearAxis * edge && v->ability == one.ability &&
             std::abs(v->n.z - one.n.z) < kEqual &&
             std::abs(v->outside - one.outside) < kEqual * static_cast<float>(edge);
    });
    if (square.size() < 4 || !equal) {
      for (const ToolVoxel* v : square) all.push_back(*v);
      continue;
    }
    ToolVoxel sum = one;
    sum.p = glm::vec3(0), sum.area = sum.inverse_r = 0;
    for (const ToolVoxel* v : square) sum.p += v->p / 4.0f, sum.area += v->area, sum.inverse_r += v->inverse_r / 4;
    all.push_back(sum);
  }
  return all;
}

}  // namespace

EndVoxels::EndVoxels(const ToolVoxels& voxels, double coarsest) {
  constexpr float kNever = 1e9f;  // m; padding voxels are this far outside, so they touch nothing
  constexpr double kRounding = 1e-9;
  std::vector<ToolVoxel> all(voxels.outer.begin(), voxels.outer.begin() + static_cast<std::ptrdiff_t>(voxels.ahead));
  if (2 * voxels.edge <= coarsest * (1 + kRounding)) all = merged(all, voxels.edge);
  count = all.size();
  float rim = 0;  // m, inner radius of the outermost ring of voxels
  for (const ToolVoxel& v : all) rim = std::max(rim, std::hypot(v.p.x, v.p.y) - static_cast<float>(voxels.edge));
  const std::size_t padded = (count + kBlock - 1) / kBlock * kBlock;
  for (std::size_t i = 0; i < padded; ++i) {
    const ToolVoxel& v = all[std::min(i, count - 1)];
    x.push_back(v.p.x), y.push_back(v.p.y), z.push_back(v.p.z);
    outside.push_back(i < count ? v.outside : kNever);
    area.push_back(v.area);
    facing.push_back(-v.n.z);
    inverse_r.push_back(v.inverse_r);
    ability.push_back(v.ability);
    inverse_ability.push_back(v.ability > 0 ? 1 / v.ability : 0);
    r.push_back(std::hypot(v.p.x, v.p.y));
    in_bone.push_back(r.back() > rim ? -static_cast<float>(kWaves) : 0.0f);
  }
}

EndScan scan_end(const EndVoxels& voxels, const TissuePatch& patch, const EndLaw& law, const dvec3& center_V,
                 const dquat& R_WT) noexcept {
  EndScan scan;
  const Task task = task_of(voxels, patch, law, center_V, R_WT);
  scan_blocks(&task, &scan);
  count_queries(voxels.count);
  return scan;
}

}  // namespace typodont::haptics::implant
