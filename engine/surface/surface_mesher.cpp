#include "engine/surface/surface_mesher.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <unordered_map>

#include "engine/surface/contour/brick_contour.h"
#include "engine/surface/contour/cell_shapes.h"

namespace typodont::surface {
namespace {

struct KeyHash {
  std::size_t operator()(const glm::ivec3& k) const noexcept {
    auto h = static_cast<std::uint64_t>(static_cast<std::uint32_t>(k.x)) * 0x9e3779b97f4a7c15u;
    h = (h ^ static_cast<std::uint32_t>(k.y)) * 0xbf58476d1ce4e5b9u;
    h = (h ^ static_cast<std::uint32_t>(k.z)) * 0x94d049bb133111ebu;
    return static_cast<std::size_t>(h ^ h >> 31);
  }
};

bool key_less(const glm::ivec3& a, const glm::ivec3& b) {
  return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
}

struct Brick {
  BrickContour contour;
  BrickMesh mesh;
  bool queued = false;
};

constexpr std::uint32_t kNone = 0xffffffff;
constexpr std::uint16_t kSeveral = 0xffff;
constexpr int kCells = FieldBrick::kCells;

// A polygon corner: a vertex of this brick (owner 0), or of a neighbouring brick with lower coordinates.
struct Corner {
  std::uint32_t owner, vertex;
  const ContourVertex* data;
  bool operator==(const Corner& o) const { return owner == o.owner && vertex == o.vertex; }
};

// Builds one brick's mesh. Its working memory is used again for the next brick.
struct PolygonBuilder {
  struct Copy {
    std::uint32_t next;
    Tissue low, high;
    bool crease;
  };
  std::vector<std::uint32_t> first_copy[8];  // for each owner (brick) and vertex: index of its first copy
  std::vector<Copy> copies;                  // copies of vertices, one for each vertex of the mesh
  // For each cell of this brick that contains surface: its vertex, or kSeveral if it has several.
  std::vector<std::uint16_t> vertex_at = std::vector<std::uint16_t>(kCells * kCells * kCells);

  void build(const BrickContour* const around[8], BrickMesh& mesh);

