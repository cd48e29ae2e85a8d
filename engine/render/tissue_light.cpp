#include "engine/render/tissue_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <memory>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "engine/base/cached_result.h"
#include "engine/base/in_parallel.h"
#include "engine/base/voxels.h"
#include "engine/render/light_passes.h"
#include "engine/render/sphere_directions.h"

namespace typodont::render {

namespace {

constexpr int kBounces = 6;  // number of diffuse reflections between surfaces inside the box
// Cells nearer to a surface than this (m) store their distance to it. Every path through a surface must meet such a
// cell, so the limit is at least kMinBand cell edges.
constexpr float kBand = 0.525e-3f, kMinBand = 1.75f;
// Cells nearer to the surface than this, in cell edges, belong to the surface and compute its light.
constexpr float kNear = 0.6f;
constexpr std::uint8_t kMaxClear = 8;  // a ray crosses at most this many blocks in one step
constexpr float kSame = 0.15f;  // in cell edges; a cell keeps its light if its distance to the surface changes by less
constexpr float kTravels = 1.2e-3f;  // m; light is computed again up to this distance from a changed surface
constexpr float kSmooth = 0.45f;     // width of the smoothing (standard deviation) in free paths of green light
constexpr int kGathered = 4;         // cost of a cell's random walks divided by the cost of gathering light in a cell
constexpr cache::Shelf kLights{"tissue_light", ".light", 64u << 20};

/// Unit directions that are distributed evenly over the sphere; w: free paths in units of the mean free path. A random
/// walk chooses the direction and the length of each step from this table at random.
const std::array<glm::vec4, shared::kStepTable>& step_table() {
  static const auto table = [] {
    std::array<glm::vec4, shared::kStepTable> steps;
    const auto directions = sphere_directions<shared::kStepTable>();
    for (std::size_t i = 0; i < steps.size(); ++i)
      steps[i] = glm::vec4(directions[i],
                           -std::log1p(-(static_cast<double>(i) + 0.5) / static_cast<double>(shared::kStepTable)));
    return steps;
  }();
  return table;
}

/// Returns the point of a triangle that is nearest to p, as weights of its corners (Ericson 2005, Real-Time Collision
/// Detection, 5.1.5).
glm::vec3 nearest_in(const std::array<glm::vec3, 3>& c, const glm::vec3& p) {
  const glm::vec3 ab = c[1] - c[0], ac = c[2] - c[0], ap = p - c[0], bp = p - c[1], cp = p - c[2];
  const float d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap), d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp),
              d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const float w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  const float all = va + vb + vc;
  return all > 0 ? glm::vec3(va, vb, vc) / all : glm::vec3(1, 0, 0);
}

/// The piece of surface that belongs to a cell.
struct Element {
  std::size_t cell = 0;
  glm::vec3 p{0}, n{0, 0, 1};  // m, frame W: point of the surface that is nearest to the cell, and its normal
  glm::vec3 color{0};          // diffuse reflectance of the tissue
  glm::vec3 albedo{0};         // probability that light survives one scattering
  glm::vec3 path{0};           // m, mean free path for red, green and blue light; 0: opaque
  float film = 0;              // fraction of diffuse light that the surface mirrors
  // Irradiance divided by π: direct light of the lamp, and all light.
  glm::vec3 lamp{0}, arrives{0};
  glm::vec4 leaves{0};  // value of the cell in the grid (TissueLightGrid::values)
};

using glm::ceil, glm::clamp, glm::cross, glm::dot, glm::exp, glm::floor, glm::greaterThanEqual, glm::ivec2, glm::ivec3,
    glm::log, glm::max, glm::min, glm::normalize, glm::pow, glm::uint, glm::uvec3, glm::vec2, glm::vec3, glm::vec4,
    std::abs, std::cos, std::sin, std::sqrt;
using shared::kFree, shared::kLampRays, shared::kLongestRay, shared::kMaxSteps, shared::kMinStep, shared::kMostWeight,
    shared::kNone, shared::kRandomOfRays, shared::kRandomOfWalks, shared::kSearched, shared::kStepShift,
    shared::kSurfaceRays;
constexpr int kBlock = shared::kBlock;

/// The rays and walks on the CPU, and the memory that they read and write.
struct TissueRays {
  shared::LightPass pass;
  const float* distances;
  const std::int32_t* element_of;
  const std::uint8_t* in_hard;
  const std::uint8_t* clear;
  const Element* elements;
  const vec4* steps;
  const LightGrid* far;
  shared::LightArrival* arrivals;
  std::int32_t* met;

