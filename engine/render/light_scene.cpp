#include "engine/render/light_scene.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "engine/base/cached_result.h"
#include "engine/base/in_parallel.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "engine/render/light_passes.h"
#include "engine/render/shared.h"
#include "engine/render/sphere_directions.h"
#include "engine/render/srgb.h"

namespace typodont::render {

namespace {

constexpr int kRays = 120;  // number of rays for each sample of the grid
// Largest fraction of a sample's rays that may meet backs of triangles; with more, the sample is inside a body.
constexpr double kInside = 0.25;
// Rays that meet the back of a triangle are left out of a sample's mean, because backs have no light. If the other rays
// together have less than this fraction of the weight, the part that is missing counts as dark.
constexpr float kMinSeen = 0.5f;
constexpr int kImageRays = 384;  // number of rays per sample for the light that a mirror surface would reflect
// Exponent n of a ray's weight cosⁿ(angle to the mirror's direction); rays within 10° have half of the total weight.
constexpr float kImageLobe = 48;
// distance, in grid spacings, between samples in open space that have light for mirror reflections
constexpr int kImageStep = 2;
constexpr float kMargin = 20e-6f;  // m; rays start at this distance from a surface, so that they do not meet it
constexpr int kLampRays = 4;
// Margin around a triangle's box, grid spacings. The shaders look up light beside the triangle; on a curved surface,
// these points may lie outside the box.
constexpr float kCurved = 0.15f;
constexpr int kOpenStep = 4;  // distance, in grid spacings, between the samples in open space
// Distance from a surface at which its light is looked up, grid spacings.
constexpr double kBegin = 0.5;
constexpr cache::Shelf kRayTables{"light", ".rays", 64u << 20};

using glm::cross, glm::dot, glm::max, glm::min, glm::vec3;
using shared::kBack, shared::kMissed, shared::kNothing, shared::kRayDepth, shared::RayHit, shared::RayNode,
    shared::RaySurface;

constexpr std::array<glm::vec3, shared::kLightDirections> kFaces{
    {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};

/// The rays on the CPU.
struct BodyRays {
  const RayNode* nodes;
  const RaySurface* surfaces;

#define INOUT(type) type&
#include "engine/render/body_rays.h"
#undef INOUT
};

/// Bounding volume hierarchy over the triangles.
class RayTree {
 public:
  explicit RayTree(const std::vector<LitTriangle>& triangles) {
    std::vector<glm::vec3> middles;
    for (const LitTriangle& t : triangles) {
      order_.push_back(static_cast<std::uint32_t>(order_.size()));
      middles.push_back((t.corners[0] + t.corners[1] + t.corners[2]) / 3.0f);
    }
    nodes_.reserve(triangles.size());
    if (!order_.empty()) build(triangles, middles, 0, order_.size(), 0);
    for (const std::uint32_t i : order_) {
      const auto& c = triangles[i].corners;
      surfaces_.push_back({c[0], static_cast<int>(i), glm::vec4(c[1] - c[0], 0), glm::vec4(c[2] - c[0], 0)});
    }
  }

  /// Sorted so that the triangles of a leaf are neighbours.
  std::span<const RaySurface> surfaces() const { return surfaces_; }
  std::span<const RayNode> nodes() const { return nodes_; }
  BodyRays rays() const { return {nodes_.data(), surfaces_.data()}; }

 private:
  static constexpr std::size_t kLeaf = 4;
  struct Box {
    glm::vec3 lo{1e9f}, hi{-1e9f};
    void grow(const glm::vec3& l, const glm::vec3& h) { lo = glm::min(lo, l), hi = glm::max(hi, h); }
    float area() const {
      const glm::vec3 d = glm::max(hi - lo, 0.0f);
      return d.x * d.y + d.y * d.z + d.z * d.x;
    }
  };

  /// Splits triangles into two groups such that rays take the least estimated time: sum of box area × number of
  /// triangles (surface area heuristic). Candidates are kParts equal steps along the longest axis of the triangles'
  /// centres.
  int build(const std::vector<LitTriangle>& triangles, const std::vector<glm::vec3>& middles, std::size_t first,
            std::size_t end, int depth) {
    constexpr int kParts = 12;
    constexpr int kUnequal = kRayDepth / 2;  // from this depth, halves are equal, so that kRayDepth is enough
    const auto index = static_cast<int>(nodes_.size());
    nodes_.emplace_back();
    Box middle, whole;
    for (std::size_t k = first; k < end; ++k) {
      for (const glm::vec3& c : triangles[order_[k]].corners) whole.grow(c, c);
      middle.grow(middles[order_[k]], middles[order_[k]]);
    }
    const glm::vec3 size = middle.hi - middle.lo;
    const int axis = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
    const auto part_of = [&](std::uint32_t i) {
      const float at = (middles[i][axis] - middle.lo[axis]) / size[axis] * kParts;
      return std::clamp(static_cast<int>(at), 0, kParts - 1);
    };
    std::size_t half = first;
    if (end - first > kLeaf && size[axis] > 0) {
      std::array<Box, kParts> boxes;
      std::array<std::size_t, kParts> counts{};
      for (std::size_t k = first; k < end; ++k) {
        const auto part = static_cast<std::size_t>(part_of(order_[k]));
        ++counts[part];
        for (const glm::vec3& c : triangles[order_[k]].corners) boxes[part].grow(c, c);
      }
      // after[i]: estimated time for the triangles in the steps from i on.
      std::array<float, kParts> after{};
      Box box;
      std::size_t count = 0;
      for (int p = kParts - 1; p > 0; --p) {
        const auto i = static_cast<std::size_t>(p);
        box.grow(boxes[i].lo, boxes[i].hi);
        after[i] = box.area() * static_cast<float>(count += counts[i]);
      }
      float least = std::numeric_limits<float>::max();
      int best = 1;
      box = {};
      count = 0;
      for (int p = 1; p < kParts; ++p) {
        const auto i = static_cast<std::size_t>(p);
        box.grow(boxes[i - 1].lo, boxes[i - 1].hi);
        const float cost = box.area() * static_cast<float>(count += counts[i - 1]) + after[i];
        if (cost < least) least = cost, best = p;
      }
      const auto at = [&](std::size_t k) { return order_.begin() + static_cast<std::ptrdiff_t>(k); };
      half = static_cast<std::size_t>(
          std::partition(at(first), at(end), [&](std::uint32_t i) { return part_of(i) < best; }) - order_.begin());
      if (depth >= kUnequal || half == first || half == end) half = (first + end) / 2;
    }
    RayNode node{whole.lo, static_cast<int>(first), whole.hi, static_cast<int>(end - first)};
    if (half > first) {
      build(triangles, middles, first, half, depth + 1);
      node.next = build(triangles, middles, half, end, depth + 1);
      node.count = 0;
    }
    nodes_[static_cast<std::size_t>(index)] = node;
    return index;
  }

  std::vector<RayNode> nodes_;
  std::vector<std::uint32_t> order_;
  std::vector<RaySurface> surfaces_;
};

glm::vec3 smooth_steps(float from, float to, float x, const glm::vec3& low, const glm::vec3& high) {
  const float t = std::clamp((x - from) / (to - from), 0.0f, 1.0f);
  return glm::mix(low, high, t * t * (3 - 2 * t));
}

}  // namespace

void append_triangles(std::vector<LitTriangle>& triangles, std::span<const MeshUpdate> bricks, const dvec3& origin,
                      const std::array<Look, kMatterCount>& looks) {
  std::array<glm::dvec3, kMatterCount> colors;
  for (std::size_t i = 0; i < looks.size(); ++i) colors[i] = linear_light(looks[i].color);
  for (const MeshUpdate& brick : bricks)
    for (std::size_t i = 0; i + 2 < brick.indices.size(); i += 3) {
      LitTriangle t;
      dvec3 color(0), path(0);
      for (std::size_t k = 0; k < 3; ++k) {
        const Vertex& v = brick.vertices[brick.indices[i + k]];
        t.corners[k] = glm::vec3(origin + dvec3(v.p));
        t.normals[k] = v.n;
        const auto matter = static_cast<std::size_t>(v.tissue[v.second > 0.5f]);
        color += layered_color(painted_color(colors[matter], v.paint), looks[matter].translucency,
                               colors[static_cast<std::size_t>(v.under)], static_cast<double>(v.shows)) /
                 3.0;
        path += free_path(looks, v) / 3.0;
      }
      const Tissue outer = brick.vertices[brick.indices[i]].tissue[0];
      t.color = glm::vec3(color);
      t.film = static_cast<float>(hemispherical_reflectance(looks[static_cast<std::size_t>(outer)]));
      t.free_path = glm::vec3(path);
      t.metal = looks[static_cast<std::size_t>(outer)].metal > 0.5;
      triangles.push_back(t);
    }
}

LightSources sources_of(const Lights& lights) {
  const glm::vec3 up(glm::normalize(lights.up)), window(toward_window(lights));
  const auto ambient = static_cast<float>(lights.ambient);
  LightSources sources;
  sources.room = [up, window, ambient](const glm::vec3& d) {
    return ambient * (smooth_steps(-0.9f, 0.9f, glm::dot(d, up), shared::kRoomFloor, shared::kRoomCeiling) +
                      smooth_steps(0.45f, 1.05f, glm::dot(d, window), glm::vec3(0), shared::kRoomWindow));
  };
  sources.toward_lamp = glm::vec3(glm::normalize(lights.key));
  sources.lamp_half_angle = shared::kLampHalfAngle;
  sources.lamp = shared::kLampColor * static_cast<float>(lights.key_strength / kPi);
  return sources;
}

glm::vec4 light_at(const LightGrid& grid, const dvec3& p, const glm::vec3& n) {
  const glm::vec3 end(grid.size - 1);
  const glm::vec3 q =
      glm::clamp(glm::vec3((p - grid.origin) / grid.spacing) + static_cast<float>(kBegin) * n, glm::vec3(0), end);
  const glm::ivec3 low = glm::min(glm::ivec3(q), glm::max(grid.size - 2, 0)), high = glm::min(low + 1, grid.size - 1);
  const glm::vec3 f = q - glm::vec3(low);
  glm::vec4 sum(0);
  for (int axis = 0; axis < 3; ++axis) {
    const int face = 2 * axis + (n[axis] < 0 ? 1 : 0);
    const auto at = [&](int x, int y, int z) { return grid.faces[grid.index(face, {x, y, z})]; };
    const auto along_z = [&](int x, int y) { return glm::mix(at(x, y, low.z), at(x, y, high.z), f.z); };
    const auto along_y = [&](int x) { return glm::mix(along_z(x, low.y), along_z(x, high.y), f.y); };
    sum += n[axis] * n[axis] * glm::mix(along_y(low.x), along_y(high.x), f.x);
  }
  return sum;
}

glm::vec3 image_direction(const glm::ivec2& node) {
  const glm::vec2 o = 2.0f * glm::vec2(node) / static_cast<float>(LightGrid::kImageSide - 1) - 1.0f;
  glm::vec3 d(o, 1 - std::abs(o.x) - std::abs(o.y));
  if (d.z < 0) {
    const glm::vec2 folded = 1.0f - glm::abs(glm::vec2(o.y, o.x));
    d.x = std::copysign(folded.x, o.x), d.y = std::copysign(folded.y, o.y);
  }
  return glm::normalize(d);
}

glm::vec3 mirrored_at(const LightGrid& grid, const dvec3& p, const glm::vec3& n, const glm::vec3& r) {
  const glm::vec3 end(grid.size - 1);
  const glm::vec3 q =
      glm::clamp(glm::vec3((p - grid.origin) / grid.spacing) + static_cast<float>(kBegin) * n, glm::vec3(0), end);
  const glm::vec3 d = r / (std::abs(r.x) + std::abs(r.y) + std::abs(r.z));
  glm::vec2 o(d);
  if (d.z < 0) {
    const glm::vec2 folded = 1.0f - glm::abs(glm::vec2(d.y, d.x));
    o = {std::copysign(folded.x, d.x), std::copysign(folded.y, d.y)};
  }
  constexpr int kLast = LightGrid::kImageSide - 1;
  const glm::vec2 at = (0.5f + 0.5f * o) * static_cast<float>(kLast);
  const glm::ivec2 node = glm::min(glm::ivec2(at), kLast - 1);
  const glm::ivec3 low = glm::min(glm::ivec3(q), glm::max(grid.size - 2, 0)), high = glm::min(low + 1, grid.size - 1);
  const glm::vec2 f = at - glm::vec2(node);
  const glm::vec3 g = q - glm::vec3(low);
  // Weights of the lower and upper neighbour along each axis.
  const std::array<glm::vec2, 2> u{1.0f - f, f};
  const std::array<glm::vec3, 2> w{1.0f - g, g};
  const std::size_t next = grid.image_index({1, 0}, glm::ivec3(0));  // index step in `images` to the next node along x
  glm::vec3 sum(0);
  for (std::size_t z = 0; z < 2; ++z)
    for (std::size_t y = 0; y < 2; ++y)
      for (std::size_t x = 0; x < 2; ++x) {
        const glm::ivec3 sample(x ? high.x : low.x, y ? high.y : low.y, z ? high.z : low.z);
        for (int v = 0; v < 2; ++v) {
          const glm::vec3* const image = &grid.images[grid.image_index({node.x, node.y + v}, sample)];
          const float row = u[static_cast<std::size_t>(v)].y;
          sum += u[0].x * row * w[x].x * w[y].y * w[z].z * image[0];
          sum += u[1].x * row * w[x].x * w[y].y * w[z].z * image[next];
        }
      }
  return sum;
}

struct LightScene::Impl {
  std::vector<LitTriangle> triangles;
  RayTree tree;
  bool tissue_mirrors;
  std::stop_token stop;
  std::shared_ptr<LightPasses> passes;  // null: the CPU casts the rays
  LightGrid empty;                      // the grid with its origin, spacing and size, before the light is computed
  std::array<glm::vec3, kRays> directions = sphere_directions<kRays>();
  std::array<glm::vec3, kImageRays> image_directions = sphere_directions<kImageRays>();
  struct Sample {
    std::size_t at = 0;   // index of the sample in the grid
    glm::vec3 p{0};       // m, frame W, position from which the sample's rays start
    bool imaged = false;  // the sample also gets rays for LightGrid::images; used only by cast_rays()
  };
  std::vector<Sample> samples;        // those outside bodies
  std::vector<std::uint32_t> imaged;  // indices of the samples for LightGrid::images
  std::vector<std::int32_t> met;      // per sample and ray: index in `used`, kNothing or kBack
  // For each sample in `imaged` and each of its kImageRays rays: index in `used`, kNothing or kBack.
  std::vector<std::int32_t> met_by_images;
  std::vector<std::uint32_t> used;  // indices of the triangles that rays met
  bool tree_on_card = false;        // the passes know the tree

