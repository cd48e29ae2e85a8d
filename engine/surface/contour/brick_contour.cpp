#include "engine/surface/contour/brick_contour.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "engine/surface/contour/cell_shapes.h"
#include "engine/surface/contour/crossing.h"
#include "engine/surface/contour/moments.h"
#include "engine/surface/contour/plane_fit.h"

namespace typodont::surface {
namespace {

constexpr int kCells = FieldBrick::kCells;
constexpr int kCorners = kCells + 1;
constexpr int kStride[3] = {FieldBrick::kSamples * FieldBrick::kSamples, FieldBrick::kSamples, 1};
constexpr std::uint16_t kNone = 0xffff;   // state of a block that contains no surface
constexpr std::uint16_t kMixed = 0xfffe;  // state of a block whose surface a single vertex cannot represent
constexpr int kLevels = 5;                // number of block sizes: 1³, 2³, 4³, 8³, 16³ cells
// These two limits decide whether a cell contains a crease. A crossing is a point where the surface crosses an edge of
// the cell. If the variance of the normals at a cell's crossings is below kSmoothSpread, the cell has no crease.
// Otherwise each normal is compared with the mean normal: if the cosine of the angle between them is below
// kCreaseCosine (angle above 14°) for any crossing, the cell contains a crease of 28° or more.
constexpr float kCreaseCosine = 0.97f;
constexpr float kSmoothSpread = 0.008f;
// Cosine of 64°. A crease is gentle (ContourVertex::gentle) if all normals in its cell differ from each other by
// less than this.
constexpr float kGentleCosine = 0.44f;
// These constants place the vertices on a curved surface. The four vertices around an edge of the grid form a facet;
// its sides are about as long as the side s of a cell. If the vertices lay on a surface of curvature κ, the middle of
// the facet would lie about s²κ/4 below the surface. So the vertices are placed outside the surface by kLift·s²κ. Then
// the facet's corners lie outside the surface by about as much as its middle lies inside. The remaining error is at
// most kSag·s²κ. Each vertex is also moved along the surface towards the middle of its cell, by the fraction kCentre of
// its distance from this middle, so that facets have similar sizes. All values were measured on spheres:
// tests/property/surface_mesh_test.cpp.
constexpr float kCentre = 0.6f;
constexpr float kLift = 0.145f;
constexpr float kSag = 0.18f;
// variance of the crossings' positions in one direction, divided by the square of the block's side; if the variance is
// smaller, greatest_curvature() cannot estimate the curvature in this direction
constexpr float kLeastSpread = 4e-3f;
// largest distance by which a vertex is placed outside the surface, as a ratio to the cell's side length
constexpr float kMaxLift = 0.1f;
constexpr double kFlatEigenvalue = 0.01;
constexpr float kOutside = 0.7f;  // voxels; the vertex on a crease may lie outside its cell by at most this distance
// voxels; a block is not merged if the distance between its vertex and the surface, as read from the field by trilinear
// interpolation, is larger than the tolerance plus this value. kCreaseValue is for a block with a crease, kSmoothValue
// for a block without.
constexpr float kCreaseValue = 0.4f;
constexpr float kSmoothValue = 0.1f;

// Returns the index of the sample at cell corner (x,y,z); x, y and z are each -1..17.
constexpr int sample(int x, int y, int z) {
  return ((x + 1) * FieldBrick::kSamples + (y + 1)) * FieldBrick::kSamples + (z + 1);
}

// Returns the signs of a row of 17 samples: bit z is set if sample z is solid.
std::uint32_t solid_bits(const float* row) {
#if defined(__SSE2__)
  const __m128 zero = _mm_setzero_ps();
  auto four = [&](int z) {
    return static_cast<std::uint32_t>(_mm_movemask_ps(_mm_cmplt_ps(_mm_loadu_ps(row + z), zero)));
  };
  return four(0) | four(4) << 4 | four(8) << 8 | four(12) << 12 | static_cast<std::uint32_t>(row[16] < 0) << 16;
#else
  std::uint32_t bits = 0;
  for (int z = 0; z < kCorners; ++z) bits |= static_cast<std::uint32_t>(row[z] < 0) << z;
  return bits;
#endif
}

// A patch of surface in a cell (at full resolution), or the whole surface in a merged block, with its vertex.
struct Node {
  CrossingSums sums;
  glm::vec3 position{0};         // position of the vertex; cell corners have integer coordinates
  Tissue tissue = Tissue::kAir;  // tissue around the vertex; kAir: there are several tissues
  bool crease = false, gentle = false;
  std::uint16_t vertex = kNone;
};

// A block consists of 2³ cells or 2³ smaller blocks, so it has 3³ corner points. Returns the number of the bit that
// stores the sign at the corner point (x, y, z).
constexpr int mid_bit(int x, int y, int z) {
  return (x * 3 + y) * 3 + z;
}
struct Middles {
  // A block has 19 parts: 12 edges, 6 faces, and its inside. For each part: the bit of its midpoint (`point`) and the
  // bits of its corners (`corners`), numbered by mid_bit().
  std::uint32_t point[19], corners[19];
};
constexpr Middles kMiddles = [] {
  Middles out{};
  int count = 0;
  for (int x = 0; x < 3; ++x) {
    for (int y = 0; y < 3; ++y) {
      for (int z = 0; z < 3; ++z) {
        if (x != 1 && y != 1 && z != 1) continue;
        out.point[count] = 1u << mid_bit(x, y, z);
        for (int c = 0; c < 8; ++c) {
          const int cx = 2 * (c & 1), cy = c & 2, cz = c >> 1 & 2;
          if ((x == 1 || cx == x) && (y == 1 || cy == y) && (z == 1 || cz == z)) {
            out.corners[count] |= 1u << mid_bit(cx, cy, cz);
          }
        }
        ++count;
      }
    }
  }
  return out;
}();

// Tests whether merging a block keeps the topology of its surface: the sign at the midpoint of each edge, of each face
// and of the block must equal the sign of one of its corners (Ju et al. 2002, sec. 4.1).
bool middles_agree(std::uint32_t signs) {
  bool agree = true;
  for (int i = 0; i < 19; ++i) {
    const std::uint32_t corners = signs & kMiddles.corners[i];
    agree &= signs & kMiddles.point[i] ? corners != 0 : corners != kMiddles.corners[i];
  }
  return agree;
}

// Finds the two most frequent tissues around a surface point, among the solid samples of the 4³ samples around its
// cell.
void mix_tissues(const FieldBrick& brick, const glm::ivec3& cell, ContourVertex& vertex, const glm::vec3& local) {
  float weight[kTissueCount] = {};
  for (int i = -1; i <= 2; ++i) {
    for (int j = -1; j <= 2; ++j) {
      for (int k = -1; k <= 2; ++k) {
        const glm::ivec3 p = cell + glm::ivec3(i, j, k);
        const auto at = static_cast<std::size_t>(sample(p.x, p.y, p.z));
        if (!(brick.distance[at] < 0)) continue;
        auto tent = [&](int axis) { return std::max(0.f, 2.f - std::abs(static_cast<float>(p[axis]) - local[axis])); };
        weight[static_cast<int>(brick.tissue[at])] += tent(0) * tent(1) * tent(2);
      }
    }
  }
  int first = 0;
  for (int t = 1; t < kTissueCount; ++t) {
    if (weight[t] > weight[first]) first = t;
  }
  int second = first;
  for (int t = 0; t < kTissueCount; ++t) {
    if (t != first && weight[t] > 0 && (second == first || weight[t] > weight[second])) second = t;
  }
  vertex.tissue[0] = static_cast<Tissue>(first);
  vertex.tissue[1] = static_cast<Tissue>(second);
  vertex.second = first == second ? 0 : weight[second] / (weight[first] + weight[second]);
}

// Returns the label of all solid samples among the 4³ samples around a cell; kAir if there are several labels.
Tissue tissue_around(const FieldBrick& brick, const glm::ivec3& cell) {
  Tissue only = Tissue::kAir;
  // Fast path: usually all labelled samples have the same label. Compares four samples at a time and skips zero bytes
  // (kAir).
  static_assert(static_cast<int>(Tissue::kAir) == 0 && kTissueCount < 128);
  std::uint32_t other = 0;
  const auto corner = static_cast<std::size_t>(sample(cell.x - 1, cell.y - 1, cell.z - 1));
  for (int i = 0; i < 8 && only == Tissue::kAir; ++i) {
    const auto at = static_cast<std::size_t>(sample(cell.x + (i & 1), cell.y + (i >> 1 & 1), cell.z + (i >> 2)));
    if (brick.distance[at] < 0) only = brick.tissue[at];
  }
  const std::uint32_t pattern = 0x01010101u * static_cast<std::uint32_t>(only);
  for (std::size_t i = 0; i < 16; ++i) {
    std::uint32_t labels;
    std::memcpy(&labels,
                &brick.tissue[corner + (i >> 2) * static_cast<std::size_t>(kStride[0]) +
                              (i & 3) * static_cast<std::size_t>(kStride[1])],
                4);
    other |= (labels ^ pattern) & (((labels + 0x7f7f7f7fu) >> 7 & 0x01010101u) * 0xffu);
  }
  if (other == 0 && only != Tissue::kAir) return only;
  // Slower version, for a cell with more than one tissue around it: reads only the labels of solid samples.
  only = Tissue::kAir;
  for (int i = -1; i <= 2; ++i) {
    for (int j = -1; j <= 2; ++j) {
      const auto row = static_cast<std::size_t>(sample(cell.x + i, cell.y + j, cell.z - 1));
      for (std::size_t at = row; at < row + 4; ++at) {
        if (!(brick.distance[at] < 0) || brick.tissue[at] == only) continue;
        if (only != Tissue::kAir) return Tissue::kAir;
        only = brick.tissue[at];
      }
    }
  }
  return only;
}

// Returns the brick's only label besides air; kAir if there are several labels.
Tissue only_tissue(const FieldBrick& brick) {
  Tissue only = Tissue::kAir;
  std::uint8_t differs = 0;
  for (const Tissue t : brick.tissue) {
    if (t != Tissue::kAir) {
      only = t;
      break;
    }
  }
  for (const Tissue t : brick.tissue) differs |= static_cast<std::uint8_t>((t != only) & (t != Tissue::kAir));
  return differs ? Tissue::kAir : only;
}

// Returns the vertex for a smooth piece of surface in a cell with the side s, relative to the cell's middle. The vertex
// starts at the mean of the crossings (the points where the surface crosses the cell's edges). On a curved surface,
// this mean does not lie on the surface: its distance from the surface is half the covariance of points and normals.
// The vertex is moved by this distance along the normal.
glm::vec3 smooth_vertex(const CrossingSums& sums, float s) {
  const float w = 1 / sums.count();
  const glm::vec3 x = sums.points() * w, n = sums.normals() * w;
  const float length = glm::length(n);
  if (length < 1e-6f) return x;
  const glm::vec3 unit = n / length;
  const float curvature = sums.curvatures() * w;
  const float onto_surface = std::clamp(0.5f * (sums.points_by_normals() * w - glm::dot(x, n)), -0.5f * s, 0.5f * s);
  const glm::vec3 along = -kCentre * (x - unit * glm::dot(x, unit));
  const float stay_on_surface = -0.5f * curvature * glm::dot(along, along);
  const float lift = std::clamp(kLift * s * s * curvature, -kMaxLift * s, kMaxLift * s);
  return x + along + unit * (onto_surface + stay_on_surface + lift);
}

bool inside(const glm::vec3& p, float s) {
  const float reach = 0.5f * s + kOutside;
  return std::abs(p.x) <= reach && std::abs(p.y) <= reach && std::abs(p.z) <= reach;
}

// Returns the vertex on a crease: the intersection of the planes of the crease's sides, if the intersection lies in or
// near the cell.
glm::vec3 crease_vertex(const PlaneSums& sums, float s) {
  for (int rank = 3; rank > 0; --rank) {
    const PlaneFit fit = fit_planes(sums, kFlatEigenvalue, rank);
    if (inside(fit.point, s)) return fit.point;
  }
  return glm::vec3(sums.point / sums.count);
}

// Returns the trilinear interpolation of the field at point p, which is within the samples. The corners of cells have
// integer coordinates.
float field_at(const float* field, const glm::vec3& p) {
  const glm::vec3 low = glm::clamp(glm::floor(p), glm::vec3(-1), glm::vec3(kCells));
  const glm::vec3 f = glm::clamp(p - low, 0.f, 1.f);
  const float* at = field + sample(static_cast<int>(low.x), static_cast<int>(low.y), static_cast<int>(low.z));
  auto along_z = [&](int offset) { return at[offset] + f.z * (at[offset + 1] - at[offset]); };
  const int x = kStride[0], y = kStride[1];
  const float v0 = along_z(0) + f.y * (along_z(y) - along_z(0));
  const float v1 = along_z(x) + f.y * (along_z(x + y) - along_z(x));
  return v0 + f.x * (v1 - v0);
}

glm::vec3 unit_or_up(const glm::vec3& n) {
  const float length = glm::length(n);
  return length > 1e-6f ? n / length : glm::vec3(0, 0, 1);
}

// Corner (x, y, z) of the brick has the number (x·17 + y)·17 + z, and a cell has the number of its lowest corner. For
// each of a cell's 12 edges, this table contains the number of the edge's base (its lower end) minus the number of the
// cell.
constexpr std::array<int, 12> kEdgeBase = [] {
  std::array<int, 12> out{};
  for (int e = 0; e < 12; ++e) {
    const int axis = e >> 2, u = e & 1, v = e >> 1 & 1;
    const int x = axis == 0 ? 0 : u, y = axis == 0 ? u : axis == 1 ? 0 : v, z = axis == 2 ? 0 : v;
    out[static_cast<std::size_t>(e)] = (x * kCorners + y) * kCorners + z;
  }
  return out;
}();

}  // namespace

// Working memory for one brick (16³ cells). Its member functions are the steps of contour().
struct Contourer::Scratch {
  struct Cell {
    glm::u8vec3 at;
    std::uint16_t shape;
    std::uint16_t first;  // index of the cell's first patch (piece of surface)
  };