 private:
  std::uint32_t copy_of(const Corner& corner, Tissue low, Tissue high, const glm::vec3& crease_normal, BrickMesh& mesh);
  void triangle(const Corner& a, const Corner& b, const Corner& c, BrickMesh& mesh);
};

constexpr float kSmallEdge = 2.5f;  // voxels; a triangle is small if all its edges are shorter than this

glm::vec3 area_normal(const Corner& a, const Corner& b, const Corner& c) {
  return glm::cross(b.data->position - a.data->position, c.data->position - a.data->position);
}

// Returns the fraction of tissue t at a corner, from the corner's two most frequent tissues.
float fraction(const ContourVertex& v, Tissue t) {
  return v.tissue[0] == t ? 1 - v.second : v.tissue[1] == t ? v.second : 0;
}

std::uint32_t PolygonBuilder::copy_of(const Corner& corner, Tissue low, Tissue high, const glm::vec3& crease_normal,
                                      BrickMesh& mesh) {
  const ContourVertex& v = *corner.data;
  std::uint32_t& first = first_copy[corner.owner][corner.vertex];
  if (!v.crease) {
    for (std::uint32_t i = first; i != kNone; i = copies[i].next) {
      if (copies[i].low == low && copies[i].high == high) return i;
    }
  } else {
    // A copy of the vertex is used again only if its normal is nearly equal. So the two sides of a crease get different
    // copies.
    for (std::uint32_t i = first; i != kNone; i = copies[i].next) {
      if (copies[i].low == low && copies[i].high == high && glm::dot(mesh.vertices[i].normal, crease_normal) > 0.999f) {
        return i;
      }
    }
  }
  SurfaceVertex out;
  out.position = v.position;
  out.normal = v.crease ? crease_normal : v.normal;
  out.tissue[0] = low;
  out.tissue[1] = high;
  const float a = fraction(v, low), b = low == high ? 0 : fraction(v, high);
  const float second = a + b > 0 ? b / (a + b) : v.tissue[0] > low ? 1.f : 0.f;
  out.second = static_cast<std::uint8_t>(std::lround(255 * second));
  const auto number = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back(out);
  mesh.point.push_back(static_cast<std::uint16_t>(corner.vertex));
  mesh.owner.push_back(static_cast<std::uint8_t>(corner.owner));
  copies.push_back({first, low, high, v.crease});
  first = number;
  return number;
}

void PolygonBuilder::triangle(const Corner& a, const Corner& b, const Corner& c, BrickMesh& mesh) {
  const Corner* corners[3] = {&a, &b, &c};
  // Finds the two most frequent tissues of the three corners.
  Tissue low = a.data->tissue[0], high = low;
  bool several = false;
  for (const Corner* corner : corners) several |= corner->data->tissue[0] != low;
  if (several) {
    float total[kTissueCount] = {};
    for (const Corner* corner : corners) {
      total[static_cast<int>(corner->data->tissue[0])] += 1 - corner->data->second;
      total[static_cast<int>(corner->data->tissue[1])] += corner->data->second;
    }
    int best = 0, next = -1;
    for (int t = 1; t < kTissueCount; ++t) {
      if (total[t] > total[best]) best = t;
    }
    for (int t = 0; t < kTissueCount; ++t) {
      if (t != best && (next < 0 || total[t] > total[next])) next = t;
    }
    low = static_cast<Tissue>(std::min(best, next));
    high = static_cast<Tissue>(std::max(best, next));
  }
  // A triangle lies on one side of a crease. Its corners on the crease get the normal of this side, `side`. It is the
  // mean of the normals at the triangle's other corners; if all corners lie on creases, it is the triangle's own
  // normal. Exception: on a gentle crease (like the floor of a fissure that is narrower than a cell), the corner of a
  // small triangle gets the mean normal of both sides, so that the crease looks round.
  glm::vec3 side(0);
  bool small = false;
  if (a.data->crease || b.data->crease || c.data->crease) {
    for (const Corner* corner : corners) {
      if (!corner->data->crease) side += corner->data->normal;
    }
    if (glm::dot(side, side) < 1e-12f) side = area_normal(a, b, c);
    const float length = glm::length(side);
    side = length > 1e-12f ? side / length : a.data->normal;
    small = glm::distance(a.data->position, b.data->position) < kSmallEdge &&
            glm::distance(b.data->position, c.data->position) < kSmallEdge &&
            glm::distance(c.data->position, a.data->position) < kSmallEdge;
  }
  for (const Corner* corner : corners) {
    mesh.indices.push_back(
        copy_of(*corner, low, high, small && corner->data->gentle ? corner->data->normal : side, mesh));
  }
}

// Builds the mesh of a brick (16³ cells). `around`[0] is this brick. `around`[o] is a lower neighbour: if bit a of o is
// set, the neighbour is one brick lower along axis a. nullptr: the neighbour does not exist.
void PolygonBuilder::build(const BrickContour* const around[8], BrickMesh& mesh) {
  const CellShapes& shapes = CellShapes::get();
  const BrickContour& own = *around[0];
  mesh.key = own.key;
  mesh.vertices.clear();
  mesh.indices.clear();
  mesh.point.clear();
  mesh.owner.clear();
  copies.clear();
  for (int o = 0; o < 8; ++o) first_copy[o].assign(around[o] ? around[o]->vertices.size() : 0, kNone);
  std::size_t number = 0;
  for (std::size_t w = 0; w < 64; ++w) {
    for (std::uint64_t bits = own.active[w]; bits; bits &= bits - 1) {
      const BrickContour::Cell cell = own.cells[number++];
      vertex_at[64 * w + static_cast<std::size_t>(std::countr_zero(bits))] =
          shapes[cell.shape].patches == 1 ? cell.vertex : kSeveral;
    }
  }

  // Four cells surround a crossed edge; their vertices are the corners of its polygon.
  for (const BrickContour::Edge edge : own.edges) {
    const int axis = edge.axis, u = (axis + 1) % 3, v = (axis + 2) % 3;
    const glm::ivec3 base(edge.cell >> 8, edge.cell >> 4 & 15, edge.cell & 15);
    static constexpr int kRing[4][2] = {
        // Offsets of the four cells around the edge, along u and v. They are in counter-clockwise order as seen from
        // the positive end of the axis.
        {1, 1},
        {0, 1},
        {0, 0},
        {1, 0}};
    static constexpr int kStep[3] = {kCells * kCells, kCells, 1};
    if (base[u] > 0 && base[v] > 0) {
      // If the four cells around the edge were merged into one block, they have only one vertex, and the polygon has no
      // area. Most polygons inside a brick are of this kind, and they are skipped here.
      const std::uint16_t* at = vertex_at.data() + edge.cell;
      const std::uint16_t first = *at;
      if (first != kSeveral && at[-kStep[u]] == first && at[-kStep[v]] == first && at[-kStep[u] - kStep[v]] == first) {
        continue;
      }
    }
    Corner corners[4];
    int count = 0;
    bool whole = true;
    for (int i = 0; i < 4; ++i) {
      const int down_u = kRing[i][0], down_v = kRing[i][1];
      glm::ivec3 cell = base;
      cell[u] -= down_u;
      cell[v] -= down_v;
      std::uint32_t owner = 0;
      for (int a = 0; a < 3; ++a) {
        if (cell[a] >= 0) continue;
        cell[a] += kCells;
        owner |= 1u << a;
      }
      const BrickContour* contour = around[owner];
      const int index = BrickContour::cell_index(cell.x, cell.y, cell.z);
      std::uint32_t vertex = owner == 0 ? vertex_at[static_cast<std::size_t>(index)] : kSeveral;
      if (vertex == kSeveral) {
        const int found = contour ? contour->find(index) : -1;
        // The brick with this cell does not exist yet. The polygon is omitted, so the surface has a hole here until
        // put() adds the brick.
        if (found < 0) {
          whole = false;
          break;
        }
        const BrickContour::Cell entry = contour->cells[static_cast<std::size_t>(found)];
        // Number of the edge in this cell, among the four edges of the cell that are parallel to `axis`
        // (cell_shapes.h).
        const int k = axis == 1 ? down_v + 2 * down_u : down_u + 2 * down_v;
        vertex = entry.vertex + shapes[entry.shape].patch[static_cast<std::size_t>(4 * axis + k)];
      }
      const Corner corner{owner, vertex, &contour->vertices[vertex]};
      if (count > 0 && corners[count - 1] == corner) continue;
      corners[count++] = corner;
    }
    if (!whole) continue;
    if (count > 1 && corners[0] == corners[count - 1]) --count;
    if (count < 3 || (count == 4 && (corners[0] == corners[2] || corners[1] == corners[3]))) continue;
    if (!edge.solid_base) std::reverse(corners, corners + count);
    if (count == 3) {
      triangle(corners[0], corners[1], corners[2], mesh);
      continue;
    }
    // Splits the quad along the shorter diagonal, unless that diagonal would fold the quad.
    const glm::vec3 n0 = area_normal(corners[0], corners[1], corners[2]),
                    n1 = area_normal(corners[0], corners[2], corners[3]);
    const glm::vec3 m0 = area_normal(corners[1], corners[2], corners[3]),
                    m1 = area_normal(corners[1], corners[3], corners[0]);
    const glm::vec3 whole_normal = n0 + n1;
    const float fold_n = std::min(glm::dot(n0, whole_normal), glm::dot(n1, whole_normal));
    const float fold_m = std::min(glm::dot(m0, whole_normal), glm::dot(m1, whole_normal));
    const glm::vec3 d02 = corners[2].data->position - corners[0].data->position;
    const glm::vec3 d13 = corners[3].data->position - corners[1].data->position;
    bool split_02 = glm::dot(d02, d02) <= glm::dot(d13, d13);
    if (fold_n <= 0 && fold_m > 0) split_02 = false;
    if (fold_m <= 0 && fold_n > 0) split_02 = true;
    if (split_02) {
      triangle(corners[0], corners[1], corners[2], mesh);
      triangle(corners[0], corners[2], corners[3], mesh);
    } else {
      triangle(corners[1], corners[2], corners[3], mesh);
      triangle(corners[1], corners[3], corners[0], mesh);
    }
  }

  // Computes the bounds of the brick's mesh; the renderer does not draw bricks whose bounds are out of view.
  mesh.low = mesh.high = mesh.vertices.empty() ? glm::vec3(0) : mesh.vertices[0].position;
  for (const SurfaceVertex& vertex : mesh.vertices) {
    mesh.low = glm::min(mesh.low, vertex.position);
    mesh.high = glm::max(mesh.high, vertex.position);
  }
  glm::vec3 sum(0);
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const glm::vec3& a = mesh.vertices[mesh.indices[i]].position;
    sum += glm::cross(mesh.vertices[mesh.indices[i + 1]].position - a, mesh.vertices[mesh.indices[i + 2]].position - a);
  }
  mesh.cone_cosine = -1;
  mesh.cone_axis = glm::vec3(0);
  const float length = glm::length(sum);
  if (length > 0) {
    mesh.cone_axis = sum / length;
    mesh.cone_cosine = 1;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      const glm::vec3& a = mesh.vertices[mesh.indices[i]].position;
      const glm::vec3 n =
          glm::cross(mesh.vertices[mesh.indices[i + 1]].position - a, mesh.vertices[mesh.indices[i + 2]].position - a);
      const float area = glm::length(n);
      if (area > 0) mesh.cone_cosine = std::min(mesh.cone_cosine, glm::dot(n, mesh.cone_axis) / area);
    }
  }
}

}  // namespace