  Impl(std::vector<LitTriangle> given, const BoxInWorld& box, double spacing, bool tissue_mirrors_too,
       std::stop_token stop_of, std::shared_ptr<LightPasses> passes_of)
      : triangles(std::move(given)),
        tree(triangles),
        tissue_mirrors(tissue_mirrors_too),
        stop(std::move(stop_of)),
        passes(std::move(passes_of)) {
    empty.origin = box.lo;
    empty.spacing = spacing;
    empty.size = glm::ivec3(glm::ceil((box.hi - box.lo) / spacing)) + 1;
    cache::read_or_make(
        kRayTables, key_of(box), [&](cache::Parts& file) { return parts_of(file); }, [&] { cast_rays(); });
  }

  template <class Each>
  void share(std::size_t count, const Each& each) const {
    in_parallel(count, each, stop, 32, background_threads());
  }

  /// Computes the key of the rays in the cache.
  std::uint64_t key_of(const BoxInWorld& box) const {
    Sha256 key;
    cache::add_build(key);
    for (const LitTriangle& t : triangles) key.bytes(t.corners.data(), sizeof t.corners);
    for (int axis = 0; axis < 3; ++axis) key.add(box.lo[axis]), key.add(box.hi[axis]);
    key.add(empty.spacing);
    key.add(tissue_mirrors);
    key.add(passes && !passes->failed());
    return key.key();
  }
  /// Writes or reads what cast_rays() computes.
  bool parts_of(cache::Parts& file) {
    const auto sample = [&](Sample& s) { return file.value(s.at) && file.value(s.p); };
    return file.list(samples, sample) && file.values(imaged) && file.values(met) && file.values(met_by_images) &&
           file.values(used);
  }

