// A triangle mesh that can be changed in place. Edges can be split, flipped and collapsed, and vertices can be moved.
// The mesh knows the neighbours of each face, finds faces near a position with a grid, and records changes.
//
// Every face stores its three vertices and its three neighbouring faces; every vertex stores one of its faces. A mesh
// may have a border. Split, flip and collapse never remove vertices or edges of the border, and only the caller moves
// them. So an open mesh keeps its border.
//
// Equal meshes and equal calls give equal bits. No function allocates memory after construction, unless its comment
// says so, because vertices and faces come from a pool of fixed size. Lengths are in m, in the workbench frame W.
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
  dvec3 p{0};          // m, position in W
  Index face = kNone;  // one of the faces at the vertex; kNone if the vertex is unused
  Index flags = 0;     // bits kBorder and kMoved; in an unused vertex: index of the next unused vertex
  bool on_border() const { return flags & kBorder; }
  bool was_moved() const { return flags & kMoved; }
  static constexpr Index kBorder = 1, kMoved = 2;
};

/// A triangle. Edge i connects v[i] and v[(i+1)%3]. n[i] is the face on the other side of edge i, or kNone at a border.
struct Face {
  // Vertices, counter-clockwise as seen from outside. In an unused face, v[0] is kNone and v[1] is the index of the
  // next unused face.
  Index v[3] = {kNone, kNone, kNone};
  Index n[3] = {kNone, kNone, kNone};
  Tissue tissue = Tissue::kAir;  // tissue below the face
};

/// A record of changes: the vertices and faces as they were before they changed. EditableMesh::exchange() exchanges the
/// recorded vertices and faces with the present ones.
struct MeshRecord {
  std::vector<std::pair<Index, Vertex>> vertices;
  std::vector<std::pair<Index, Face>> faces;
  Index vertices_used = 0, faces_used = 0, free_vertex = kNone, free_face = kNone;
  bool empty() const { return vertices.empty() && faces.empty(); }
};

class EditableMesh {
 public:
  static constexpr int kMostAround = 64;  // if a vertex has more faces than this, its edges cannot be collapsed
  EditableMesh() = default;
  /// Makes an editable copy of a mesh. `edge` is the longest edge, in m, of the faces in the finest level of the grid.
  /// `spare` is the number of vertices that can be added. An edge with more than two faces, or with two faces of
  /// inconsistent orientation, becomes a border. If groups of faces touch only in a vertex, each group gets its own
  /// vertex. Triangles with two equal vertices are omitted.
  EditableMesh(const TissueMesh& mesh, double edge, std::size_t spare);
  EditableMesh(const EditableMesh& other);
  EditableMesh& operator=(const EditableMesh& other);
  EditableMesh(EditableMesh&&) noexcept = default;
  EditableMesh& operator=(EditableMesh&&) noexcept = default;
  ~EditableMesh() = default;

  // Access to vertices and faces by index. Some indices belong to unused vertices or faces.
  const Vertex& vertex(Index v) const noexcept { return vertices_[v]; }
  const Face& face(Index f) const noexcept { return faces_[f]; }
  const dvec3& point(Index f, int corner) const noexcept { return vertices_[faces_[f].v[corner]].p; }
  bool uses(Index f) const noexcept { return faces_[f].v[0] != kNone; }
  Index vertex_range() const noexcept { return vertices_used_; }
  Index face_range() const noexcept { return faces_used_; }
  std::size_t vertex_count() const noexcept { return vertex_count_; }
  std::size_t face_count() const noexcept { return face_count_; }
  std::size_t vertex_room() const noexcept { return vertices_.size(); }
  std::size_t face_room() const noexcept { return faces_.size(); }
  std::size_t border_edges() const noexcept;
  /// Returns the mesh as a TissueMesh, without unused vertices and faces.
  TissueMesh copy() const;

  // Functions that change the mesh. If a split, flip or collapse is impossible, the function returns kNone or false and
  // changes nothing.
  void move(Index v, const dvec3& p) noexcept;  // moves a vertex to p (m, workbench frame W), and sets its flag kMoved
  /// Undoes a move, including its flag. `before` is vertex(v) as it was before the move.
  void move_back(Index v, const Vertex& before) noexcept;
  void set_tissue(Index f, Tissue tissue) noexcept;
  /// After move(), the grid must be updated: by settle() for all faces around the vertex, or by settle_face() for each
  /// of these faces.
  void settle(Index v) noexcept;
  void settle_face(Index f) noexcept { place(f); }
  /// Splits edge i of face f at the point p. Returns the new vertex, or kNone if the edge is at a border or no unused
  /// vertex or face is left.
  Index split(Index f, int i, const dvec3& p) noexcept;
  /// Replaces edge i of face f by the other diagonal of the quad of its two faces. Returns false at a border, or if the
  /// other diagonal is already an edge.
  bool flip(Index f, int i) noexcept;
  /// Collapses edge i of face f: one end of the edge is removed, and its faces are connected to the other end. The
  /// first end is removed, or the second one if `keeps_first` is true. Returns false if the end to remove is on the
  /// border, or if the surface would touch itself.
  bool collapse(Index f, int i, bool keeps_first) noexcept;
  bool may_collapse(Index f, int i, bool keeps_first) const noexcept;

