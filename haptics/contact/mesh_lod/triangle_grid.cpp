#include "haptics/contact/mesh_lod/triangle_grid.h"

#include <cmath>
#include <limits>
#include <numeric>

#include "engine/base/nearest.h"
#include "engine/base/voxels.h"

namespace typodont::haptics::mesh_lod {

namespace {

constexpr double kCellEdges = 1.5;  // edge of a grid cell divided by the mesh's mean edge
constexpr double kMaxCells = 4e6;
// The cells of the grid together list at most this × (number of faces) + kFewEntries faces; else cells become larger.
constexpr double kEntriesPerFace = 16;
// number of faces that all cells may list in addition, so that a small mesh does not get larger cells
constexpr double kFewEntries = 1e6;

/// Returns 1 if the origin is left of the line a–b, -1 if right. An origin on the line counts as moved slightly along
/// the first axis, and less along the second, so exactly one of two adjacent faces contains it.
int side(double au, double av, double bu, double bv) noexcept {
  const double one = au * bv, other = bu * av;
  if (one != other) return one > other ? 1 : -1;
  if (av != bv) return av > bv ? 1 : -1;
  return bu > au ? 1 : -1;
}

// m; two adjacent faces count as flat if the third vertex of one is no farther from the plane of the other
constexpr double kFlat = 1e-10;

/// Stores on which sides of a face an edge is concave or flat. `beyond`: third vertex of the face beyond this edge.
void note_bend(Face& face, int edge, const dvec3& beyond) {
  const dvec3 n = face.normal();
  const double size = glm::length(n);
  if (!(size > 0)) return;
  const double height = glm::dot(n, beyond - face.a) / size;
  const auto bit = static_cast<std::uint8_t>(1 << edge);
  if (height >= -kFlat) face.hollow_front |= bit;
  if (height <= kFlat) face.hollow_back |= bit;
}

}  // namespace

OnFace nearest_on(const Face& face, const dvec3& p) noexcept {
  const dvec3 e = face.b - face.a, f = face.c - face.a, v = p - face.a;
  const double ee = glm::dot(e, e), ef = glm::dot(e, f), ff = glm::dot(f, f);
  const double ve = glm::dot(v, e), vf = glm::dot(v, f), det = ee * ff - ef * ef;
  const double s = ff * ve - ef * vf, t = ee * vf - ef * ve;
  if (det > kSliver * ee * ff && s >= 0 && t >= 0 && s + t <= det) return {face.a + (s * e + t * f) / det};
  OnFace best;
  double best2 = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const dvec3 a = face.corner(i), b = face.corner(i == 2 ? 0 : i + 1);
    const double part = nearest_fraction(a, b, p);
    const dvec3 q = a + part * (b - a);
    if (const double d2 = glm::dot(p - q, p - q); d2 < best2) {
      best = {q, i, part == 0 || part == 1};
      best2 = d2;
    }
  }
  return best;
}