  glm::vec3 place(const glm::ivec3& i) const { return glm::vec3(empty.origin + empty.spacing * dvec3(i)); }

  /// Finds the samples that the shaders may read. They look up light at kBegin grid spacings outside the surface along
  /// its normal. So all samples around each triangle's box, moved by this distance, are needed.
  void find_samples() {
    constexpr std::uint8_t kWanted = 1, kImage = 2;
    std::vector<std::uint8_t> wanted(empty.samples(), 0);
    for (const LitTriangle& t : triangles) {
      const auto& c = t.corners;
      const glm::vec3 origin(empty.origin);
      const float scale = static_cast<float>(1 / empty.spacing);
      const glm::vec3 normal = glm::cross(c[1] - c[0], c[2] - c[0]);
      const float length = glm::length(normal);
      if (!(length > 0)) continue;
      const glm::vec3 ahead = static_cast<float>(kBegin) * normal / length;
      const glm::vec3 lo = (glm::min(glm::min(c[0], c[1]), c[2]) - origin) * scale + ahead - kCurved;
      const glm::vec3 hi = (glm::max(glm::max(c[0], c[1]), c[2]) - origin) * scale + ahead + kCurved;
      const glm::ivec3 first = glm::max(glm::ivec3(glm::floor(lo)), 0);
      const glm::ivec3 last = glm::min(glm::ivec3(glm::ceil(hi)), empty.size - 1);
      for_each_voxel_between(first, last, [&](const glm::ivec3& i) {
        wanted[empty.index(0, i)] |= t.metal || tissue_mirrors ? kWanted | kImage : kWanted;
      });
    }
    // In the open space between bodies, where the tool is drawn, light changes slowly. So only each `step`-th sample
    // there is computed; fill() interpolates the others.
    const auto mark = [&](int step, std::uint8_t as) {
      for (int x = 0; x < empty.size.x; x += step)
        for (int y = 0; y < empty.size.y; y += step)
          for (int z = 0; z < empty.size.z; z += step) wanted[empty.index(0, {x, y, z})] |= as;
    };
    mark(kOpenStep, kWanted);
    mark(kImageStep, kImage);
    for_each_voxel(empty.size, [&](const glm::ivec3& i) {
      const std::size_t at = empty.index(0, i);
      if (wanted[at]) samples.push_back({at, place(i), (wanted[at] & kImage) != 0});
    });
  }

