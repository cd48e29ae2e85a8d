#include "haptics/mesh/editable_mesh.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>

namespace typodont::haptics::mesh {

namespace {

struct HalfEdge {
  Index lo, hi, face;
  int edge;
  // true: the face lists the edge's ends in the order lo, hi
  bool forward;
};

}  // namespace

EditableMesh::EditableMesh(const TissueMesh& mesh, double edge, std::size_t spare) {
  join_faces(mesh);
  make_vertices(mesh, spare);
  make_grid(edge);
}

EditableMesh::EditableMesh(const EditableMesh& other) {
  *this = other;
}

EditableMesh& EditableMesh::operator=(const EditableMesh& other) {
  if (this == &other) return *this;
  const auto take = [](auto& to, const auto& from, std::size_t used) {
    to.resize(from.size());
    std::copy_n(from.begin(), used, to.begin());
  };
  take(vertices_, other.vertices_, other.vertices_used_);
  take(faces_, other.faces_, other.faces_used_);
  take(places_, other.places_, other.faces_used_);
  take(rough_normals_, other.rough_normals_, other.faces_used_);
  heads_ = other.heads_;
  vertices_used_ = other.vertices_used_, faces_used_ = other.faces_used_;
  free_vertex_ = other.free_vertex_, free_face_ = other.free_face_;
  vertex_count_ = other.vertex_count_, face_count_ = other.face_count_;
  std::copy_n(other.size_, kLevels, size_);
  std::copy_n(other.in_level_, kLevels, in_level_);
  bucket_shift_ = other.bucket_shift_;
  return *this;
}

/// Makes the faces with their neighbours; the faces still refer to vertices of `mesh`.
void EditableMesh::join_faces(const TissueMesh& mesh) {
  faces_.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3& v = mesh.triangles[t];
    if (v.x == v.y || v.y == v.z || v.z == v.x) continue;
    faces_.push_back({{v.x, v.y, v.z}, {kNone, kNone, kNone}, mesh.tissue[t]});
  }
  faces_used_ = static_cast<Index>(faces_.size());
  face_count_ = faces_.size();
  std::vector<HalfEdge> edges;
  edges.reserve(3 * faces_.size());
  for (Index f = 0; f < faces_used_; ++f) {
    for (int i = 0; i < 3; ++i) {
      const Index a = faces_[f].v[i], b = faces_[f].v[(i + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), f, i, a < b});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.lo, a.hi, a.face) < std::tie(b.lo, b.hi, b.face);
  });
  for (std::size_t from = 0, to; from < edges.size(); from = to) {
    to = from + 1;
    while (to < edges.size() && edges[to].lo == edges[from].lo && edges[to].hi == edges[from].hi) ++to;
    if (to - from != 2 || edges[from].forward == edges[from + 1].forward) continue;
    faces_[edges[from].face].n[edges[from].edge] = edges[from + 1].face;
    faces_[edges[from + 1].face].n[edges[from + 1].edge] = edges[from].face;
  }
}

/// Makes one vertex for each fan of faces (connected faces around a vertex).
void EditableMesh::make_vertices(const TissueMesh& mesh, std::size_t spare) {
  const std::vector<Face> old = faces_;  // the faces, still with the vertex indices of `mesh`
  std::vector<std::uint8_t> done(3 * old.size(), 0);
  for (Index f = 0; f < faces_used_; ++f) {
    for (int c = 0; c < 3; ++c) {
      if (done[3 * std::size_t{f} + static_cast<std::size_t>(c)]) continue;
      const Index name = old[f].v[c], v = static_cast<Index>(vertices_.size());
      vertices_.push_back({mesh.vertices[name], f, 0});
      const auto give = [&](Index g, int k) {
        faces_[g].v[k] = v;
        done[3 * std::size_t{g} + static_cast<std::size_t>(k)] = 1;
      };
      // At a border, walks around the vertex in both directions.
      const auto step = [&](Index& g, int& k, int edge) {
        const Index next = old[g].n[edge];
        if (next == kNone) return false;
        g = next;
        k = old[g].v[0] == name ? 0 : old[g].v[1] == name ? 1 : 2;
        return true;
      };
      Index g = f;
      int k = c;
      give(g, k);
      bool closed = false, on = true;
      while (on) {
        on = step(g, k, (k + 2) % 3);
        if (on && g == f) closed = true, on = false;
        if (on) give(g, k);
      }
      if (closed) continue;
      vertices_[v].flags = Vertex::kBorder;
      g = f, k = c;
      while (step(g, k, k)) give(g, k);
    }
  }
  vertices_used_ = static_cast<Index>(vertices_.size());
  vertex_count_ = vertices_.size();
  vertices_.resize(vertex_count_ + spare);
  faces_.resize(face_count_ + 2 * spare);
}

