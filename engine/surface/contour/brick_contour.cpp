#include "engine/surface/contour/brick_contour.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "engine/surface/contour/cell_shapes.h"
#include "engine/surface/contour/crossing.h"
#include "engine/surface/contour/plane_fit.h"

namespace typodont::surface {
namespace {

constexpr int kCells = FieldBrick::kCells;
constexpr int kCorners = kCells + 1;
constexpr int kStride[3] = {FieldBrick::kSamples * FieldBrick::kSamples, FieldBrick::kSamples, 1};
constexpr std::uint16_t kNone = 0xffff;   // no surface here
constexpr std::uint16_t kMixed = 0xfffe;  // surface that one vertex cannot stand for
constexpr int kLevels = 5;                // blocks of 1³, 2³, 4³, 8³, 16³ cells
// Crossings of one cell whose normals lie further apart than this belong to different sides of a crease.
constexpr float kCreaseCosine = 0.88f;
// The four vertices around an edge make a facet of about the cell's side s. On a surface of curvature κ its middle sags
// by about s²κ/4 below them; so the vertices stand kLift·s²κ outside the surface, and facets err as far outward as
// inward. They are moved along the surface by kCentre of the way to the cell's middle, which evens the facets' sizes.
// kSag·s²κ bounds the error that is left. All measured on spheres: tests/property/surface_sphere_test.cpp.
constexpr float kCentre = 0.6f;
constexpr float kLift = 0.145f;
constexpr float kSag = 0.18f;
constexpr float kLeastSpread = 4e-3f;  // of s²: see greatest_curvature
constexpr float kMaxLift = 0.1f;  // of s, whatever the curvature
constexpr double kFlatEigenvalue = 0.01;
constexpr float kOutside = 0.7f;  // voxels: how far outside its cell a crease's vertex may lie
// How far from zero a trilinear sample of the field may be at a vertex on the surface, at a crease and elsewhere.
constexpr float kCreaseValue = 0.4f;
constexpr float kSmoothValue = 0.1f;

// Sample of cell corner (x,y,z), each -1..17.
constexpr int sample(int x, int y, int z) {
  return ((x + 1) * FieldBrick::kSamples + (y + 1)) * FieldBrick::kSamples + (z + 1);
}

// Bit z set: sample z of 17 in a row is solid.
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

struct Node {
  CrossingSums sums;
  glm::vec3 position{0};  // of its vertex, in cell corners
  Tissue tissue = Tissue::kAir;
  bool crease = false;
  std::uint16_t vertex = kNone;
};

}  // namespace

struct Contourer::Scratch {
  std::uint32_t solid[kCorners * kCorners];
  std::uint16_t edge_at[3][kCorners * kCorners * kCorners];  // crossing on the edge based at a corner
  std::vector<std::uint32_t> edges[3];                       // corner numbers of the crossed edges per axis
  std::vector<Crossing> crossings;
  std::vector<Node> patches;                                  // one per vertex at full resolution
  std::vector<Node> nodes[kLevels];                           // [0] unused
  std::vector<std::uint16_t> blocks[kLevels];                 // blocks the surface passes through
  std::vector<std::uint16_t> state[kLevels];                  // per block: kNone, kMixed or its node
  std::vector<glm::u8vec3> cell_of;                           // of the active cells, in order
};

Contourer::Contourer() : scratch_(std::make_unique<Scratch>()) {
  for (int level = 0; level < kLevels; ++level) {
    const int n = kCells >> level;
    scratch_->state[level].assign(static_cast<std::size_t>(n * n * n), kNone);
  }
}
Contourer::~Contourer() = default;

namespace {

// The two commonest tissues around a point of the surface, from the solid samples of the 4³ around its cell.
void mix_tissues(const FieldBrick& brick, int x, int y, int z, const glm::vec3& local, ContourVertex& vertex) {
  float weight[kTissueCount] = {};
  for (int i = -1; i <= 2; ++i) {
    for (int j = -1; j <= 2; ++j) {
      for (int k = -1; k <= 2; ++k) {
        const auto at = static_cast<std::size_t>(sample(x + i, y + j, z + k));
        if (!(brick.distance[at] < 0)) continue;
        auto tent = [](float d) { return std::max(0.f, 2.f - std::abs(d)); };
        weight[static_cast<int>(brick.tissue[at])] += tent(static_cast<float>(x + i) - local.x) *
                                                      tent(static_cast<float>(y + j) - local.y) *
                                                      tent(static_cast<float>(z + k) - local.z);
      }
    }
  }
  int first = 0, second = 0;
  for (int t = 1; t < kTissueCount; ++t) {
    if (weight[t] > weight[first]) {
      second = first;
      first = t;
    } else if (second == first || weight[t] > weight[second]) {
      second = t;
    }
  }
  if (weight[second] <= 0) second = first;
  vertex.tissue[0] = static_cast<Tissue>(first);
  vertex.tissue[1] = static_cast<Tissue>(second);
  vertex.second = first == second ? 0 : weight[second] / (weight[first] + weight[second]);
}

// The label of the brick when it has but one besides air; kAir when there are several.
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

// The vertex for a smooth piece of surface of cell size s, relative to the cell's middle. The crossings' mean lies below
// the surface by half the covariance of points and normals.
glm::vec3 smooth_vertex(const CrossingSums& sums, float s) {
  const float w = 1 / sums.count;
  const glm::vec3 x = sums.x * w, n = sums.n * w;
  const float length = glm::length(n);
  if (length < 1e-6f) return x;
  const glm::vec3 unit = n / length;
  const float curvature = sums.curvature * w;
  const float onto_surface = std::clamp(0.5f * (sums.xn() * w - glm::dot(x, n)), -0.5f * s, 0.5f * s);
  const glm::vec3 along = -kCentre * (x - unit * glm::dot(x, unit));
  const float stay_on_surface = -0.5f * curvature * glm::dot(along, along);
  const float lift = std::clamp(kLift * s * s * curvature, -kMaxLift * s, kMaxLift * s);
  return x + along + unit * (onto_surface + stay_on_surface + lift);
}

bool inside(const glm::vec3& p, float s) {
  const float reach = 0.5f * s + kOutside;
  return std::abs(p.x) <= reach && std::abs(p.y) <= reach && std::abs(p.z) <= reach;
}

// The vertex on a crease: where its sides meet, if that is in the cell.
glm::vec3 crease_vertex(const CrossingSums& sums, float s) {
  for (int rank = 3; rank > 0; --rank) {
    const PlaneFit fit = fit_planes(sums, kFlatEigenvalue, rank);
    if (inside(fit.point, s)) return fit.point;
  }
  return sums.x / sums.count;
}

// Trilinear, at a point within the samples, in cell corners.
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

// How far the surface may lie from the facets that would stand for it.
float merge_error(const Node& node, float s) {
  const CrossingSums& sums = node.sums;
  if (!node.crease) return kSag * s * s * greatest_curvature(sums, kLeastSpread * s * s);
  // A vertex can stand for the sides of a crease when they meet in the block.
  const PlaneFit fit = fit_planes(sums, kFlatEigenvalue);
  return inside(fit.point, s) ? 3 * fit.residual : std::numeric_limits<float>::infinity();
}

}  // namespace

void Contourer::contour(const FieldBrick& brick, float tolerance, BrickContour& out) {
  Scratch& s = *scratch_;
  const CellShapes& shapes = CellShapes::get();
  const float* field = brick.distance.data();
  out.key = brick.key;
  out.cells.clear();
  out.vertices.clear();
  out.edges.clear();
  out.active.fill(0);
  out.before.fill(0);

  // Signs, as bits along z.
  std::uint32_t any = 0, all = 0x1ffff;
  for (int x = 0; x < kCorners; ++x) {
    for (int y = 0; y < kCorners; ++y) {
      const std::uint32_t bits = solid_bits(field + sample(x, y, 0));
      s.solid[x * kCorners + y] = bits;
      any |= bits;
      all &= bits;
    }
  }
  if (any == 0 || all == 0x1ffff) return;

  // Crossed edges, and where and in which direction the surface crosses them.
  for (auto& list : s.edges) list.clear();
  auto note = [&](int axis, int x, int y, std::uint32_t crossed, std::uint32_t solid) {
    for (; crossed; crossed &= crossed - 1) {
      const int z = std::countr_zero(crossed);
      const int corner = (x * kCorners + y) * kCorners + z;
      s.edges[axis].push_back(static_cast<std::uint32_t>(corner));
      if (x < kCells && y < kCells && z < kCells) {
        out.edges.push_back({static_cast<std::uint16_t>(BrickContour::cell_index(x, y, z) & 0xfff),
                             static_cast<std::uint16_t>(axis & 3), static_cast<std::uint16_t>(solid >> z & 1)});
      }
    }
  };
  for (int x = 0; x < kCorners; ++x) {
    for (int y = 0; y < kCorners; ++y) {
      const std::uint32_t bits = s.solid[x * kCorners + y];
      if (x < kCells) note(0, x, y, bits ^ s.solid[(x + 1) * kCorners + y], bits);
      if (y < kCells) note(1, x, y, bits ^ s.solid[x * kCorners + y + 1], bits);
      note(2, x, y, (bits ^ bits >> 1) & 0xffff, bits);
    }
  }
  s.crossings.clear();
  for (int axis = 0; axis < 3; ++axis) {
    const int a = kStride[axis], b = kStride[(axis + 1) % 3], c = kStride[(axis + 2) % 3];
    for (const std::uint32_t corner : s.edges[axis]) {
      const int x = static_cast<int>(corner) / (kCorners * kCorners);
      const int y = static_cast<int>(corner) / kCorners % kCorners, z = static_cast<int>(corner) % kCorners;
      const LocalCrossing local = cross_edge(field + sample(x, y, z), a, b, c);
      Crossing crossing;
      crossing.point = {x, y, z};
      crossing.point[axis] += local.t;
      crossing.curvature = local.curvature;
      crossing.normal[axis] = local.na;
      crossing.normal[(axis + 1) % 3] = local.nb;
      crossing.normal[(axis + 2) % 3] = local.nc;
      s.edge_at[axis][corner] = static_cast<std::uint16_t>(s.crossings.size());
      s.crossings.push_back(crossing);
    }
  }

  // Cells, and the patches of surface in each.
  const Tissue only = only_tissue(brick);
  s.patches.clear();
  s.cell_of.clear();
  for (int level = 0; level < kLevels; ++level) {
    s.nodes[level].clear();
    s.blocks[level].clear();
  }
  for (int x = 0; x < kCells; ++x) {
    for (int y = 0; y < kCells; ++y) {
      const std::uint32_t r00 = s.solid[x * kCorners + y], r01 = s.solid[x * kCorners + y + 1];
      const std::uint32_t r10 = s.solid[(x + 1) * kCorners + y], r11 = s.solid[(x + 1) * kCorners + y + 1];
      const std::uint32_t some = r00 | r01 | r10 | r11, every = r00 & r01 & r10 & r11;
      std::uint32_t surface = (some | some >> 1) & ~(every & every >> 1) & 0xffff;
      const int row = x * kCells + y;
      out.active[static_cast<std::size_t>(row >> 2)] |= std::uint64_t{surface} << (16 * (row & 3));
      for (; surface; surface &= surface - 1) {
        const int z = std::countr_zero(surface);
        auto two = [&](std::uint32_t bits) { return static_cast<int>(bits >> z & 3); };
        const int a = two(r00), b = two(r10), c = two(r01), d = two(r11);  // corners in the order of x, then y
        const int config = (a & 1) | (b & 1) << 1 | (c & 1) << 2 | (d & 1) << 3 | (a >> 1) << 4 | (b >> 1) << 5 |
                           (c >> 1) << 6 | (d >> 1) << 7;
        int shape = config;
        if (const int doubtful = shapes.doubtful_faces(config)) {
          int flips = 0;
          for (int face = 0; face < 6; ++face) {
            if (!(doubtful >> face & 1)) continue;
            const int step = face % 2 ? 1 : -1;
            const glm::ivec3 other(x + (face / 2 == 0) * step, y + (face / 2 == 1) * step, z + (face / 2 == 2) * step);
            int neighbour = 0;
            for (int corner = 0; corner < 8; ++corner) {
              const float value =
                  field[sample(other.x + (corner & 1), other.y + (corner >> 1 & 1), other.z + (corner >> 2))];
              neighbour |= (value < 0) << corner;
            }
            if (shapes.doubtful_faces(neighbour) >> (face ^ 1) & 1) flips |= 1 << face;
          }
          if (flips) shape = shapes.flipped(config, flips);
        }

        const CellShape& cell = shapes[shape];
        const auto first = s.patches.size();
        out.cells.push_back({static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(shape)});
        s.cell_of.push_back({x, y, z});
        s.patches.resize(first + cell.patches);
        const glm::vec3 centre(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f,
                               static_cast<float>(z) + 0.5f);
        const Crossing* members[12];
        for (int i = 0; i < cell.edges; ++i) {
          const int e = cell.edge[static_cast<std::size_t>(i)], axis = e >> 2, u = e & 1, v = e >> 1 & 1;
          const int cx = x + (axis == 0 ? 0 : u), cy = y + (axis == 0 ? u : axis == 1 ? 0 : v);
          const int cz = z + (axis == 2 ? 0 : v);
          members[i] = &s.crossings[s.edge_at[axis][(cx * kCorners + cy) * kCorners + cz]];
          s.patches[first + cell.patch[static_cast<std::size_t>(e)]].sums.add(members[i]->point - centre,
                                                                              members[i]->normal, members[i]->curvature);
        }
        for (std::size_t p = first; p < s.patches.size(); ++p) {
          Node& patch = s.patches[p];
          const glm::vec3 mean = unit_or_up(patch.sums.n);
          for (int i = 0; i < cell.edges && !patch.crease; ++i) {
            if (cell.patch[cell.edge[static_cast<std::size_t>(i)]] != p - first) continue;
            // Half the angle between two sides lies between each side and the mean.
            patch.crease = glm::dot(members[i]->normal, mean) < std::sqrt(0.5f + 0.5f * kCreaseCosine);
          }
          ContourVertex vertex;
          if (patch.crease) {
            vertex.position = crease_vertex(patch.sums, 1) + centre;
            vertex.crease = true;
          } else {
            vertex.position = smooth_vertex(patch.sums, 1) + centre;
          }
          vertex.normal = mean;
          if (only != Tissue::kAir) {
            vertex.tissue[0] = vertex.tissue[1] = only;
          } else {
            mix_tissues(brick, x, y, z, vertex.position, vertex);
          }
          patch.tissue = vertex.tissue[0] == vertex.tissue[1] ? vertex.tissue[0] : Tissue::kAir;
          out.vertices.push_back(vertex);
        }
        s.state[0][static_cast<std::size_t>(BrickContour::cell_index(x, y, z))] =
            shape < 256 && shapes.simple(shape) ? static_cast<std::uint16_t>(first) : kMixed;
        s.blocks[0].push_back(static_cast<std::uint16_t>(BrickContour::cell_index(x, y, z)));
      }
    }
  }
  std::uint16_t total = 0;
  for (std::size_t w = 0; w < 64; ++w) {
    out.before[w] = total;
    total = static_cast<std::uint16_t>(total + std::popcount(out.active[w]));
  }

  // Blocks of cells whose surface one vertex can stand for, from small to large.
  auto solid_at = [&](int x, int y, int z) { return s.solid[x * kCorners + y] >> z & 1; };
  int top = 0;  // the highest level with any merged block
  for (int level = 1; tolerance >= 0 && level < kLevels; ++level) {
    const int size = 1 << level, half = size / 2, n = kCells >> level, children_n = n * 2;
    bool merged_any = false;
    for (const std::uint16_t child : s.blocks[level - 1]) {
      const int bx = child / (children_n * children_n) / 2, by = child / children_n % children_n / 2;
      const int bz = child % children_n / 2;
      const int block = (bx * n + by) * n + bz;
      std::uint16_t& state = s.state[level][static_cast<std::size_t>(block)];
      if (state != kNone) continue;
      s.blocks[level].push_back(static_cast<std::uint16_t>(block));
      state = kMixed;
      const std::vector<Node>& below = level == 1 ? s.patches : s.nodes[level - 1];
      auto child_state = [&](int c) {
        return s.state[level - 1][static_cast<std::size_t>(
            ((2 * bx + (c & 1)) * children_n + 2 * by + (c >> 1 & 1)) * children_n + 2 * bz + (c >> 2))];
      };
      bool simple = true;
      for (int c = 0; c < 8 && simple; ++c) simple = child_state(c) != kMixed;
      if (!simple) continue;

      // The surface keeps its topology when the block's corners have a simple configuration and the sign in the middle
      // of each edge, face and of the block is that of one of its corners (Ju et al. 2002, sec. 4.1).
      const int x0 = bx * size, y0 = by * size, z0 = bz * size;
      auto sign = [&](int i, int j, int k) { return solid_at(x0 + i * half, y0 + j * half, z0 + k * half); };
      int config = 0;
      for (int c = 0; c < 8; ++c) config |= static_cast<int>(sign(2 * (c & 1), c & 2, c >> 1 & 2)) << c;
      if (!shapes.simple(config)) continue;
      for (int i = 0; i < 3 && simple; ++i) {
        for (int j = 0; j < 3 && simple; ++j) {
          for (int k = 0; k < 3 && simple; ++k) {
            if (i != 1 && j != 1 && k != 1) continue;
            const auto middle = sign(i, j, k);
            bool found = false;
            for (int c = 0; c < 8 && !found; ++c) {
              const int ci = 2 * (c & 1), cj = c & 2, ck = c >> 1 & 2;
              if ((i != 1 && ci != i) || (j != 1 && cj != j) || (k != 1 && ck != k)) continue;
              found = static_cast<unsigned>(config >> c & 1) == middle;
            }
            simple = found;
          }
        }
      }
      if (!simple) continue;

      Node node;
      bool first = true;
      for (int c = 0; c < 8; ++c) {
        const std::uint16_t member = child_state(c);
        if (member == kNone) continue;
        const Node& from = below[member];
        const float quarter = 0.5f * static_cast<float>(half);
        node.sums.add(from.sums, {c & 1 ? quarter : -quarter, c & 2 ? quarter : -quarter, c & 4 ? quarter : -quarter});
        node.crease |= from.crease;
        if (first) node.tissue = from.tissue;
        if (from.tissue != node.tissue) node.tissue = Tissue::kAir;
        first = false;
      }
      const auto side = static_cast<float>(size);
      if (node.tissue == Tissue::kAir || merge_error(node, side) > tolerance) continue;
      node.position = glm::vec3(x0, y0, z0) + 0.5f * side +
                      (node.crease ? crease_vertex(node.sums, side) : smooth_vertex(node.sums, side));
      const float off = std::abs(field_at(field, node.position));
      if (off > tolerance + (node.crease ? kCreaseValue : kSmoothValue)) continue;
      state = static_cast<std::uint16_t>(s.nodes[level].size());
      s.nodes[level].push_back(node);
      merged_any = true;
    }
    if (!merged_any) break;
    top = level;
  }

  // Merged cells share the vertex of the largest block around them.
  if (top > 0) {
    auto& vertices = out.vertices;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < out.cells.size(); ++i) {
      const glm::ivec3 cell(s.cell_of[i]);
      BrickContour::Cell& entry = out.cells[i];
      const std::size_t patches = shapes[entry.shape].patches;
      int level = 0;
      std::uint16_t node_number = kNone;
      for (int up = 1; up <= top; ++up) {
        const int n = kCells >> up;
        const std::uint16_t state =
            s.state[up][static_cast<std::size_t>(((cell.x >> up) * n + (cell.y >> up)) * n + (cell.z >> up))];
        if (state == kMixed) break;
        level = up;
        node_number = state;
      }
      if (level == 0) {
        for (std::size_t p = 0; p < patches; ++p) vertices[kept + p] = vertices[entry.vertex + p];
        entry.vertex = static_cast<std::uint16_t>(kept);
        kept += patches;
        continue;
      }
      Node& node = s.nodes[level][node_number];
      if (node.vertex == kNone) {
        ContourVertex vertex;
        vertex.crease = node.crease;
        vertex.position = node.position;
        vertex.normal = unit_or_up(node.sums.n);
        vertex.tissue[0] = vertex.tissue[1] = node.tissue;
        node.vertex = static_cast<std::uint16_t>(kept);
        vertices[kept++] = vertex;
      }
      entry.vertex = node.vertex;
    }
    vertices.resize(kept);
  }

  const glm::vec3 origin(16 * brick.key);
  for (ContourVertex& vertex : out.vertices) vertex.position += origin;

  for (int level = 0; level < kLevels; ++level) {
    for (const std::uint16_t block : s.blocks[level]) s.state[level][block] = kNone;
  }
}

}  // namespace typodont::surface
