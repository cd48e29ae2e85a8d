// A triangle mesh that is changed in place (split, flip, collapse, move), with neighbours, a grid of faces and undo.
// Open borders remain. Equal calls give bit-identical meshes. Allocates only where stated. Positions in m, frame W.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "haptics/tissue_mesh.h"

namespace typodont::haptics::mesh {

using Index = std::uint32_t;
inline constexpr Index kNone = 0xffffffff;

struct Vertex {
  dvec3 p{0};          // m, frame W, position of the vertex
  Index face = kNone;  // one of its faces; kNone: the vertex is not used
  Index flags = 0;     // kBorder, kMoved; of an unused vertex: the next unused one
  bool on_border() const { return flags & kBorder; }
  bool was_moved() const { return flags & kMoved; }
  static constexpr Index kBorder = 1, kMoved = 2;
};

/// Edge i leads from v[i] to v[(i+1)%3]. n[i]: the neighbouring face at edge i, or kNone.
struct Face {
  // Counter-clockwise seen from outside. Unused face: v[0] is kNone, v[1] is the next unused face.
  Index v[3] = {kNone, kNone, kNone};
  Index n[3] = {kNone, kNone, kNone};
  Tissue tissue = Tissue::kAir;  // tissue below the face
};

/// Vertices and faces before they changed; EditableMesh::exchange() swaps them.
struct MeshRecord {
  std::vector<std::pair<Index, Vertex>> vertices;
  std::vector<std::pair<Index, Face>> faces;
  Index vertices_used = 0, faces_used = 0, free_vertex = kNone, free_face = kNone;
  bool empty() const { return vertices.empty() && faces.empty(); }
};

class EditableMesh {
 public:
  static constexpr int kMaxAround = 64;  // largest number of faces around a vertex whose edges can collapse
  EditableMesh() = default;
  /// `edge`: m, longest edge in the finest level of the grid; `spare`: vertices that can be added. An edge becomes a
  /// border if it has more than two faces, or faces of inconsistent orientation. Fans that share a vertex are
  /// separated; degenerate triangles are omitted.
  EditableMesh(const TissueMesh& mesh, double edge, std::size_t spare);
  EditableMesh(const EditableMesh& other);
  EditableMesh& operator=(const EditableMesh& other);
  EditableMesh(EditableMesh&&) noexcept = default;
  EditableMesh& operator=(EditableMesh&&) noexcept = default;
  ~EditableMesh() = default;

  // Some indices are not used; see uses().
  const Vertex& vertex(Index v) const noexcept { return vertices_[v]; }
  const Face& face(Index f) const noexcept { return faces_[f]; }
  const dvec3& point(Index f, int corner) const noexcept { return vertices_[faces_[f].v[corner]].p; }
  bool uses(Index f) const noexcept { return faces_[f].v[0] != kNone; }
  Index vertex_range() const noexcept { return vertices_used_; }
  Index face_range() const noexcept { return faces_used_; }
  std::size_t vertex_count() const noexcept { return vertex_count_; }
  std::size_t face_count() const noexcept { return face_count_; }
  std::size_t vertex_capacity() const noexcept { return vertices_.size(); }
  std::size_t face_capacity() const noexcept { return faces_.size(); }
  std::size_t border_edges() const noexcept;
  /// Mesh as a TissueMesh, without unused vertices and faces.
  TissueMesh copy() const;

  // The following functions return kNone or false, and change nothing, if the change is impossible.
  void move(Index v, const dvec3& p) noexcept;  // moves v to p (m, frame W), and sets kMoved
  /// Undoes move(v): restores position and flags. `before`: vertex(v) before the move.
  void move_back(Index v, const Vertex& before) noexcept;
  void set_tissue(Index f, Tissue tissue) noexcept;
  /// Updates the grid of faces. Call after move(): settle() for the vertex, or settle_face() for each face around it.
  void settle(Index v) noexcept;
  void settle_face(Index f) noexcept { place(f); }
  /// Splits edge i of face f at p. Returns the new vertex; kNone: the edge is on a border, or there is no free vertex.
  Index split(Index f, int i, const dvec3& p) noexcept;
  /// Replaces edge i by the other diagonal of its two faces. Returns false at a border, or if the new edge exists.
  bool flip(Index f, int i) noexcept;
  /// Collapses edge i: removes its first end, or with `keeps_first` its second. Returns false at a border, or if the
  /// surface would touch itself.
  bool collapse(Index f, int i, bool keeps_first) noexcept;
  bool may_collapse(Index f, int i, bool keeps_first) const noexcept;