void EditableMesh::make_grid(double edge) {
  for (int level = 0; level < kLevels; ++level) size_[level] = edge * static_cast<double>(1u << level);
  places_.resize(faces_.size());
  rough_normals_.resize(faces_.size());
  const auto buckets = std::bit_ceil(std::max<std::size_t>(faces_.size() / 2, 64));
  heads_.assign(buckets, kNone);
  bucket_shift_ = 64 - std::countr_zero(buckets);
  for (Index f = 0; f < faces_used_; ++f) link(f);
}

std::size_t EditableMesh::border_edges() const noexcept {
  std::size_t count = 0;
  for (Index f = 0; f < faces_used_; ++f) {
    if (uses(f)) count += static_cast<std::size_t>(std::count(faces_[f].n, faces_[f].n + 3, kNone));
  }
  return count;
}

TissueMesh EditableMesh::copy() const {
  TissueMesh mesh;
  std::vector<Index> number(vertices_used_, kNone);
  for (Index v = 0; v < vertices_used_; ++v) {
    if (vertices_[v].face == kNone) continue;
    number[v] = static_cast<Index>(mesh.vertices.size());
    mesh.vertices.push_back(vertices_[v].p);
  }
  for (Index f = 0; f < faces_used_; ++f) {
    if (!uses(f)) continue;
    mesh.triangles.emplace_back(number[faces_[f].v[0]], number[faces_[f].v[1]], number[faces_[f].v[2]]);
    mesh.tissue.push_back(faces_[f].tissue);
  }
  return mesh;
}

// The following functions maintain the grid, in which faces near a position are found.

EditableMesh::Place EditableMesh::place_for(Index f) const noexcept {
  // margin of a face's enclosing ball, divided by a coordinate; covers the rounding of floats
  constexpr float kRounding = 1e-6f;
  const dvec3 &a = point(f, 0), &b = point(f, 1), &c = point(f, 2);
  const dvec3 ab = b - a, bc = c - b, ca = a - c, g = (a + b + c) / 3.0;
  const double longest2 = std::max({glm::dot(ab, ab), glm::dot(bc, bc), glm::dot(ca, ca)});
  int level = 0;
  while (level < kLevels - 1 && longest2 > size_[level] * size_[level]) ++level;
  Place place;
  place.key = key_of(level, glm::ivec3(glm::floor(g * (1 / (kCellOfSize * size_[level])))));
  place.center = glm::vec3(g);
  const double reach2 = std::max({glm::dot(a - g, a - g), glm::dot(b - g, b - g), glm::dot(c - g, c - g)});
  const glm::vec3 size = glm::abs(place.center);
  place.radius = std::sqrt(static_cast<float>(reach2)) * (1 + kRounding) + kRounding * (size.x + size.y + size.z);
  return place;
}

void EditableMesh::set_rough_normal(Index f) noexcept {
  constexpr double kTiny2 = 1e-100;  // m⁴; smaller squares have lost digits (denormal numbers)
  const dvec3& a = point(f, 0);
  const dvec3 n = glm::cross(point(f, 1) - a, point(f, 2) - a);
  const double n2 = glm::dot(n, n);
  const dvec3 scaled = n2 > kTiny2 ? n * (127 / std::sqrt(n2)) : dvec3(0);
  for (int k = 0; k < 3; ++k) rough_normals_[f][k] = static_cast<std::int8_t>(std::lrint(scaled[k]));
}

void EditableMesh::link(Index f) noexcept {
  Place& place = places_[f];
  place = place_for(f);
  set_rough_normal(f);
  ++in_level_[place.key >> kLevelShift];
  Index& head = heads_[bucket_of(place.key)];
  place.next = head;
  if (head != kNone) places_[head].before = f;
  head = f;
}