  const FieldBrick* brick = nullptr;
  const CellShapes& shapes = CellShapes::get();
  std::uint32_t solid[kCorners * kCorners];  // bit z of row (x, y) is set if corner (x,y,z) is solid
  // For each axis and corner: index of the crossing on the edge of the grid that starts at this corner along this axis.
  std::uint16_t edge_at[3][kCorners * kCorners * kCorners];
  std::vector<Crossing> crossings;
  std::vector<Cell> cells;                     // cells that contain surface
  std::vector<Node> nodes[kLevels];            // level 0: one node per piece of surface; else one per merged block
  std::vector<Moments> moments[kLevels];       // the moments of each node; empty if no blocks are to be merged
  std::vector<std::uint16_t> blocks[kLevels];  // blocks that contain surface
  std::vector<std::uint16_t> state[kLevels];   // state of each block: kNone, kMixed or the index of its node

  // The mesher keeps the results of all bricks. They are first computed in this memory, so that the arrays of each
  // brick are allocated only once, in their final size.
  std::vector<BrickContour::Edge> edges;
  std::vector<ContourVertex> vertices;

  bool read_signs();
  void find_crossings();
  int shape_at(const glm::ivec3& cell, int config) const;
  void find_patches(bool merging);
  bool merge(int level, float tolerance);
  void place_vertices(int top, BrickContour& out);
  PlaneSums planes_of(const Cell& cell, int patch, const glm::vec3& centre) const;
  PlaneSums planes_of(const glm::ivec3& low, int size) const;