  /// Calls fn(face, corner at v) for the faces around v, counter-clockwise unless v is on a border.
  template <class Fn>
  void around(Index v, Fn&& fn) const noexcept(noexcept(fn(Index{}, 0))) {
    const Index first = vertices_[v].face;
    Index f = first;
    do {
      const int c = corner(f, v);
      fn(f, c);
      f = faces_[f].n[(c + 2) % 3];
    } while (f != kNone && f != first);
    if (f == first) return;
    f = faces_[first].n[corner(first, v)];
    while (f != kNone) {
      const int c = corner(f, v);
      fn(f, c);
      f = faces_[f].n[c];
    }
  }
  /// Returns which corner of face f is the vertex v.
  int corner(Index f, Index v) const noexcept {
    const Face& face = faces_[f];
    return face.v[0] == v ? 0 : face.v[1] == v ? 1 : 2;
  }
  /// Index of the edge of f that begins at v and has the neighbouring face g; such an edge must exist.
  int edge_to(Index f, Index g, Index v) const noexcept {
    const Face& face = faces_[f];
    for (int i = 0; i < 2; ++i) {
      if (face.n[i] == g && face.v[i] == v) return i;
    }
    return 2;
  }

  /// A search for near faces that can be continued later.
  struct NearSearch {
    dvec3 lo_W, hi_W;          // m, corners of the box
    int level = 0;             // level of the grid at which the search continues
    bool began_level = false;  // true: the search of the grid level `level` has begun
    glm::ivec3 cell{0};        // next grid cell to search in `level`
    Index face = 0;            // next face, if the search tests all faces of the mesh
  };
  /// Calls fn(face) once for each face in the box, and for some faces near it.
  template <class Fn>
  void near(const dvec3& lo_W, const dvec3& hi_W, Fn&& fn) const {
    NearSearch search{lo_W, hi_W};
    std::int64_t left = std::numeric_limits<std::int64_t>::max();
    near_in_part(search, left, fn);
  }
  /// Continues a search of near faces until it is complete (returns true) or has read `left` cells and faces. Subtracts
  /// the number read from `left`. The mesh must not change before the search is complete.
  template <class Fn>
  bool near_in_part(NearSearch& search, std::int64_t& left, Fn&& fn) const {
    const glm::vec3 lo(search.lo_W), hi(search.hi_W);
    for (; search.level < kLevels; ++search.level, search.began_level = false) {
      const int level = search.level;
      if (in_level_[level] == 0) continue;
      const double margin = size_[level] * (2.0 / 3.0), cell = 1 / (kCellOfSize * size_[level]);
      const glm::ivec3 a(glm::floor((search.lo_W - margin) * cell)), b(glm::floor((search.hi_W + margin) * cell));
      glm::ivec3& at = search.cell;
      if (!std::exchange(search.began_level, true)) at = a, search.face = 0;
      const glm::dvec3 span(b - a + 1);
      if (span.x * span.y * span.z > static_cast<double>(face_count_)) {
        for (Index& f = search.face; f < faces_used_; ++f) {
          if (left <= 0) return false;
          --left;
          if (uses(f) && static_cast<int>(places_[f].key >> kLevelShift) == level && places_[f].meets(lo, hi)) fn(f);
        }
        continue;
      }
      for (; at.x <= b.x; ++at.x, at.y = a.y)
        for (; at.y <= b.y; ++at.y, at.z = a.z)
          for (int fetched = at.z; at.z <= b.z; ++at.z) {
            if (left <= 0) return false;
            if (at.z == fetched) fetched = fetch_cells(level, at, b.z);
            --left;
            const std::uint64_t key = key_of(level, at);
            for (Index f = heads_[bucket_of(key)]; f != kNone; f = places_[f].next) {
              --left;
              if (places_[f].key == key && places_[f].meets(lo, hi)) fn(f);
            }
          }
    }
    return true;
  }
  /// Returns false if the face's enclosing ball is outside the box, so that near() skips the face.
  bool may_meet(Index f, const glm::vec3& lo, const glm::vec3& hi) const noexcept { return places_[f].meets(lo, hi); }
  /// Centre of the ball that encloses a face, m.
  const glm::vec3& ball_center(Index f) const noexcept { return places_[f].center; }
  float ball_radius(Index f) const noexcept { return places_[f].radius; }
  /// Approximate normal in steps of 1/127; dot products have an error of at most kRoughNormalError. Zero: almost no
  /// area. Faster than computing it from the corners.
  glm::vec3 rough_normal(Index f) const noexcept {
    const RoughNormal& n = rough_normals_[f];
    return glm::vec3(n[0], n[1], n[2]) * (1.0f / 127);
  }
  static constexpr float kRoughNormalError = 0.01f;

