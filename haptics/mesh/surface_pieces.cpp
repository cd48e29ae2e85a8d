#include "haptics/mesh/surface_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace typodont::haptics::mesh {

namespace {

constexpr std::uint32_t kNoPiece = 0xffffffff;
constexpr std::size_t kMaxAround = 64;  // largest number of faces around a vertex; more are ignored

/// Normal whose length is twice the area of the face.
dvec3 area_normal(const EditableMesh& mesh, Index f) {
  return glm::cross(mesh.point(f, 1) - mesh.point(f, 0), mesh.point(f, 2) - mesh.point(f, 0));
}

/// Edge of a grid cell in m, chosen so that a cell contains about the wanted number of faces.
double cell_for(const EditableMesh& mesh, const PieceParameters& parameters) {
  double area = 0;
  for (Index f = 0; f < mesh.face_range(); ++f)
    if (mesh.uses(f)) area += 0.5 * glm::length(area_normal(mesh, f));
  const double each = area / static_cast<double>(std::max<std::size_t>(mesh.face_count(), 1));
  return std::clamp(std::sqrt(parameters.faces * each), parameters.least, parameters.most);
}

}  // namespace

SurfacePieces::SurfacePieces(EditableMesh& mesh, const TissueVolume& labels, const PieceParameters& parameters)
    : mesh_(mesh),
      labels_(labels),
      origin_(labels.frame().origin),
      parameters_(parameters),
      cell_(cell_for(mesh, parameters)),
      open_(mesh.border_edges() > 0),
      piece_of_(mesh.face_capacity(), kNoPiece),
      locals_(mesh.vertex_capacity()) {
  mesh_.list_changes();
  for (Index f = 0; f < mesh_.face_range(); ++f)
    if (mesh_.uses(f)) put(f);
}

std::uint32_t SurfacePieces::piece_at(Index f) {
  const dvec3 middle = (mesh_.point(f, 0) + mesh_.point(f, 1) + mesh_.point(f, 2)) / 3.0 - origin_;
  const glm::ivec3 cell(glm::floor(middle / cell_));
  const auto [found, fresh] = by_cell_.try_emplace(cell, static_cast<std::uint32_t>(pieces_.size()));
  if (fresh) pieces_.push_back({cell, {}, false});
  return found->second;
}

void SurfacePieces::mark(std::uint32_t piece) {
  if (piece == kNoPiece || pieces_[piece].dirty) return;
  pieces_[piece].dirty = true;
  dirty_.push_back(piece);
}

/// Updates the lists of faces in the pieces after face f was added, changed or removed.
void SurfacePieces::put(Index f) {
  const std::uint32_t before = piece_of_[f];
  mark(before);
  if (!mesh_.uses(f)) {
    piece_of_[f] = kNoPiece;
    return;
  }
  const std::uint32_t now = piece_at(f);
  mark(now);
  if (now == before) return;
  piece_of_[f] = now;
  pieces_[now].faces.push_back(f);
}

std::vector<SurfacePiece> SurfacePieces::take_changed() {
  mesh_.take_changes(changes_);
  for (const Index f : changes_) put(f);
  // Marks all pieces at the vertices of changed faces, because normals and tissues change there.
  for (const Index f : changes_) {
    if (!mesh_.uses(f)) continue;
    for (const Index v : mesh_.face(f).v) mesh_.around(v, [&](Index g, int) { mark(piece_of_[g]); });
  }
  std::ranges::sort(dirty_);
  std::vector<SurfacePiece> pieces;
  pieces.reserve(dirty_.size());
  for (const std::uint32_t i : dirty_) {
    pieces_[i].dirty = false;
    pieces.push_back(make(pieces_[i]));
  }
  dirty_.clear();
  return pieces;
}