  bool solid_at(int x, int y, int z) const { return solid[x * kCorners + y] >> z & 1; }
  const Crossing& crossing_of(const glm::ivec3& cell, int edge) const {
    const int corner = (cell.x * kCorners + cell.y) * kCorners + cell.z + kEdgeBase[static_cast<std::size_t>(edge)];
    return crossings[edge_at[edge >> 2][corner]];
  }
};

Contourer::Contourer() : scratch_(std::make_unique<Scratch>()) {
  for (int level = 0; level < kLevels; ++level) {
    const int n = kCells >> level;
    scratch_->state[level].assign(static_cast<std::size_t>(n * n * n), kNone);
  }
}
Contourer::~Contourer() = default;

void Contourer::contour(const FieldBrick& brick, float tolerance, BrickContour& out) {
  Scratch& s = *scratch_;
  s.brick = &brick;
  out.key = brick.key;
  out.cells.clear();
  out.vertices.clear();
  out.edges.clear();
  out.active.fill(0);
  out.before.fill(0);
  if (!s.read_signs()) return;
  s.find_crossings();
  out.edges.assign(s.edges.begin(), s.edges.end());
  s.find_patches(tolerance >= 0);
  int top = 0;
  while (tolerance >= 0 && top + 1 < kLevels && s.merge(top + 1, tolerance)) ++top;
  s.place_vertices(top, out);
  for (int level = 0; level < kLevels; ++level) {
    for (const std::uint16_t block : s.blocks[level]) s.state[level][block] = kNone;
    s.blocks[level].clear();
    s.nodes[level].clear();
    s.moments[level].clear();
  }
}

// Reads the signs of the corners. Returns false if the brick (16³ cells) contains no surface.
bool Contourer::Scratch::read_signs() {
  std::uint32_t any = 0, all = 0x1ffff;
  for (int x = 0; x < kCorners; ++x) {
    for (int y = 0; y < kCorners; ++y) {
      const std::uint32_t bits = solid_bits(brick->distance.data() + sample(x, y, 0));
      solid[x * kCorners + y] = bits;
      any |= bits;
      all &= bits;
    }
  }
  return any != 0 && all != 0x1ffff;
}

// Finds the crossed edges, and the position and normal of each crossing. Edges whose base (lower end) lies in the
// brick's own cells are added to `edges`; each becomes a polygon.
void Contourer::Scratch::find_crossings() {
  crossings.clear();
  edges.clear();
  auto find = [&]<int kAxis>(std::integral_constant<int, kAxis>, int x, int y, std::uint32_t crossed,
                             std::uint32_t bits) {
    constexpr int kA = kStride[kAxis], kB = kStride[(kAxis + 1) % 3], kC = kStride[(kAxis + 2) % 3];
    for (; crossed; crossed &= crossed - 1) {
      const int z = std::countr_zero(crossed);
      const LocalCrossing local = cross_edge(brick->distance.data() + sample(x, y, z), kA, kB, kC);
      edge_at[kAxis][(x * kCorners + y) * kCorners + z] = static_cast<std::uint16_t>(crossings.size());
      Crossing& crossing = crossings.emplace_back();
      crossing.point[0] = static_cast<float>(x);
      crossing.point[1] = static_cast<float>(y);
      crossing.point[2] = static_cast<float>(z);
      crossing.point[kAxis] += local.t;
      crossing.normal[kAxis] = local.na;
      crossing.normal[(kAxis + 1) % 3] = local.nb;
      crossing.normal[(kAxis + 2) % 3] = local.nc;
      crossing.curvature = local.curvature;
      if (x < kCells && y < kCells && z < kCells) {
        edges.push_back({static_cast<std::uint16_t>(BrickContour::cell_index(x, y, z) & 0xfff),
                         static_cast<std::uint16_t>(kAxis & 3), static_cast<std::uint16_t>(bits >> z & 1)});
      }
    }
  };
  for (int x = 0; x < kCorners; ++x) {
    for (int y = 0; y < kCorners; ++y) {
      const std::uint32_t bits = solid[x * kCorners + y];
      if (x < kCells) find(std::integral_constant<int, 0>(), x, y, bits ^ solid[(x + 1) * kCorners + y], bits);
      if (y < kCells) find(std::integral_constant<int, 1>(), x, y, bits ^ solid[x * kCorners + y + 1], bits);
      find(std::integral_constant<int, 2>(), x, y, (bits ^ bits >> 1) & 0xffff, bits);
    }
  }
}

// Returns the number of a cell's shape. With the usual shapes, the surface in this cell and the surface in a
// neighbouring cell can meet in two arcs on their common face. An edge of the mesh would then have four polygons. If
// the surfaces would meet in two arcs, the function returns another shape. The arcs of this other shape connect the
// four crossings on the common face in the other way (see CellShapes).
int Contourer::Scratch::shape_at(const glm::ivec3& cell, int config) const {
  const int doubtful = shapes.flippable_faces(config);
  if (doubtful == 0) return config;
  int flips = 0;
  for (int face = 0; face < 6; ++face) {
    if (!(doubtful >> face & 1)) continue;
    glm::ivec3 other = cell;
    other[face / 2] += face % 2 ? 1 : -1;
    int neighbour = 0;
    for (int c = 0; c < 8; ++c) {
      const auto at = static_cast<std::size_t>(sample(other.x + (c & 1), other.y + (c >> 1 & 1), other.z + (c >> 2)));
      neighbour |= (brick->distance[at] < 0) << c;
    }
    if (shapes.flippable_faces(neighbour) >> (face ^ 1) & 1) flips |= 1 << face;
  }
  return shapes.flipped(config, flips);
}

// Finds the cells that contain surface, and the patches (pieces of surface) in each cell. `merging`: also computes the
// moments, from which blocks of cells are merged.
void Contourer::Scratch::find_patches(bool merging) {
  const Tissue only = only_tissue(*brick);
  cells.clear();
  std::vector<Node>& patches = nodes[0];
  for (int x = 0; x < kCells; ++x) {
    for (int y = 0; y < kCells; ++y) {
      const std::uint32_t r00 = solid[x * kCorners + y], r01 = solid[x * kCorners + y + 1];
      const std::uint32_t r10 = solid[(x + 1) * kCorners + y], r11 = solid[(x + 1) * kCorners + y + 1];
      const std::uint32_t some = r00 | r01 | r10 | r11, every = r00 & r01 & r10 & r11;
      std::uint32_t surface = (some | some >> 1) & ~(every & every >> 1) & 0xffff;
      for (; surface; surface &= surface - 1) {
        const int z = std::countr_zero(surface);
        auto pair = [&](std::uint32_t bits, int at) {  // returns the signs at the corners z and z + 1 of a row
          return static_cast<int>((bits >> z & 1) << at | (bits >> (z + 1) & 1) << (at + 4));
        };
        const glm::ivec3 at(x, y, z);
        const int shape = shape_at(at, pair(r00, 0) | pair(r10, 1) | pair(r01, 2) | pair(r11, 3));
        const CellShape& cell = shapes[shape];
        const auto first = patches.size();
        cells.push_back({glm::u8vec3(at), static_cast<std::uint16_t>(shape), static_cast<std::uint16_t>(first)});
        patches.resize(first + cell.patches);
        const glm::vec3 centre = glm::vec3(at) + 0.5f;
        for (int p = 0; p < cell.patches; ++p) {
          const auto sum_up = [&](auto sums) {
            for (int i = 0; i < cell.edges; ++i) {
              const std::uint8_t e = cell.edge[static_cast<std::size_t>(i)];
              if (cell.patch[e] == p) sums.add(crossing_of(at, e), centre);
            }
            return sums;
          };
          CrossingSums& sums = patches[first + static_cast<std::size_t>(p)].sums;
          if (merging) {
            sums = moments[0].emplace_back(sum_up(Moments())).sums();
          } else {
            sums = sum_up(CrossingSums());
          }
        }
        for (std::size_t p = first; p < patches.size(); ++p) {
          Node& patch = patches[p];
          patch.tissue = only != Tissue::kAir ? only : tissue_around(*brick, at);
          const glm::vec3 mean = patch.sums.normals() / patch.sums.count();
          if (1 - glm::dot(mean, mean) < kSmoothSpread) continue;
          const float length = glm::length(mean);
          glm::vec3 normals[12];
          int count = 0;
          for (int i = 0; i < cell.edges; ++i) {
            const std::uint8_t e = cell.edge[static_cast<std::size_t>(i)];
            if (cell.patch[e] != p - first) continue;
            const float* n = crossing_of(at, e).normal;
            normals[count] = {n[0], n[1], n[2]};
            patch.crease |= glm::dot(normals[count++], mean) < kCreaseCosine * length;
          }
          patch.gentle = patch.crease;
          for (int i = 1; i < count && patch.gentle; ++i) {
            for (int j = 0; j < i; ++j) patch.gentle &= glm::dot(normals[i], normals[j]) > kGentleCosine;
          }
        }
        const int index = BrickContour::cell_index(x, y, z);
        state[0][static_cast<std::size_t>(index)] =
            shape < 256 && shapes.simple(shape) ? static_cast<std::uint16_t>(first) : kMixed;
        blocks[0].push_back(static_cast<std::uint16_t>(index));
      }
    }
  }
}

PlaneSums Contourer::Scratch::planes_of(const Cell& cell, int patch, const glm::vec3& centre) const {
  const CellShape& shape = shapes[cell.shape];
  PlaneSums sums;
  for (int i = 0; i < shape.edges; ++i) {
    const std::uint8_t e = shape.edge[static_cast<std::size_t>(i)];
    if (shape.patch[e] == patch) sums.add(crossing_of(glm::ivec3(cell.at), e), centre);
  }
  return sums;
}

// Returns the sums over the tangent planes at all crossings in all cells of a block.
PlaneSums Contourer::Scratch::planes_of(const glm::ivec3& low, int size) const {
  const glm::vec3 centre = glm::vec3(low) + 0.5f * static_cast<float>(size);
  PlaneSums sums;
  for (int x = low.x; x < low.x + size; ++x) {
    for (int y = low.y; y < low.y + size; ++y) {
      for (int z = low.z; z < low.z + size; ++z) {
        const std::uint16_t patch = state[0][static_cast<std::size_t>(BrickContour::cell_index(x, y, z))];
        if (patch == kNone) continue;
        int config = 0;
        for (int c = 0; c < 8; ++c) config |= solid_at(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)) << c;
        const CellShape& shape = shapes[config];
        for (int i = 0; i < shape.edges; ++i) {
          sums.add(crossing_of({x, y, z}, shape.edge[static_cast<std::size_t>(i)]), centre);
        }
      }
    }
  }
  return sums;
}