void EditableMesh::unlink(Index f) noexcept {
  const Place& place = places_[f];
  --in_level_[place.key >> kLevelShift];
  if (place.next != kNone) places_[place.next].before = place.before;
  if (place.before != kNone) {
    places_[place.before].next = place.next;
  } else {
    heads_[bucket_of(place.key)] = place.next;
  }
}

void EditableMesh::place(Index f) noexcept {
  Place now = place_for(f);
  Place& place = places_[f];
  if (now.key != place.key) {
    unlink(f);
    link(f);
    return;
  }
  now.next = place.next, now.before = place.before;
  place = now;
  set_rough_normal(f);
}

// The following functions change vertices and faces, and record the changes.

Vertex& EditableMesh::write_vertex(Index v) noexcept {
  if (record_ && vertex_stroke_[v] != stroke_) {
    vertex_stroke_[v] = stroke_;
    record_->vertices.emplace_back(v, vertices_[v]);
  }
  return vertices_[v];
}

void EditableMesh::note_change(Index f) noexcept {
  if (!lists_changes_ || is_changed_[f]) return;
  is_changed_[f] = 1;
  changed_.push_back(f);
}

Face& EditableMesh::write_face(Index f) noexcept {
  if (record_ && face_stroke_[f] != stroke_) {
    face_stroke_[f] = stroke_;
    record_->faces.emplace_back(f, faces_[f]);
  }
  note_change(f);
  return faces_[f];
}

Index EditableMesh::take_vertex() noexcept {
  ++vertex_count_;
  if (free_vertex_ == kNone) {
    (void)write_vertex(vertices_used_);
    return vertices_used_++;
  }
  const Index v = free_vertex_;
  free_vertex_ = write_vertex(v).flags;
  return v;
}

Index EditableMesh::take_face() noexcept {
  ++face_count_;
  if (free_face_ == kNone) {
    (void)write_face(faces_used_);
    return faces_used_++;
  }
  const Index f = free_face_;
  free_face_ = write_face(f).v[1];
  return f;
}

void EditableMesh::drop_vertex(Index v) noexcept {
  Vertex& vertex = write_vertex(v);
  vertex.face = kNone;
  vertex.flags = free_vertex_;
  free_vertex_ = v;
  --vertex_count_;
}

void EditableMesh::drop_face(Index f) noexcept {
  unlink(f);
  Face& face = write_face(f);
  face.v[0] = kNone;
  face.v[1] = free_face_;
  free_face_ = f;
  --face_count_;
}

void EditableMesh::record(MeshRecord* record) {
  record_ = record;
  if (!record) return;
  vertex_stroke_.resize(vertices_.size());
  face_stroke_.resize(faces_.size());
  ++stroke_;
  record->vertices_used = vertices_used_, record->faces_used = faces_used_;
  record->free_vertex = free_vertex_, record->free_face = free_face_;
}

void EditableMesh::exchange(MeshRecord& record) {
  for (const auto& [f, face] : record.faces) {
    if (f < faces_used_ && uses(f)) unlink(f), --face_count_;
  }
  for (auto& [v, vertex] : record.vertices) {
    if (v < vertices_used_ && vertices_[v].face != kNone) --vertex_count_;
    std::swap(vertices_[v], vertex);
  }
  for (auto& [f, face] : record.faces) {
    std::swap(faces_[f], face);
    note_change(f);
  }
  std::swap(record.vertices_used, vertices_used_);
  std::swap(record.faces_used, faces_used_);
  std::swap(record.free_vertex, free_vertex_);
  std::swap(record.free_face, free_face_);
  for (const auto& [v, vertex] : record.vertices) vertex_count_ += v < vertices_used_ && vertices_[v].face != kNone;
  for (const auto& [f, face] : record.faces) {
    if (f < faces_used_ && uses(f)) link(f), ++face_count_;
  }
  // The faces around a changed vertex may lie in other cells of the grid now.
  for (const auto& [v, vertex] : record.vertices) {
    if (!(v < vertices_used_ && vertices_[v].face != kNone)) continue;
    around(v, [&](Index f, int) {
      place(f);
      note_change(f);
    });
  }
}

