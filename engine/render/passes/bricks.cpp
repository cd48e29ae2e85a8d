#include "engine/render/passes/bricks.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace typodont::render {

namespace {

constexpr std::uint64_t kBlockVertices = 1u << 17, kBlockIndices = 3u << 18;

std::int16_t snorm16(float v) {
  return static_cast<std::int16_t>(std::lround(std::clamp(v, -1.0f, 1.0f) * 32767.0f));
}
GpuVertex pack(const Vertex& v) {
  static_assert(kTissueCount <= 16, "four bits name the tissue beneath");
  const long shows = std::lround(std::clamp(v.shows, 0.0f, 1.0f) * 15.0f);
  return {{v.p.x, v.p.y, v.p.z},
          {snorm16(v.n.x), snorm16(v.n.y), snorm16(v.n.z), snorm16(v.difference / kDifferenceRange)},
          {static_cast<std::uint8_t>(v.tissue[0]), static_cast<std::uint8_t>(v.tissue[1]),
           static_cast<std::uint8_t>(std::lround(std::clamp(v.second, 0.0f, 1.0f) * 255.0f)),
           static_cast<std::uint8_t>(static_cast<long>(v.under) | shows << 4)}};
}

/// Box and normal cone: what decides whether a brick is worth drawing.
void measure(Brick& brick, const MeshUpdate& u) {
  brick.lo = glm::vec3(1e9f);
  brick.hi = glm::vec3(-1e9f);
  for (const Vertex& v : u.vertices) {
    brick.lo = glm::min(brick.lo, v.p);
    brick.hi = glm::max(brick.hi, v.p);
  }
  // The cone holds the normals of the triangles (they, not the corners' normals, decide what faces away).
  glm::vec3 sum(0);
  const auto face = [&](std::size_t i) {
    const glm::vec3 a = u.vertices[u.indices[i]].p, b = u.vertices[u.indices[i + 1]].p,
                    c = u.vertices[u.indices[i + 2]].p;
    const glm::vec3 n = glm::cross(b - a, c - a);
    const float length = glm::length(n);
    return length > 1e-20f ? n / length : glm::vec3(0);
  };
  for (std::size_t i = 0; i + 2 < u.indices.size(); i += 3) sum += face(i);
  const float length = glm::length(sum);
  brick.cone_cutoff = 1;
  if (length < 1e-6f) return;
  brick.cone_axis = sum / length;
  float least = 1;
  for (std::size_t i = 0; i + 2 < u.indices.size(); i += 3) {
    const glm::vec3 n = face(i);
    if (n != glm::vec3(0)) least = std::min(least, glm::dot(n, brick.cone_axis));
  }
  if (least > 0.05f) brick.cone_cutoff = std::sqrt(1 - least * least);
}

struct Planes {
  std::array<glm::vec4, 6> plane;
};

/// Inside is where all six are positive (Gribb & Hartmann 2001, depth 0..1).
Planes planes(const glm::dmat4& clip_from_mesh) {
  const glm::dmat4 rows = glm::transpose(clip_from_mesh);
  return {{glm::vec4(rows[3] + rows[0]), glm::vec4(rows[3] - rows[0]), glm::vec4(rows[3] + rows[1]),
           glm::vec4(rows[3] - rows[1]), glm::vec4(rows[2]), glm::vec4(rows[3] - rows[2])}};
}

bool outside(const Planes& p, const Brick& b) {
  for (const glm::vec4& plane : p.plane) {
    const glm::vec3 farthest(plane.x > 0 ? b.hi.x : b.lo.x, plane.y > 0 ? b.hi.y : b.lo.y,
                             plane.z > 0 ? b.hi.z : b.lo.z);
    if (glm::dot(glm::vec3(plane), farthest) + plane.w < 0) return true;
  }
  return false;
}

bool faces_away(const Brick& b, const glm::vec3& eye) {
  if (b.cone_cutoff >= 1) return false;
  // meshoptimizer's cone test about the box's middle
  const glm::vec3 middle = 0.5f * (b.lo + b.hi), way = middle - eye;
  const float radius = 0.5f * glm::length(b.hi - b.lo);
  return glm::dot(way, b.cone_axis) >= b.cone_cutoff * glm::length(way) + radius;
}

}  // namespace

bool shown_in(View view, MeshId mesh) {
  switch (view) {
    case View::kLook:
    case View::kDifference:
      return mesh < kSectionFace;
    case View::kSection:
      return mesh <= kSectionFace;
    case View::kXray:
      return mesh == kWorkingTooth || mesh > kSectionFace;
  }
  return true;
}

bool glassy_in(View view, MeshId mesh) {
  return view == View::kXray && (mesh == kWorkingTooth || mesh == kInsideDentin);
}