  /// Casts a ray from each start in each direction. `any`: as in body_rays.h.
  std::vector<RayHit> cast(std::span<const glm::vec3> starts, std::span<const glm::vec3> rays, bool any = false) {
    std::vector<RayHit> hits(starts.size() * rays.size(), {kNothing, kMissed});
    if (hits.empty() || triangles.empty()) return hits;
    const auto on_card = [&](LightPasses& card) {
      if (!std::exchange(tree_on_card, true)) {
        std::ranges::copy(tree.nodes(), card.memory(LightPasses::kNodes, tree.nodes().size()).begin());
        std::ranges::copy(tree.surfaces(), card.memory(LightPasses::kSurfaces, tree.surfaces().size()).begin());
      }
      card.cast(starts, rays, any, hits, stop);
    };
    if (passes && passes->attempt(on_card)) return hits;
    share(starts.size(), [&](std::size_t s) {
      for (std::size_t r = 0; r < rays.size(); ++r)
        hits[s * rays.size() + r] = tree.rays().first_hit(starts[s], rays[r], any);
    });
    return hits;
  }
  std::vector<glm::vec3> starts_of_samples() const {
    std::vector<glm::vec3> starts;
    std::ranges::transform(samples, std::back_inserter(starts), &Sample::p);
    return starts;
  }