void EditableMesh::list_changes() {
  lists_changes_ = true;
  is_changed_.resize(faces_.size());
}

void EditableMesh::take_changes(std::vector<Index>& faces) {
  faces.assign(changed_.begin(), changed_.end());
  for (const Index f : changed_) is_changed_[f] = 0;
  changed_.clear();
}

// The following functions edit the mesh.

void EditableMesh::move(Index v, const dvec3& p) noexcept {
  Vertex& vertex = write_vertex(v);
  vertex.p = p;
  vertex.flags |= Vertex::kMoved;
  if (lists_changes_) around(v, [&](Index f, int) { note_change(f); });
}

void EditableMesh::move_back(Index v, const Vertex& before) noexcept {
  Vertex& vertex = write_vertex(v);
  vertex.p = before.p;
  vertex.flags = before.flags;
}

void EditableMesh::settle(Index v) noexcept {
  around(v, [&](Index f, int) { place(f); });
}

void EditableMesh::set_tissue(Index f, Tissue tissue) noexcept {
  if (faces_[f].tissue != tissue) write_face(f).tissue = tissue;
}

void EditableMesh::replace_neighbour(Index f, Index old_one, Index v, Index new_one) noexcept {
  if (f == kNone) return;
  const int i = edge_to(f, old_one, v);
  write_face(f).n[i] = new_one;
}

Index EditableMesh::split(Index f, int i, const dvec3& p) noexcept {
  const Index g = faces_[f].n[i];
  const bool has_room = vertex_count_ < vertices_.size() && face_count_ + 2 <= faces_.size();
  if (g == kNone || !has_room) return kNone;
  const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
  const Index a = faces_[f].v[i], b = faces_[f].v[i1], c = faces_[f].v[i2];
  const int j = edge_to(g, f, b), j1 = (j + 1) % 3, j2 = (j + 2) % 3;
  const Index d = faces_[g].v[j2];
  const Index f_bc = faces_[f].n[i1], g_ad = faces_[g].n[j1];
  const Index m = take_vertex(), f2 = take_face(), g2 = take_face();
  Vertex& vertex = write_vertex(m);
  vertex.p = p, vertex.face = f, vertex.flags = vertices_[a].flags & vertices_[b].flags & Vertex::kMoved;

  // Splits edge a–b at m. c, d: third corners of its two faces. Then f: a, m, c; f2: m, b, c; g: b, m, d; g2: m, a, d.
  Face& F = write_face(f);
  Face& G = write_face(g);
  F.v[i1] = m, F.n[i] = g2, F.n[i1] = f2;
  G.v[j1] = m, G.n[j] = f2, G.n[j1] = g2;
  write_face(f2) = {{m, b, c}, {g, f_bc, f}, F.tissue};
  write_face(g2) = {{m, a, d}, {f, g_ad, g}, G.tissue};
  replace_neighbour(f_bc, f, c, f2);
  replace_neighbour(g_ad, g, d, g2);
  if (vertices_[b].face == f) write_vertex(b).face = f2;
  if (vertices_[a].face == g) write_vertex(a).face = g2;
  place(f), place(g), link(f2), link(g2);
  return m;
}

bool EditableMesh::flip(Index f, int i) noexcept {
  const Index g = faces_[f].n[i];
  if (g == kNone) return false;
  const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
  const Index a = faces_[f].v[i], b = faces_[f].v[i1], c = faces_[f].v[i2];
  const int j = edge_to(g, f, b), j1 = (j + 1) % 3, j2 = (j + 2) % 3;
  const Index d = faces_[g].v[j2];
  bool joined = c == d;
  around(c, [&](Index h, int k) { joined |= faces_[h].v[(k + 1) % 3] == d || faces_[h].v[(k + 2) % 3] == d; });
  if (joined) return false;
  const Index f_bc = faces_[f].n[i1], f_ca = faces_[f].n[i2], g_ad = faces_[g].n[j1], g_db = faces_[g].n[j2];
  const Tissue f_tissue = faces_[f].tissue, g_tissue = faces_[g].tissue;

  // Edge a–b becomes c–d. Afterwards f: a, d, c; g: d, b, c.
  write_face(f) = {{a, d, c}, {g_ad, g, f_ca}, f_tissue};
  write_face(g) = {{d, b, c}, {g_db, f_bc, f}, g_tissue};
  replace_neighbour(g_ad, g, d, f);
  replace_neighbour(f_bc, f, c, g);
  if (vertices_[a].face == g) write_vertex(a).face = f;
  if (vertices_[b].face == f) write_vertex(b).face = g;
  place(f), place(g);
  return true;
}