TriangleGrid::TriangleGrid(const TissueMesh& mesh, bool part) : part_(part) {
  if (mesh.triangles.empty()) return;
  dvec3 lo(1e300), hi(-1e300);
  for (const glm::uvec3& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) lo = glm::min(lo, mesh.vertices[t[k]]), hi = glm::max(hi, mesh.vertices[t[k]]);
  }
  origin_ = lo;
  const auto face_of = [&](std::size_t i) {
    const glm::uvec3& t = mesh.triangles[i];
    return Face{mesh.vertices[t.x], mesh.vertices[t.y], mesh.vertices[t.z], mesh.tissue[i], {}};
  };
  double edges = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Face face = face_of(i);
    edges += glm::distance(face.a, face.b) + glm::distance(face.b, face.c) + glm::distance(face.c, face.a);
  }
  cell_ = std::max(kCellEdges * edges / (3 * static_cast<double>(mesh.triangles.size())), 1e-6);
  if (part) sort_faces(mesh);
  faces_.reserve(mesh.triangles.size());
  boxes_.reserve(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const Face face = face_of(rank(i));
    faces_.push_back(face);
    boxes_.push_back({glm::vec3(glm::min(face.a, glm::min(face.b, face.c)) - origin_) - kBoxRounding,
                      glm::vec3(glm::max(face.a, glm::max(face.b, face.c)) - origin_) + kBoxRounding});
  }
  for (Block& block : blocks_) {
    block.box = boxes_[block.first];
    for (std::uint32_t i = block.first; i < block.last; ++i) {
      block.box.lo = glm::min(block.box.lo, boxes_[i].lo), block.box.hi = glm::max(block.box.hi, boxes_[i].hi);
    }
  }
  join_faces(mesh);
  const glm::vec3 extent(hi - lo);
  const double max_entries = kEntriesPerFace * static_cast<double>(faces_.size()) + kFewEntries;
  for (;; cell_ *= 1.5) {
    choose_cells(extent);
    double entries = 0;
    for (const Box& box : boxes_) {
      const glm::dvec3 span(cell_of(box.hi) - cell_of(box.lo) + 1);
      entries += span.x * span.y * span.z;
    }
    if (static_cast<double>(cells_.x) * cells_.y * cells_.z <= kMaxCells && entries <= max_entries) break;
  }
  start_.assign(voxel_count(cells_) + 1, 0);
  const auto each_cell = [&](const Box& box, const auto& use) {
    const glm::ivec3 first = cell_of(box.lo), last = cell_of(box.hi);
    for_each_voxel_between(first, last, [&](int x, int y, int z) { use(index({x, y, z})); });
  };
  for (const Box& box : boxes_) each_cell(box, [&](std::size_t at) { ++start_[at + 1]; });
  std::partial_sum(start_.begin(), start_.end(), start_.begin());
  entries_.resize(start_.back());
  std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
  // Sorts the faces of each cell into the order of the mesh.
  std::vector<std::uint32_t> by_rank(rank_.size());
  for (std::uint32_t i = 0; i < rank_.size(); ++i) by_rank[rank_[i]] = i;
  for (std::uint32_t k = 0; k < boxes_.size(); ++k) {
    const std::uint32_t i = part_ ? by_rank[k] : k;
    each_cell(boxes_[i], [&](std::size_t at) { entries_[next[at]++] = i; });
  }
}

/// Sorts faces so that neighbours are near in memory.
void TriangleGrid::sort_faces(const TissueMesh& mesh) {
  constexpr double kBlock = 4;        // edge length of a block, in cells
  constexpr double kMaxBlocks = 1e6;  // upper limit of the number of blocks
  const auto corner_of = [&](std::size_t i) {
    const glm::uvec3& t = mesh.triangles[i];
    return glm::min(mesh.vertices[t.x], glm::min(mesh.vertices[t.y], mesh.vertices[t.z])) - origin_;
  };
  dvec3 extent(0);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) extent = glm::max(extent, corner_of(i));
  double block = kBlock * cell_;
  glm::dvec3 count(1);
  for (;; block *= 2) {
    count = glm::floor(extent / block) + 1.0;
    if (count.x * count.y * count.z <= kMaxBlocks) break;
  }
  const auto block_of = [&](std::size_t i) {
    const glm::dvec3 at = glm::floor(corner_of(i) / block);
    return static_cast<std::size_t>((at.x * count.y + at.y) * count.z + at.z);
  };
  std::vector<std::uint32_t> start(static_cast<std::size_t>(count.x * count.y * count.z) + 1);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) ++start[block_of(i) + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  rank_.resize(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) rank_[start[block_of(i)]++] = i;
  // start[k] now contains the end of block k.
  for (std::size_t k = 0; k + 1 < start.size(); ++k) {
    const std::uint32_t first = k == 0 ? 0 : start[k - 1];
    if (start[k] > first) blocks_.push_back({{}, first, start[k]});
  }
}