struct SurfaceMesher::State {
  MesherOptions options;
  Contourer contourer;
  PolygonBuilder weaver;
  std::unordered_map<glm::ivec3, Brick, KeyHash> bricks;
  std::vector<glm::ivec3> queue;  // keys of the bricks (blocks of 16³ cells) that must be meshed again
  std::vector<glm::ivec3> changed;

  void enqueue_around(const glm::ivec3& key) {
    // Polygons join a brick's cells with cells of its lower neighbours. So if a brick (16³ cells) changes, its upper
    // neighbours change, too.
    for (int o = 0; o < 8; ++o) {
      const glm::ivec3 upper = key + glm::ivec3(o & 1, o >> 1 & 1, o >> 2);
      const auto it = bricks.find(upper);
      if (it == bricks.end() || it->second.queued) continue;
      it->second.queued = true;
      queue.push_back(upper);
    }
  }
};

SurfaceMesher::SurfaceMesher(const MesherOptions& options) : state_(std::make_unique<State>()) {
  state_->options = options;
}
SurfaceMesher::~SurfaceMesher() = default;
SurfaceMesher::SurfaceMesher(SurfaceMesher&&) noexcept = default;
SurfaceMesher& SurfaceMesher::operator=(SurfaceMesher&&) noexcept = default;