// Merges 2³ blocks of the next finer level into one block with 2^level cells per side, wherever one vertex can
// represent the surface in the larger block. Returns false if no block was merged.
bool Contourer::Scratch::merge(int level, float tolerance) {
  const int size = 1 << level, half = size / 2, n = kCells >> level, children = 2 * n;
  const auto side = static_cast<float>(size);
  bool merged = false;
  for (const std::uint16_t child : blocks[level - 1]) {
    const int bx = child / (children * children) / 2, by = child / children % children / 2, bz = child % children / 2;
    const int block = (bx * n + by) * n + bz;
    std::uint16_t& mine = state[level][static_cast<std::size_t>(block)];
    if (mine != kNone) continue;
    blocks[level].push_back(static_cast<std::uint16_t>(block));
    mine = kMixed;
    std::uint16_t members[8];
    bool whole = true;
    for (int c = 0; c < 8; ++c) {
      members[c] = state[level - 1][static_cast<std::size_t>(
          ((2 * bx + (c & 1)) * children + 2 * by + (c >> 1 & 1)) * children + 2 * bz + (c >> 2))];
      whole &= members[c] != kMixed;
    }
    if (!whole) continue;

    const glm::ivec3 low = size * glm::ivec3(bx, by, bz);
    std::uint32_t signs = 0;
    for (int i = 0; i < 9; ++i) {
      const std::uint32_t row = solid[(low.x + i / 3 * half) * kCorners + low.y + i % 3 * half] >> low.z;
      signs |= ((row & 1) | (row >> half & 1) << 1 | (row >> size & 1) << 2) << (3 * i);
    }
    int config = 0;
    for (int c = 0; c < 8; ++c) config |= static_cast<int>(signs >> mid_bit(2 * (c & 1), c & 2, c >> 1 & 2) & 1) << c;
    if (!shapes.simple(config) || !middles_agree(signs)) continue;

    Node node;
    Moments sums;
    bool first = true;
    for (int c = 0; c < 8; ++c) {
      if (members[c] == kNone) continue;
      const Node& from = nodes[level - 1][members[c]];
      const float quarter = 0.25f * side;
      sums.add(moments[level - 1][members[c]],
               {c & 1 ? quarter : -quarter, c & 2 ? quarter : -quarter, c & 4 ? quarter : -quarter});
      node.crease |= from.crease;
      if (first) node.tissue = from.tissue;
      if (from.tissue != node.tissue) node.tissue = Tissue::kAir;
      first = false;
    }
    if (node.tissue == Tissue::kAir) continue;
    node.sums = sums.sums();
    const glm::vec3 centre = glm::vec3(low) + 0.5f * side;
    if (node.crease) {
      // One vertex can represent both sides of a crease if these sides meet in the block.
      const PlaneSums planes = planes_of(low, size);
      const PlaneFit fit = fit_planes(planes, kFlatEigenvalue);
      if (3 * fit.residual > tolerance || !inside(fit.point, side)) continue;
      node.position = centre + fit.point;
    } else {
      const float bound = tolerance / (kSag * side * side);
      if (std::abs(node.sums.curvatures()) > bound * node.sums.count()) continue;
      if (greatest_curvature(sums, kLeastSpread * side * side) > bound) continue;
      node.position = centre + smooth_vertex(node.sums, side);
    }
    const float off = std::abs(field_at(brick->distance.data(), node.position));
    if (off > tolerance + (node.crease ? kCreaseValue : kSmoothValue)) continue;
    mine = static_cast<std::uint16_t>(nodes[level].size());
    nodes[level].push_back(node);
    moments[level].push_back(sums);
    merged = true;
  }
  return merged;
}

