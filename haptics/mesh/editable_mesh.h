// A triangle mesh changed in place: split, flip, collapse, move. Knows neighbours, finds faces by a grid, records.
//
// Borders stay: no function removes their vertices or edges, and only the caller moves them.
//
// Equal calls give equal bits. Vertices and faces come from a fixed pool; allocation only where stated. m, W.
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
  Index face = kNone;  // one of its faces; kNone: unused
  Index flags = 0;     // kBorder, kMoved; unused: next unused vertex
  bool on_border() const { return flags & kBorder; }
  bool was_moved() const { return flags & kMoved; }
  static constexpr Index kBorder = 1, kMoved = 2;
};

/// Edge i: v[i] to v[(i+1)%3]; n[i]: the face beyond, or kNone.
struct Face {
  // Counter-clockwise from outside. Unused: v[0] kNone, v[1] the next unused.
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
  static constexpr int kMostAround = 64;  // faces; more: edges cannot be collapsed
  EditableMesh() = default;
  /// `edge`: m, longest of the finest grid level; `spare`: vertices that can be added. Edges of more than two or
  /// inconsistent faces become borders; groups that touch in a vertex get their own; degenerate triangles are left out.
  EditableMesh(const TissueMesh& mesh, double edge, std::size_t spare);
  EditableMesh(const EditableMesh& other);
  EditableMesh& operator=(const EditableMesh& other);
  EditableMesh(EditableMesh&&) noexcept = default;
  EditableMesh& operator=(EditableMesh&&) noexcept = default;
  ~EditableMesh() = default;

  // Some indices are unused.
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

  // kNone or false: impossible, nothing changed.
  void move(Index v, const dvec3& p) noexcept;  // to p (m, W), sets kMoved
  /// With its flag; `before`: vertex(v) before the move.
  void move_back(Index v, const Vertex& before) noexcept;
  void set_tissue(Index f, Tissue tissue) noexcept;
  /// After move(): settle() the vertex, or settle_face() each face around it.
  void settle(Index v) noexcept;
  void settle_face(Index f) noexcept { place(f); }
  /// At p. New vertex, or kNone: border, or none left.
  Index split(Index f, int i, const dvec3& p) noexcept;
  /// The other diagonal of both faces; false: border, or already an edge.
  bool flip(Index f, int i) noexcept;
  /// Removes the first end, or with `keeps_first` the second. False: on the border, or the surface would touch itself.
  bool collapse(Index f, int i, bool keeps_first) noexcept;
  bool may_collapse(Index f, int i, bool keeps_first) const noexcept;

  /// fn(face, corner at v); counter-clockwise unless on a border.
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
  /// From v, with g beyond.
  int edge_to(Index f, Index g, Index v) const noexcept {
    const Face& face = faces_[f];
    for (int i = 0; i < 2; ++i) {
      if (face.n[i] == g && face.v[i] == v) return i;
    }
    return 2;
  }

  /// May be interrupted and continued.
  struct NearSearch {
    dvec3 lo_W, hi_W;          // m, corners of the box
    int level = 0;             // level of the grid at which the search continues
    bool began_level = false;  // true if the search has begun with this level
    glm::ivec3 cell{0};        // next cell of the level
    Index face = 0;            // next face, if the search tests all faces of the mesh
  };
  /// fn(face) once per face in the box, and some near it.
  template <class Fn>
  void near(const dvec3& lo_W, const dvec3& hi_W, Fn&& fn) const {
    NearSearch search{lo_W, hi_W};
    std::int64_t left = std::numeric_limits<std::int64_t>::max();
    near_in_part(search, left, fn);
  }
  /// Until complete or `left` (cells and faces) is used up. True: complete. No change of the mesh before.
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
  /// false: its enclosing ball is outside, so near() skips it.
  bool may_meet(Index f, const glm::vec3& lo, const glm::vec3& hi) const noexcept { return places_[f].meets(lo, hi); }
  /// Centre of a ball that encloses a face, in m.
  const glm::vec3& ball_center(Index f) const noexcept { return places_[f].center; }
  float ball_radius(Index f) const noexcept { return places_[f].radius; }
  /// In steps of 1/127: dot products within kRoughNormalError. Zero: almost no area. Cheaper than from corners.
  glm::vec3 rough_normal(Index f) const noexcept {
    const RoughNormal& n = rough_normals_[f];
    return glm::vec3(n[0], n[1], n[2]) * (1.0f / 127);
  }
  static constexpr float kRoughNormalError = 0.01f;

  // Stores before the first change; null ends. Allocates in `record`.
  void record(MeshRecord* record);
  /// Undoes, and the next call repeats.
  void exchange(MeshRecord& record);
  /// Also removed ones. Allocates.
  void list_changes();
  /// Since the last call, once each.
  void take_changes(std::vector<Index>& faces);

  /// FNV-1a of points, faces and tissues in use, in order.
  std::uint64_t hash() const noexcept;

 private:
  /// Prefetches the lists of several cells along z, `at` to `last`, in turn, so that linked reads overlap. Returns the
  /// first z not read.
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
  // cell edge / longest edge of the level's faces
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
  /// Neighbours along z share cache lines.
  std::size_t bucket_of(std::uint64_t key) const noexcept {
    // One product would collide on a regular grid.
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
  double size_[kLevels] = {};  // m, longest edge per level
  std::size_t in_level_[kLevels] = {};
  int bucket_shift_ = 63;

  // Not copied: they belong to one recording.
  MeshRecord* record_ = nullptr;
  std::uint32_t stroke_ = 0;
  // last recording that stored it
  std::vector<std::uint32_t> vertex_stroke_, face_stroke_;
  bool lists_changes_ = false;
  std::vector<Index> changed_;
  std::vector<std::uint8_t> is_changed_;
};

}  // namespace typodont::haptics::mesh
