#include "engine/surface/contour/brick_contour.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "engine/base/voxels.h"
#include "engine/surface/contour/cell_shapes.h"
#include "engine/surface/contour/crossing.h"
#include "engine/surface/contour/moments.h"
#include "engine/surface/contour/plane_fit.h"
#include "engine/surface/contour/smooth_vertices.h"

namespace typodont::surface {
namespace {

constexpr int kCells = FieldBrick::kCells;
constexpr int kCorners = kCells + 1;
constexpr int kStride[3] = {FieldBrick::kSamples * FieldBrick::kSamples, FieldBrick::kSamples, 1};
constexpr std::uint16_t kNoSurface = 0xffff;  // state of a block that contains no surface
constexpr std::uint16_t kMixed = 0xfffe;      // state of a block whose surface needs several vertices
constexpr int kLevels = 5;                    // number of block sizes: 1³, 2³, 4³, 8³, 16³ cells
// A cell has a crease of 28° or more if its normals vary by kSmoothSpread and one of them lies more than 14° (cosine
// kCreaseCosine) from their mean.
constexpr float kCreaseCosine = 0.97f;
constexpr float kSmoothSpread = 0.008f;
// cosine of 64°, the largest angle between normals of a gentle crease (ContourVertex::gentle)
constexpr float kGentleCosine = 0.44f;
// a block of side s on a surface of curvature κ has an error of at most kSag·s²κ (smooth_vertices.cpp)
constexpr float kSag = 0.18f;
// smallest variance of the crossings' positions, divided by the block's side², that suffices for max_curvature()
constexpr float kMinSpread = 4e-3f;
constexpr double kFlatEigenvalue = 0.01;
constexpr float kOutside = 0.7f;  // voxels, largest distance of a crease vertex from its cell
// A block is merged only if |distance| at its vertex is at most the tolerance plus
// kCreaseValue (block with a crease) or kSmoothValue (block without), voxels.
constexpr float kCreaseValue = 0.4f;
constexpr float kSmoothValue = 0.1f;

// Index of a sample; x, y and z are -1..17.
constexpr int sample(int x, int y, int z) {
  return ((x + 1) * FieldBrick::kSamples + (y + 1)) * FieldBrick::kSamples + (z + 1);
}

// Returns a bit for each of the 17 samples of a row: bit z is 1 if sample z is solid.
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

// A patch (piece of surface) in a cell, or the surface of a merged block; each gets one vertex.
struct Node {
  CrossingSums sums;
  glm::vec3 position{0};         // position of the vertex; cell corners have integer coordinates
  Tissue tissue = Tissue::kAir;  // tissue around the vertex; kAir: there are several tissues
  bool crease = false, gentle = false;
  std::uint16_t vertex = kNoSurface;
  glm::u8vec3 color_min{255}, color_max{0};  // range of the surrounding colours; red, blue: 0..31, green: 0..63
};
// Largest range of colours in a merged block: 2 of 32 levels (green: 4 of 64). kTissueColor merges only with itself.
constexpr int kColorRange = 2;
glm::u8vec3 levels_of(VoxelColor color) {
  return color == kTissueColor ? glm::u8vec3(255) : glm::u8vec3(color >> 11, color >> 5 & 63, color & 31);
}
bool one_color(const Node& node) {
  const glm::ivec3 range = glm::ivec3(node.color_max) - glm::ivec3(node.color_min);
  return glm::all(glm::lessThanEqual(range, kColorRange * glm::ivec3(1, 2, 1)));
}

// Number of the bit of point (x, y, z) in a grid of 3³ points.
constexpr int mid_bit(int x, int y, int z) {
  return (x * 3 + y) * 3 + z;
}
struct Middles {
  // For the midpoints of 12 edges, 6 faces and the cube: bit masks of the midpoint itself and of the corners around it.
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

// Merging keeps the topology if each midpoint has the sign of at least one of its corners (Ju et al. 2002, sec. 4.1).
bool middles_agree(std::uint32_t signs) {
  bool agree = true;
  for (int i = 0; i < 19; ++i) {
    const std::uint32_t corners = signs & kMiddles.corners[i];
    agree &= signs & kMiddles.point[i] ? corners != 0 : corners != kMiddles.corners[i];
  }
  return agree;
}

// Sets a vertex's two most frequent tissues among the solid samples of the 4³ samples around the cell.
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

// Returns the tissue of all solid samples in the 4³ samples around the cell, or kAir if there are several.
Tissue tissue_around(const FieldBrick& brick, const glm::ivec3& cell) {
  Tissue only = Tissue::kAir;
  // Fast test: compares the labels of four samples at a time with `only`, and skips kAir.
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
  // Slower test: compares only the labels of solid samples.
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

// Returns the only tissue of the brick besides air, or kAir if there are several.
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

bool inside(const glm::vec3& p, float s) {
  const float reach = 0.5f * s + kOutside;
  return std::abs(p.x) <= reach && std::abs(p.y) <= reach && std::abs(p.z) <= reach;
}

// Returns the point where the planes of a crease's sides meet, if it lies in or near the cell.
glm::vec3 crease_vertex(const PlaneSums& sums, float s) {
  for (int rank = 3; rank > 0; --rank) {
    const PlaneFit fit = fit_planes(sums, kFlatEigenvalue, rank);
    if (inside(fit.point, s)) return fit.point;
  }
  return glm::vec3(sums.point / sums.count);
}

// Returns the field at a point by trilinear interpolation. Cell corners have integer coordinates.
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

// Corner (x, y, z) has the number (x·17 + y)·17 + z, and a cell has the number of its lowest corner. The edge from
// corner n along axis a has the number n + a·17³.
constexpr int kCornerCount = kCorners * kCorners * kCorners;
// For each edge of a cell: its number minus the cell's number.
constexpr std::array<int, 12> kEdgeNumber = [] {
  std::array<int, 12> out{};
  for (int e = 0; e < 12; ++e) {
    const int axis = e >> 2, u = e & 1, v = e >> 1 & 1;
    const int x = axis == 0 ? 0 : u, y = axis == 0 ? u : axis == 1 ? 0 : v, z = axis == 2 ? 0 : v;
    out[static_cast<std::size_t>(e)] = axis * kCornerCount + (x * kCorners + y) * kCorners + z;
  }
  return out;
}();
// largest number of crossed edges along one axis
constexpr int kMaxEdges = kCells * kCorners * kCorners;

}  // namespace

// Working memory for one brick; its functions are the steps of contour().
struct Contourer::Scratch {
  struct Cell {
    glm::u8vec3 at;
    std::uint16_t shape;
    std::uint16_t first;  // index of the cell's first patch (piece of surface)
  };