  int element_in(int cell) const { return element_of[cell]; }
  bool hard(int cell) const { return in_hard[cell]; }
  int clear_of(int block) const { return clear[block]; }
  dvec3 place(const vec3& q) const { return dvec3(vec3(pass.origin) + pass.origin.w * q); }
  float far_lamp(const vec3& q, const vec3& n) const { return light_at(*far, place(q), n).w; }
  vec3 far_light(const vec3& q, const vec3& r) const { return mirrored_at(*far, place(q), r, r); }

#define INOUT(type) type&
#include "engine/render/tissue_rays.h"
#undef INOUT
  /// Inverse of packed_weight().
  static vec3 weight_of(int packed) {
    return vec3(uvec3(uint(packed), uint(packed) >> 10u, uint(packed) >> 20u) & 1023u) * (kMostWeight / 1023.0f);
  }
};

}  // namespace

float scattering_albedo(float reflectance) {
  const float r = std::clamp(reflectance, 0.0f, 0.999f);
  const float s = (1 - r) * (1 + r * (-1.43085f + r * (2.09657f + r * (-2.44179f + r * (1.74075f - r * 0.53311f)))));
  return 1 - s * s;
}

struct TissueLight::Impl {
  TissueLightGrid grid;
  float spacing = 0, band = 0;  // m; band: cells nearer than this to a surface store their distance to the surface
  int walks = 0;                // number of random walks from each cell at a surface
  glm::vec3 origin{0};
  std::array<Look, kMatterCount> looks;
  std::stop_token stop;
  LightSources sources;
  LightGrid far;
  std::shared_ptr<LightPasses> passes;  // null: the CPU follows rays and walks
  // What the passes do not know yet: the lights from outside; cells. `room`: number of elements for which they have
  // memory.
  bool far_changed = false;
  CellBox changed_cells;
  std::size_t room = 0;

  // Distance of each cell to a surface, m, negative inside a body, limited to `band`. `fixed`: static bodies; `tooth`:
  // working tooth; `lit_tooth`: working tooth when its cells last got light; `distance`: all bodies at that time.
  std::vector<float> fixed, tooth, lit_tooth, distance;
  // Distance of each cell to the hard and soft static bodies, and to the body of add_fixed(). `in_hard`: the cell
  // belongs to a hard body, also where it overlaps a soft one.
  std::vector<float> hard_fixed, soft_fixed, added;
  std::vector<std::uint8_t> in_hard;
  // For each cell: nearest triangle of the static bodies; null if it is farther than `band`.
  std::vector<const LitTriangle*> fixed_nearest;
  // For each block of kBlock³ cells: distance in blocks to the nearest block with a cell nearer than `band` to a
  // surface, at most kMaxClear.
  std::vector<std::uint8_t> clear;
  std::vector<std::uint8_t> near_surface;  // for each block: 1 if a cell is nearer than `band` to a surface
  glm::ivec3 blocks{0};
  std::vector<std::int32_t> element_of;  // for each cell: its index in `elements`, or kNone
  std::vector<Element> elements;
  std::vector<std::int32_t> unused;  // indices of `elements` that no cell uses any more
  std::deque<std::vector<LitTriangle>> fixed_triangles;
  struct Brick {
    CellBox box;  // the cells whose distance may depend on the brick's triangles
    std::vector<LitTriangle> triangles;
  };
  std::unordered_map<std::uint64_t, Brick> bricks;  // bricks of the working tooth
  bool lit = false;                                 // true after the first call of light()
  std::vector<CellBox> moved;                       // boxes of cells whose distances must be computed again
  // Cells whose light must be computed again, in order: new parts of the surface; cells whose arriving light changed;
  // cells whose arriving light is known, but not the leaving light.
  std::vector<std::size_t> fresh;
  std::deque<std::size_t> gathering, walking;
  static constexpr std::uint8_t kForLight = 1, kForWalk = 2, kListed = 3;
  std::vector<std::uint8_t> waits;  // for each cell: number of the list in which it waits; 0: none

  std::size_t index(const glm::ivec3& i) const { return voxel_index(i, grid.size); }
  glm::ivec3 cell_of(std::size_t at) const { return voxel_at(at, grid.size); }
  glm::vec3 place(const glm::ivec3& i) const { return origin + spacing * glm::vec3(i); }
  template <class Each>
  static void each_cell(const CellBox& box, const Each& each) {
    for_each_voxel_between(box.lo, box.hi, each);
  }
  CellBox all() const { return {glm::ivec3(0), grid.size - 1}; }
  CellBox clipped(const CellBox& box) const {
    return {glm::max(box.lo, glm::ivec3(0)), glm::min(box.hi, grid.size - 1)};
  }
  CellBox grown(const CellBox& box, int by) const {
    return {glm::max(box.lo - by, glm::ivec3(0)), glm::min(box.hi + by, grid.size - 1)};
  }

  template <class Each>
  void share(std::size_t count, const Each& each, std::size_t block = 32) const {
    in_parallel(count, each, stop, block, background_threads());
  }