  // Begins to store vertices and faces before their first change; null ends this. Allocates in `record`.
  void record(MeshRecord* record);
  /// Undoes the recorded changes; the next call repeats them.
  void exchange(MeshRecord& record);
  /// From now on, lists changed and removed faces for take_changes(). Allocates.
  void list_changes();
  /// Returns all faces changed since the last call, each once.
  void take_changes(std::vector<Index>& faces);

 private:
  /// Prefetches the lists of several cells along z, from `at` to `last`, so that memory accesses overlap. Returns the
  /// first z that was not read.
  int fetch_cells(int level, const glm::ivec3& at, int last) const noexcept {
    constexpr int kCells = 8;
    Index next[kCells];
    const int count = std::min(last - at.z + 1, kCells);
    for (int i = 0; i < count; ++i) next[i] = heads_[bucket_of(key_of(level, {at.x, at.y, at.z + i}))];
    for (int open = count; open > 0;) {
      int kept = 0;
      for (int i = 0; i < open; ++i) {
        if (next[i] == kNone) continue;
        next[kept] = places_[next[i]].next;
        if (next[kept] != kNone) __builtin_prefetch(&places_[next[kept]]);
        ++kept;
      }
      open = kept;
    }
    return at.z + count;
  }

  static constexpr int kLevels = 12;
  static constexpr int kLevelShift = 60;
  // edge of a level's cells divided by the longest edge of the faces in this level
  static constexpr double kCellOfSize = 2;
  struct Place {
    std::uint64_t key = 0;  // number that identifies the grid cell and its level
    Index next = kNone, before = kNone;
    glm::vec3 center{0};  // m, centre of a ball that encloses the face
    float radius = 0;     // m, radius of the ball that encloses the face, rounded up
    bool meets(const glm::vec3& lo, const glm::vec3& hi) const noexcept {
      const glm::vec3 off = center - glm::clamp(center, lo, hi);
      return glm::dot(off, off) <= radius * radius;
    }
  };

  using RoughNormal = std::array<std::int8_t, 4>;  // three components in units of 1/127, and an unused byte

  static std::uint64_t key_of(int level, const glm::ivec3& cell) noexcept {
    constexpr std::uint64_t kMask = (1u << 20) - 1;
    const auto bits = [](int c) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(c)) & kMask; };
    return static_cast<std::uint64_t>(level) << kLevelShift | bits(cell.x) << 40 | bits(cell.y) << 20 | bits(cell.z);
  }
  /// Neighbouring cells along z share cache lines.
  std::size_t bucket_of(std::uint64_t key) const noexcept {
    // Hashes the key with two products, because one product would give collisions on a regular grid.
    std::uint64_t column = (key >> 20) * 0x9e3779b97f4a7c15u;
    column = (column ^ column >> 32) * 0xd6e8feb86659fd93u >> bucket_shift_;
    return static_cast<std::size_t>(column + (key & 0xfffff)) & (heads_.size() - 1);
  }

  void join_faces(const TissueMesh& mesh);
  void make_vertices(const TissueMesh& mesh, std::size_t spare);
  void make_grid(double edge);
  Place place_for(Index f) const noexcept;
  void link(Index f) noexcept;
  void unlink(Index f) noexcept;
  void place(Index f) noexcept;
  void set_rough_normal(Index f) noexcept;
  Vertex& write_vertex(Index v) noexcept;
  Face& write_face(Index f) noexcept;
  Index take_vertex() noexcept;
  Index take_face() noexcept;
  void drop_vertex(Index v) noexcept;
  void drop_face(Index f) noexcept;
  void replace_neighbour(Index f, Index old_one, Index v, Index new_one) noexcept;
  int valence(Index v) const noexcept;
  void note_change(Index f) noexcept;

  std::vector<Vertex> vertices_;  // all vertices, used and unused
  std::vector<Face> faces_;
  std::vector<Place> places_;
  std::vector<RoughNormal> rough_normals_;
  std::vector<Index> heads_;  // for each bucket of the hash table: first face in this bucket
  Index vertices_used_ = 0, faces_used_ = 0, free_vertex_ = kNone, free_face_ = kNone;
  std::size_t vertex_count_ = 0, face_count_ = 0;
  double size_[kLevels] = {};  // m, longest edge in each level
  std::size_t in_level_[kLevels] = {};
  int bucket_shift_ = 63;

  // A copy of the mesh does not copy the following members, because they describe a recording of changes.
  MeshRecord* record_ = nullptr;
  std::uint32_t stroke_ = 0;
  // for each vertex and face: last recording that stored it
  std::vector<std::uint32_t> vertex_stroke_, face_stroke_;
  bool lists_changes_ = false;
  std::vector<Index> changed_;
  std::vector<std::uint8_t> is_changed_;
};

}  // namespace typodont::haptics::mesh