  const FieldBrick* brick = nullptr;
  const CellShapes& shapes = CellShapes::get();
  std::uint32_t solid[kCorners * kCorners];     // for row (x, y): bit z is set if the sample is solid
  std::uint16_t crossing_at[3 * kCornerCount];  // for each crossed edge's number: index of its crossing
  // The crossed edges along axis a start at a·kMaxEdges.
  std::vector<GridEdge> grid_edges = std::vector<GridEdge>(3 * kMaxEdges);
  std::vector<Crossing> crossings = std::vector<Crossing>(3 * kMaxEdges);
  std::vector<Cell> cells;                     // cells that contain surface
  std::vector<Node> nodes[kLevels];            // level 0: one node per patch; higher levels: one per merged block
  std::vector<Moments> moments[kLevels];       // one entry per node; empty if blocks are not merged
  std::vector<std::uint16_t> blocks[kLevels];  // blocks that contain surface
  std::vector<std::uint16_t> state[kLevels];   // for each block: kNoSurface, kMixed or its node's index

  // The results are built in these vectors and then copied once into memory of the right size.
  std::vector<BrickContour::Edge> edges;
  std::vector<ContourVertex> vertices;
  // Vertex of a smooth patch that is in no merged block.
  struct SmoothVertex {
    std::uint16_t patch, vertex;  // indices: of the patch in nodes[0], of its vertex in `vertices`
    glm::u8vec3 cell;
  };
  std::vector<SmoothVertex> smooth;

  bool read_signs();
  void find_crossings();
  int shape_at(const glm::ivec3& cell, int config) const;
  void find_colors(const glm::ivec3& cell, Node& patch) const;
  void find_patches(bool merging);
  bool merge(int level, float tolerance);
  void find_creases();
  void place_vertices(int top, BrickContour& out);
  void place_smooth_vertices(const glm::vec3& origin);
  PlaneSums planes_of(const Cell& cell, int patch, const glm::vec3& centre) const;
  PlaneSums planes_of(const glm::ivec3& low, int size) const;

