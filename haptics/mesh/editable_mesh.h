// A triangle mesh that can be edited in place: split, flip, collapse and move, with neighbours, a grid over the faces
// and a record of what changed.
//
// Every face stores its three vertices and the three faces beside it; every vertex stores one of its faces. A mesh may
// have a border. Edits never remove vertices and edges of the border, and only the caller moves them, so an open mesh
// keeps its border.
//
// Equal meshes and equal calls give equal bits. After construction nothing allocates: records come from a pool whose
// size is fixed at set-up. Lengths in metres, frame W.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "haptics/tissue_mesh.h"

namespace typodont::haptics::mesh {

using Index = std::uint32_t;
inline constexpr Index kNone = 0xffffffff;

struct Vertex {
  dvec3 p{0};          // m, W
  Index face = kNone;  // one of the vertex's faces; kNone: not in use
  Index flags = 0;     // kBorder, kMoved; in an unused vertex: index of the next unused one
  bool on_border() const { return flags & kBorder; }
  bool was_moved() const { return flags & kMoved; }
  static constexpr Index kBorder = 1, kMoved = 2;
};

/// Edge i connects v[i] and v[(i+1)%3]; n[i] is the face on its other side, kNone at a border.
struct Face {
  // Counter-clockwise seen from outside. An unused face has v[0] = kNone, and v[1] is the index of the next unused one
  Index v[3] = {kNone, kNone, kNone};
  Index n[3] = {kNone, kNone, kNone};
  Tissue tissue = Tissue::kAir;  // tissue below the face
};

/// A recording of changes: the vertices and faces before they changed. EditableMesh::exchange() swaps them with the
/// mesh.
struct MeshRecord {
  std::vector<std::pair<Index, Vertex>> vertices;
  std::vector<std::pair<Index, Face>> faces;
  Index vertices_used = 0, faces_used = 0, free_vertex = kNone, free_face = kNone;
  bool empty() const { return vertices.empty() && faces.empty(); }
};

class EditableMesh {
 public:
  EditableMesh() = default;
  /// `edge`: m, longest edge of the faces in the finest level of the grid. `spare`: number of vertices that may be
  /// added. An edge with more than two faces, or with two of inconsistent orientation, becomes a border. A vertex whose
  /// faces touch only in this vertex becomes several vertices. Triangles that name a vertex twice are omitted.
  EditableMesh(const TissueMesh& mesh, double edge, std::size_t spare);
  EditableMesh(const EditableMesh& other);
  EditableMesh& operator=(const EditableMesh& other);
  EditableMesh(EditableMesh&&) noexcept = default;
  EditableMesh& operator=(EditableMesh&&) noexcept = default;
  ~EditableMesh() = default;

  // Access to vertices and faces. Ranges include unused ones.
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
  /// The mesh as a plain mesh, without unused vertices and faces.
  TissueMesh copy() const;

  // Edits. If split, flip or collapse are impossible, they return kNone or false and change nothing.
  void move(Index v, const dvec3& p) noexcept;  // also sets kMoved
  /// Undoes a move, flags included. `before`: vertex(v) before the move.
  void move_back(Index v, const Vertex& before) noexcept;
  void set_tissue(Index f, Tissue tissue) noexcept;
  /// After move(): updates the grid cells of the faces around a vertex, or of one face.
  void settle(Index v) noexcept;
  void settle_face(Index f) noexcept { place(f); }
  /// Splits edge i of f at a point. Returns the new vertex; kNone at a border or if the pool is empty.
  Index split(Index f, int i, const dvec3& p) noexcept;
  /// Replaces edge i of f by the other diagonal of its two faces. Returns false at a border, or if the other diagonal
  /// is an edge already.
  bool flip(Index f, int i) noexcept;
  /// Removes the first vertex of edge i of f (the second one if `keeps_first`) and connects its faces to the other
  /// vertex of the edge. Returns false if a border vertex would be removed, or if the surface would touch itself.
  bool collapse(Index f, int i, bool keeps_first) noexcept;
  bool may_collapse(Index f, int i, bool keeps_first) const noexcept;

  /// Calls fn(face, corner) for each face around v; counter-clockwise if there is no border.
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
  /// Index of the corner of f that is v.
  int corner(Index f, Index v) const noexcept {
    const Face& face = faces_[f];
    return face.v[0] == v ? 0 : face.v[1] == v ? 1 : 2;
  }
  /// Index of the edge of f that begins at v and has face g on its other side.
  int edge_to(Index f, Index g, Index v) const noexcept {
    const Face& face = faces_[f];
    for (int i = 0; i < 2; ++i) {
      if (face.n[i] == g && face.v[i] == v) return i;
    }
    return 2;
  }

