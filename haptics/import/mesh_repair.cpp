#include "haptics/import/mesh_repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "haptics/import/distance.h"
#include "haptics/import/triangle_tree.h"

namespace typodont::haptics::importing {

namespace {

using glm::dvec3;

struct EdgeUse {
  int low, high;  // indices of the edge's two points; low < high
  std::size_t triangle;
  bool up;  // true: in the triangle's order of corners, `high` follows `low`
};

std::vector<EdgeUse> edges_of(const Mesh& mesh) {
  std::vector<EdgeUse> edges;
  edges.reserve(3 * mesh.corners.size());
  for (std::size_t t = 0; t < mesh.corners.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = mesh.corners[t][k], b = mesh.corners[t][(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), t, a < b});
    }
  }
  std::ranges::sort(edges, [](const EdgeUse& a, const EdgeUse& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return edges;
}

/// Calls use(first, end) for each edge, with the range of its triangles.
template <class Use>
void for_each_edge(const std::vector<EdgeUse>& edges, Use use) {
  for (std::size_t first = 0; first < edges.size();) {
    std::size_t end = first + 1;
    while (end < edges.size() && edges[end].low == edges[first].low && edges[end].high == edges[first].high) ++end;
    use(first, end);
    first = end;
  }
}

void turn(std::array<int, 3>& corners) {
  std::swap(corners[1], corners[2]);
}

/// Adds the corners and the centre of a triangle to the list of repaired positions.
void add_place(const Mesh& mesh, const std::array<int, 3>& corners, MeshRepairs& repairs) {
  dvec3 middle(0);
  for (const int corner : corners) {
    repairs.places.push_back(mesh.point(corner));
    middle += mesh.point(corner) / 3.0;
  }
  repairs.places.push_back(middle);
}

}  // namespace

std::vector<std::string> MeshRepairs::in_words() const {
  std::vector<std::string> words;
  if (welded > 0) words.push_back(fmt::format("{} corners welded to others nearly at the same place", welded));
  if (collapsed > 0) words.push_back(fmt::format("{} triangles with two equal corners left out", collapsed));
  if (copies > 0) words.push_back(fmt::format("{} second copies of triangles left out", copies));
  if (turned > 0) words.push_back(fmt::format("{} triangles turned to agree with their neighbours", turned));
  if (shells_turned > 0) words.push_back(fmt::format("{} shells turned inside out", shells_turned));
  if (holes > 0) words.push_back(fmt::format("{} small holes with {} edges closed", holes, hole_edges));
  return words;
}

void drop_copies(Mesh& mesh, MeshRepairs& repairs) {
  std::set<std::array<int, 3>> known;
  repairs.copies += std::erase_if(mesh.corners, [&](std::array<int, 3> t) {
    std::ranges::rotate(t, std::ranges::min_element(t));
    if (known.insert(t).second) return false;
    add_place(mesh, t, repairs);
    return true;
  });
}

void orient(Mesh& mesh, MeshRepairs& repairs) {
  // Neighbour over an edge with two triangles. `same_way`: both triangles list the edge in the same direction.
  struct Neighbour {
    std::size_t triangle;
    bool same_way;
  };
  std::vector<std::vector<Neighbour>> neighbours(mesh.corners.size());
  const std::vector<EdgeUse> edges = edges_of(mesh);
  for_each_edge(edges, [&](std::size_t first, std::size_t end) {
    if (end - first != 2) return;
    const EdgeUse &a = edges[first], &b = edges[first + 1];
    neighbours[a.triangle].push_back({b.triangle, a.up == b.up});
    neighbours[b.triangle].push_back({a.triangle, a.up == b.up});
  });
  std::vector<std::uint8_t> seen(mesh.corners.size(), 0), turned(mesh.corners.size(), 0);
  for (std::size_t seed = 0; seed < mesh.corners.size(); ++seed) {
    if (seen[seed]) continue;
    std::vector<std::size_t> part{seed};
    seen[seed] = 1;
    std::size_t count = 0;
    for (std::size_t k = 0; k < part.size(); ++k) {
      const std::size_t t = part[k];
      for (const Neighbour& n : neighbours[t]) {
        if (seen[n.triangle]) continue;
        seen[n.triangle] = 1;
        turned[n.triangle] = turned[t] ^ static_cast<std::uint8_t>(n.same_way);
        count += turned[n.triangle];
        part.push_back(n.triangle);
      }
    }
    const bool others = 2 * count > part.size();
    repairs.turned += others ? part.size() - count : count;
    for (const std::size_t t : part) {
      if (static_cast<bool>(turned[t]) == others) continue;
      turn(mesh.corners[t]);
      add_place(mesh, mesh.corners[t], repairs);
    }
  }
}

std::vector<Border> borders(const Mesh& mesh) {
  // Edges of borders, from first to second point.
  std::multimap<int, int> next;
  const std::vector<EdgeUse> edges = edges_of(mesh);
  for_each_edge(edges, [&](std::size_t first, std::size_t end) {
    if ((end - first) % 2 == 0) return;
    std::ptrdiff_t ups = 0;
    for (std::size_t k = first; k < end; ++k) ups += edges[k].up ? 1 : -1;
    const EdgeUse& e = edges[first];
    next.emplace(ups > 0 ? e.low : e.high, ups > 0 ? e.high : e.low);
  });
  std::vector<Border> found;
  const auto add = [&](auto first, auto last, bool closed) {
    Border border;
    border.points.assign(first, last);
    border.closed = closed;
    const std::size_t n = border.points.size();
    for (std::size_t k = 0; k + (closed ? 0 : 1) < n; ++k)
      border.length += glm::length(mesh.point(border.points[k]) - mesh.point(border.points[(k + 1) % n]));
    found.push_back(std::move(border));
  };
  while (!next.empty()) {
    // Follows the edges from point to point. When a point is reached again, the walk since then is a closed border.
    std::vector<int> walk{next.begin()->first};
    std::map<int, std::size_t> place{{walk[0], 0}};
    for (auto step = next.begin(); step != next.end(); step = next.find(walk.back())) {
      const int to = step->second;
      next.erase(step);
      if (const auto [before, fresh] = place.emplace(to, walk.size()); fresh) {
        walk.push_back(to);
      } else {
        const std::size_t from = before->second;
        add(walk.begin() + static_cast<std::ptrdiff_t>(from), walk.end(), true);
        for (std::size_t k = from + 1; k < walk.size(); ++k) place.erase(walk[k]);
        walk.resize(from + 1);
      }
    }
    if (walk.size() > 1) add(walk.begin(), walk.end(), false);
  }
  return found;
}

void close_border(Mesh& mesh, const Border& border, MeshRepairs& repairs) {
  const std::size_t n = border.points.size();
  if (n == 3) {
    mesh.corners.push_back({border.points[2], border.points[1], border.points[0]});
    add_place(mesh, mesh.corners.back(), repairs);
    return;
  }
  dvec3 middle(0);
  for (const int p : border.points) middle += mesh.point(p) / static_cast<double>(n);
  const int center = static_cast<int>(mesh.points.size());
  mesh.points.push_back(middle);
  if (!mesh.colors.empty()) mesh.colors.push_back(mesh.colors[static_cast<std::size_t>(border.points[0])]);
  for (std::size_t k = 0; k < n; ++k) {
    mesh.corners.push_back({border.points[(k + 1) % n], border.points[k], center});
    add_place(mesh, mesh.corners.back(), repairs);
  }
}

void close_holes(Mesh& mesh, double longest, MeshRepairs& repairs) {
  constexpr std::size_t kFewEdges = 4;
  for (const Border& border : borders(mesh)) {
    if (!border.closed || border.points.size() < 3 || (border.length > longest && border.points.size() > kFewEdges))
      continue;
    close_border(mesh, border, repairs);
    ++repairs.holes;
    repairs.hole_edges += border.points.size();
  }
}

Shells shells_of(const Mesh& mesh, bool nesting) {
  Shells shells;
  // Groups the triangles that are connected over edges (union–find).
  std::vector<int> root(mesh.corners.size());
  for (std::size_t i = 0; i < root.size(); ++i) root[i] = static_cast<int>(i);
  const auto find = [&](int i) {
    const auto at = [&](int k) -> int& { return root[static_cast<std::size_t>(k)]; };
    while (at(i) != i) i = at(i) = at(at(i));
    return i;
  };
  const std::vector<EdgeUse> edges = edges_of(mesh);
  for_each_edge(edges, [&](std::size_t first, std::size_t end) {
    for (std::size_t k = first + 1; k < end; ++k)
      root[static_cast<std::size_t>(find(static_cast<int>(edges[k].triangle)))] =
          find(static_cast<int>(edges[first].triangle));
  });
  std::map<int, int> number;
  std::vector<std::vector<Triangle>> triangles;
  std::vector<dvec3> first;  // one point of each shell
  for (std::size_t t = 0; t < mesh.corners.size(); ++t) {
    const auto [it, fresh] = number.try_emplace(find(static_cast<int>(t)), static_cast<int>(number.size()));
    const auto s = static_cast<std::size_t>(it->second);
    const Triangle tri = mesh.triangle(t);
    if (fresh) {
      first.push_back(tri.a);
      shells.volume.push_back(0);
      triangles.emplace_back();
    }
    shells.of_triangle.push_back(it->second);
    shells.volume[s] += glm::dot(tri.a - first[s], glm::cross(tri.b - first[s], tri.c - first[s])) / 6;
    triangles[s].push_back(tri);
  }
  const std::size_t count = triangles.size();
  shells.depth.assign(count, 0);
  if (!nesting || count < 2 || count > kMaxNested) return shells;

  struct Box {
    dvec3 lo{1e300}, hi{-1e300};
  };
  std::vector<Box> boxes(count);
  for (std::size_t s = 0; s < count; ++s) {
    for (const Triangle& t : triangles[s]) {
      boxes[s].lo = glm::min(boxes[s].lo, glm::min(t.a, glm::min(t.b, t.c)));
      boxes[s].hi = glm::max(boxes[s].hi, glm::max(t.a, glm::max(t.b, t.c)));
    }
  }
  constexpr std::size_t kSamples = 40;
  for (std::size_t outer = 0; outer < count; ++outer) {
    std::optional<TriangleTree> tree;
    for (std::size_t s = 0; s < count; ++s) {
      if (s == outer || !glm::all(glm::greaterThanEqual(boxes[s].lo, boxes[outer].lo)) ||
          !glm::all(glm::lessThanEqual(boxes[s].hi, boxes[outer].hi)))
        continue;
      if (!tree) tree.emplace(triangles[outer]);
      const std::size_t step = std::max<std::size_t>(1, triangles[s].size() / kSamples);
      bool within = true;
      for (std::size_t t = 0; t < triangles[s].size() && within; t += step)
        within = tree->winding(triangles[s][t].a) != 0;
      shells.depth[s] += within;
    }
  }
  return shells;
}

void turn_shells(Mesh& mesh, MeshRepairs& repairs) {
  const Shells shells = shells_of(mesh, true);
  for (std::size_t s = 0; s < shells.volume.size(); ++s) {
    const bool hollow = shells.depth[s] % 2 == 1;
    if ((shells.volume[s] < 0) == hollow) continue;
    // A reversed hollow is not counted as a repair, because in many files hollows face outward.
    repairs.shells_turned += !hollow;
    for (std::size_t t = 0; t < mesh.corners.size(); ++t) {
      if (shells.of_triangle[t] == static_cast<int>(s)) turn(mesh.corners[t]);
    }
  }
}

}  // namespace typodont::haptics::importing