  bool solid_at(int x, int y, int z) const { return solid[x * kCorners + y] >> z & 1; }
  const Crossing& crossing_of(const glm::ivec3& cell, int edge) const {
    const int corner = (cell.x * kCorners + cell.y) * kCorners + cell.z;
    return crossings[crossing_at[corner + kEdgeNumber[static_cast<std::size_t>(edge)]]];
  }
};

Contourer::Contourer() : scratch_(std::make_unique<Scratch>()) {
  for (int level = 0; level < kLevels; ++level) {
    const int n = kCells >> level;
    scratch_->state[level].assign(static_cast<std::size_t>(n * n * n), kNoSurface);
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
  s.find_creases();
  int top = 0;
  while (tolerance >= 0 && top + 1 < kLevels && s.merge(top + 1, tolerance)) ++top;
  s.place_vertices(top, out);
  for (int level = 0; level < kLevels; ++level) {
    for (const std::uint16_t block : s.blocks[level]) s.state[level][block] = kNoSurface;
    s.blocks[level].clear();
    s.nodes[level].clear();
    s.moments[level].clear();
  }
}

// Reads the signs of the samples. Returns false if the brick contains no surface.
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

// Finds the edges that the surface crosses. Those whose lower end lies in this brick become polygons (`edges`).
void Contourer::Scratch::find_crossings() {
  edges.clear();
  int next[3] = {0, kMaxEdges, 2 * kMaxEdges};
  const auto find = [&](int axis, int x, int y, std::uint32_t crossed, std::uint32_t bits) {
    for (; crossed; crossed &= crossed - 1) {
      const int z = std::countr_zero(crossed), number = next[axis]++;
      crossing_at[axis * kCornerCount + (x * kCorners + y) * kCorners + z] = static_cast<std::uint16_t>(number);
      grid_edges[static_cast<std::size_t>(number)] = {static_cast<std::uint16_t>(sample(x, y, z)),
                                                      static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y),
                                                      static_cast<std::uint8_t>(z)};
      if (x < kCells && y < kCells && z < kCells) {
        edges.push_back({static_cast<std::uint16_t>(BrickContour::cell_index(x, y, z) & 0xfff),
                         static_cast<std::uint16_t>(axis & 3), static_cast<std::uint16_t>(bits >> z & 1)});
      }
    }
  };
  for (int x = 0; x < kCorners; ++x) {
    for (int y = 0; y < kCorners; ++y) {
      const std::uint32_t bits = solid[x * kCorners + y];
      if (x < kCells) find(0, x, y, bits ^ solid[(x + 1) * kCorners + y], bits);
      if (y < kCells) find(1, x, y, bits ^ solid[x * kCorners + y + 1], bits);
      find(2, x, y, (bits ^ bits >> 1) & 0xffff, bits);
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const auto first = static_cast<std::size_t>(axis * kMaxEdges), end = static_cast<std::size_t>(next[axis]);
    cross_edges(brick->distance.data(), kStride, axis, {grid_edges.data() + first, grid_edges.data() + end},
                crossings.data() + first);
  }
}

// Returns the shape of a cell. Where the usual shapes of two neighbouring cells would give two arcs on their common
// face, and so four polygons at an edge, it returns the flipped shape (CellShapes).
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

// Finds the range of the colours among the 4³ samples around the cell. Cells beside a colour border are not merged.
void Contourer::Scratch::find_colors(const glm::ivec3& cell, Node& patch) const {
  for (int i = -1; i <= 2; ++i) {
    for (int j = -1; j <= 2; ++j) {
      const auto row = static_cast<std::size_t>(sample(cell.x + i, cell.y + j, cell.z - 1));
      for (std::size_t at = row; at < row + 4; ++at) {
        if (brick->tissue[at] == Tissue::kAir) continue;
        const glm::u8vec3 levels = levels_of(brick->color[at]);
        patch.color_min = glm::min(patch.color_min, levels);
        patch.color_max = glm::max(patch.color_max, levels);
      }
    }
  }
}

// Finds the patches of surface in each cell. `merging`: also computes their Moments, which merge() needs.
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
        auto pair = [&](std::uint32_t bits, int at) {  // signs at z and z + 1
          return static_cast<int>((bits >> z & 1) << at | (bits >> (z + 1) & 1) << (at + 4));
        };
        const glm::ivec3 at(x, y, z);
        const int shape = shape_at(at, pair(r00, 0) | pair(r10, 1) | pair(r01, 2) | pair(r11, 3));
        const CellShape& cell = shapes[shape];
        const auto first = patches.size();
        cells.push_back({glm::u8vec3(at), static_cast<std::uint16_t>(shape), static_cast<std::uint16_t>(first)});
        patches.resize(first + cell.patches);
        const glm::vec3 centre = glm::vec3(at) + 0.5f;
        const Tissue tissue = only != Tissue::kAir ? only : tissue_around(*brick, at);
        for (int p = 0; p < cell.patches; ++p) {
          const auto sum_up = [&](auto sums) {
            for (int i = 0; i < cell.edges; ++i) {
              const std::uint8_t e = cell.edge[static_cast<std::size_t>(i)];
              if (cell.patch[e] == p) sums.add(crossing_of(at, e), centre);
            }
            return sums;
          };
          Node& patch = patches[first + static_cast<std::size_t>(p)];
          patch.tissue = tissue;
          if (brick->colored) find_colors(at, patch);
          CrossingSums& sums = patch.sums;
          if (merging) {
            sums = moments[0].emplace_back(sum_up(Moments())).sums();
          } else {
            sums = sum_up(CrossingSums());
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

// Marks patches with a crease. Most patches have nearly equal normals and need no closer test.
void Contourer::Scratch::find_creases() {
  std::vector<Node>& patches = nodes[0];
  std::size_t cell_index = 0;
  for (std::size_t first = 0; first < patches.size(); first += 8) {
    const std::size_t count = std::min<std::size_t>(8, patches.size() - first);
    const CrossingSums* sums[8];
    for (std::size_t i = 0; i < 8; ++i) sums[i] = &patches[first + std::min(i, count - 1)].sums;
    unsigned spread = spread_of_normals(sums, kSmoothSpread) & ((1u << count) - 1);
    for (; spread; spread &= spread - 1) {
      const std::size_t p = first + static_cast<std::size_t>(std::countr_zero(spread));
      while (cell_index + 1 < cells.size() && cells[cell_index + 1].first <= p) ++cell_index;
      const Cell& cell = cells[cell_index];
      const CellShape& shape = shapes[cell.shape];
      Node& patch = patches[p];
      const glm::vec3 mean = patch.sums.normals() / patch.sums.count();
      const float length = glm::length(mean);
      glm::vec3 normals[12];
      int normal_count = 0;
      for (int i = 0; i < shape.edges; ++i) {
        const std::uint8_t e = shape.edge[static_cast<std::size_t>(i)];
        if (shape.patch[e] != p - cell.first) continue;
        const float* n = crossing_of(glm::ivec3(cell.at), e).normal;
        glm::vec3& normal = normals[normal_count++];
        normal = {n[0], n[1], n[2]};
        patch.crease |= glm::dot(normal, mean) < kCreaseCosine * length;
      }
      patch.gentle = patch.crease;
      for (int i = 1; i < normal_count && patch.gentle; ++i) {
        for (int j = 0; j < i; ++j) patch.gentle &= glm::dot(normals[i], normals[j]) > kGentleCosine;
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

// Sums the tangent planes of all crossings in a block.
PlaneSums Contourer::Scratch::planes_of(const glm::ivec3& low, int size) const {
  const glm::vec3 centre = glm::vec3(low) + 0.5f * static_cast<float>(size);
  PlaneSums sums;
  for_each_voxel_between(low, low + size - 1, [&](int x, int y, int z) {
    const std::uint16_t patch = state[0][static_cast<std::size_t>(BrickContour::cell_index(x, y, z))];
    if (patch == kNoSurface) return;
    int config = 0;
    for (int c = 0; c < 8; ++c) config |= solid_at(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)) << c;
    const CellShape& shape = shapes[config];
    for (int i = 0; i < shape.edges; ++i) {
      sums.add(crossing_of({x, y, z}, shape.edge[static_cast<std::size_t>(i)]), centre);
    }
  });
  return sums;
}

// Merges 2³ finer blocks into one block with an edge of 2^level cells, where one vertex is enough. Returns false if
// no block was merged.
bool Contourer::Scratch::merge(int level, float tolerance) {
  const int size = 1 << level, half = size / 2, n = kCells >> level, children = 2 * n;
  const auto side = static_cast<float>(size);
  bool merged = false;
  for (const std::uint16_t child : blocks[level - 1]) {
    const int bx = child / (children * children) / 2, by = child / children % children / 2, bz = child % children / 2;
    const int block = (bx * n + by) * n + bz;
    std::uint16_t& mine = state[level][static_cast<std::size_t>(block)];
    if (mine != kNoSurface) continue;
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
      if (members[c] == kNoSurface) continue;
      const Node& from = nodes[level - 1][members[c]];
      const float quarter = 0.25f * side;
      sums.add(moments[level - 1][members[c]],
               {c & 1 ? quarter : -quarter, c & 2 ? quarter : -quarter, c & 4 ? quarter : -quarter});
      node.crease |= from.crease;
      if (first) node.tissue = from.tissue;
      if (from.tissue != node.tissue) node.tissue = Tissue::kAir;
      node.color_min = glm::min(node.color_min, from.color_min);
      node.color_max = glm::max(node.color_max, from.color_max);
      first = false;
    }
    if (node.tissue == Tissue::kAir || (brick->colored && !one_color(node))) continue;
    node.sums = sums.sums();
    const glm::vec3 centre = glm::vec3(low) + 0.5f * side;
    if (node.crease) {
      // The vertex is the point nearest to the tangent planes of all crossings; it must lie in or near the block.
      const PlaneSums planes = planes_of(low, size);
      const PlaneFit fit = fit_planes(planes, kFlatEigenvalue);
      if (3 * fit.residual > tolerance || !inside(fit.point, side)) continue;
      node.position = centre + fit.point;
    } else {
      const float bound = tolerance / (kSag * side * side);
      if (std::abs(node.sums.curvatures()) > bound * node.sums.count()) continue;
      if (max_curvature(sums, kMinSpread * side * side) > bound) continue;
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

// Creates the vertex of each merged block and of each patch outside merged blocks.
void Contourer::Scratch::place_vertices(int top, BrickContour& out) {
  const glm::vec3 origin(kCells * brick->key);
  vertices.clear();
  smooth.clear();
  const auto add = [&](const Node& node) -> ContourVertex& {
    ContourVertex& vertex = vertices.emplace_back();
    vertex.crease = node.crease;
    vertex.gentle = node.gentle;
    vertex.tissue[0] = vertex.tissue[1] = node.tissue;
    return vertex;
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
      if (block->vertex == kNoSurface) {
        block->vertex = static_cast<std::uint16_t>(vertices.size());
        ContourVertex& vertex = add(*block);
        vertex.position = origin + block->position;
        vertex.normal = unit_normal(block->sums);
      }
      out.cells.push_back({block->vertex, cell.shape});
      continue;
    }
    out.cells.push_back({static_cast<std::uint16_t>(vertices.size()), cell.shape});
    for (int p = 0; p < shapes[cell.shape].patches; ++p) {
      const auto number = static_cast<std::uint16_t>(cell.first + p);
      const Node& patch = nodes[0][number];
      ContourVertex& vertex = add(patch);
      if (!patch.crease) {
        smooth.push_back({number, static_cast<std::uint16_t>(vertices.size() - 1), cell.at});
        continue;
      }
      const glm::vec3 centre = glm::vec3(at) + 0.5f, position = centre + crease_vertex(planes_of(cell, p, centre), 1);
      vertex.position = origin + position;
      vertex.normal = unit_normal(patch.sums);
      if (patch.tissue == Tissue::kAir) mix_tissues(*brick, at, vertex, position);
    }
  }
  place_smooth_vertices(origin);
  out.vertices.assign(vertices.begin(), vertices.end());
}

// Computes the vertices of `smooth`, eight at a time.
void Contourer::Scratch::place_smooth_vertices(const glm::vec3& origin) {
  for (std::size_t first = 0; first < smooth.size(); first += 8) {
    const std::size_t count = std::min<std::size_t>(8, smooth.size() - first);
    const CrossingSums* sums[8];
    for (std::size_t i = 0; i < 8; ++i) sums[i] = &nodes[0][smooth[first + std::min(i, count - 1)].patch].sums;
    SmoothVertices eight;
    smooth_vertices(sums, eight);
    for (std::size_t i = 0; i < count; ++i) {
      const SmoothVertex& from = smooth[first + i];
      ContourVertex& vertex = vertices[from.vertex];
      const glm::vec3 centre = glm::vec3(from.cell) + 0.5f;
      const glm::vec3 position = centre + glm::vec3(eight.position[0][i], eight.position[1][i], eight.position[2][i]);
      vertex.position = origin + position;
      vertex.normal = {eight.normal[0][i], eight.normal[1][i], eight.normal[2][i]};
      if (nodes[0][from.patch].tissue == Tissue::kAir) mix_tissues(*brick, glm::ivec3(from.cell), vertex, position);
    }
  }
}

}  // namespace typodont::surface
