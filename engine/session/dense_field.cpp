#include "engine/session/dense_field.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "engine/base/dispatch.h"
#include "engine/base/in_parallel.h"
#include "engine/base/vectors.h"
#include "engine/base/voxels.h"

namespace typodont::session {

namespace {

// Voxels; up to this distance from the surface, computed() refines the estimate of a voxel's closest surface point.
constexpr float kRefineLimit = 20;
// Voxels; smaller distances remain unchanged. Larger than a voxel's diagonal (1.73), so that the distances at all
// corners of a cell that the surface crosses remain unchanged.
constexpr float kUnchangedBand = 1.8f;
// Voxels. A distance d below kUnchangedBand is kept if the nearest known surface point is at most d + kSeedGap away.
constexpr float kSeedGap = 0.4f;

/// For each voxel: index and surface point (voxels) of its nearest seed (voxel beside the surface), and a bound. A
/// nearer seed (squared distance below the bound) replaces this seed. Arrays, so that vector instructions can be used.
struct Nearest {
  float *bound, *x, *y, *z;
  std::uint32_t* seed;

  Nearest operator+(std::size_t by) const { return {bound + by, x + by, y + by, z + by, seed + by}; }
};

/// kNoBound is larger than any squared distance. kNoPoint is the coordinate of the surface point while a voxel has no
/// seed (nearest voxel beside the surface). This point is so far away that no neighbour takes it.
constexpr float kNoBound = 1e12f;
constexpr float kNoPoint = 1e9f;

/// Value of Nearest::bound for a seed at this squared distance. With kRooted, the square root is rounded to a float and
/// squared again, because callers compare distances. The result can differ from `square` in the last bit.
template <bool kRooted>
float bound_of(float square) {
  if constexpr (kRooted) {
    const float root = std::sqrt(square);
    return root * root;
  } else {
    return square;
  }
}

/// Each voxel (x, y, 0…n-1) of row `to` takes the seed (surface voxel) of its neighbour in row `from` if it is nearer.
template <bool kRooted>
TYPODONT_INLINE void pass_to_row(int n, float x, float y, const Nearest& from, const Nearest& to) {
  float* const __restrict bound = to.bound;
  float* const __restrict to_x = to.x;
  float* const __restrict to_y = to.y;
  float* const __restrict to_z = to.z;
  std::uint32_t* const __restrict seed = to.seed;
  for (int z = 0; z < n; ++z) {
    const float dx = x - from.x[z], dy = y - from.y[z], dz = static_cast<float>(z) - from.z[z];
    const float square = dx * dx + dy * dy + dz * dz;
    const bool nearer = square < bound[z];
    bound[z] = nearer ? bound_of<kRooted>(square) : bound[z];
    to_x[z] = nearer ? from.x[z] : to_x[z];
    to_y[z] = nearer ? from.y[z] : to_y[z];
    to_z[z] = nearer ? from.z[z] : to_z[z];
    seed[z] = nearer ? from.seed[z] : seed[z];
  }
}
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void pass_rooted(int n, float x, float y, const Nearest& from, const Nearest& to) {
  pass_to_row<true>(n, x, y, from, to);
}
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void pass_exact(int n, float x, float y, const Nearest& from, const Nearest& to) {
  pass_to_row<false>(n, x, y, from, to);
}

/// Passes the seeds (nearest voxels beside the surface) along the row of n voxels at (x, y), up or down.
template <bool kRooted>
void pass_along(int n, bool up, float x, float y, const Nearest& row) {
  const int step = up ? 1 : -1;
  int z = up ? 0 : n - 1;
  float px = row.x[z], py = row.y[z], pz = row.z[z];
  std::uint32_t seed = row.seed[z];
  for (int k = 1; k < n; ++k) {
    z += step;
    const float dx = x - px, dy = y - py, dz = static_cast<float>(z) - pz;
    const float square = dx * dx + dy * dy + dz * dz;
    if (square < row.bound[z]) {
      row.bound[z] = bound_of<kRooted>(square);
      row.x[z] = px, row.y[z] = py, row.z[z] = pz;
      row.seed[z] = seed;
    } else {
      px = row.x[z], py = row.y[z], pz = row.z[z];
      seed = row.seed[z];
    }
  }
}

using FourDoubles = double __attribute__((vector_size(32)));
using TwoDoubles = double __attribute__((vector_size(16)));

/// Trilinear interpolation of `value(index)` at p (voxels): first four lines along z at once, then two along y.
template <class Value>
double interpolated(const DenseField& field, const glm::dvec3& p, const Value& value) {
  const glm::dvec3 q = glm::clamp(p, glm::dvec3(0), glm::dvec3(field.size - 1));
  const glm::ivec3 i = glm::min(glm::ivec3(q), glm::max(field.size - 2, glm::ivec3(0)));
  const glm::dvec3 f = q - glm::dvec3(i);
  // Index steps to the other corners of the cell; 0 along an axis on which the field has only one voxel.
  const auto nz = static_cast<std::size_t>(field.size.z), nyz = static_cast<std::size_t>(field.size.y) * nz;
  const std::size_t x = field.size.x > 1 ? nyz : 0, y = field.size.y > 1 ? nz : 0, z = field.size.z > 1 ? 1 : 0;
  const std::size_t at = field.at(i.x, i.y, i.z);
  const auto lines = [&](std::size_t from) {
    return Four{value(from), value(from + x), value(from + y), value(from + x + y)};
  };
  const auto low = __builtin_convertvector(lines(at), FourDoubles),
             high = __builtin_convertvector(lines(at + z), FourDoubles), along_z = low + f.z * (high - low);
  const TwoDoubles near = {along_z[0], along_z[1]}, far = {along_z[2], along_z[3]}, along_y = near + f.y * (far - near);
  return along_y[0] + f.x * (along_y[1] - along_y[0]);
}

/// Surface normal at p (voxels). Empty: the gradient is too small.
std::optional<glm::dvec3> normal_at(const DenseField& field, const glm::dvec3& p) {
  const glm::dvec3 g = field.gradient(p);
  return glm::length(g) > 0.5 ? std::optional(glm::normalize(g)) : std::nullopt;
}

/// Finds the seed of each voxel of a box: the nearest voxel beside the surface.
class NearestSeeds {
 public:
  explicit NearestSeeds(const glm::ivec3& size)
      : size_(size),
        count_(voxel_count(size)),
        bounds_(count_, kNoBound),
        points_(3 * count_, kNoPoint),
        seeds_(count_, kNone) {}
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  /// Sets a voxel's seed (nearest voxel beside the surface). `p`: point of the surface at the seed; `bound`: distance².
  void set(std::size_t at, std::uint32_t seed, const glm::vec3& p, float bound) {
    bounds_[at] = bound;
    for (int axis = 0; axis < 3; ++axis) points_[static_cast<std::size_t>(axis) * count_ + at] = p[axis];
    seeds_[at] = seed;
  }
  /// Return for each voxel: index of its seed (nearest voxel beside the surface); distance² to the surface, voxels².
  std::vector<std::uint32_t> seeds() && { return std::move(seeds_); }
  std::vector<float> bounds() && { return std::move(bounds_); }