/// Divides the faces around v into groups between creases; each group has one normal.
void SurfacePieces::look_around(Index v) {
  struct Around {
    Index face;
    int corner;
    dvec3 unit, weighted;
    std::size_t group;
  };
  std::array<Around, kMaxAround> ring;
  std::size_t count = 0;
  mesh_.around(v, [&](Index f, int c) {
    if (count == kMaxAround) return;
    const dvec3 a = mesh_.point(f, (c + 1) % 3) - mesh_.point(f, c),
                b = mesh_.point(f, (c + 2) % 3) - mesh_.point(f, c);
    const dvec3 n = glm::cross(a, b);
    const double length2 = glm::dot(n, n), edges2 = glm::dot(a, a) * glm::dot(b, b);
    const bool flat = !(length2 > 0 && edges2 > 0);
    ring[count] = {f, c, flat ? dvec3(0) : n / std::sqrt(length2), flat ? dvec3(0) : n / edges2, count};
    ++count;
  });
  const auto group_of = [&](std::size_t i) {
    while (ring[i].group != i) i = ring[i].group;
    return i;
  };
  for (std::size_t i = 0; i < count; ++i) {
    // Next face counter-clockwise, across the edge ending in v.
    const Index next = mesh_.face(ring[i].face).n[(ring[i].corner + 2) % 3];
    if (next == kNone) continue;
    std::size_t k = 0;
    while (k < count && ring[k].face != next) ++k;
    if (k == count) continue;
    const dvec3 &one = ring[i].unit, &other = ring[k].unit;
    // A face without area has no normal. It counts as smooth.
    const bool smooth = one == dvec3(0) || other == dvec3(0) || glm::dot(one, other) > parameters_.crease_cosine;
    if (!smooth) continue;
    const std::size_t a = group_of(i), b = group_of(k);
    ring[std::max(a, b)].group = std::min(a, b);
  }
  Local& local = locals_[v];
  local.first = static_cast<std::uint32_t>(normals_.size());
  local.count = static_cast<std::uint32_t>(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t group = group_of(i);
    dvec3 sum(0);
    for (std::size_t k = 0; k < count; ++k)
      if (group_of(k) == group) sum += ring[k].weighted;
    const double length = glm::length(sum);
    const dvec3 own = ring[i].unit == dvec3(0) ? dvec3(0, 0, 1) : ring[i].unit;
    normals_.push_back({ring[i].face, glm::vec3(length > 0 ? sum / length : own)});
  }
}

SurfacePiece SurfacePieces::make(Piece& piece) {
  const auto number = static_cast<std::uint32_t>(&piece - pieces_.data());
  std::erase_if(piece.faces, [&](Index f) { return piece_of_[f] != number; });
  // The faces are sorted, so that the piece does not depend on the order in which they were added.
  std::ranges::sort(piece.faces);
  piece.faces.erase(std::unique(piece.faces.begin(), piece.faces.end()), piece.faces.end());
  SurfacePiece made;
  made.cell = piece.cell;
  ++stamp_;
  normals_.clear();
  copies_.clear();
  constexpr std::uint32_t kNoCopy = 0xffffffff;
  made.indices.reserve(3 * piece.faces.size());
  for (const Index f : piece.faces) {
    const Face& face = mesh_.face(f);
    // Number of faces of each tissue around each corner. Tissues meet where their interpolated numbers are equal.
    std::array<std::array<float, kTissueCount>, 3> fractions{};
    std::array<float, kTissueCount> all{};
    for (std::size_t c = 0; c < 3; ++c) {
      const Index v = face.v[c];
      if (locals_[v].stamp != stamp_) {
        look_around(v);
        locals_[v].stamp = stamp_;
        locals_[v].copy = kNoCopy;
      }
      for (std::uint32_t i = 0; i < locals_[v].count; ++i) {
        const auto t = static_cast<std::size_t>(mesh_.face(normals_[locals_[v].first + i].face).tissue);
        fractions[c][t] += 1, all[t] += 1;
      }
    }
    Tissue other = face.tissue;
    for (std::size_t t = 0; t < all.size(); ++t) {
      if (t == static_cast<std::size_t>(face.tissue) || all[t] == 0) continue;
      if (other == face.tissue || all[t] > all[static_cast<std::size_t>(other)]) other = static_cast<Tissue>(t);
    }
    const std::array<Tissue, 2> pair{std::min(face.tissue, other), std::max(face.tissue, other)};
    for (std::size_t c = 0; c < 3; ++c) {
      Local& local = locals_[face.v[c]];
      SurfaceCorner corner;
      corner.p = glm::vec3(mesh_.vertex(face.v[c]).p - origin_);
      for (std::uint32_t i = 0; i < local.count; ++i)
        if (normals_[local.first + i].face == f) corner.n = normals_[local.first + i].n;
      corner.tissue = pair;
      const float first = fractions[c][static_cast<std::size_t>(pair[0])],
                  second = fractions[c][static_cast<std::size_t>(pair[1])];
      corner.second = pair[0] == pair[1] ? 0.0f : first + second > 0 ? second / (first + second) : 0.5f;
      std::uint32_t k = local.copy;
      while (k != kNoCopy && !(made.corners[k].n == corner.n && made.corners[k].tissue == pair)) k = copies_[k].older;
      if (k == kNoCopy) {
        k = static_cast<std::uint32_t>(made.corners.size());
        made.corners.push_back(corner);
        copies_.push_back({local.copy});
        local.copy = k;
      }
      made.indices.push_back(k);
    }
  }
  return made;
}

}  // namespace typodont::haptics::mesh
