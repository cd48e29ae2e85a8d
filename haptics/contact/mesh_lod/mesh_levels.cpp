#include "haptics/contact/mesh_lod/mesh_levels.h"

#ifdef TYPODONT_LATE_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/late_library.h"
#include "haptics/mesh/spatial_order.h"

namespace typodont::haptics::mesh_lod {

namespace {

// Number of vertices of levels 2 and 3 / number of vertices of level 1 (Wang et al. 2009, Table 2).
constexpr double kSecondLevel = 13306.0 / 33140, kThirdLevel = 7443.0 / 33140;
constexpr std::size_t kFewestVertices = 64;  // smallest number of vertices of a level by default
// largest number of attempts to get the requested number of vertices
constexpr int kTries = 8;
constexpr double kNear = 0.005;  // allowed difference from the requested number of vertices, as a fraction of it

#ifdef TYPODONT_LATE_MESHOPTIMIZER
/// Function type of meshopt_simplify, which the header also declares as a template.
using Simplify = std::size_t(unsigned*, const unsigned*, std::size_t, const float*, std::size_t, std::size_t,
                             std::size_t, float, unsigned, float*);
constinit LateLibrary meshoptimizer{TYPODONT_LATE_MESHOPTIMIZER};
const Late<std::remove_pointer_t<decltype(static_cast<Simplify*>(meshopt_simplify))>> simplify{meshoptimizer,
                                                                                               "meshopt_simplify"};
#endif

/// Simplifies to about `triangles` triangles; open borders remain. `positions`: x, y, z of each vertex. Throws Error
/// without meshoptimizer.
std::vector<unsigned> simplified_indices(const std::vector<unsigned>& indices,
                                         [[maybe_unused]] const std::vector<float>& positions, std::size_t triangles) {
#ifdef TYPODONT_LATE_MESHOPTIMIZER
  std::vector<unsigned> kept(indices.size());
  kept.resize(simplify(kept.data(), indices.data(), indices.size(), positions.data(), positions.size() / 3,
                       3 * sizeof(float), 3 * triangles, FLT_MAX, meshopt_SimplifyLockBorder, nullptr));
  return kept;
#else
  throw Error("model", "mesh_lod", fmt::format("{} triangles to simplify to {}", indices.size() / 3, triangles),
              "a library that was built with meshoptimizer");
#endif
}

/// A mesh in the format of meshoptimizer.
class Simplifier {
 public:
  explicit Simplifier(const TissueMesh& mesh) : mesh_(mesh) {
    // A vertex at a border between tissues is copied for each tissue, because the simplifier preserves such seams.
    std::unordered_map<std::uint64_t, unsigned> copies;
    const dvec3 from = mesh.vertices[mesh.triangles.front().x];
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t v = mesh.triangles[i][k];
        const auto [it, fresh] = copies.try_emplace(std::uint64_t{v} << 8 | static_cast<std::uint8_t>(mesh.tissue[i]),
                                                    static_cast<unsigned>(original_.size()));
        if (fresh) {
          original_.push_back(v);
          tissue_.push_back(mesh.tissue[i]);
          for (int a = 0; a < 3; ++a) positions_.push_back(static_cast<float>(mesh.vertices[v][a] - from[a]));
        }
        indices_.push_back(it->second);
      }
    }
  }
  /// Mesh with about `triangles` triangles; it still contains unused vertices.
  TissueMesh to(std::size_t triangles) const {
    const std::vector<unsigned> kept = simplified_indices(indices_, positions_, triangles);
    TissueMesh result;
    result.vertices = mesh_.vertices;
    for (std::size_t i = 0; i + 2 < kept.size(); i += 3) {
      const glm::uvec3 t(original_[kept[i]], original_[kept[i + 1]], original_[kept[i + 2]]);
      if (t.x == t.y || t.y == t.z || t.z == t.x) continue;
      result.triangles.push_back(t);
      result.tissue.push_back(tissue_[kept[i]]);
    }
    return result;
  }

 private:
  const TissueMesh& mesh_;
  std::vector<unsigned> indices_;
  std::vector<std::uint32_t> original_;  // for each copy of a vertex: index of the original vertex
  std::vector<Tissue> tissue_;           // for each copy of a vertex: its tissue
  std::vector<float> positions_;         // m from the first vertex
};