  /// Eight passes, one for each combination of directions along x, y and z. A voxel takes the seed (surface voxel) of a
  /// neighbour if that seed is nearer. A finished row passes its seeds to a whole neighbouring row at once.
  template <bool kRooted>
  void pass_all() {
    const auto nz = static_cast<std::size_t>(size_.z), nyz = static_cast<std::size_t>(size_.y) * nz;
    const Nearest all{bounds_.data(), points_.data(), points_.data() + count_, points_.data() + 2 * count_,
                      seeds_.data()};
    for (int pass = 0; pass < 8; ++pass) {
      const bool up_x = (pass & 1) == 0, up_y = (pass & 2) == 0, up_z = (pass & 4) == 0;
      for (int a = 0; a < size_.x; ++a) {
        const int x = up_x ? a : size_.x - 1 - a;
        for (int b = 0; b < size_.y; ++b) {
          const int y = up_y ? b : size_.y - 1 - b;
          const std::size_t at = static_cast<std::size_t>(x) * nyz + static_cast<std::size_t>(y) * nz;
          const auto px = static_cast<float>(x), py = static_cast<float>(y);
          const auto pass_row = kRooted ? pass_rooted : pass_exact;
          if (a > 0) pass_row(size_.z, px, py, all + (up_x ? at - nyz : at + nyz), all + at);
          if (b > 0) pass_row(size_.z, px, py, all + (up_y ? at - nz : at + nz), all + at);
          pass_along<kRooted>(size_.z, up_z, px, py, all + at);
        }
      }
    }
  }

