#include "engine/surface/surface_mesher.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <unordered_map>
#include <utility>

#include "engine/base/voxels.h"
#include "engine/surface/contour/brick_contour.h"
#include "engine/surface/contour/cell_shapes.h"

namespace typodont::surface {
namespace {

struct Brick {
  glm::ivec3 key{0};
  BrickContour contour;
  BrickMesh mesh;              // empty if the mesher does not keep the meshes
  bool has_triangles = false;  // true if the last mesh of this brick had triangles
  bool queued = false;
};

constexpr std::uint32_t kNone = 0xffffffff;
constexpr std::uint16_t kSeveral = 0xffff;

// Vertex of this brick (owner 0) or of a neighbouring brick with lower coordinates (owner 1 to 7).
struct Corner {
  std::uint32_t owner, vertex;
  const ContourVertex* data;
  bool operator==(const Corner& o) const { return owner == o.owner && vertex == o.vertex; }
};

// Builds the polygons of one brick at a time and reuses its memory.
struct PolygonBuilder {
  struct Copy {
    std::uint32_t next;
    Tissue low, high;
    std::uint8_t owner;
    std::uint16_t point;
  };
  BrickMesh mesh;
  std::vector<std::uint32_t> first_copy[8];  // for each vertex of each brick: index in `copies` of its first copy
  std::vector<Copy> copies;                  // for each vertex of `mesh`: the brick's vertex of which it is a copy
  std::uint32_t* index_end = nullptr;        // end of the indices that were written to `mesh`
  // For each cell with surface: its vertex, or kSeveral.
  std::vector<std::uint16_t> vertex_at =
      std::vector<std::uint16_t>(FieldBrick::kCells * FieldBrick::kCells * FieldBrick::kCells);

  void build(const BrickContour* const around[8]);