/// Sets, for each edge of each face, the adjacent face, and its tissue if this differs.
void TriangleGrid::join_faces(const TissueMesh& mesh) {
  // An edge of one face. After sorting, the faces of an edge are consecutive.
  struct Side {
    std::uint32_t a, b, rank, face;
    int edge;
    bool operator<(const Side& o) const { return a != o.a ? a < o.a : b != o.b ? b < o.b : rank < o.rank; }
  };
  std::vector<Side> sides;
  sides.reserve(3 * faces_.size());
  for (std::uint32_t i = 0; i < faces_.size(); ++i) {
    const glm::uvec3& t = mesh.triangles[rank(i)];
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), rank(i), i, k});
    }
  }
  std::ranges::sort(sides, std::less<>());
  const auto same_edge = [](const Side& s, const Side& o) { return s.a == o.a && s.b == o.b; };
  for (auto first = sides.begin(), end = first; first != sides.end(); first = end) {
    end = std::find_if(first, sides.end(), [&](const Side& s) { return !same_edge(s, *first); });
    for (auto i = first; i + 1 != end; ++i) {
      const Side &s = *i, &o = *(i + 1);
      Face &f = faces_[s.face], &g = faces_[o.face];
      if (f.tissue != g.tissue) {
        f.across[static_cast<std::size_t>(s.edge)] = g.tissue;
        g.across[static_cast<std::size_t>(o.edge)] = f.tissue;
      }
      if (end - first != 2) continue;
      f.beyond[static_cast<std::size_t>(s.edge)] = o.face;
      g.beyond[static_cast<std::size_t>(o.edge)] = s.face;
      note_bend(f, s.edge, g.corner((o.edge + 2) % 3));
      note_bend(g, o.edge, f.corner((s.edge + 2) % 3));
    }
  }
}

void TriangleGrid::choose_cells(const glm::vec3& extent) {
  inverse_ = static_cast<float>(1 / cell_);
  cells_ = glm::ivec3(glm::min(extent * inverse_, glm::vec3(1e5f))) + 1;
}

TriangleGrid::Nearest TriangleGrid::nearest(const dvec3& p, double most) const noexcept {
  Nearest best;
  best.distance = most;
  // Doubles the search distance until the nearest face is certain.
  for (double reach = std::min(cell_, most);; reach = std::min(2 * reach, most)) {
    for_near(p - reach, p + reach, [&](std::uint32_t i) {
      const dvec3 q = nearest_on(faces_[i], p).p;
      const double d = glm::distance(p, q);
      if (d < best.distance || (d == best.distance && !best.found)) best = {true, i, q, d};
    });
    if (reach >= most || (best.found && best.distance <= reach)) return best;
  }
}

bool TriangleGrid::inside(const dvec3& p) const noexcept {
  if (!part_) return winding_sixths(p) >= 3;
  constexpr double kFar = 2e-3;  // m, search distance for the nearest face
  const Nearest near = nearest(p, kFar);
  return near.found && glm::dot(faces_[near.face].normal(), p - near.p) < 0;
}

int TriangleGrid::winding_sixths(const dvec3& p) const noexcept {
  if (faces_.empty()) return 0;
  int sixths = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    dvec3 lo = p, hi = p;
    lo[axis] = origin_[axis] - 1, hi[axis] = origin_[axis] + 10;
    for_near(lo, hi, [&](std::uint32_t i) {
      const Face& f = faces_[i];
      int w[3];
      for (int k = 0; k < 3; ++k) {
        const dvec3 a = f.corner((k + 1) % 3), b = f.corner((k + 2) % 3);
        w[k] = side(a[u] - p[u], a[v] - p[v], b[u] - p[u], b[v] - p[v]);
      }
      const bool left = w[0] > 0 && w[1] > 0 && w[2] > 0, right = w[0] < 0 && w[1] < 0 && w[2] < 0;
      if (!left && !right) return;
      const dvec3 n = f.normal();
      // m, distance of the face from p along the ray
      const double above = glm::dot(n, f.a - p) / n[axis];
      sixths += (above > 0) == left ? 1 : -1;
    });
  }
  return sixths;
}

}  // namespace typodont::haptics::mesh_lod
