#include "engine/render/tissue_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <filesystem>
#include <limits>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "engine/base/cached_result.h"
#include "engine/base/in_parallel.h"
#include "engine/base/split_mix.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "engine/render/sphere_directions.h"

namespace typodont::render {

namespace {

constexpr int kRays = 24;     // number of rays from each cell at a surface, which find the light of other surfaces
constexpr int kLampRays = 6;  // number of rays from each cell to the lamp
constexpr int kBounces = 6;   // number of diffuse reflections between surfaces inside the box
// Cells nearer to a surface than this (m) store their distance to it. Every path through a surface must meet such a
// cell, so the limit is at least kMinBand cell edges.
constexpr float kBand = 0.525e-3f, kMinBand = 1.75f;
// Cells nearer to the surface than this, in cell edges, belong to the surface and compute its light.
constexpr float kNear = 0.6f;
// Rays cross empty space in steps of whole blocks. kBlock: cells along a block's edge; kMaxClear: largest number of
// blocks in one step.
constexpr int kBlock = 8;
constexpr std::uint8_t kMaxClear = 8;
// Distance up to which the surface at the end of a ray or walk is searched, m.
constexpr float kSearched = 0.3e-3f;
constexpr float kMinStep = 45e-6f;    // m, smallest step of rays and random walks
constexpr float kLongestRay = 8e-3f;  // m, longest ray; farther away, the light of the LightGrid is used
constexpr float kSame = 0.15f;  // in cell edges; a cell keeps its light if its distance to the surface changes by less
constexpr float kTravels = 1.2e-3f;  // m; light is computed again up to this distance from a changed surface
constexpr float kSmooth = 0.45f;     // width of the smoothing (standard deviation) in free paths of green light
constexpr int kGathered = 4;         // cost of a cell's random walks divided by the cost of gathering light in a cell
// Used instead of the index of an element. kNone: there is no element; kFree: the ray leaves the box.
constexpr std::int32_t kNone = -1, kFree = -2;
constexpr int kMaxSteps = 200;  // largest number of steps of a random walk; a walk rarely needs 30

constexpr cache::Shelf kLights{"tissue_light", ".light", 64u << 20};

/// Unit directions that are distributed evenly over the sphere, and free paths in units of the mean free path. A random
/// walk chooses the direction and the length of each step from these tables at random.
struct StepTables {
  static constexpr std::size_t kCount = 2048;
  std::array<glm::vec3, kCount> directions = sphere_directions<kCount>();
  std::array<float, kCount> lengths;
  StepTables() {
    for (std::size_t i = 0; i < kCount; ++i)
      lengths[i] = static_cast<float>(-std::log1p(-(static_cast<double>(i) + 0.5) / kCount));
  }
};
const StepTables& step_tables() {
  static const StepTables tables;
  return tables;
}

/// Returns a number from 0 to 1, without 1.
float fraction_of(std::uint64_t bits) {
  return static_cast<float>(bits >> 40) * 0x1p-24f;
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

/// Returns two unit vectors that are perpendicular to n and to each other.
std::array<glm::vec3, 2> beside(const glm::vec3& n) {
  const glm::vec3 a = glm::normalize(glm::cross(std::abs(n.x) < 0.8f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0), n));
  return {a, glm::cross(n, a)};
}

/// Returns a direction around n with a density that is proportional to its cosine. u, v: 0..1
glm::vec3 cosine_direction(const glm::vec3& n, float u, float v) {
  const auto [a, b] = beside(n);
  const float r = std::sqrt(u), turn = static_cast<float>(2 * kPi) * v;
  return r * std::cos(turn) * a + r * std::sin(turn) * b + std::sqrt(std::max(1 - u, 0.0f)) * n;
}

/// Returns point i of a sequence that fills the unit square evenly (Roberts 2018, R2), moved by (u, v).
glm::vec2 spread(int i, float u, float v) {
  const glm::vec2 p(u + 0.7548776662f * static_cast<float>(i), v + 0.5698402910f * static_cast<float>(i));
  return p - glm::floor(p);
}

/// The piece of surface that belongs to a cell.
struct Element {
  std::size_t cell = 0;
  glm::vec3 p{0}, n{0, 0, 1};  // m, frame W: point of the surface that is nearest to the cell, and its normal
  glm::vec3 color{0};          // diffuse reflectance of the tissue
  glm::vec3 path{0};           // m, mean free path for red, green and blue light; 0: opaque
  float film = 0;              // fraction of diffuse light that the surface mirrors
  // Irradiance divided by π: direct light of the lamp, and all light.
  glm::vec3 lamp{0}, arrives{0};
  glm::vec4 leaves{0};  // value of the cell in the grid (TissueLightGrid::values)
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