  /// If a sample is inside a body, and the nearest surface is less than 1.75 grid spacings away, its rays start just
  /// outside this surface. Removes samples deeper inside. Every fourth ray tells whether a sample is inside a body.
  void leave_bodies() {
    constexpr std::size_t kFew = kRays / 4;
    std::array<glm::vec3, kFew> few;
    for (std::size_t r = 0; r < kFew; ++r) few[r] = directions[4 * r];
    const std::vector<RayHit> hits = cast(starts_of_samples(), few);
    std::size_t kept = 0;
    for (std::size_t s = 0; s < samples.size(); ++s) {
      int backs = 0;
      float nearest = static_cast<float>(1.75 * empty.spacing);
      glm::vec3 out(0);
      for (std::size_t r = 0; r < kFew; ++r) {
        const RayHit& hit = hits[s * kFew + r];
        if (hit.met != kBack) continue;
        ++backs;
        if (hit.distance < nearest) nearest = hit.distance, out = few[r] * (hit.distance + 3 * kMargin);
      }
      if (backs > kInside * kFew && out == glm::vec3(0)) continue;
      samples[kept] = samples[s];
      if (backs > kInside * kFew) samples[kept].p += out;
      ++kept;
    }
    samples.resize(kept);
  }
  void cast_rays() {
    samples.clear(), imaged.clear(), met.clear(), met_by_images.clear(), used.clear();
    find_samples();
    leave_bodies();
    const std::vector<RayHit> hits = cast(starts_of_samples(), directions);
    std::vector<glm::vec3> image_starts;
    std::size_t kept = 0;
    for (std::size_t s = 0; s < samples.size(); ++s) {
      const std::span rays = std::span(hits).subspan(s * kRays, kRays);
      if (static_cast<double>(std::ranges::count(rays, kBack, &RayHit::met)) > kInside * kRays) continue;
      std::ranges::transform(rays, std::back_inserter(met), &RayHit::met);
      if (samples[s].imaged) {
        imaged.push_back(static_cast<std::uint32_t>(kept));
        image_starts.push_back(samples[s].p);
      }
      samples[kept++] = samples[s];
    }
    samples.resize(kept);
    std::ranges::transform(cast(image_starts, image_directions), std::back_inserter(met_by_images), &RayHit::met);
    // Gives the triangles that rays met the numbers 0, 1, 2 …, and stores these numbers instead of indices.
    std::vector<std::int32_t> number(triangles.size(), kNothing);
    const auto renumber = [&](std::int32_t& m) {
      if (m < 0) return;
      std::int32_t& n = number[static_cast<std::size_t>(m)];
      if (n == kNothing) {
        n = static_cast<std::int32_t>(used.size());
        used.push_back(static_cast<std::uint32_t>(m));
      }
      m = n;
    };
    std::ranges::for_each(met, renumber);
    std::ranges::for_each(met_by_images, renumber);
  }

