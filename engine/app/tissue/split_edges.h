// Splits long edges of a mesh, because light and displacement are interpolated between its vertices.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <utility>
#include <vector>

#include "engine/render/renderer.h"

namespace typodont {

/// The vertex in the middle of an edge.
inline render::Vertex middle_of(const render::Vertex& a, const render::Vertex& b) {
  render::Vertex m = a;
  m.p = 0.5f * (a.p + b.p);
  if (const glm::vec3 n = a.n + b.n; glm::dot(n, n) > 0) m.n = glm::normalize(n);
  m.second = 0.5f * (a.second + b.second);
  m.shows = 0.5f * (a.shows + b.shows);
  m.lesion = 0.5f * (a.lesion + b.lesion);
  m.paint = 0.5f * (a.paint + b.paint);
  m.difference = 0.5f * (a.difference + b.difference);
  return m;
}

/// Halves each edge for which `splits(a, b)` is true. False if there was none. If `splits` depends only on the two
/// vertices, no cracks appear, even between bricks.
template <class Splits>
bool split_edges(render::MeshUpdate& mesh, Splits&& splits) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
  const auto middle = [&](std::uint32_t a, std::uint32_t b) -> std::int64_t {
    const auto key = std::minmax(a, b);
    if (const auto found = middles.find(key); found != middles.end()) return found->second;
    if (!splits(mesh.vertices[a], mesh.vertices[b])) return -1;
    const auto index = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(middle_of(mesh.vertices[key.first], mesh.vertices[key.second]));
    middles.emplace(key, index);
    return index;
  };
  std::vector<std::uint32_t> indices;
  for (std::size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
    std::array<std::uint32_t, 3> c{mesh.indices[t], mesh.indices[t + 1], mesh.indices[t + 2]};
    // Index of the vertex in the middle of the edge after corner i; negative: the edge is not split.
    std::array<std::int64_t, 3> m{middle(c[0], c[1]), middle(c[1], c[2]), middle(c[2], c[0])};
    const auto add = [&](std::int64_t a, std::int64_t b, std::int64_t d) {
      for (const std::int64_t i : {a, b, d}) indices.push_back(static_cast<std::uint32_t>(i));
    };
    const auto count = std::count_if(m.begin(), m.end(), [](std::int64_t i) { return i >= 0; });
    // Rotates the corners so that the first edge is split and the last one is not, unless all or no edges are split.
    for (int turn = 0; turn < 3 && count > 0 && count < 3 && !(m[0] >= 0 && m[2] < 0); ++turn) {
      std::rotate(c.begin(), c.begin() + 1, c.end());
      std::rotate(m.begin(), m.begin() + 1, m.end());
    }
    if (count == 0) {
      add(c[0], c[1], c[2]);
    } else if (count == 1) {
      add(c[0], m[0], c[2]);
      add(m[0], c[1], c[2]);
    } else if (count == 2) {
      add(m[0], c[1], m[1]);
      add(c[0], m[0], m[1]);
      add(c[0], m[1], c[2]);
    } else {
      add(c[0], m[0], m[2]);
      add(m[0], c[1], m[1]);
      add(m[2], m[1], c[2]);
      add(m[0], m[1], m[2]);
    }
  }
  mesh.indices = std::move(indices);
  return !middles.empty();
}

}  // namespace typodont