/// Removes vertices that no triangle uses.
TissueMesh compact(TissueMesh mesh) {
  constexpr std::uint32_t kUnused = ~0u;
  std::vector<std::uint32_t> number(mesh.vertices.size(), kUnused);
  std::vector<dvec3> used;
  for (glm::uvec3& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      std::uint32_t& to = number[t[k]];
      if (to == kUnused) to = static_cast<std::uint32_t>(used.size()), used.push_back(mesh.vertices[t[k]]);
      t[k] = to;
    }
  }
  mesh.vertices = std::move(used);
  return mesh;
}

}  // namespace

std::size_t vertex_count(const TissueMesh& mesh) {
  std::vector<bool> used(mesh.vertices.size());
  for (const glm::uvec3& t : mesh.triangles) used[t.x] = used[t.y] = used[t.z] = true;
  return static_cast<std::size_t>(std::ranges::count(used, true));
}

TissueMesh subdivided(const TissueMesh& mesh) {
  TissueMesh fine;
  fine.vertices = mesh.vertices;
  std::unordered_map<std::uint64_t, std::uint32_t> middles;
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto [it, fresh] = middles.try_emplace(std::uint64_t{std::min(a, b)} << 32 | std::max(a, b),
                                                 static_cast<std::uint32_t>(fine.vertices.size()));
    if (fresh) fine.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]) / 2.0);
    return it->second;
  };
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::uvec3& t = mesh.triangles[i];
    const std::uint32_t ab = middle(t.x, t.y), bc = middle(t.y, t.z), ca = middle(t.z, t.x);
    for (const glm::uvec3& part :
         {glm::uvec3(t.x, ab, ca), glm::uvec3(ab, t.y, bc), glm::uvec3(ca, bc, t.z), glm::uvec3(ab, bc, ca)}) {
      fine.triangles.push_back(part);
      fine.tissue.push_back(mesh.tissue[i]);
    }
  }
  return fine;
}

TissueMesh thinned(const TissueMesh& mesh, double part) {
  const auto wanted = static_cast<double>(mesh.triangles.size()) * part;
  return mesh.triangles.empty() ? mesh : compact(Simplifier(mesh).to(static_cast<std::size_t>(wanted)));
}

TissueMesh simplified(const TissueMesh& mesh, std::size_t vertices) {
  const std::size_t there = vertex_count(mesh);
  if (there <= vertices) return mesh;
  const Simplifier simplifier(mesh);
  // A closed mesh has about two triangles per vertex; a mesh with open borders has fewer.
  double triangles =
      static_cast<double>(mesh.triangles.size()) * static_cast<double>(vertices) / static_cast<double>(there);
  TissueMesh best;
  double least = 1e300;
  for (int i = 0; i < kTries; ++i) {
    TissueMesh result = simplifier.to(static_cast<std::size_t>(std::max(triangles, 1.0)));
    const double off = static_cast<double>(vertex_count(result)) - static_cast<double>(vertices);
    if (std::abs(off) < least) least = std::abs(off), best = std::move(result);
    if (least <= kNear * static_cast<double>(vertices)) break;
    triangles -= 2 * off;
  }
  return compact(std::move(best));
}

TissueMesh base_mesh(TissueMesh mesh, const LevelOptions& options) {
  if (options.vertices) {
    while (vertex_count(mesh) < *options.vertices) mesh = subdivided(mesh);
    mesh = simplified(mesh, *options.vertices);
  }
  return mesh;
}

std::shared_ptr<const Levels> make_levels(const TissueMesh& mesh, const LevelOptions& options) {
  const TissueMesh base = base_mesh(mesh, options);
  const std::size_t all = vertex_count(base);
  std::vector<std::size_t> wanted = options.levels;
  if (wanted.empty()) {
    wanted.push_back(all);
    for (const double part : {kSecondLevel, kThirdLevel}) {
      const auto count = static_cast<std::size_t>(std::lround(part * static_cast<double>(all)));
      if (count >= kFewestVertices) wanted.push_back(count);
    }
  }
  auto levels = std::make_shared<Levels>();
  for (const std::size_t count : wanted) {
    TissueMesh level = mesh::in_spatial_order(simplified(base, count));
    levels->vertices.push_back(vertex_count(level));
    levels->grids.emplace_back(level);
    if (levels->finest.triangles.empty()) levels->finest = std::move(level);
  }
  return levels;
}

}  // namespace typodont::haptics::mesh_lod