 private:
  bool find_corners(const BrickContour* const around[8], BrickContour::Edge edge, Corner corners[4], int& count) const;
  std::uint32_t copy_of(const Corner& corner, Tissue low, Tissue high, const glm::vec3& crease_normal);
  std::uint32_t new_copy(const Corner& corner, Tissue low, Tissue high, const glm::vec3& crease_normal);
  void triangle(const Corner& a, const Corner& b, const Corner& c);
  void quad(const Corner& a, const Corner& b, const Corner& c, const Corner& d);
  void two_triangles(const Corner& a, const Corner& b, const Corner& c, const Corner& d);
  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    index_end[0] = a, index_end[1] = b, index_end[2] = c;
    index_end += 3;
  }
};

constexpr float kSmallEdge = 2.5f;  // voxels, limit for the edges of a small triangle

glm::vec3 area_normal(const Corner& a, const Corner& b, const Corner& c) {
  return glm::cross(b.data->position - a.data->position, c.data->position - a.data->position);
}

// Returns the fraction of tissue t at a vertex if t is one of its two most frequent tissues, else 0.
float fraction(const ContourVertex& v, Tissue t) {
  return v.tissue[0] == t ? 1 - v.second : v.tissue[1] == t ? v.second : 0;
}

// Returns the copy of a vertex that has the tissues `low` and `high`; creates this copy if it does not exist.
inline std::uint32_t PolygonBuilder::copy_of(const Corner& corner, Tissue low, Tissue high,
                                             const glm::vec3& crease_normal) {
  const bool crease = corner.data->crease;
  for (std::uint32_t i = first_copy[corner.owner][corner.vertex]; i != kNone; i = copies[i].next) {
    // The sides of a crease have different normals, so a copy on a crease is shared only if its normal is nearly equal.
    if (copies[i].low == low && copies[i].high == high &&
        (!crease || glm::dot(mesh.vertices[i].normal, crease_normal) > 0.999f)) {
      return i;
    }
  }
  return new_copy(corner, low, high, crease_normal);
}

std::uint32_t PolygonBuilder::new_copy(const Corner& corner, Tissue low, Tissue high, const glm::vec3& crease_normal) {
  const ContourVertex& v = *corner.data;
  std::uint32_t& first = first_copy[corner.owner][corner.vertex];
  const auto number = static_cast<std::uint32_t>(mesh.vertices.size());
  SurfaceVertex& out = mesh.vertices.emplace_back();
  out.position = v.position;
  out.normal = v.crease ? crease_normal : v.normal;
  out.tissue[0] = low;
  out.tissue[1] = high;
  if (low != high) {
    const float a = fraction(v, low), b = fraction(v, high);
    const float second = a + b > 0 ? b / (a + b) : v.tissue[0] > low ? 1.f : 0.f;
    out.second = static_cast<std::uint8_t>(std::lround(255 * second));
  }
  copies.push_back(
      {first, low, high, static_cast<std::uint8_t>(corner.owner), static_cast<std::uint16_t>(corner.vertex)});
  first = number;
  return number;
}

void PolygonBuilder::triangle(const Corner& a, const Corner& b, const Corner& c) {
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
  // Corners on a crease get the normal `side`: the mean normal of the corners that are on no crease; if there are none,
  // the triangle's normal. On a gentle crease (narrow fissure), small triangles get the mean normal of both sides.
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
  const auto copy = [&](const Corner& corner) {
    return copy_of(corner, low, high, small && corner.data->gentle ? corner.data->normal : side);
  };
  const std::uint32_t first = copy(a), second = copy(b), third = copy(c);
  add(first, second, third);
}

// Adds the triangles a b c and a c d.
inline void PolygonBuilder::two_triangles(const Corner& a, const Corner& b, const Corner& c, const Corner& d) {
  // Usually there is one tissue and no crease, so both triangles use the same copy of a shared corner.
  const Tissue tissue = a.data->tissue[0];
  if (b.data->tissue[0] == tissue && c.data->tissue[0] == tissue && d.data->tissue[0] == tissue && !a.data->crease &&
      !b.data->crease && !c.data->crease && !d.data->crease) {
    const glm::vec3 none(0);
    const std::uint32_t first = copy_of(a, tissue, tissue, none), second = copy_of(b, tissue, tissue, none),
                        third = copy_of(c, tissue, tissue, none), fourth = copy_of(d, tissue, tissue, none);
    add(first, second, third);
    add(first, third, fourth);
    return;
  }
  triangle(a, b, c);
  triangle(a, c, d);
}

// Splits the quad along the shorter diagonal, or along the longer one if only the shorter one would fold the quad.
inline void PolygonBuilder::quad(const Corner& a, const Corner& b, const Corner& c, const Corner& d) {
  const glm::vec3 &pa = a.data->position, &pb = b.data->position, &pc = c.data->position, &pd = d.data->position;
  const glm::vec3 ac = pc - pa, bd = pd - pb;
  // area vectors of the triangles on both sides of the diagonal a–c, and their sum
  const glm::vec3 abc = glm::cross(pb - pa, ac), acd = glm::cross(ac, pd - pa), whole = abc + acd;
  const auto folds_ac = [&] { return std::min(glm::dot(abc, whole), glm::dot(acd, whole)) <= 0; };
  const auto folds_bd = [&] {
    const glm::vec3 bcd = area_normal(b, c, d), bda = area_normal(b, d, a);
    return std::min(glm::dot(bcd, whole), glm::dot(bda, whole)) <= 0;
  };
  bool split_ac = glm::dot(ac, ac) <= glm::dot(bd, bd);
  if (split_ac ? folds_ac() && !folds_bd() : folds_bd() && !folds_ac()) split_ac = !split_ac;
  if (split_ac) {
    two_triangles(a, b, c, d);
  } else {
    two_triangles(b, c, d, a);
  }
}

// Finds the vertices of the four cells around a crossed edge, counter-clockwise as seen from its positive end. Returns
// false if they form no polygon.
inline bool PolygonBuilder::find_corners(const BrickContour* const around[8], BrickContour::Edge edge,
                                         Corner corners[4], int& count) const {
  static constexpr int kStep[3] = {FieldBrick::kCells * FieldBrick::kCells, FieldBrick::kCells, 1};
  // bits of a cell's number that store the cell's coordinate on each axis
  static constexpr int kBits[3] = {0xf00, 0x0f0, 0x00f};
  const int axis = edge.axis, u = axis == 2 ? 0 : axis + 1, v = axis == 0 ? 2 : axis - 1;
  if ((edge.cell & kBits[u]) && (edge.cell & kBits[v])) {
    // Usual case: all four cells are in this brick, and each cell has a single vertex.
    const std::uint16_t* at = vertex_at.data() + edge.cell;
    const std::uint16_t ring[4] = {at[-kStep[u] - kStep[v]], at[-kStep[v]], *at, at[-kStep[u]]};
    if (ring[0] != kSeveral && ring[1] != kSeveral && ring[2] != kSeveral && ring[3] != kSeveral) {
      const ContourVertex* const own = around[0]->vertices.data();
      corners[0] = {0, ring[0], own + ring[0]};
      count = 1;
      for (int i = 1; i < 4; ++i) {
        if (ring[i] != ring[i - 1] && (i < 3 || ring[i] != ring[0])) corners[count++] = {0, ring[i], own + ring[i]};
      }
      return count > 2 && ring[0] != ring[2] && ring[1] != ring[3];
    }
  }
  const CellShapes& shapes = CellShapes::get();
  // for each of the four cells around the edge: number of cells, 0 or 1, by which it is lower along u, and along v
  static constexpr int kRing[4][2] = {{1, 1}, {0, 1}, {0, 0}, {1, 0}};
  const glm::ivec3 base(edge.cell >> 8, edge.cell >> 4 & 15, edge.cell & 15);
  count = 0;
  for (int i = 0; i < 4; ++i) {
    const int down_u = kRing[i][0], down_v = kRing[i][1];
    glm::ivec3 cell = base;
    cell[u] -= down_u;
    cell[v] -= down_v;
    std::uint32_t owner = 0;
    for (int a = 0; a < 3; ++a) {
      if (cell[a] >= 0) continue;
      cell[a] += FieldBrick::kCells;
      owner |= 1u << a;
    }
    const BrickContour* contour = around[owner];
    const int index = BrickContour::cell_index(cell.x, cell.y, cell.z);
    std::uint32_t vertex = owner == 0 ? vertex_at[static_cast<std::size_t>(index)] : kSeveral;
    if (vertex == kSeveral) {
      const int found = contour ? contour->find(index) : -1;
      // If the neighbouring brick is missing, the mesh has a hole until put() adds this brick.
      if (found < 0) return false;
      const BrickContour::Cell entry = contour->cells[static_cast<std::size_t>(found)];
      // number of the edge among the cell's four edges parallel to `axis` (cell_shapes.h)
      const int k = axis == 1 ? down_v + 2 * down_u : down_u + 2 * down_v;
      vertex = entry.vertex + shapes[entry.shape].patch[static_cast<std::size_t>(4 * axis + k)];
    }
    const Corner corner{owner, vertex, &contour->vertices[vertex]};
    if (count > 0 && corners[count - 1] == corner) continue;
    corners[count++] = corner;
  }
  if (count > 1 && corners[0] == corners[count - 1]) --count;
  return count > 2 && (count == 3 || (corners[0] != corners[2] && corners[1] != corners[3]));
}

// Builds the mesh of brick around[0]. around[o]: its neighbour that is one brick lower along each axis whose bit is set
// in o; null: this neighbour is missing.
void PolygonBuilder::build(const BrickContour* const around[8]) {
  const CellShapes& shapes = CellShapes::get();
  const BrickContour& own = *around[0];
  mesh.key = own.key;
  mesh.vertices.clear();
  mesh.indices.resize(6 * own.edges.size());  // room for the triangles of all edges
  index_end = mesh.indices.data();
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

  Corner corners[4];
  int count = 0;
  for (const BrickContour::Edge edge : own.edges) {
    if (!find_corners(around, edge, corners, count)) continue;
    // Passes the corners as separate arguments, because an array would first have to be copied into the right order.
    if (count == 3) {
      if (edge.solid_base) {
        triangle(corners[0], corners[1], corners[2]);
      } else {
        triangle(corners[2], corners[1], corners[0]);
      }
    } else if (edge.solid_base) {
      quad(corners[0], corners[1], corners[2], corners[3]);
    } else {
      quad(corners[3], corners[2], corners[1], corners[0]);
    }
  }
  mesh.indices.resize(static_cast<std::size_t>(index_end - mesh.indices.data()));
  mesh.point.resize(copies.size());
  mesh.owner.resize(copies.size());
  for (std::size_t i = 0; i < copies.size(); ++i) {
    mesh.point[i] = copies[i].point;
    mesh.owner[i] = copies[i].owner;
  }
}

}  // namespace