// Places one vertex for every remaining patch (piece of surface) and for every merged block.
void Contourer::Scratch::place_vertices(int top, BrickContour& out) {
  const glm::vec3 origin(kCells * brick->key);
  vertices.clear();
  auto place = [&](const Node& node, const glm::vec3& position) {
    ContourVertex& vertex = vertices.emplace_back();
    vertex.position = origin + position;
    vertex.normal = unit_or_up(node.sums.normals());
    vertex.crease = node.crease;
    vertex.gentle = node.gentle;
    vertex.tissue[0] = vertex.tissue[1] = node.tissue;
  };
  out.cells.reserve(cells.size());
  for (const Cell& cell : cells) {
    const glm::ivec3 at(cell.at);
    const int index = BrickContour::cell_index(at.x, at.y, at.z);
    if (!out.active[static_cast<std::size_t>(index >> 6)]) {
      out.before[static_cast<std::size_t>(index >> 6)] = static_cast<std::uint16_t>(out.cells.size());
    }
    out.active[static_cast<std::size_t>(index >> 6)] |= std::uint64_t{1} << (index & 63);

    Node* block = nullptr;  // the largest merged block that contains the cell
    for (int level = 1; level <= top; ++level) {
      const int n = kCells >> level;
      const std::uint16_t up =
          state[level][static_cast<std::size_t>(((at.x >> level) * n + (at.y >> level)) * n + (at.z >> level))];
      if (up == kMixed) break;
      block = &nodes[level][up];
    }
    if (block) {
      if (block->vertex == kNone) {
        block->vertex = static_cast<std::uint16_t>(vertices.size());
        place(*block, block->position);
      }
      out.cells.push_back({block->vertex, cell.shape});
      continue;
    }
    out.cells.push_back({static_cast<std::uint16_t>(vertices.size()), cell.shape});
    const glm::vec3 centre = glm::vec3(at) + 0.5f;
    for (int p = 0; p < shapes[cell.shape].patches; ++p) {
      const Node& patch = nodes[0][static_cast<std::size_t>(cell.first + p)];
      const glm::vec3 position =
          centre + (patch.crease ? crease_vertex(planes_of(cell, p, centre), 1) : smooth_vertex(patch.sums, 1));
      place(patch, position);
      if (patch.tissue == Tissue::kAir) mix_tissues(*brick, at, vertices.back(), position);
    }
  }
  out.vertices.assign(vertices.begin(), vertices.end());
}

}  // namespace typodont::surface