  Impl(const BoxInWorld& box, double cell, int walks_of, const std::array<Look, kMatterCount>& looks_of,
       std::stop_token stop_of)
      : walks(walks_of), looks(looks_of), stop(std::move(stop_of)) {
    grid.origin = box.lo, grid.spacing = cell;
    grid.size = glm::ivec3(glm::ceil((box.hi - box.lo) / cell)) + 1;
    spacing = static_cast<float>(cell), band = std::max(kBand, kMinBand * spacing), origin = glm::vec3(box.lo);
    const std::size_t cells = index(grid.size - 1) + 1;
    fixed.assign(cells, band);
    tooth = lit_tooth = distance = hard_fixed = soft_fixed = fixed;
    added = fixed;
    in_hard.assign(cells, 0);
    fixed_nearest.assign(cells, nullptr);
    known.assign(cells, 0);
    blocks = (grid.size + kBlock - 1) / kBlock;
    near_surface.assign(static_cast<std::size_t>(blocks.x * blocks.y * blocks.z), 0);
    clear.assign(near_surface.size(), kMaxClear);
    element_of.assign(cells, kNone);
    nearest.assign(cells, nullptr);
    waits.assign(cells, 0);
    grid.values.assign(cells, glm::vec4(0));
  }

  /// Returns the box of the cells that are less than `band` away from the triangle.
  CellBox reach(const LitTriangle& t) const {
    const auto& c = t.corners;
    const glm::vec3 low = (glm::min(glm::min(c[0], c[1]), c[2]) - origin - band) / spacing,
                    high = (glm::max(glm::max(c[0], c[1]), c[2]) - origin + band) / spacing;
    const glm::vec3 last(grid.size - 1);
    return {glm::ivec3(glm::ceil(glm::clamp(low, glm::vec3(0), last + 1.0f))),
            glm::ivec3(glm::floor(glm::clamp(high, glm::vec3(-1), last)))};
  }

  // For each cell of the box of the last measure(): nearest triangle or null; how the distance's sign was found.
  std::vector<const LitTriangle*> nearest;
  static constexpr std::uint8_t kUnknown = 0, kByTriangle = 1, kByRegion = 2;
  std::vector<std::uint8_t> known;

  /// Computes distances of the cells in `box` to the surface of one body, and the nearest triangles. A cell farther
  /// than `band` from all triangles gets its sign from its neighbours.
  void measure(std::span<const std::span<const LitTriangle>> parts, const CellBox& box, std::vector<float>& result) {
    each_cell(box, [&](const glm::ivec3& i) {
      nearest[index(i)] = nullptr, result[index(i)] = band, known[index(i)] = kUnknown;
    });
    // Number of cells along x in a slab. Each slab belongs to one thread.
    constexpr int kLayers = 8;
    const auto slab_of = [&](int x) { return static_cast<std::size_t>((x - box.lo.x) / kLayers); };
    std::vector<std::vector<const LitTriangle*>> slabs(slab_of(box.hi.x) + 1);
    for (const std::span<const LitTriangle> triangles : parts)
      for (const LitTriangle& t : triangles) {
        const CellBox near = reach(t);
        if (!near.meets(box)) continue;
        const std::size_t last = slab_of(std::min(near.hi.x, box.hi.x));
        for (std::size_t slab = slab_of(std::max(near.lo.x, box.lo.x)); slab <= last; ++slab) slabs[slab].push_back(&t);
      }
    const auto measure_slab = [&](std::size_t slab) {
      CellBox layers = box;
      layers.lo.x += static_cast<int>(slab) * kLayers;
      layers.hi.x = std::min(layers.lo.x + kLayers - 1, box.hi.x);
      for (const LitTriangle* const t : slabs[slab]) measure_triangle(*t, layers, result);
    };
    if (slabs.size() > 4)
      share(slabs.size(), measure_slab, 1);
    else
      for (std::size_t slab = 0; slab < slabs.size(); ++slab) measure_slab(slab);
    each_cell(box, [&](const glm::ivec3& i) {
      const std::size_t at = index(i);
      const LitTriangle* const t = nearest[at];
      if (!t) return;
      const glm::vec3 q = place(i), w = nearest_in(t->corners, q);
      const glm::vec3 n = w.x * t->normals[0] + w.y * t->normals[1] + w.z * t->normals[2];
      if (glm::dot(n, q - (w.x * t->corners[0] + w.y * t->corners[1] + w.z * t->corners[2])) < 0)
        result[at] = -result[at];
      known[at] = kByTriangle;
    });
    // Cells far from the surface form connected regions. The cells beside a region decide by majority whether it is
    // inside, because at a sharp edge the sign of a single cell can be wrong. The search goes on from the last found
    // cell, so it follows lines of cells that are neighbours in memory.
    std::vector<std::size_t> region;
    std::vector<glm::ivec3> waiting;
    each_cell(box, [&](const glm::ivec3& first) {
      if (known[index(first)] != kUnknown) return;
      int inside = 0;
      region.clear();
      const auto add = [&](const glm::ivec3& i) {
        known[index(i)] = kByRegion;
        region.push_back(index(i));
        waiting.push_back(i);
      };
      add(first);
      while (!waiting.empty()) {
        const glm::ivec3 i = waiting.back();
        waiting.pop_back();
        for (int side = 0; side < 6; ++side) {
          glm::ivec3 j = i;
          j[side / 2] += side % 2 ? 1 : -1;
          if (!in_grid(j, grid.size)) continue;
          const std::size_t at = index(j);
          if (!box.meets({j, j}) || known[at] == kByTriangle)
            inside += result[at] < 0 ? 1 : -1;
          else if (known[at] == kUnknown)
            add(j);
        }
      }
      for (const std::size_t at : region) result[at] = inside > 0 ? -band : band;
    });
  }