struct SurfaceMesher::State {
  MesherOptions options;
  Contourer contourer;
  PolygonBuilder weaver;
  // The map is searched often. It stores only pointers, so that it is small and stays in the processor's cache.
  std::unordered_map<glm::ivec3, std::unique_ptr<Brick>, KeyHash> bricks;
  std::unique_ptr<Brick> spare = std::make_unique<Brick>();  // unused; becomes the next new brick (16³ cells)
  std::vector<Brick*> queue;                                 // bricks (blocks of 16³ cells) that must be meshed again
  std::vector<glm::ivec3> changed;

  Brick* find(const glm::ivec3& key) const {
    const auto it = bricks.find(key);
    return it == bricks.end() ? nullptr : it->second.get();
  }
  void enqueue_around(const glm::ivec3& key) {
    // Also queues the neighbours with higher indices, because their polygons use this brick's cells.
    for (int o = 0; o < 8; ++o) {
      Brick* const upper = find(key + glm::ivec3(o & 1, o >> 1 & 1, o >> 2));
      if (!upper || upper->queued) continue;
      upper->queued = true;
      queue.push_back(upper);
    }
  }
  /// Calls `changed_to(brick, mesh)` for each changed brick that has triangles now or had some before.
  template <class Changed>
  void remesh(const Changed& changed_to) {
    std::sort(queue.begin(), queue.end(), [](const Brick* a, const Brick* b) { return LessByAxes{}(a->key, b->key); });
    for (Brick* const brick : queue) {
      brick->queued = false;
      const BrickContour* around[8] = {&brick->contour};
      for (int o = 1; o < 8; ++o) {
        const Brick* const lower = find(brick->key - glm::ivec3(o & 1, o >> 1 & 1, o >> 2));
        around[o] = lower ? &lower->contour : nullptr;
      }
      weaver.build(around);
      const bool had_triangles = std::exchange(brick->has_triangles, !weaver.mesh.indices.empty());
      if (had_triangles || brick->has_triangles) changed_to(*brick, weaver.mesh);
    }
    // Erases bricks without surface.
    for (const Brick* const brick : queue) {
      if (brick->contour.empty() && !brick->has_triangles) bricks.erase(brick->key);
    }
    queue.clear();
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
  State& s = *state_;
  Brick* const known = s.find(brick.key);
  Brick& changed = known ? *known : *s.spare;
  s.contourer.contour(brick, s.options.tolerance, changed.contour);
  if (!known) {
    if (changed.contour.empty()) return;  // neither this brick (16³ cells) nor its neighbours change
    changed.key = brick.key;
    s.bricks.emplace(brick.key, std::exchange(s.spare, std::make_unique<Brick>()));
  }
  s.enqueue_around(brick.key);
}

void SurfaceMesher::remove(const glm::ivec3& key) {
  Brick* const brick = state_->find(key);
  if (!brick) return;
  brick->contour = BrickContour{};
  brick->contour.key = key;
  state_->enqueue_around(key);
}

std::span<const glm::ivec3> SurfaceMesher::remesh() {
  State& s = *state_;
  s.changed.clear();
  s.remesh([&s](Brick& brick, const BrickMesh& mesh) {
    brick.mesh = mesh;
    s.changed.push_back(brick.key);
  });
  return s.changed;
}

void SurfaceMesher::remesh(const std::function<void(const BrickMesh&)>& visit) {
  state_->remesh([&visit](const Brick&, const BrickMesh& mesh) { visit(mesh); });
}

const BrickMesh* SurfaceMesher::find(const glm::ivec3& key) const {
  const Brick* const brick = state_->find(key);
  return !brick || brick->mesh.indices.empty() ? nullptr : &brick->mesh;
}

std::vector<glm::ivec3> SurfaceMesher::keys() const {
  std::vector<glm::ivec3> keys;
  for (const auto& [key, brick] : state_->bricks) {
    if (!brick->mesh.indices.empty()) keys.push_back(key);
  }
  std::sort(keys.begin(), keys.end(), LessByAxes{});
  return keys;
}

}  // namespace typodont::surface