int EditableMesh::valence(Index v) const noexcept {
  int n = 0;
  around(v, [&](Index, int) { ++n; });
  return n;
}

bool EditableMesh::may_collapse(Index f, int i, bool keeps_first) const noexcept {
  const Index g = faces_[f].n[i];
  const Index first = faces_[f].v[i], second = faces_[f].v[(i + 1) % 3];
  const Index kept = keeps_first ? first : second, gone = keeps_first ? second : first;
  if (g == kNone || vertices_[gone].on_border()) return false;
  const Index c = faces_[f].v[(i + 2) % 3];
  const Index d = faces_[g].v[(edge_to(g, f, second) + 2) % 3];
  for (const Index v : {c, d}) {
    if (valence(v) <= (vertices_[v].on_border() ? 1 : 3)) return false;
  }
  // The edge's ends may have only c and d as common neighbours; otherwise the surface would touch itself.
  Index beside[kMaxAround];
  int count = 0;
  bool allowed = true;
  const auto add = [&](Index v) {
    if (count == kMaxAround) {
      allowed = false;
    } else {
      beside[count++] = v;
    }
  };
  // `gone` is not on a border, so around() visits all faces around this vertex.
  around(gone, [&](Index h, int k) { add(faces_[h].v[(k + 1) % 3]); });
  const auto shares = [&](Index v) {
    if (v != gone && v != c && v != d && std::find(beside, beside + count, v) != beside + count) allowed = false;
  };
  around(kept, [&](Index h, int k) {
    shares(faces_[h].v[(k + 1) % 3]);
    shares(faces_[h].v[(k + 2) % 3]);
  });
  return allowed;
}

bool EditableMesh::collapse(Index f, int i, bool keeps_first) noexcept {
  if (!may_collapse(f, i, keeps_first)) return false;
  const Index first = faces_[f].v[i], second = faces_[f].v[(i + 1) % 3];
  const Index kept = keeps_first ? first : second, gone = keeps_first ? second : first;
  const Index g = faces_[f].n[i];
  const Index c = faces_[f].v[(i + 2) % 3];
  const int j = edge_to(g, f, second);
  const Index d = faces_[g].v[(j + 2) % 3];
  const Index f_bc = faces_[f].n[(i + 1) % 3], f_ca = faces_[f].n[(i + 2) % 3];
  const Index g_ad = faces_[g].n[(j + 1) % 3], g_db = faces_[g].n[(j + 2) % 3];

  Index ring[kMaxAround];
  int count = 0;
  around(gone, [&](Index h, int) {
    if (h != f && h != g) ring[count++] = h;
  });
  for (int k = 0; k < count; ++k) write_face(ring[k]).v[corner(ring[k], gone)] = kept;
  // The outer neighbours of the two removed faces become neighbours of each other. now(): `kept` in place of `gone`.
  const auto now = [&](Index v) { return v == gone ? kept : v; };
  replace_neighbour(f_bc, f, c, f_ca);
  replace_neighbour(f_ca, f, now(first), f_bc);
  replace_neighbour(g_ad, g, d, g_db);
  replace_neighbour(g_db, g, now(second), g_ad);
  const auto give_face = [&](Index v, Index one, Index other) {
    const Index face = vertices_[v].face;
    if (face == f || face == g || v == kept) write_vertex(v).face = one != kNone ? one : other;
  };
  give_face(c, f_bc, f_ca);
  give_face(d, g_ad, g_db);
  give_face(kept, f_bc != kNone ? f_bc : f_ca, g_db != kNone ? g_db : g_ad);
  drop_face(f), drop_face(g);
  drop_vertex(gone);
  for (int k = 0; k < count; ++k) place(ring[k]);
  return true;
}

}  // namespace typodont::haptics::mesh