void SurfaceMesher::set_tolerance(float tolerance) {
  state_->options.tolerance = tolerance;
}

void SurfaceMesher::put(const FieldBrick& brick) {
  Brick& entry = state_->bricks[brick.key];
  state_->contourer.contour(brick, state_->options.tolerance, entry.contour);
  state_->enqueue_around(brick.key);
}

void SurfaceMesher::remove(const glm::ivec3& key) {
  const auto it = state_->bricks.find(key);
  if (it == state_->bricks.end()) return;
  it->second.contour = BrickContour{};
  it->second.contour.key = key;
  state_->enqueue_around(key);
}

std::span<const glm::ivec3> SurfaceMesher::remesh() {
  State& s = *state_;
  s.changed.clear();
  std::sort(s.queue.begin(), s.queue.end(), key_less);
  for (const glm::ivec3& key : s.queue) {
    Brick& brick = s.bricks.find(key)->second;
    brick.queued = false;
    const bool was_empty = brick.mesh.indices.empty();
    const BrickContour* around[8];
    for (int o = 0; o < 8; ++o) {
      const auto it = o == 0 ? s.bricks.find(key) : s.bricks.find(key - glm::ivec3(o & 1, o >> 1 & 1, o >> 2));
      around[o] = it == s.bricks.end() ? nullptr : &it->second.contour;
    }
    s.weaver.build(around, brick.mesh);
    if (!was_empty || !brick.mesh.indices.empty()) s.changed.push_back(key);
  }
  // Erases a brick (16³ cells) without surface if no other brick refers to it.
  for (const glm::ivec3& key : s.queue) {
    const auto it = s.bricks.find(key);
    if (it->second.contour.empty() && it->second.mesh.indices.empty()) s.bricks.erase(it);
  }
  s.queue.clear();
  return s.changed;
}

const BrickMesh* SurfaceMesher::find(const glm::ivec3& key) const {
  const auto it = state_->bricks.find(key);
  return it == state_->bricks.end() || it->second.mesh.indices.empty() ? nullptr : &it->second.mesh;
}

std::vector<glm::ivec3> SurfaceMesher::keys() const {
  std::vector<glm::ivec3> keys;
  for (const auto& [key, brick] : state_->bricks) {
    if (!brick.mesh.indices.empty()) keys.push_back(key);
  }
  std::sort(keys.begin(), keys.end(), key_less);
  return keys;
}

std::size_t SurfaceMesher::triangle_count() const {
  std::size_t count = 0;
  for (const auto& [key, brick] : state_->bricks) count += brick.mesh.indices.size() / 3;
  return count;
}

std::uint64_t SurfaceMesher::hash() const {
  std::uint64_t h = 0xcbf29ce484222325u;  // FNV-1a hash over 32-bit words
  auto mix = [&h](std::uint32_t word) { h = (h ^ word) * 0x100000001b3u; };
  auto mix_float = [&mix](float f) { mix(std::bit_cast<std::uint32_t>(f)); };
  for (const glm::ivec3& key : keys()) {
    const BrickMesh& mesh = *find(key);
    for (int a = 0; a < 3; ++a) mix(static_cast<std::uint32_t>(key[a]));
    for (const SurfaceVertex& v : mesh.vertices) {
      for (int a = 0; a < 3; ++a) mix_float(v.position[a]);
      for (int a = 0; a < 3; ++a) mix_float(v.normal[a]);
      mix(static_cast<std::uint32_t>(v.tissue[0]) | static_cast<std::uint32_t>(v.tissue[1]) << 8 |
          static_cast<std::uint32_t>(v.second) << 16);
    }
    for (const std::uint32_t index : mesh.indices) mix(index);
  }
  return h;
}

}  // namespace typodont::surface