  /// Returns the visible fraction of the lamp at each start.
  std::vector<float> lamp_seen(std::span<const glm::vec3> starts, const LightSources& sources) {
    const glm::vec3 l = sources.toward_lamp, side = std::abs(l.x) < 0.8f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    const glm::vec3 a = glm::normalize(glm::cross(side, l)), b = glm::cross(l, a);
    std::array<glm::vec3, kLampRays> rays;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const float r = sources.lamp_half_angle * std::sqrt((static_cast<float>(i) + 0.5f) / kLampRays);
      const float turn = 2.39996323f * static_cast<float>(i);
      rays[i] = glm::normalize(l + r * (std::cos(turn) * a + std::sin(turn) * b));
    }
    const std::vector<RayHit> hits = cast(starts, rays, true);
    std::vector<float> seen(starts.size(), 0);
    for (std::size_t i = 0; i < hits.size(); ++i)
      if (hits[i].met == kNothing) seen[i / kLampRays] += 1.0f / kLampRays;
    return seen;
  }

  /// Gives samples without light the mean light of neighbours with light, layer by layer, until all have light.
  /// `mean(i, neighbours)`: sets sample i to the mean of these samples.
  template <class Mean>
  void fill(std::vector<std::uint8_t> known, const Mean& mean) const {
    std::vector<glm::ivec3> missing, next, neighbours;
    for_each_voxel(empty.size, [&](const glm::ivec3& i) {
      if (!known[empty.index(0, i)]) missing.push_back(i);
    });
    while (!missing.empty()) {
      next.clear();
      std::vector<std::size_t> found;
      for (const glm::ivec3& i : missing) {
        neighbours.clear();
        for (const glm::vec3& face : kFaces) {
          const glm::ivec3 j = i + glm::ivec3(face);
          if (in_grid(j, empty.size) && known[empty.index(0, j)]) neighbours.push_back(j);
        }
        if (neighbours.empty()) {
          next.push_back(i);
          continue;
        }
        mean(i, neighbours);
        found.push_back(empty.index(0, i));
      }
      if (found.empty()) return;  // no sample has light
      for (const std::size_t at : found) known[at] = 1;
      std::swap(missing, next);
    }
  }