 private:
  glm::ivec3 size_;
  std::size_t count_;
  std::vector<float> bounds_, points_;  // bounds_: distances², voxels²; points_: all x, then all y, all z
  std::vector<std::uint32_t> seeds_;
};

}  // namespace

double DenseField::sample(const glm::dvec3& p) const {
  return interpolated(*this, p, [this](std::size_t at) { return distance[at]; });
}

glm::dvec3 DenseField::gradient(const glm::dvec3& p, double reach) const {
  glm::dvec3 g;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 d(0);
    d[axis] = reach;
    g[axis] = (sample(p + d) - sample(p - d)) / (2 * reach);
  }
  return g;
}

double fraction_inside(double distance) {
  return std::clamp(0.5 - distance, 0.0, 1.0);
}

TrueDistances::TrueDistances(DenseField field)
    : field_(std::move(field)), known_(field_.distance.size(), std::numeric_limits<float>::quiet_NaN()) {
  const glm::ivec3 n = field_.size;
  NearestSeeds nearest(n);
  // Each voxel beside the surface becomes a seed. Its closest surface point is computed from the gradient.
  const auto inside = [&](int x, int y, int z) { return field_.distance[field_.at(x, y, z)] < 0; };
  std::vector<std::vector<std::pair<std::size_t, glm::vec3>>> slices(static_cast<std::size_t>(n.x));
  const auto add_seed = [&](int x, int y, int z) {
    const bool in = inside(x, y, z);
    const bool border = (x > 0 && inside(x - 1, y, z) != in) || (x + 1 < n.x && inside(x + 1, y, z) != in) ||
                        (y > 0 && inside(x, y - 1, z) != in) || (y + 1 < n.y && inside(x, y + 1, z) != in) ||
                        (z > 0 && inside(x, y, z - 1) != in) || (z + 1 < n.z && inside(x, y, z + 1) != in);
    if (!border) return;
    const std::size_t at = field_.at(x, y, z);
    const glm::dvec3 p(x, y, z);
    const glm::dvec3 g = field_.gradient(p);
    const double length = glm::length(g), d = static_cast<double>(field_.distance[at]);
    const glm::vec3 closest(length > 0.1 ? p - std::clamp(d, -1.5, 1.5) * g / length : p);
    slices[static_cast<std::size_t>(x)].emplace_back(at, closest);
  };
  in_parallel(
      slices.size(),
      [&](std::size_t slice) {
        const int x = static_cast<int>(slice);
        for_each_voxel_between({x, 0, 0}, {x, n.y - 1, n.z - 1}, add_seed);
      },
      {}, /*block=*/4);
  for (const auto& slice : slices) {
    for (const auto& [at, closest] : slice) {
      // Starts with the distance that the field states; a nearer surface point of another voxel replaces it.
      nearest.set(at, static_cast<std::uint32_t>(seeds_.size()), closest, field_.distance[at] * field_.distance[at]);
      seeds_.push_back({closest, Seed::kNone, {}});
    }
  }
  nearest.pass_all<true>();
  nearest_ = std::move(nearest).seeds();
  reach_ = std::move(nearest).bounds();
  for (float& reach : reach_) reach = std::sqrt(reach);
}

float TrueDistances::operator[](std::size_t at) const {
  // Threads that compute the same distance at the same time store equal values.
  const std::atomic_ref known(known_[at]);
  float distance = known.load(std::memory_order_relaxed);
  if (std::isnan(distance)) known.store(distance = computed(at), std::memory_order_relaxed);
  return distance;
}

double TrueDistances::sample(const glm::dvec3& p) const {
  return interpolated(field_, p, [this](std::size_t at) { return (*this)[at]; });
}