  /// Calls fn(face) once for each face that may intersect the box, and for some faces that do not.
  template <class Fn>
  void near(const dvec3& lo_W, const dvec3& hi_W, Fn&& fn) const {
    const glm::vec3 lo(lo_W), hi(hi_W);
    for (int level = 0; level < kLevels; ++level) {
      if (in_level_[level] == 0) continue;
      const double margin = size_[level] * (2.0 / 3.0), cell = 1 / (kCellOfSize * size_[level]);
      const glm::ivec3 a(glm::floor((lo_W - margin) * cell)), b(glm::floor((hi_W + margin) * cell));
      const glm::dvec3 span(b - a + 1);
      if (span.x * span.y * span.z > static_cast<double>(face_count_)) {
        for (Index f = 0; f < faces_used_; ++f) {
          if (uses(f) && static_cast<int>(places_[f].key >> kLevelShift) == level && places_[f].meets(lo, hi)) fn(f);
        }
        continue;
      }
      for (int x = a.x; x <= b.x; ++x)
        for (int y = a.y; y <= b.y; ++y)
          for (int z = a.z; z <= b.z; ++z) {
            const std::uint64_t key = key_of(level, {x, y, z});
            for (Index f = heads_[bucket_of(key)]; f != kNone; f = places_[f].next) {
              if (places_[f].key == key && places_[f].meets(lo, hi)) fn(f);
            }
          }
    }
  }
  /// Centre of a ball around a face, m, as stored in the grid.
  const glm::vec3& ball_center(Index f) const noexcept { return places_[f].center; }
  float ball_radius(Index f) const noexcept { return places_[f].radius; }

  // Recording of changes.
  /// Starts to store in `record` each vertex and face before its first change; null: stops. Allocates memory in
  /// `record`.
  void record(MeshRecord* record);
  /// Swaps the stored vertices and faces of a finished recording with the present ones.
  void exchange(MeshRecord& record);
  /// Starts to list the faces that change, removed ones included. Allocates memory.
  void list_changes();
  /// Returns the faces that changed since the last call, each once.
  void take_changes(std::vector<Index>& faces);

  /// FNV-1a hash of points, faces and tissues in use, in order.
  std::uint64_t hash() const noexcept;

 private:
  static constexpr int kLevels = 12;
  static constexpr int kLevelShift = 60;
  static constexpr double kCellOfSize = 2;  // ratio of a cell's edge to the longest edge of its faces
  struct Place {
    std::uint64_t key = 0;  // level and cell
    Index next = kNone, before = kNone;
    glm::vec3 center{0};  // m, centre of a bounding ball of the face
    float radius = 0;     // m, radius of the bounding ball, rounded up
    bool meets(const glm::vec3& lo, const glm::vec3& hi) const noexcept {
      const glm::vec3 off = center - glm::clamp(center, lo, hi);
      return glm::dot(off, off) <= radius * radius;
    }
  };

  static std::uint64_t key_of(int level, const glm::ivec3& cell) noexcept {
    constexpr std::uint64_t kMask = (1u << 20) - 1;
    const auto bits = [](int c) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(c)) & kMask; };
    return static_cast<std::uint64_t>(level) << kLevelShift | bits(cell.x) << 40 | bits(cell.y) << 20 | bits(cell.z);
  }
  /// Cells that lie above each other have adjacent buckets, so a search reads whole cache lines.
  std::size_t bucket_of(std::uint64_t key) const noexcept {
    const std::uint64_t column = (key >> 20) * 0x9e3779b97f4a7c15u >> bucket_shift_;
    return static_cast<std::size_t>(column + (key & 0xfffff)) & (heads_.size() - 1);
  }

  void join_faces(const TissueMesh& mesh);
  void make_vertices(const TissueMesh& mesh, std::size_t spare);
  void make_grid(double edge);
  Place place_for(Index f) const noexcept;
  void link(Index f) noexcept;
  void unlink(Index f) noexcept;
  void place(Index f) noexcept;
  Vertex& write_vertex(Index v) noexcept;
  Face& write_face(Index f) noexcept;
  Index take_vertex() noexcept;
  Index take_face() noexcept;
  void drop_vertex(Index v) noexcept;
  void drop_face(Index f) noexcept;
  void replace_neighbour(Index f, Index old_one, Index v, Index new_one) noexcept;
  int valence(Index v) const noexcept;
  void note_change(Index f) noexcept;

  std::vector<Vertex> vertices_;  // all vertices of the pool, used and unused
  std::vector<Face> faces_;
  std::vector<Place> places_;
  std::vector<Index> heads_;  // first face of each bucket
  Index vertices_used_ = 0, faces_used_ = 0, free_vertex_ = kNone, free_face_ = kNone;
  std::size_t vertex_count_ = 0, face_count_ = 0;
  double size_[kLevels] = {};  // m, longest edge of a level's faces
  std::size_t in_level_[kLevels] = {};
  int bucket_shift_ = 63;

  // Not copied: these members belong to one owner.
  MeshRecord* record_ = nullptr;
  std::uint32_t stroke_ = 0;
  // Number of the last recording that stored this vertex or face
  std::vector<std::uint32_t> vertex_stroke_, face_stroke_;
  bool lists_changes_ = false;
  std::vector<Index> changed_;
  std::vector<std::uint8_t> is_changed_;
};

}  // namespace typodont::haptics::mesh