  LightGrid light(const LightSources& sources, int bounces) {
    LightGrid grid = empty;
    grid.faces.assign(LightGrid::kFaces * grid.samples(), glm::vec4(0));

    std::vector<glm::vec3> direct(used.size()), radiance(used.size()), middles(used.size()), normals(used.size());
    std::vector<std::size_t> facing;  // indices in `used` of the triangles that face the lamp
    std::vector<glm::vec3> starts;
    for (std::size_t i = 0; i < used.size(); ++i) {
      const LitTriangle& t = triangles[used[i]];
      const glm::vec3 n = glm::cross(t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]);
      const float length = glm::length(n);
      normals[i] = length > 0 ? n / length : glm::vec3(0);
      middles[i] = (t.corners[0] + t.corners[1] + t.corners[2]) / 3.0f;
      if (!(glm::dot(normals[i], sources.toward_lamp) > 0)) continue;
      facing.push_back(i);
      starts.push_back(middles[i] + kMargin * normals[i]);
    }
    const std::vector<float> lit = lamp_seen(starts, sources);
    for (std::size_t k = 0; k < facing.size(); ++k)
      direct[facing[k]] = glm::dot(normals[facing[k]], sources.toward_lamp) * lit[k] * sources.lamp;

    // Weight of each ray in the light of a surface that faces +x, -x, +y, -y, +z or -z.
    std::array<std::array<float, kRays>, LightGrid::kFaces> weights;
    for (std::size_t f = 0; f < LightGrid::kFaces; ++f) {
      float sum = 0;
      for (std::size_t r = 0; r < kRays; ++r) sum += weights[f][r] = std::max(glm::dot(directions[r], kFaces[f]), 0.0f);
      for (float& w : weights[f]) w /= sum;
    }
    std::array<glm::vec3, kRays> outside;
    for (std::size_t r = 0; r < kRays; ++r) outside[r] = sources.room(directions[r]);

    std::vector<std::uint8_t> known(grid.samples(), 0);
    for (const Sample& s : samples) known[s.at] = 1;
    const std::vector<float> lamp = lamp_seen(starts_of_samples(), sources);
    const std::size_t stride = grid.samples();
    for (int bounce = 0; bounce <= bounces; ++bounce) {
      if (bounce > 0)
        share(used.size(), [&](std::size_t i) {
          const glm::vec3 arrives = glm::vec3(light_at(grid, dvec3(middles[i]), normals[i]));
          radiance[i] = triangles[used[i]].reflected(direct[i], arrives);
        });
      share(samples.size(), [&](std::size_t s) {
        std::array<glm::vec3, LightGrid::kFaces> sums{};
        std::array<float, LightGrid::kFaces> seen{};  // sum of the weights of rays that did not meet a back
        for (std::size_t r = 0; r < kRays; ++r) {
          const std::int32_t m = met[s * kRays + r];
          if (m == kBack) continue;
          const glm::vec3& light = m == kNothing ? outside[r] : radiance[static_cast<std::size_t>(m)];
          for (std::size_t f = 0; f < LightGrid::kFaces; ++f)
            sums[f] += weights[f][r] * light, seen[f] += weights[f][r];
        }
        for (std::size_t f = 0; f < LightGrid::kFaces; ++f)
          grid.faces[f * stride + samples[s].at] = glm::vec4(sums[f] / std::max(seen[f], kMinSeen), lamp[s]);
      });
      fill(known, [&](const glm::ivec3& i, std::span<const glm::ivec3> neighbours) {
        for (int f = 0; f < LightGrid::kFaces; ++f) {
          glm::vec4 sum(0);
          for (const glm::ivec3& j : neighbours) sum += grid.faces[grid.index(f, j)];
          grid.faces[grid.index(f, i)] = sum / static_cast<float>(neighbours.size());
        }
      });
    }
    mirror(grid, radiance, sources);
    return grid;
  }