  /// Calls fn(face, corner) for each face around the vertex v; `corner` is the face's corner at v. If v is not on a
  /// border, the order is counter-clockwise.
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
  /// Returns which edge of face f begins at the vertex v and has the face g on its other side.
  int edge_to(Index f, Index g, Index v) const noexcept {
    const Face& face = faces_[f];
    for (int i = 0; i < 2; ++i) {
      if (face.n[i] == g && face.v[i] == v) return i;
    }
    return 2;
  }

  /// The state of a search for the faces near a box. The search can be interrupted and continued.
  struct NearSearch {
    dvec3 lo_W, hi_W;          // m, corners of the box
    int level = 0;             // level of the grid at which the search continues
    bool began_level = false;  // true if the search has begun with this level
    glm::ivec3 cell{0};        // next cell of the level
    Index face = 0;            // next face, if the search tests all faces of the mesh
  };
  /// Calls fn(face) once for each face that intersects the box, and for some other faces near the box.
  template <class Fn>
  void near(const dvec3& lo_W, const dvec3& hi_W, Fn&& fn) const {
    NearSearch search{lo_W, hi_W};
    std::int64_t left = std::numeric_limits<std::int64_t>::max();
    near_in_part(search, left, fn);
  }
  /// Continues the search until it is complete or `left` is not positive. Subtracts from `left` the number of cells and
  /// faces that the search visited. Returns true if the search is complete. While a search is not complete, the mesh
  /// must not change.
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
  /// Returns false if the ball that encloses the face f lies outside the box. near() would then not visit this face.
  bool may_meet(Index f, const glm::vec3& lo, const glm::vec3& hi) const noexcept { return places_[f].meets(lo, hi); }
  /// Centre of a ball that encloses a face, in m.
  const glm::vec3& ball_center(Index f) const noexcept { return places_[f].center; }
  float ball_radius(Index f) const noexcept { return places_[f].radius; }
  /// Outer unit normal of a face. Each component is rounded to a multiple of 1/127, so the scalar product of this
  /// vector and a unit vector has an error of at most kRoughNormalError. The result is the zero vector if the face has
  /// almost no area. Reading the rough normal is cheaper than computing the normal from the corners.
  glm::vec3 rough_normal(Index f) const noexcept {
    const RoughNormal& n = rough_normals_[f];
    return glm::vec3(n[0], n[1], n[2]) * (1.0f / 127);
  }
  static constexpr float kRoughNormalError = 0.01f;

  // Records changes: from this call on, the mesh stores each vertex and face in `record` before its first change. A
  // null pointer ends the recording. Allocates memory in `record`.
  void record(MeshRecord* record);
  /// Exchanges the vertices and faces in a finished record with the vertices and faces that the mesh has now. So the
  /// first call undoes the changes, and the next call repeats them.
  void exchange(MeshRecord& record);
  /// From this call on, the mesh lists the faces that change, including those that are removed. Allocates memory.
  void list_changes();
  /// Returns the faces that changed since the last call. Each face appears once.
  void take_changes(std::vector<Index>& faces);

  /// Returns the FNV-1a hash of the points, faces and tissues that are in use, in their order.
  std::uint64_t hash() const noexcept;

 private:
  /// Reads the lists of faces of several cells along z, from `at` up to `last`, so that they are in the cache when the
  /// search visits them. A list is linked, and its faces are scattered in memory; the lists of several cells are read
  /// in turn, so that the processor waits for several reads at once. Returns the z of the first cell that was not read.
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
  // edge of a grid cell in a level, divided by the length of the longest edge of the faces in this level
  static constexpr double kCellOfSize = 2;
  struct Place {
    std::uint64_t key = 0;  // number that identifies the grid cell and its level
    Index next = kNone, before = kNone;
    glm::vec3 center{0};  // m, centre of a ball that encloses the face
    float radius = 0;     // m, radius of this ball, rounded up
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
  /// Returns the bucket of a cell. Cells that are neighbours along z have neighbouring buckets, so a search reads whole
  /// cache lines.
  std::size_t bucket_of(std::uint64_t key) const noexcept {
    // The vertices of a large flat surface often lie on a regular grid. If the hash were a single product, many cells
    // of such a surface would get the same bucket.
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
  std::vector<Index> heads_;  // for each bucket of the hash table: its first face
  Index vertices_used_ = 0, faces_used_ = 0, free_vertex_ = kNone, free_face_ = kNone;
  std::size_t vertex_count_ = 0, face_count_ = 0;
  double size_[kLevels] = {};  // m, for each level of the grid: the longest edge of its faces
  std::size_t in_level_[kLevels] = {};
  int bucket_shift_ = 63;

  // The following members are not copied with the mesh, because they belong to the recording of one particular mesh.
  MeshRecord* record_ = nullptr;
  std::uint32_t stroke_ = 0;
  // for each vertex and each face: number of the last recording that stored it
  std::vector<std::uint32_t> vertex_stroke_, face_stroke_;
  bool lists_changes_ = false;
  std::vector<Index> changed_;
  std::vector<std::uint8_t> is_changed_;
};

}  // namespace typodont::haptics::mesh