  std::size_t index(const glm::ivec3& i) const {
    return (static_cast<std::size_t>(i.x) * static_cast<std::size_t>(grid.size.y) + static_cast<std::size_t>(i.y)) *
               static_cast<std::size_t>(grid.size.z) +
           static_cast<std::size_t>(i.z);
  }
  glm::ivec3 cell_of(std::size_t at) const {
    const auto z = static_cast<std::size_t>(grid.size.z), y = static_cast<std::size_t>(grid.size.y);
    return {static_cast<int>(at / (z * y)), static_cast<int>(at / z % y), static_cast<int>(at % z)};
  }
  glm::vec3 place(const glm::ivec3& i) const { return origin + spacing * glm::vec3(i); }
  template <class Each>
  static void each_cell(const CellBox& box, const Each& each) {
    for_each_voxel_between(box.lo, box.hi, [&](int x, int y, int z) { each(glm::ivec3(x, y, z)); });
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
    in_parallel(count, each, stop, block);
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

  // For each cell of the box of the last measure(): nearest triangle or null; whether the distance's sign is known.
  std::vector<const LitTriangle*> nearest;
  std::vector<std::uint8_t> known;

  /// Computes distances of the cells in `box` to the surface of one body, and the nearest triangles. A cell farther
  /// than `band` from all triangles gets its sign from its neighbours.
  void measure(std::span<const std::span<const LitTriangle>> parts, const CellBox& box, std::vector<float>& result) {
    each_cell(box,
              [&](const glm::ivec3& i) { nearest[index(i)] = nullptr, result[index(i)] = band, known[index(i)] = 0; });
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
      known[at] = 1;
    });
    // Cells far from the surface form connected regions. The cells beside a region decide by majority whether it is
    // inside, because at a sharp edge the sign of a single cell can be wrong.
    std::vector<std::size_t> part;
    each_cell(box, [&](const glm::ivec3& first) {
      if (known[index(first)]) return;
      int inside = 0;
      part.assign(1, index(first));
      known[index(first)] = 1;
      for (std::size_t k = 0; k < part.size(); ++k)
        for (int side = 0; side < 6; ++side) {
          glm::ivec3 j = cell_of(part[k]);
          j[side / 2] += side % 2 ? 1 : -1;
          if (glm::any(glm::lessThan(j, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(j, grid.size))) continue;
          const std::size_t at = index(j);
          const bool in_box = glm::all(glm::lessThanEqual(box.lo, j)) && glm::all(glm::lessThanEqual(j, box.hi));
          if (!in_box || nearest[at])
            inside += result[at] < 0 ? 1 : -1;
          else if (std::exchange(known[at], std::uint8_t{1}) == 0)
            part.push_back(at);
        }
      for (const std::size_t at : part) result[at] = inside > 0 ? -band : band;
    });
  }