  /// Computes the light that surfaces mirror (LightGrid::images). `radiance`: radiance of the triangles in `used`.
  void mirror(LightGrid& grid, std::span<const glm::vec3> radiance, const LightSources& sources) const {
    constexpr int kSide = LightGrid::kImageSide;
    grid.images.assign(grid.samples() * kSide * kSide, glm::vec3(0));
    // For each direction of the image map (image_direction()): the rays with weight in this direction.
    struct Part {
      std::size_t ray;
      float weight;
    };
    constexpr float kMinWeight = 0.01f;
    std::array<std::vector<Part>, kSide * kSide> parts;
    std::array<glm::vec3, kImageRays> outside;
    for (std::size_t r = 0; r < kImageRays; ++r) {
      outside[r] = sources.room(image_directions[r]);
      for (int n = 0; n < kSide * kSide; ++n) {
        const float near = glm::dot(image_directions[r], image_direction({n % kSide, n / kSide}));
        const float weight = std::pow(std::max(near, 0.0f), kImageLobe);
        if (weight > kMinWeight) parts[static_cast<std::size_t>(n)].push_back({r, weight});
      }
    }
    std::vector<std::uint8_t> known(grid.samples(), 0);
    for (const std::uint32_t s : imaged) known[samples[s].at] = 1;
    const auto place_of = [&](std::size_t at) {
      const auto z = static_cast<std::size_t>(grid.size.z), y = static_cast<std::size_t>(grid.size.y);
      return glm::ivec3(at / (z * y), at / z % y, at % z);
    };
    share(imaged.size(), [&](std::size_t i) {
      const Sample& sample = samples[imaged[i]];
      for (int n = 0; n < kSide * kSide; ++n) {
        glm::vec3 sum(0);
        float seen = 0, all = 0;
        for (const Part& part : parts[static_cast<std::size_t>(n)]) {
          all += part.weight;
          const std::int32_t m = met_by_images[i * kImageRays + part.ray];
          if (m == kBack) continue;
          sum += part.weight * (m == kNothing ? outside[part.ray] : radiance[static_cast<std::size_t>(m)]);
          seen += part.weight;
        }
        grid.images[grid.image_index({n % kSide, n / kSide}, place_of(sample.at))] =
            sum / std::max(seen, kMinSeen * all);
      }
    });
    fill(known, [&](const glm::ivec3& i, std::span<const glm::ivec3> neighbours) {
      for (int n = 0; n < kSide * kSide; ++n) {
        const glm::ivec2 node(n % kSide, n / kSide);
        glm::vec3 sum(0);
        for (const glm::ivec3& j : neighbours) sum += grid.images[grid.image_index(node, j)];
        grid.images[grid.image_index(node, i)] = sum / static_cast<float>(neighbours.size());
      }
    });
  }
};

LightScene::LightScene(std::vector<LitTriangle> triangles, const BoxInWorld& box, double spacing, bool tissue_mirrors,
                       std::stop_token stop, std::shared_ptr<LightPasses> passes)
    : impl_(std::make_unique<Impl>(std::move(triangles), box, spacing, tissue_mirrors, std::move(stop),
                                   std::move(passes))) {}
LightScene::~LightScene() = default;
LightScene::LightScene(LightScene&&) noexcept = default;
LightScene& LightScene::operator=(LightScene&&) noexcept = default;

LightGrid LightScene::light(const LightSources& sources, int bounces) const {
  return impl_->light(sources, bounces);
}

}  // namespace typodont::render
