// A triangle mesh that can be edited in place: split, flip, collapse and move, with neighbours, a grid over the faces
// and a record of what changed.
//
// Every face knows its three vertices and the three faces beside it; every vertex knows one of its faces. A mesh may
// have a border. Vertices and edges of the border are never removed, and moving them is left to the caller, so an open
// mesh keeps the border that it came with.
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
  Index face = kNone;  // one of its faces; kNone: not in use
  Index flags = 0;     // kBorder, kMoved. Of a vertex not in use: the next such
  bool on_border() const { return flags & kBorder; }
  bool was_moved() const { return flags & kMoved; }
  static constexpr Index kBorder = 1, kMoved = 2;
};

/// Edge i runs from v[i] to v[(i+1)%3]; n[i] is the face beyond it, kNone at a border.
struct Face {
  Index v[3] = {kNone, kNone, kNone};  // counter-clockwise seen from outside; v[0] kNone: not in use, v[1]: the next
  Index n[3] = {kNone, kNone, kNone};
  Tissue tissue = Tissue::kAir;  // the tissue under it
};

/// What changed while it was recorded: the records as they were before. EditableMesh::exchange() swaps them back.
struct MeshRecord {
  std::vector<std::pair<Index, Vertex>> vertices;
  std::vector<std::pair<Index, Face>> faces;
  Index vertices_used = 0, faces_used = 0, free_vertex = kNone, free_face = kNone;
  bool empty() const { return vertices.empty() && faces.empty(); }
};

class EditableMesh {
 public:
  EditableMesh() = default;
  /// `edge`: m, the longest edge that the finest level of the grid is made for. `spare`: vertices that may be added.
  /// An edge with more than two faces, or with two that disagree on their orientation, becomes a border; a vertex whose
  /// faces touch in that vertex alone becomes several. Triangles that name a vertex twice are left out.
  EditableMesh(const TissueMesh& mesh, double edge, std::size_t spare);
  EditableMesh(const EditableMesh& other);
  EditableMesh& operator=(const EditableMesh& other);
  EditableMesh(EditableMesh&&) noexcept = default;
  EditableMesh& operator=(EditableMesh&&) noexcept = default;
  ~EditableMesh() = default;

  // Records. Ranges include those not in use.
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
  /// As a plain mesh, without records that are not in use.
  TissueMesh copy() const;

  // Edits. Those that split, flip or collapse return what they could not do by kNone or false, and then do nothing.
  void move(Index v, const dvec3& p) noexcept;  // and says so in its flags
  /// Takes a move back, flags included. `before` as vertex(v) was.
  void move_back(Index v, const Vertex& before) noexcept;
  void set_tissue(Index f, Tissue tissue) noexcept;
  /// Puts the faces of a vertex, or one face, into the right cells of the grid, after move().
  void settle(Index v) noexcept;
  void settle_face(Index f) noexcept { place(f); }
  /// Splits edge i of f at a point. Returns the new vertex; kNone at a border or without room.
  Index split(Index f, int i, const dvec3& p) noexcept;
  /// Turns edge i of f to join the two other vertices. False at a border, or where those are joined already.
  bool flip(Index f, int i) noexcept;
  /// Draws the first (`keeps_first` false) or second vertex of edge i of f into the other one, which stays where it is.
  /// False where a border vertex would go, or where the surface would touch itself.
  bool collapse(Index f, int i, bool keeps_first) noexcept;
  bool may_collapse(Index f, int i, bool keeps_first) const noexcept;

  /// Calls fn(face, corner) for each face around v. Counter-clockwise, as long as there is no border.
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
  /// Which corner of f is v.
  int corner(Index f, Index v) const noexcept {
    const Face& face = faces_[f];
    return face.v[0] == v ? 0 : face.v[1] == v ? 1 : 2;
  }
  /// Which edge of f has face g beyond it and begins at v.
  int edge_to(Index f, Index g, Index v) const noexcept {
    const Face& face = faces_[f];
    for (int i = 0; i < 2; ++i) {
      if (face.n[i] == g && face.v[i] == v) return i;
    }
    return 2;
  }

  /// Calls fn(face) once for each face that may reach into the box, and for some that do not.
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
  /// A ball around a face, as the grid has it: m.
  const glm::vec3& ball_center(Index f) const noexcept { return places_[f].center; }
  float ball_radius(Index f) const noexcept { return places_[f].radius; }

  // What changes.
  /// From now on, records are kept in `record` before they first change; null: no longer. Allocates in `record`.
  void record(MeshRecord* record);
  /// Makes the records of a finished recording what they were, and leaves in it what they are.
  void exchange(MeshRecord& record);
  /// From now on the faces that change are listed, dead ones included. Allocates.
  void list_changes();
  /// The faces that changed since the last call, each once.
  void take_changes(std::vector<Index>& faces);

  /// FNV-1a over points, faces and tissues in use, in order.
  std::uint64_t hash() const noexcept;

 private:
  static constexpr int kLevels = 12;
  static constexpr int kLevelShift = 60;
  static constexpr double kCellOfSize = 2;  // edge of a cell over the longest edge of its faces
  struct Place {
    std::uint64_t key = 0;  // level and cell
    Index next = kNone, before = kNone;
    glm::vec3 center{0};  // m, of a ball around the face …
    float radius = 0;     // … rounded up
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
  /// Cells above each other lie side by side, so that a look reads whole cache lines.
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

  std::vector<Vertex> vertices_;  // as many as there is room for
  std::vector<Face> faces_;
  std::vector<Place> places_;
  std::vector<Index> heads_;  // first face of each bucket
  Index vertices_used_ = 0, faces_used_ = 0, free_vertex_ = kNone, free_face_ = kNone;
  std::size_t vertex_count_ = 0, face_count_ = 0;
  double size_[kLevels] = {};  // m, longest edge of a level's faces
  std::size_t in_level_[kLevels] = {};
  int bucket_shift_ = 63;

  // Not copied: they belong to one owner.
  MeshRecord* record_ = nullptr;
  std::uint32_t stroke_ = 0;
  std::vector<std::uint32_t> vertex_stroke_, face_stroke_;  // the last recording that kept a record
  bool lists_changes_ = false;
  std::vector<Index> changed_;
  std::vector<std::uint8_t> is_changed_;
};

}  // namespace typodont::haptics::mesh