void BrickStore::update(gpu::Device& device, MeshId id, std::span<const MeshUpdate> updates, std::uint64_t frame) {
  if (updates.empty()) return;
  Mesh& mesh = meshes[id];
  for (const MeshUpdate& u : updates) {
    if (const auto old = mesh.bricks.find(u.brick); old != mesh.bricks.end()) {
      retire(old->second, frame);
      mesh.bricks.erase(old);
    }
    ++uploaded;
    if (u.indices.empty()) continue;

    Brick brick;
    brick.vertices = static_cast<std::uint32_t>(u.vertices.size());
    brick.indices = static_cast<std::uint32_t>(u.indices.size());
    measure(brick, u);
    std::uint64_t v = gpu::RangeAllocator::kNone, i = v;
    for (std::size_t k = 0; k < blocks.size() && brick.block < 0; ++k) {
      v = blocks[k].free_vertices.allocate(brick.vertices);
      if (v == gpu::RangeAllocator::kNone) continue;
      i = blocks[k].free_indices.allocate(brick.indices);
      if (i == gpu::RangeAllocator::kNone) {
        blocks[k].free_vertices.release(v, brick.vertices);
        continue;
      }
      brick.block = static_cast<int>(k);
    }
    if (brick.block < 0) {
      BrickBlock block;
      const std::uint64_t vertices = std::max<std::uint64_t>(kBlockVertices, brick.vertices);
      const std::uint64_t indices = std::max<std::uint64_t>(kBlockIndices, brick.indices);
      block.vertices = gpu::Buffer::create(device, vertices * sizeof(GpuVertex), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
      block.indices = gpu::Buffer::create(device, indices * sizeof(std::uint32_t), VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
      block.free_vertices = gpu::RangeAllocator(vertices);
      block.free_indices = gpu::RangeAllocator(indices);
      v = block.free_vertices.allocate(brick.vertices);
      i = block.free_indices.allocate(brick.indices);
      brick.block = static_cast<int>(blocks.size());
      blocks.push_back(std::move(block));
    }
    brick.first_vertex = static_cast<std::uint32_t>(v);
    brick.first_index = static_cast<std::uint32_t>(i);
    // Written straight into memory the GPU reads: the range is new, so no unfinished frame looks at it.
    const BrickBlock& block = blocks[static_cast<std::size_t>(brick.block)];
    packed_.clear();
    for (const Vertex& vertex : u.vertices) packed_.push_back(pack(vertex));
    std::memcpy(block.vertices.mapped<GpuVertex>(v * sizeof(GpuVertex)), packed_.data(),
                packed_.size() * sizeof(GpuVertex));
    std::memcpy(block.indices.mapped<std::uint32_t>(i * sizeof(std::uint32_t)), u.indices.data(),
                u.indices.size() * sizeof(std::uint32_t));
    uploaded_bytes += packed_.size() * sizeof(GpuVertex) + u.indices.size() * sizeof(std::uint32_t);
    mesh.bricks.emplace(u.brick, brick);
  }
  ++version;
}

void BrickStore::remove(MeshId id, std::uint64_t frame) {
  const auto found = meshes.find(id);
  if (found == meshes.end()) return;
  for (const auto& [key, brick] : found->second.bricks) retire(brick, frame);
  meshes.erase(found);
  ++version;
}

void BrickStore::retire(const Brick& brick, std::uint64_t frame) {
  retired_.push_back({frame, brick});
}

void BrickStore::collect(std::uint64_t finished) {
  while (!retired_.empty() && retired_.front().frame <= finished) {
    const Brick& b = retired_.front().brick;
    BrickBlock& block = blocks[static_cast<std::size_t>(b.block)];
    block.free_vertices.release(b.first_vertex, b.vertices);
    block.free_indices.release(b.first_index, b.indices);
    retired_.pop_front();
  }
}

bool BrickStore::bounds(glm::dvec3& lo, glm::dvec3& hi, glm::dvec3& all_lo, glm::dvec3& all_hi) const {
  lo = all_lo = glm::dvec3(1e9);
  hi = all_hi = glm::dvec3(-1e9);
  for (const auto& [id, mesh] : meshes)
    for (const auto& [key, b] : mesh.bricks)
      for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p = mesh.X_WM * glm::dvec3(corner & 1 ? b.hi.x : b.lo.x, corner & 2 ? b.hi.y : b.lo.y,
                                                    corner & 4 ? b.hi.z : b.lo.z);
        all_lo = glm::min(all_lo, p);
        all_hi = glm::max(all_hi, p);
        if (id != kWorkingTooth) continue;
        lo = glm::min(lo, p);
        hi = glm::max(hi, p);
      }
  if (all_lo.x > all_hi.x) return false;
  if (lo.x > hi.x) {
    lo = all_lo;
    hi = all_hi;
  }
  return true;
}

std::vector<DrawGroup> BrickStore::visible(gpu::Device& device, int slot, const Frame& frame, SlotBuffers& into,
                                           FrameStats& stats) {
  std::size_t count = 0;
  for (const auto& [id, mesh] : meshes) count += mesh.bricks.size();
  gpu::Buffer& buffer = into.at_least(device, slot, count * sizeof(VkDrawIndexedIndirectCommand),
                                          VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT);
  auto* out = buffer.mapped<VkDrawIndexedIndirectCommand>();
  std::uint32_t written = 0;
  std::vector<DrawGroup> groups;
  std::vector<std::vector<VkDrawIndexedIndirectCommand>> by_block(blocks.size());
  for (const auto& [id, mesh] : meshes) {
    if (!shown_in(frame.view, id)) continue;
    const Pose X_MW = inverse(mesh.X_WM);
    const glm::dmat4 world_from_mesh = [&X_WM = mesh.X_WM] {
      glm::dmat4 m(glm::mat3_cast(X_WM.R));
      m[3] = glm::dvec4(X_WM.p, 1);
      return m;
    }();
    std::array<Planes, 2> frusta;
    std::array<glm::vec3, 2> eyes;
    for (std::size_t e = 0; e < static_cast<std::size_t>(frame.views); ++e) {
      frusta[e] = planes(frame.eyes[e].projection * frame.eyes[e].view * world_from_mesh);
      eyes[e] = glm::vec3(X_MW * frame.eyes[e].position);
    }
    for (auto& list : by_block) list.clear();
    for (const auto& [key, b] : mesh.bricks) {
      bool out_of_view = true, away = true;
      for (std::size_t e = 0; e < static_cast<std::size_t>(frame.views); ++e) {
        out_of_view = out_of_view && outside(frusta[e], b);
        away = away && frame.view != View::kSection && faces_away(b, eyes[e]);  // a cut shows insides
      }
      if (out_of_view) {
        ++stats.bricks_culled;
      } else if (away) {
        ++stats.bricks_facing_away;
      } else {
        ++stats.bricks_drawn;
        stats.triangles += b.indices / 3;
        by_block[static_cast<std::size_t>(b.block)].push_back(
            {b.indices, 1, b.first_index, static_cast<std::int32_t>(b.first_vertex), 0});
      }
    }
    for (std::size_t block = 0; block < by_block.size(); ++block) {
      if (by_block[block].empty()) continue;
      groups.push_back({id, static_cast<int>(block), written, static_cast<std::uint32_t>(by_block[block].size())});
      std::memcpy(out + written, by_block[block].data(), by_block[block].size() * sizeof(*out));
      written += static_cast<std::uint32_t>(by_block[block].size());
    }
  }
  return groups;
}

std::vector<DrawGroup> BrickStore::all(gpu::Device& device, int slot, View view) {
  std::size_t count = 0;
  for (const auto& [id, mesh] : meshes) count += mesh.bricks.size();
  gpu::Buffer& buffer = shadow_indirect.at_least(device, slot, count * sizeof(VkDrawIndexedIndirectCommand),
                                                 VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT);
  auto* out = buffer.mapped<VkDrawIndexedIndirectCommand>();
  std::uint32_t written = 0;
  std::vector<DrawGroup> groups;
  for (const auto& [id, mesh] : meshes)
    for (std::size_t block = 0; shown_in(view, id) && block < blocks.size(); ++block) {
      const std::uint32_t first = written;
      for (const auto& [key, b] : mesh.bricks)
        if (b.block == static_cast<int>(block))
          out[written++] = {b.indices, 1, b.first_index, static_cast<std::int32_t>(b.first_vertex), 0};
      if (written > first) groups.push_back({id, static_cast<int>(block), first, written - first});
    }
  return groups;
}

void BrickStore::draw(VkCommandBuffer commands, VkPipelineLayout layout, VkBuffer buffer,
                      std::span<const DrawGroup> groups) const {
  for (const DrawGroup& g : groups) {
    const BrickBlock& block = blocks[static_cast<std::size_t>(g.block)];
    push(commands, layout, meshes.at(g.mesh).X_WM);
    const VkDeviceSize zero = 0;
    vkCmdBindVertexBuffers(commands, 0, 1, &block.vertices.buffer, &zero);
    vkCmdBindIndexBuffer(commands, block.indices.buffer, 0, VK_INDEX_TYPE_UINT32);
    vkCmdDrawIndexedIndirect(commands, buffer, g.first * sizeof(VkDrawIndexedIndirectCommand), g.count,
                             sizeof(VkDrawIndexedIndirectCommand));
  }
}

void BrickStore::destroy(gpu::Device& device) {
  for (BrickBlock& b : blocks) {
    b.vertices.destroy(device);
    b.indices.destroy(device);
  }
  blocks.clear();
  indirect.destroy(device);
  shadow_indirect.destroy(device);
  mirror_indirect.destroy(device);
}

}  // namespace typodont::render