DenseField TrueDistances::all() && {
  constexpr std::size_t kBlock = 4096;
  in_parallel(
      seeds_.size(), [this](std::size_t k) { (void)normal_of(seeds_[k]); }, {}, kBlock);
  in_parallel(
      known_.size(), [this](std::size_t at) { (void)(*this)[at]; }, {}, kBlock);
  return {field_.size, std::move(known_)};
}

std::optional<glm::dvec3> TrueDistances::normal_of(Seed& seed) const {
  const std::atomic_ref state(seed.state);
  if (state.load(std::memory_order_acquire) == Seed::kKnown) return seed.normal;
  const std::optional<glm::dvec3> normal = normal_at(field_, glm::dvec3(seed.closest));
  Seed::State expected = Seed::kNone;
  if (state.compare_exchange_strong(expected, Seed::kWritten, std::memory_order_relaxed)) {
    seed.normal = normal;
    state.store(Seed::kKnown, std::memory_order_release);
  }
  return normal;
}

bool TrueDistances::is_beside_surface(std::size_t at) const {
  const glm::ivec3 p = voxel_at(at, field_.size);
  const glm::ivec3 lo = glm::max(p - 1, glm::ivec3(0)), hi = glm::min(p + 1, field_.size - 1);
  for (int x = lo.x; x <= hi.x; ++x) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int z = lo.z; z <= hi.z; ++z) {
        if ((field_.distance[field_.at(x, y, z)] < 0) != (field_.distance[at] < 0)) return true;
      }
    }
  }
  return false;
}

float TrueDistances::computed(std::size_t at) const {
  const float given = field_.distance[at];
  if (nearest_[at] == NearestSeeds::kNone) return given;
  // Small values are not always near the surface: where a solid was subtracted from air, they occur far from it.
  const bool in_band = std::abs(given) <= kUnchangedBand;
  if (in_band && (reach_[at] <= std::abs(given) + kSeedGap || is_beside_surface(at))) return given;
  if (reach_[at] > kRefineLimit) return std::copysign(reach_[at], given);
  // Moves the surface point of the seed (nearest voxel beside the surface) along the surface to the voxel's own closest
  // point. Many voxels share a seed, so its normal is computed once.
  const glm::dvec3 p(voxel_at(at, field_.size));
  Seed& seed = seeds_[nearest_[at]];
  glm::dvec3 c(seed.closest);
  double reach = static_cast<double>(reach_[at]);
  std::optional<glm::dvec3> normal = normal_of(seed);
  for (int k = 0; k < 2; ++k) {
    if (k > 0) normal = normal_at(field_, c);
    if (!normal) break;
    glm::dvec3 along = p - c - glm::dot(p - c, *normal) * *normal;
    const double length = glm::length(along);
    if (length > 1) along /= length;
    const glm::dvec3 moved = c + along - field_.sample(c + along) * *normal;
    const double now = glm::length(p - moved);
    if (!(now < reach) || std::abs(field_.sample(moved)) > 0.05) break;
    reach = now;
    c = moved;
  }
  return std::copysign(std::max(static_cast<float>(reach), in_band ? std::abs(given) : kUnchangedBand), given);
}

DenseField redistanced(const DenseField& field) {
  return TrueDistances(field).all();
}

std::vector<std::size_t> nearest_marked(const glm::ivec3& size, const std::vector<bool>& marked) {
  NearestSeeds nearest(size);
  std::vector<std::size_t> places;  // array index of each seed
  std::size_t at = 0;
  for (int x = 0; x < size.x; ++x) {
    for (int y = 0; y < size.y; ++y) {
      for (int z = 0; z < size.z; ++z, ++at) {
        if (!marked[at]) continue;
        nearest.set(at, static_cast<std::uint32_t>(places.size()), glm::vec3(x, y, z), 0);
        places.push_back(at);
      }
    }
  }
  nearest.pass_all<false>();
  std::vector<std::size_t> result(marked.size(), std::numeric_limits<std::size_t>::max());
  const std::vector<std::uint32_t> seeds = std::move(nearest).seeds();
  for (std::size_t i = 0; i < result.size(); ++i) {
    if (seeds[i] != NearestSeeds::kNone) result[i] = places[seeds[i]];
  }
  return result;
}

}  // namespace typodont::session
