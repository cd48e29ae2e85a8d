#include "engine/surface/contour/cell_shapes.h"

#include <numeric>

namespace typodont::surface {
namespace {

int edge_between(int corner_a, int corner_b) {
  const int low = corner_a & corner_b;  // the corner nearer to the origin; the two corners differ in one bit
  switch (corner_a ^ corner_b) {
    case 1:
      return 0 + (low >> 1 & 3);
    case 2:
      return 4 + ((low & 1) | (low >> 2) << 1);
    default:
      return 8 + (low & 3);
  }
}

// Returns the corners of a face, in circular order.
std::array<int, 4> ring_of(int face) {
  const int axis = face / 2;
  const int u = 1 << ((axis + 1) % 3), v = 1 << ((axis + 2) % 3);
  const int base = face % 2 ? 1 << axis : 0;
  return {base, base | u, base | u | v, base | v};
}

bool solid(int config, int corner) {
  return config >> corner & 1;
}

bool ambiguous(int config, int face) {
  const auto ring = ring_of(face);
  return solid(config, ring[0]) == solid(config, ring[2]) && solid(config, ring[1]) == solid(config, ring[3]) &&
         solid(config, ring[0]) != solid(config, ring[1]);
}

struct Joined {
  CellShape shape;
  std::uint8_t doubtful = 0;
  bool any_ambiguous = false;
};

Joined join(int config, int flipped_faces) {
  std::array<int, 12> parent;
  std::iota(parent.begin(), parent.end(), 0);
  auto root = [&](int e) {
    while (parent[static_cast<std::size_t>(e)] != e) e = parent[static_cast<std::size_t>(e)];
    return e;
  };
  auto unite = [&](int a, int b) { parent[static_cast<std::size_t>(root(a))] = root(b); };

  // The surface crosses a face in arcs; joins the two crossings at the ends of each arc.
  Joined out;
  for (int face = 0; face < 6; ++face) {
    const auto ring = ring_of(face);
    if (ambiguous(config, face)) {
      out.any_ambiguous = true;
      const bool cut_off_solid = !(flipped_faces >> face & 1);
      for (int i = 0; i < 4; ++i) {
        const int corner = ring[static_cast<std::size_t>(i)];
        if (solid(config, corner) != cut_off_solid) continue;
        unite(edge_between(corner, ring[static_cast<std::size_t>((i + 1) % 4)]),
              edge_between(corner, ring[static_cast<std::size_t>((i + 3) % 4)]));
      }
      continue;
    }
    int first = -1;
    for (int i = 0; i < 4; ++i) {
      const int a = ring[static_cast<std::size_t>(i)], b = ring[static_cast<std::size_t>((i + 1) % 4)];
      if (solid(config, a) == solid(config, b)) continue;
      if (first < 0) {
        first = edge_between(a, b);
      } else {
        unite(first, edge_between(a, b));
      }
    }
  }

  // Numbers the patches (pieces of surface) of the cell in the order of their lowest edge.
  std::array<int, 12> number;
  number.fill(-1);
  for (int corner = 0; corner < 8; ++corner) {
    for (int bit = 1; bit < 8; bit <<= 1) {
      const int other = corner | bit;
      if (other == corner || solid(config, corner) == solid(config, other)) continue;
      out.shape.edge[out.shape.edges++] = static_cast<std::uint8_t>(edge_between(corner, other));
    }
  }
  for (int e = 0; e < 12; ++e) {
    bool crossed = false;
    for (int i = 0; i < out.shape.edges; ++i) crossed |= out.shape.edge[static_cast<std::size_t>(i)] == e;
    if (!crossed) continue;
    int& n = number[static_cast<std::size_t>(root(e))];
    if (n < 0) n = out.shape.patches++;
    out.shape.patch[static_cast<std::size_t>(e)] = static_cast<std::uint8_t>(n);
  }

  for (int face = 0; face < 6; ++face) {
    if (!ambiguous(config, face)) continue;
    const auto ring = ring_of(face);
    const int a = root(edge_between(ring[0], ring[1])), b = root(edge_between(ring[1], ring[2]));
    const int c = root(edge_between(ring[2], ring[3]));
    if (a == b && b == c) out.doubtful |= static_cast<std::uint8_t>(1 << face);
  }
  return out;
}

}  // namespace

const CellShapes& CellShapes::get() {
  static const CellShapes shapes;
  return shapes;
}

CellShapes::CellShapes() {
  shapes_.resize(256);
  for (int config = 0; config < 256; ++config) {
    const auto c = static_cast<std::size_t>(config);
    const Joined plain = join(config, 0);
    shapes_[c] = plain.shape;
    doubtful_[c] = plain.doubtful;
    simple_[c] = plain.shape.patches == 1 && !plain.any_ambiguous;
    flipped_[c].fill(static_cast<std::uint16_t>(config));
    for (int faces = 1; faces < 64; ++faces) {
      if (faces & ~plain.doubtful) continue;
      flipped_[c][static_cast<std::size_t>(faces)] = static_cast<std::uint16_t>(shapes_.size());
      shapes_.push_back(join(config, faces).shape);
    }
  }
}

}  // namespace typodont::surface