  /// Computes the distances of the cells in `box` to one triangle, where it is nearer than all earlier triangles.
  void measure_triangle(const LitTriangle& t, const CellBox& box, std::vector<float>& result) {
    const CellBox near = reach(t);
    const CellBox cells{glm::max(near.lo, box.lo), glm::min(near.hi, box.hi)};
    const glm::vec3 normal = glm::cross(t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]);
    const float length = glm::length(normal);
    if (cells.empty() || !(length > 0)) return;
    const glm::vec3 unit = normal / length;
    each_cell(cells, [&](const glm::ivec3& i) {
      const glm::vec3 q = place(i);
      const std::size_t at = index(i);
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
    CellBox changed;
    for (const CellBox& box : std::exchange(moved, {})) changed.take(follow_tooth(box));
    if (lit && !changed.empty()) find_clear_blocks(changed);
  }
  /// Computes the distances to the working tooth in one box of cells. Returns the box of the cells that changed.
  CellBox follow_tooth(const CellBox& box) {
    std::vector<std::span<const LitTriangle>> parts;
    for (const auto& [number, brick] : bricks)
      if (brick.box.meets(box)) parts.emplace_back(brick.triangles);
    measure(parts, box, tooth);
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

  /// Returns the cell that contains the point q (in cells), limited to 0 … `last`. After limiting, q is not negative,
  /// so the conversion rounds down; this is faster than std::floor.
  static glm::ivec3 cell_below(const glm::vec3& q, const glm::ivec3& last) {
    return glm::ivec3(glm::min(glm::max(glm::vec3(0), q), glm::vec3(last)));
  }
  /// Returns the cell with the centre nearest to q (cells).
  glm::ivec3 cell_nearest(const glm::vec3& q) const {
    const glm::vec3 inside = glm::min(glm::max(glm::vec3(0), q), glm::vec3(grid.size - 1));
    const glm::ivec3 below(inside);
    return below + glm::ivec3(glm::greaterThanEqual(inside - glm::vec3(below), glm::vec3(0.5f)));
  }
  /// Returns the distance (m) to the nearest surface at a point in cells, interpolated between the cells.
  float distance_at(const glm::vec3& q) const {
    const glm::ivec3 low = cell_below(q, grid.size - 2);
    const glm::vec3 f = glm::clamp(q - glm::vec3(low), 0.0f, 1.0f);
    const float* const at = distance.data() + index(low);
    const std::size_t dx = static_cast<std::size_t>(grid.size.y) * static_cast<std::size_t>(grid.size.z),
                      dy = static_cast<std::size_t>(grid.size.z);
    const auto along_z = [&](std::size_t i) { return at[i] + f.z * (at[i + 1] - at[i]); };
    const float a = along_z(0), b = along_z(dy), c = along_z(dx), d = along_z(dx + dy);
    const float ab = a + f.y * (b - a), cd = c + f.y * (d - c);
    return ab + f.x * (cd - ab);
  }
  std::size_t block(const glm::ivec3& b) const {
    return static_cast<std::size_t>((b.x * blocks.y + b.y) * blocks.z + b.z);
  }
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
  bool in_box(const glm::vec3& q) const {
    return q.x >= 0 && q.y >= 0 && q.z >= 0 && q.x <= static_cast<float>(grid.size.x - 1) &&
           q.y <= static_cast<float>(grid.size.y - 1) && q.z <= static_cast<float>(grid.size.z - 1);
  }
  /// Returns the element at a point of the surface (in cells), or kNone if no surface is within the larger of
  /// kSearched and a cell edge.
  std::int32_t element_at(const glm::vec3& q) const {
    const glm::vec3 p = origin + spacing * q;
    const float reach = std::max(kSearched, spacing);
    const auto squared_distance = [&](std::int32_t other) {
      const glm::vec3 apart = elements[static_cast<std::size_t>(other)].p - p;
      return glm::dot(apart, apart);
    };
    const auto is_near = [&](std::int32_t other) { return other >= 0 && squared_distance(other) < reach * reach; };
    const std::int32_t found = element_of[index(cell_nearest(q))];
    if (is_near(found)) return found;
    const glm::ivec3 low = cell_below(q, grid.size - 2);
    for (int k = 0; k < 8; ++k) {
      const std::int32_t other = element_of[index(low + glm::ivec3(k & 1, (k >> 1) & 1, k >> 2))];
      if (is_near(other)) return other;
    }
    // The sign of some cells is wrong, for example beside a folded triangle. A ray or walk that ends there ends at the
    // nearest surface instead, so that its light is not lost.
    std::int32_t best = kNone;
    const int most = static_cast<int>(std::ceil(kSearched / spacing));
    for (int around = 1; best == kNone && around <= most; ++around) {
      float least = reach * reach;
      each_cell(grown({low, low + 1}, around), [&](const glm::ivec3& i) {
        const std::int32_t other = element_of[index(i)];
        if (other < 0) return;
        if (const float d = squared_distance(other); d < least) least = d, best = other;
      });
    }
    return best;
  }
  /// Returns the distance (m) from a point of the box (in cells) along a direction to the border of the box.
  float way_to_border(const glm::vec3& q, const glm::vec3& direction) const {
    float ray_length = std::numeric_limits<float>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      if (direction[axis] == 0) continue;
      const float border = direction[axis] > 0 ? static_cast<float>(grid.size[axis] - 1) : 0;
      ray_length = std::min(ray_length, (border - q[axis]) / direction[axis]);
    }
    return std::max(ray_length, 0.0f) * spacing;
  }
  /// Follows a ray outside the bodies. `q`: start in cells; on return, the end. Returns the element that the ray meets,
  /// or kFree if it meets none within `longest` (m) or leaves the box.
  std::int32_t follow_outside(glm::vec3& q, const glm::vec3& direction, float longest) const {
    const float all = std::min(longest, way_to_border(q, direction));
    const glm::vec3 start = q, along = direction / spacing;
    for (float ray_length = 0; ray_length < all;) {
      const float d = distance_at(q);
      if (d <= 0) return element_at(q);
      float step = std::max(d, kMinStep);
      if (d >= band) {
        const int far_blocks = clear[block(glm::ivec3(q) / kBlock)];
        step = std::max(step, static_cast<float>(kBlock * (far_blocks - 1)) * spacing);
      }
      ray_length += step;
      q = start + std::min(ray_length, all) * along;
    }
    return kFree;
  }

  /// End of a random walk: the element where it leaves the tissue, and its weight for each colour. Weights have ten
  /// bits each, because a large grid has tens of millions of walks.
  struct Exit {
    static constexpr float kMost = 3, kSteps = 1023;  // largest weight, and the number of steps up to it
    std::int32_t element = kNone;
    std::uint32_t packed = 0;
    void set(const glm::vec3& weight) {
      const glm::uvec3 steps(glm::min(weight, kMost) * (kSteps / kMost) + 0.5f);
      packed = steps.x | steps.y << 10 | steps.z << 20;
    }
    glm::vec3 weight() const {
      return glm::vec3(glm::uvec3(packed, packed >> 10, packed >> 20) & 1023u) * (kMost / kSteps);
    }
  };
  /// Follows one random walk from an element until it leaves the tissue. `first`, `length`: direction and length (mean
  /// free paths) of the first step. One colour determines the steps; weights correct the others (Veach & Guibas 1995).
  Exit walk(const Element& e, const glm::vec3& albedo, int leading, const glm::vec3& first, float length,
            SplitMix64& random) const {
    const StepTables& tables = step_tables();
    const float survives = std::max({albedo.x, albedo.y, albedo.z});
    glm::vec3 q = (e.p - e.n * (0.01f * spacing) - origin) / spacing, direction = first;
    float d = distance_at(q), total = 0;  // m; d: distance to the surface; total: length of the walk so far
    bool astray = false;  // true in a region that counts as outside, but has no surface nearby: its sign is wrong
    for (int scattered = 0; scattered < kMaxSteps; ++scattered) {
      const float left = length * e.path[leading];
      // The first step leaves the surface, where the interpolated distance may not be negative yet. A walk that is
      // outside after a step has left the tissue before it could be scattered.
      std::int32_t met = kNone;
      float done = 0;
      for (;;) {
        if (d < 0) {
          astray = false;
        } else if (!astray && (scattered > 0 || done > 0.25f * spacing)) {
          met = element_at(q);
          if (met != kNone) break;
          astray = true;
        }
        if (done >= left) break;
        const float step = std::min(std::max(-d, kMinStep), left - done);
        q += direction * (step / spacing);
        done += step;
        if (!in_box(q)) return {};
        d = distance_at(q);
      }
      total += done;
      if (met != kNone) {
        if (in_hard[elements[static_cast<std::size_t>(met)].cell] != in_hard[e.cell]) return {};
        Exit exit{met};
        // Probability density of this walk for each colour, relative to the largest one. Computed from logarithms,
        // because densities of long walks may exceed the range of float.
        glm::vec3 density;
        for (int c = 0; c < 3; ++c)
          density[c] = static_cast<float>(scattered) * std::log(e.path[leading] / e.path[c]) +
                       (1 / e.path[leading] - 1 / e.path[c]) * total;
        density = glm::exp(density - std::max({density.x, density.y, density.z}));
        const float mean = (density.x + density.y + density.z) / 3;
        exit.set(glm::pow(albedo / survives, glm::vec3(static_cast<float>(scattered))) * density / mean);
        return exit;
      }
      // Light from a tooth into the gum counts as lost, because the gum absorbs most of it. Light from the gum into a
      // tooth counts only if it returns to the gum.
      if (in_hard[e.cell]) {
        const std::size_t cell = index(cell_nearest(q));
        if (!in_hard[cell] && distance[cell] < 0) return {};
      }
      const std::uint64_t bits = random.next();
      if (fraction_of(bits) >= survives) return {};
      direction = tables.directions[bits % StepTables::kCount];
      length = tables.lengths[(bits >> 12) % StepTables::kCount];
    }
    return {};
  }

  /// Computes the light that arrives at an element from the lamp and from outside the box. `met`: receives the kRays
  /// elements that the rays to other surfaces meet, or kFree or kNone.
  glm::vec3 gather(Element& e, std::int32_t* met) const {
    SplitMix64 random{e.cell};
    const float u = fraction_of(random.next()), v = fraction_of(random.next());
    const glm::vec3 start = (e.p + e.n * (0.35f * spacing) - origin) / spacing;
    const float facing = glm::dot(e.n, sources.toward_lamp);
    e.lamp = glm::vec3(0);
    if (facing > 0) {
      const auto [a, b] = beside(sources.toward_lamp);
      float seen = 0;
      for (int k = 0; k < kLampRays; ++k) {
        const glm::vec2 s = spread(k, u, v);
        const float r = sources.lamp_half_angle * std::sqrt(s.x), turn = static_cast<float>(2 * kPi) * s.y;
        const glm::vec3 d = glm::normalize(sources.toward_lamp + r * (std::cos(turn) * a + std::sin(turn) * b));
        glm::vec3 q = start;
        if (follow_outside(q, d, 1.0f) == kFree) seen += light_at(far, dvec3(origin + spacing * q), d).w;
      }
      e.lamp = sources.lamp * (facing * seen / kLampRays);
    }
    glm::vec3 distant(0);
    for (int k = 0; k < kRays; ++k) {
      const glm::vec2 s = spread(k, u, v);
      const glm::vec3 d = cosine_direction(e.n, s.x, s.y);
      glm::vec3 q = start;
      met[k] = follow_outside(q, d, kLongestRay);
      if (met[k] == kFree) distant += mirrored_at(far, dvec3(origin + spacing * q), d, d);
    }
    return e.lamp + distant / float{kRays};
  }
  /// Returns the light that other elements send to an element.
  glm::vec3 from_others(const std::int32_t* met) const {
    glm::vec3 sum(0);
    for (int k = 0; k < kRays; ++k) {
      if (met[k] < 0) continue;
      const Element& other = elements[static_cast<std::size_t>(met[k])];
      sum += mirrored_by_film(other.film, other.lamp, other.arrives - other.lamp) +
             (1 - other.film) * other.color * glm::vec3(other.leaves);
    }
    return sum / float{kRays};
  }
  void walk_all(const Element& e, Exit* exits) const {
    SplitMix64 random{~e.cell};
    glm::vec3 albedo;
    for (int c = 0; c < 3; ++c) albedo[c] = scattering_albedo(e.color[c]);
    const float u = fraction_of(random.next()), v = fraction_of(random.next());
    for (int k = 0; k < walks; ++k) {
      const glm::vec2 s = spread(k, u, v);
      const float length =
          -std::log1p(-(static_cast<float>(k) + fraction_of(random.next())) / (static_cast<float>(walks) + 1e-4f));
      exits[k] = walk(e, albedo, k % 3, cosine_direction(-e.n, s.x, s.y), length, random);
    }
  }
  /// Returns the light that leaves an element (Element::leaves).
  glm::vec4 leaving(const Element& e, const Exit* exits) const {
    glm::vec3 sum(0), lamp(0);
    if (e.path == glm::vec3(0)) {
      sum = e.arrives, lamp = e.lamp;
    } else {
      for (int k = 0; k < walks; ++k) {
        if (exits[k].element < 0) continue;
        const Element& at = elements[static_cast<std::size_t>(exits[k].element)];
        const glm::vec3 weight = exits[k].weight();
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
    sources = new_sources, far = new_far;
    follow_tooth();
    if (!lit) find_clear_blocks(all());
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
    std::vector<std::size_t> every(element_of.size());
    std::iota(every.begin(), every.end(), std::size_t{0});
    fill(every);
  }
  void compute() {
    const std::size_t count = elements.size();
    std::vector<std::int32_t> met(count * kRays);
    const auto of_each = static_cast<std::size_t>(walks);
    std::vector<Exit> exits(count * of_each);
    std::vector<glm::vec3> outer(count), next(count);
    share(count, [&](std::size_t i) {
      outer[i] = elements[i].arrives = gather(elements[i], &met[i * kRays]);
      if (elements[i].path != glm::vec3(0)) walk_all(elements[i], &exits[i * of_each]);
    });
    for (int bounce = 0; bounce <= kBounces; ++bounce) {
      share(count, [&](std::size_t i) { elements[i].leaves = leaving(elements[i], &exits[i * of_each]); });
      if (bounce == kBounces) break;
      share(count, [&](std::size_t i) { next[i] = outer[i] + from_others(&met[i * kRays]); });
      for (std::size_t i = 0; i < count; ++i) elements[i].arrives = next[i];
    }
  }
  /// Computes the key of the light in the cache, from all values on which the light depends.
  std::uint64_t key_of_light() const {
    Sha256 key;
    cache::add_build(key);
    key.add(spacing);
    key.add(walks);
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
    std::vector<std::size_t> walked;
    std::array<std::int32_t, kRays> met;
    std::vector<Exit> exits(static_cast<std::size_t>(walks));
    const auto gather_now = [&](Element& e) {
      e.arrives = gather(e, met.data());
      e.arrives += from_others(met.data());
    };
    const auto walk_now = [&](Element& e) {
      if (e.path != glm::vec3(0)) walk_all(e, exits.data());
      e.leaves = leaving(e, exits.data());
      walked.push_back(e.cell);
    };
    // New parts of the surface get their light at once. For other cells, the arriving light is computed first, because
    // the light that leaves a cell is computed from the light that arrives at other cells.
    for (const std::size_t at : fresh)
      if (Element* const e = element(at)) gather_now(*e);
    for (const std::size_t at : fresh)
      if (Element* const e = element(at)) walk_now(*e);
    fresh.clear();
    for (int left = kGathered * most; left > 0 && !gathering.empty(); gathering.pop_front()) {
      const std::size_t at = gathering.front();
      Element* const e = element(at);
      waits[at] = e ? kForWalk : 0;
      if (!e) continue;
      gather_now(*e);
      walking.push_back(at);
      --left;
    }
    for (int left = most; left > 0 && !walking.empty(); walking.pop_front()) {
      const std::size_t at = walking.front();
      Element* const e = element(at);
      if (waits[at] == kForWalk) waits[at] = 0;
      if (!e) continue;
      walk_now(*e);
      --left;
    }
    // Smoothing and fill() change cells up to three cells away from each cell in `walked`.
    std::vector<std::size_t> near;
    CellBox changed;
    for (const std::size_t at : walked) {
      const glm::ivec3 i = cell_of(at);
      const CellBox around = grown({i, i}, 3);
      changed.take(around);
      each_cell(around, [&](const glm::ivec3& j) {
        if (std::exchange(known[index(j)], kListed) != kListed) near.push_back(index(j));
      });
    }
    for (const std::size_t at : near) known[at] = 0;
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