  /// Computes the distances of the cells in `box` to one triangle, where it is nearer than all earlier triangles.
  void measure_triangle(const LitTriangle& t, const CellBox& box, std::vector<float>& result) {
    const CellBox near = reach(t);
    const CellBox cells{glm::max(near.lo, box.lo), glm::min(near.hi, box.hi)};
    const glm::vec3 normal = glm::cross(t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]);
    const float length = glm::length(normal);
    if (cells.empty() || !(length > 0)) return;
    // The triangle is inside a sphere around `middle`. If this sphere is farther from a cell than the nearest triangle
    // found so far, the cell needs no exact distance.
    constexpr float kRounding = 1e-7f;  // m, more than the rounding error of positions up to 0.1 m
    const glm::vec3 middle = (t.corners[0] + t.corners[1] + t.corners[2]) / 3.0f;
    float radius = 0;
    for (const glm::vec3& c : t.corners) radius = std::max(radius, glm::distance(c, middle) + kRounding);
    const glm::vec3 unit = normal / length;
    each_cell(cells, [&](const glm::ivec3& i) {
      const glm::vec3 q = place(i), apart = q - middle;
      const std::size_t at = index(i);
      const float farthest = result[at] + radius;
      if (glm::dot(apart, apart) >= farthest * farthest) return;
      if (std::abs(glm::dot(unit, q - t.corners[0])) >= result[at]) return;
      const glm::vec3 w = nearest_in(t.corners, q);
      const float d = glm::length(q - (w.x * t.corners[0] + w.y * t.corners[1] + w.z * t.corners[2]));
      if (d < result[at]) result[at] = d, nearest[at] = &t;
    });
  }

  Element element_for(std::size_t at, const LitTriangle& t) const {
    const glm::vec3 w = nearest_in(t.corners, place(cell_of(at)));
    Element e;
    e.cell = at;
    e.p = w.x * t.corners[0] + w.y * t.corners[1] + w.z * t.corners[2];
    e.n = glm::normalize(w.x * t.normals[0] + w.y * t.normals[1] + w.z * t.normals[2]);
    e.color = t.color, e.path = t.free_path, e.film = t.film;
    for (int c = 0; c < 3; ++c) e.albedo[c] = scattering_albedo(e.color[c]);
    return e;
  }
  void set_element(std::size_t at, const Element& e) {
    std::int32_t& own = element_of[at];
    if (own == kNone && !unused.empty()) {
      own = unused.back();
      unused.pop_back();
    } else if (own == kNone) {
      own = static_cast<std::int32_t>(elements.size());
      elements.emplace_back();
    }
    Element& set = elements[static_cast<std::size_t>(own)];
    const glm::vec4 leaves = set.leaves;  // the old light stays until the new light is computed
    set = e;
    set.leaves = leaves;
  }
  void remove_element(std::size_t at) {
    if (element_of[at] == kNone) return;
    unused.push_back(element_of[at]);
    element_of[at] = kNone;
  }

  void add_fixed(std::vector<LitTriangle> triangles, bool hard) {
    fixed_triangles.push_back(std::move(triangles));
    const std::array<std::span<const LitTriangle>, 1> parts{fixed_triangles.back()};
    CellBox reached;
    for (const LitTriangle& t : fixed_triangles.back()) reached.take(reach(t));
    const CellBox box = clipped(reached);
    if (box.empty()) return;
    measure(parts, box, added);
    std::vector<float>& kind = hard ? hard_fixed : soft_fixed;
    each_cell(box, [&](const glm::ivec3& i) {
      const std::size_t at = index(i);
      kind[at] = std::min(kind[at], added[at]);
      if (added[at] < fixed[at]) {
        fixed[at] = added[at];
        fixed_nearest[at] = nearest[at];
        choose(at, nullptr);
      }
      find_kind(at);
      added[at] = band;
    });
  }
  /// Stores in `in_hard` whether a cell belongs to a hard body.
  void find_kind(std::size_t at) {
    const float hard = std::min(lit_tooth[at], hard_fixed[at]);
    in_hard[at] = hard < 0 || hard < soft_fixed[at];
  }
  /// Chooses the nearest surface of a cell, on the working tooth or a static body. `triangle`: nearest triangle of the
  /// working tooth, or null.
  void choose(std::size_t at, const LitTriangle* triangle) {
    const bool of_tooth = lit_tooth[at] < fixed[at];
    distance[at] = of_tooth ? lit_tooth[at] : fixed[at];
    const LitTriangle* const own = of_tooth ? triangle : fixed_nearest[at];
    if (own && std::abs(distance[at]) <= kNear * spacing)
      set_element(at, element_for(at, *own));
    else
      remove_element(at);
  }

  void put(std::span<const MeshUpdate> updates, const dvec3& body_origin) {
    for (const MeshUpdate& update : updates) {
      Brick& brick = bricks[update.brick];
      CellBox box = brick.box;
      brick = {};
      append_triangles(brick.triangles, {&update, 1}, body_origin, looks);
      for (const LitTriangle& t : brick.triangles) brick.box.take(reach(t));
      box.take(brick.box);
      if (brick.triangles.empty()) bricks.erase(update.brick);
      box = clipped(box);
      if (!box.empty()) moved.push_back(box);
    }
  }

  /// Computes the distance to the working tooth again where its bricks were replaced. Cells whose distance changed wait
  /// for new light. So do all cells nearby, because their light comes from the same tissue.
  void follow_tooth() {
    constexpr std::size_t kMaxBoxes = 64;  // with more boxes, measuring one box around all boxes is faster
    if (moved.size() > kMaxBoxes) {
      CellBox whole;
      for (const CellBox& box : moved) whole.take(box);
      moved.assign(1, whole);
    }
    for (const CellBox& box : joined(moved)) {
      std::vector<std::span<const LitTriangle>> parts;
      for (const auto& [number, brick] : bricks)
        if (brick.box.meets(box)) parts.emplace_back(brick.triangles);
      measure(parts, box, tooth);
    }
    CellBox changed;
    for (const CellBox& box : std::exchange(moved, {})) changed.take(use_distances(box));
    changed_cells.take(changed);
    if (lit && !changed.empty()) find_clear_blocks(changed);
  }
  /// Joins boxes where this saves cells: the boxes of neighbouring bricks overlap.
  static std::vector<CellBox> joined(std::span<const CellBox> boxes) {
    const auto cells = [](const CellBox& box) {
      const glm::ivec3 size = box.hi - box.lo + 1;
      return std::int64_t{size.x} * size.y * size.z;
    };
    std::vector<CellBox> result;
    for (CellBox box : boxes) {
      for (std::size_t i = 0; i < result.size();) {
        CellBox both = box;
        both.take(result[i]);
        if (cells(both) > cells(box) + cells(result[i])) {
          ++i;
          continue;
        }
        box = both;
        result[i] = result.back();
        result.pop_back();
        i = 0;
      }
      result.push_back(box);
    }
    return result;
  }
  /// Takes over the new distances to the working tooth in one box of cells. Returns the box of the cells that changed.
  CellBox use_distances(const CellBox& box) {
    CellBox changed;
    each_cell(box, [&](const glm::ivec3& i) {
      const std::size_t at = index(i);
      if (lit && std::abs(tooth[at] - lit_tooth[at]) < kSame * spacing) return;
      const bool is_new = element_of[at] == kNone;
      lit_tooth[at] = tooth[at];
      choose(at, nearest[at]);
      find_kind(at);
      changed.take({i, i});
      if (lit && is_new && element_of[at] != kNone) fresh.push_back(at);
    });
    if (!lit || changed.empty()) return changed;
    each_cell(grown(changed, static_cast<int>(std::lround(kTravels / spacing))), [&](const glm::ivec3& i) {
      if (element_of[index(i)] != kNone) wait(index(i));
    });
    return changed;
  }
  void wait(std::size_t at) {
    if (std::exchange(waits[at], kForLight) != kForLight) gathering.push_back(at);
  }
  Element* element(std::size_t at) {
    return element_of[at] == kNone ? nullptr : &elements[static_cast<std::size_t>(element_of[at])];
  }

  std::size_t block(const glm::ivec3& b) const { return voxel_index(b, blocks); }
  /// Computes `clear` again, after `distance` has changed in a box of cells.
  void find_clear_blocks(const CellBox& changed) {
    each_cell({changed.lo / kBlock, changed.hi / kBlock}, [&](const glm::ivec3& b) {
      bool near = false;
      each_cell(clipped({kBlock * b, kBlock * b + kBlock - 1}),
                [&](const glm::ivec3& i) { near = near || std::abs(distance[index(i)]) < band; });
      near_surface[block(b)] = near;
    });
    for (std::size_t b = 0; b < clear.size(); ++b) clear[b] = near_surface[b] ? 0 : kMaxClear;
    // The distance in blocks is the largest of the distances along the three axes. So it is found along one axis at a
    // time, in ascending and then in descending order.
    for (int axis = 0; axis < 3; ++axis) {
      for (const int by : {1, -1}) {
        each_cell({glm::ivec3(0), blocks - 1}, [&](glm::ivec3 b) {
          if (by < 0) b = blocks - 1 - b;
          glm::ivec3 before = b;
          before[axis] -= by;
          if (before[axis] < 0 || before[axis] >= blocks[axis]) return;
          std::uint8_t& here = clear[block(b)];
          here = static_cast<std::uint8_t>(std::min(int{here}, clear[block(before)] + 1));
        });
      }
    }
  }
  /// Returns the light that other elements send to an element.
  glm::vec3 from_others(const std::int32_t* met) const {
    glm::vec3 sum(0);
    for (int k = 0; k < kSurfaceRays; ++k) {
      if (met[k] < 0) continue;
      const Element& other = elements[static_cast<std::size_t>(met[k])];
      sum += mirrored_by_film(other.film, other.lamp, other.arrives - other.lamp) +
             (1 - other.film) * other.color * glm::vec3(other.leaves);
    }
    return sum / static_cast<float>(kSurfaceRays);
  }
  /// Returns the light that leaves an element (Element::leaves).
  glm::vec4 leaving(const Element& e, const ivec2* exits) const {
    glm::vec3 sum(0), lamp(0);
    if (e.path == glm::vec3(0)) {
      sum = e.arrives, lamp = e.lamp;
    } else {
      for (int k = 0; k < walks; ++k) {
        if (exits[k].x < 0) continue;
        const Element& at = elements[static_cast<std::size_t>(exits[k].x)];
        const vec3 weight = TissueRays::weight_of(exits[k].y);
        sum += weight * at.arrives, lamp += weight * at.lamp;
      }
      const glm::vec3 whole = static_cast<float>(walks) * glm::max(e.color, glm::vec3(1e-3f));
      sum /= whole, lamp /= whole;
    }
    const glm::vec3 luma(0.2126f, 0.7152f, 0.0722f);
    const float all = glm::dot(luma, sum);
    return {sum, all > 0 ? std::min(glm::dot(luma, lamp) / all, 1.0f) : 0.0f};
  }

  void light(const LightSources& new_sources, const LightGrid& new_far) {
    sources = new_sources, far = new_far, far_changed = true;
    follow_tooth();
    if (!lit) {
      find_clear_blocks(all());
      changed_cells = all();
    }
    lit = true;
    std::fill(waits.begin(), waits.end(), std::uint8_t{0});
    fresh.clear(), gathering.clear(), walking.clear();
    cache::read_or_make(
        kLights, key_of_light(),
        [&](cache::Parts& file) {  // what compute() computes
          return std::ranges::all_of(elements, [&](Element& e) {
            return file.value(e.lamp) && file.value(e.arrives) && file.value(e.leaves);
          });
        },
        [&] { compute(); });
    TracedLight nothing;
    trace({}, {}, nothing,
          true);  // if the light was stored: uploads the grid now, not in the frame after the first cut
    std::vector<std::size_t> every(element_of.size());
    std::iota(every.begin(), every.end(), std::size_t{0});
    fill(every);
  }
  void compute() {
    const std::size_t count = elements.size();
    const auto of_each = static_cast<std::size_t>(walks);
    std::vector<std::int32_t> every(count);
    std::iota(every.begin(), every.end(), 0);
    TracedLight found;
    trace(every, every, found, true);
    std::vector<glm::vec3> next(count);
    for (std::size_t i = 0; i < count; ++i) take(elements[i], found.arrivals[i]);
    for (int bounce = 0; bounce <= kBounces; ++bounce) {
      share(count, [&](std::size_t i) { elements[i].leaves = leaving(elements[i], &found.exits[i * of_each]); });
      if (bounce == kBounces) break;
      share(count, [&](std::size_t i) {
        next[i] = vec3(found.arrivals[i].outer) + from_others(&found.met[i * kSurfaceRays]);
      });
      for (std::size_t i = 0; i < count; ++i) elements[i].arrives = next[i];
    }
  }
  static void take(Element& e, const shared::LightArrival& arrival) {
    e.lamp = vec3(arrival.lamp), e.arrives = vec3(arrival.outer);
  }

  bool on_card() const { return passes && !passes->failed(); }
  /// Casts the rays of the elements `gathered` and follows the walks of the elements `walked`, on the graphics card if
  /// there are passes. `threads`: without passes, uses several threads instead of only the caller's.
  void trace(std::span<const std::int32_t> gathered, std::span<const std::int32_t> walked, TracedLight& found,
             bool threads) {
    const shared::LightPass pass{
        glm::vec4(origin, spacing),
        glm::ivec4(grid.size, walks),
        glm::ivec4(blocks, 0),
        glm::vec4(glm::dvec4((grid.origin - far.origin) / far.spacing, grid.spacing / far.spacing)),
        glm::ivec4(far.size, 0),
        glm::vec4(sources.lamp, band),
        glm::vec4(sources.toward_lamp, sources.lamp_half_angle)};
    const auto on_card = [&](LightPasses& card) {
      upload(card);
      card.trace(pass, gathered, walked, found, stop);
    };
    if (passes && passes->attempt(on_card)) return;
    const auto of_each = static_cast<std::size_t>(walks);
    found.arrivals.resize(gathered.size());
    found.met.resize(gathered.size() * kSurfaceRays);
    found.exits.resize(walked.size() * of_each);
    TissueRays rays{pass,
                    distance.data(),
                    element_of.data(),
                    in_hard.data(),
                    clear.data(),
                    elements.data(),
                    step_table().data(),
                    &far,
                    found.arrivals.data(),
                    found.met.data()};
    const auto loop = [&](std::size_t count, const auto& each) {
      in_parallel(count, each, stop, 4, threads ? background_threads() : 1);
    };
    loop(gathered.size(), [&](std::size_t i) { rays.gather(gathered[i], static_cast<int>(i)); });
    loop(walked.size(), [&](std::size_t i) {
      for (int k = 0; k < walks; ++k) found.exits[i * of_each + static_cast<std::size_t>(k)] = rays.walk(walked[i], k);
    });
  }
  /// Copies what changed since the last call to the graphics card.
  void upload(LightPasses& card) {
    if (far_changed) {
      std::ranges::copy(step_table(), card.memory(LightPasses::kSteps, step_table().size()).begin());
      std::ranges::copy(far.faces, card.memory(LightPasses::kFaces, far.faces.size()).begin());
      std::ranges::copy(far.images, card.memory(LightPasses::kImages, far.images.size()).begin());
      far_changed = false;
    }
    if (changed_cells.empty()) return;
    const std::span distances = card.memory(LightPasses::kDistances, distance.size());
    const std::span cells = card.memory(LightPasses::kCells, distance.size());
    for (std::size_t at = index(changed_cells.lo); at <= index(changed_cells.hi); ++at) {
      distances[at] = distance[at];
      cells[at] = static_cast<std::uint32_t>(element_of[at] + 1) << 1 | in_hard[at];
    }
    std::ranges::copy(clear, card.memory(LightPasses::kBlocks, clear.size()).begin());
    const bool all_again = elements.size() > room;
    if (all_again) room = elements.size() + elements.size() / 4;
    const auto put = [to = card.memory(LightPasses::kElements, room)](std::size_t i, const Element& e) {
      to[i] = {vec4(e.p, 0), vec4(e.n, 0), vec4(e.albedo, 0), vec4(e.path, 0), glm::ivec4(static_cast<int>(e.cell))};
    };
    if (all_again) {
      for (std::size_t i = 0; i < elements.size(); ++i) put(i, elements[i]);
    } else {
      each_cell(changed_cells, [&](const glm::ivec3& i) {
        if (const Element* const e = element(index(i))) put(static_cast<std::size_t>(element_of[index(i)]), *e);
      });
    }
    changed_cells = {};
  }
  /// Computes the key of the light in the cache, from all values on which the light depends.
  std::uint64_t key_of_light() const {
    Sha256 key;
    cache::add_build(key);
    key.add(spacing);
    key.add(walks);
    key.add(on_card());
    key.bytes(distance.data(), distance.size() * sizeof distance[0]);
    for (const Element& e : elements) {
      key.add(e.cell);
      key.add(e.film);
      for (const glm::vec3& v : {e.p, e.n, e.color, e.path}) key.bytes(&v, sizeof v);
    }
    key.bytes(far.faces.data(), far.faces.size() * sizeof far.faces[0]);
    key.bytes(far.images.data(), far.images.size() * sizeof far.images[0]);
    for (const glm::vec3& v : {sources.toward_lamp, sources.lamp}) key.bytes(&v, sizeof v);
    key.add(sources.lamp_half_angle);
    return key.key();
  }
  CellBox refresh(int most) {
    if (!lit) return {};
    follow_tooth();
    // New parts of the surface get their light at once. For other cells, the arriving light is computed first, because
    // the light that leaves a cell is computed from the light that arrives at other cells.
    std::vector<std::int32_t> gathered, walked;
    for (const std::size_t at : fresh)
      if (element_of[at] != kNone) gathered.push_back(element_of[at]);
    fresh.clear();
    walked = gathered;
    const std::size_t fresh_count = gathered.size();
    for (int left = kGathered * most; left > 0 && !gathering.empty(); gathering.pop_front()) {
      const std::size_t at = gathering.front();
      waits[at] = element_of[at] != kNone ? kForWalk : 0;
      if (element_of[at] == kNone) continue;
      gathered.push_back(element_of[at]);
      walking.push_back(at);
      --left;
    }
    for (int left = most; left > 0 && !walking.empty(); walking.pop_front()) {
      const std::size_t at = walking.front();
      if (waits[at] == kForWalk) waits[at] = 0;
      if (element_of[at] == kNone) continue;
      walked.push_back(element_of[at]);
      --left;
    }
    if (gathered.empty() && walked.empty()) return {};
    TracedLight found;
    trace(gathered, walked, found, false);
    const auto gather_now = [&](std::size_t i) {
      Element& e = elements[static_cast<std::size_t>(gathered[i])];
      take(e, found.arrivals[i]);
      e.arrives += from_others(&found.met[i * kSurfaceRays]);
    };
    const auto walk_now = [&](std::size_t i) {
      Element& e = elements[static_cast<std::size_t>(walked[i])];
      e.leaves = leaving(e, &found.exits[i * static_cast<std::size_t>(walks)]);
    };
    for (std::size_t i = 0; i < fresh_count; ++i) gather_now(i);
    for (std::size_t i = 0; i < fresh_count; ++i) walk_now(i);
    for (std::size_t i = fresh_count; i < gathered.size(); ++i) gather_now(i);
    for (std::size_t i = fresh_count; i < walked.size(); ++i) walk_now(i);
    // Smoothing and fill() change cells up to three cells away from each cell in `walked`.
    std::vector<std::size_t> near;
    CellBox changed;
    for (const std::int32_t at : walked) {
      const glm::ivec3 i = cell_of(elements[static_cast<std::size_t>(at)].cell);
      const CellBox around = grown({i, i}, 3);
      changed.take(around);
      each_cell(around, [&](const glm::ivec3& j) {
        if (std::exchange(known[index(j)], kListed) != kListed) near.push_back(index(j));
      });
    }
    for (const std::size_t at : near) known[at] = kUnknown;
    fill(near);
    return changed;
  }

  /// Returns the light of an element, averaged over neighbours on the same side of the body to reduce
  /// noise. Width of the mean: a part of the free path in tissue; on opaque bodies, only the nearest cells.
  glm::vec4 smoothed(const Element& e) const {
    const bool opaque = e.path == glm::vec3(0);
    const float width = std::clamp(kSmooth * e.path.y / spacing, 0.6f, 1.6f);  // cells
    constexpr int reach = 2;
    glm::vec4 sum(0);
    float weights = 0;
    each_cell(grown(CellBox{cell_of(e.cell), cell_of(e.cell)}, reach), [&](const glm::ivec3& i) {
      const std::int32_t at = element_of[index(i)];
      if (at == kNone) return;
      const Element& other = elements[static_cast<std::size_t>(at)];
      const float facing = glm::dot(e.n, other.n);
      if (facing <= 0 || (other.path == glm::vec3(0)) != opaque) return;
      const glm::vec3 apart = (other.p - e.p) / spacing;
      const float alike = opaque ? 1 : std::min(e.path.y, other.path.y) / std::max(e.path.y, other.path.y);
      const float w = facing * facing * alike * alike * std::exp(-0.5f * glm::dot(apart, apart) / (width * width));
      sum += w * other.leaves;
      weights += w;
    });
    return sum / weights;
  }

  /// Writes the light of these cells into the grid. Cells beside them get the mean of their neighbours, because shaders
  /// interpolate.
  void fill(std::span<const std::size_t> cells) {
    const auto smooth = [&](std::size_t at) {
      const Element* const e = element(at);
      grid.values[at] = e ? smoothed(*e) : glm::vec4(0);
    };
    constexpr std::size_t kMany = 10'000;  // number of cells from which several threads are faster
    if (cells.size() > kMany)
      share(cells.size(), [&](std::size_t k) { smooth(cells[k]); });
    else
      for (const std::size_t at : cells) smooth(at);
    for (const std::size_t at : cells) {
      if (element(at) || std::abs(distance[at]) >= band) continue;
      glm::vec4 sum(0);
      int count = 0;
      const glm::ivec3 i = cell_of(at);
      each_cell(grown({i, i}, 1), [&](const glm::ivec3& j) {
        if (element_of[index(j)] == kNone) return;
        sum += grid.values[index(j)];
        ++count;
      });
      if (count > 0) grid.values[at] = sum / static_cast<float>(count);
    }
  }
};

TissueLight::TissueLight(const BoxInWorld& box, double spacing, int walks, const std::array<Look, kMatterCount>& looks,
                         std::stop_token stop)
    : impl_(std::make_unique<Impl>(box, spacing, walks, looks, std::move(stop))) {}
TissueLight::~TissueLight() = default;
TissueLight::TissueLight(TissueLight&&) noexcept = default;
TissueLight& TissueLight::operator=(TissueLight&&) noexcept = default;

void TissueLight::add_fixed(std::vector<LitTriangle> triangles, bool hard) {
  impl_->add_fixed(std::move(triangles), hard);
}
void TissueLight::put(std::span<const MeshUpdate> bricks, const dvec3& origin) {
  impl_->put(bricks, origin);
}
void TissueLight::use(std::shared_ptr<LightPasses> passes) {
  impl_->passes = std::move(passes);
}
bool TissueLight::on_card() const {
  return impl_->on_card();
}
void TissueLight::light(const LightSources& sources, const LightGrid& far) {
  impl_->light(sources, far);
}
CellBox TissueLight::refresh(int most) {
  return impl_->refresh(most);
}
const TissueLightGrid& TissueLight::grid() const {
  return impl_->grid;
}

}  // namespace typodont::render
