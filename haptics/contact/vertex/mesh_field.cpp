#include "haptics/contact/vertex/mesh_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "engine/base/nearest.h"
#include "engine/base/voxels.h"

namespace typodont::haptics::vertex {

using mesh::EditableMesh;
using mesh::Index;
using mesh::kNone;

namespace {

constexpr int kEdge = 8, kApron = kEdge + 2;
// voxels; faces within this distance of a sample determine the sample's value
constexpr double kNearSample = 2.5;

dvec3 unit_normal(const EditableMesh& mesh, Index f) {
  const dvec3 n = normal2(mesh, f);
  const double length = glm::length(n);
  return length > 0 ? n / length : dvec3(0);
}

/// Pseudonormal of `feature`; it points outside (Baerentzen & Aanaes 2005).
dvec3 pseudonormal(const EditableMesh& mesh, Index f, int feature) {
  if (feature == 6) return unit_normal(mesh, f);
  if (feature >= 3) {
    const Index g = mesh.face(f).n[feature - 3];
    return unit_normal(mesh, f) + (g == kNone ? dvec3(0) : unit_normal(mesh, g));
  }
  dvec3 sum(0);
  mesh.around(mesh.face(f).v[feature], [&](Index g, int c) {
    const dvec3 a = mesh.point(g, (c + 1) % 3) - mesh.point(g, c), b = mesh.point(g, (c + 2) % 3) - mesh.point(g, c);
    const double size = glm::length(a) * glm::length(b);
    if (size > 0) sum += std::acos(std::clamp(glm::dot(a, b) / size, -1.0, 1.0)) * unit_normal(mesh, g);
  });
  return sum;
}

bool was_cut(const EditableMesh& mesh, Index f) {
  return std::any_of(mesh.face(f).v, mesh.face(f).v + 3, [&](Index v) { return mesh.vertex(v).was_moved(); });
}

struct Block {
  // values of the samples before all cuts, with one more layer on each side
  std::array<float, kApron * kApron * kApron> before;
  std::array<float, kEdge * kEdge * kEdge> value;
  std::array<std::int8_t, kEdge * kEdge * kEdge> side;  // -1 inside, 1 outside, 0 unknown
};
std::size_t at(int x, int y, int z) {
  return static_cast<std::size_t>((x * kEdge + y) * kEdge + z);
}
using Blocks = std::map<glm::ivec3, Block, LessByAxes>;

/// For samples near a face (kNearSample): computes whether they are inside, and their distance if a cut has moved the
/// face.
void measure(const EditableMesh& mesh, const VoxelFrame& frame, const glm::ivec3& key, Block& block) {
  struct Nearest {
    double distance2 = 1e300;
    Index f = kNone;
    NearestOnTriangle to{};
  };
  std::array<Nearest, kEdge * kEdge * kEdge> nearest;
  const double reach = kNearSample * frame.voxel;
  const dvec3 lo = frame.to_world(dvec3(key * kEdge)), hi = frame.to_world(dvec3(key * kEdge + kEdge - 1));
  mesh.near(lo - reach, hi + reach, [&](Index f) {
    const dvec3 &a = mesh.point(f, 0), &b = mesh.point(f, 1), &c = mesh.point(f, 2);
    const dvec3 first = frame.to_voxels(glm::min(glm::min(a, b), c)) - kNearSample,
                last = frame.to_voxels(glm::max(glm::max(a, b), c)) + kNearSample;
    const glm::ivec3 from = glm::max(glm::ivec3(glm::ceil(first)) - key * kEdge, glm::ivec3(0));
    const glm::ivec3 to = glm::min(glm::ivec3(glm::floor(last)) - key * kEdge, glm::ivec3(kEdge - 1));
    for_each_voxel_between(from, to, [&](int x, int y, int z) {
      const dvec3 p = frame.to_world(dvec3(key * kEdge + glm::ivec3(x, y, z)));
      const NearestOnTriangle found = nearest_on_triangle(a, b, c, p);
      const double distance2 = glm::dot(p - found.p, p - found.p);
      Nearest& best = nearest[at(x, y, z)];
      if (distance2 < best.distance2 || (distance2 == best.distance2 && f < best.f)) best = {distance2, f, found};
    });
  });
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    const Nearest& best = nearest[i];
    block.side[i] = 0;
    if (!(best.distance2 < reach * reach)) continue;
    const glm::ivec3 v(static_cast<int>(i) / (kEdge * kEdge), static_cast<int>(i) / kEdge % kEdge,
                       static_cast<int>(i) % kEdge);
    const dvec3 off = frame.to_world(dvec3(key * kEdge + v)) - best.to.p;
    const bool outside = glm::dot(off, pseudonormal(mesh, best.f, best.to.feature)) > 0;
    block.side[i] = outside ? 1 : -1;
    if (!was_cut(mesh, best.f)) continue;
    const double distance = std::sqrt(best.distance2) / frame.voxel;
    block.value[i] = std::max(block.value[i], static_cast<float>(outside ? distance : -distance));
  }
}

/// Samples far from all faces receive the side (inside, outside) of a neighbouring sample.
void spread_sides(Blocks& blocks) {
  struct Place {
    glm::ivec3 key, v;
  };
  std::vector<Place> queue;
  const auto normal = [](Place place) {
    for (int axis = 0; axis < 3; ++axis) {
      if (place.v[axis] < 0) place.v[axis] += kEdge, --place.key[axis];
      if (place.v[axis] >= kEdge) place.v[axis] -= kEdge, ++place.key[axis];
    }
    return place;
  };
  for (auto& [key, block] : blocks) {
    for_each_voxel(glm::ivec3(kEdge), [&](const glm::ivec3& v) {
      std::int8_t& side = block.side[at(v.x, v.y, v.z)];
      // A neighbour outside all blocks has the original sign of the field, because no cut has changed it.
      for (const glm::ivec3& step : kFaceSteps) {
        const glm::ivec3 n = v + step;
        if (side != 0 ||
            (glm::all(glm::greaterThanEqual(n, glm::ivec3(0))) && glm::all(glm::lessThan(n, glm::ivec3(kEdge))))) {
          continue;
        }
        if (blocks.contains(normal({key, n}).key)) continue;
        const float beyond = block.before[static_cast<std::size_t>(((n.x + 1) * kApron + n.y + 1) * kApron + n.z + 1)];
        if (std::abs(beyond) >= 1) side = beyond > 0 ? 1 : -1;
      }
      if (side != 0) queue.push_back({key, v});
    });
  }
  while (!queue.empty()) {
    const Place from = queue.back();
    queue.pop_back();
    const std::int8_t side = blocks.at(from.key).side[at(from.v.x, from.v.y, from.v.z)];
    for (const glm::ivec3& step : kFaceSteps) {
      const Place to = normal({from.key, from.v + step});
      const auto found = blocks.find(to.key);
      if (found == blocks.end()) continue;
      std::int8_t& other = found->second.side[at(to.v.x, to.v.y, to.v.z)];
      if (other != 0) continue;
      other = side;
      float& value = found->second.value[at(to.v.x, to.v.y, to.v.z)];
      // Inside before the cuts, outside now, and no face near: the value becomes the positive constant kNearSample.
      if (side > 0 && value < 0) value = static_cast<float>(kNearSample);
      queue.push_back(to);
    }
  }
}

}  // namespace

std::vector<RasterBlock> field_of(const EditableMesh& mesh, const FieldBlocks& wanted, const TissueVolume& untouched,
                                  const TissueVolume& now) {
  Blocks blocks;
  const VoxelFrame frame = untouched.frame();
  for (const glm::ivec3& key : wanted) {
    Block& block = blocks[key];
    untouched.copy(key * kEdge, glm::ivec3(kEdge), block.value.data(), nullptr);
    now.copy(key * kEdge - 1, glm::ivec3(kApron), block.before.data(), nullptr);
    measure(mesh, frame, key, block);
  }
  spread_sides(blocks);
  std::vector<RasterBlock> field;
  for (const auto& [key, block] : blocks) {
    field.push_back({key * kEdge, glm::ivec3(kEdge), {block.value.begin(), block.value.end()}});
  }
  return field;
}

}  // namespace typodont::haptics::vertex
