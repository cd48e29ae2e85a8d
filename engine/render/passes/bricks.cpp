#include "engine/render/passes/bricks.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "engine/base/voxels.h"
#include "engine/render/drawn_matter.h"

namespace typodont::render {

namespace {

// Size of the pieces of a brick that are redrawn separately if their light changes, m.
constexpr float kPiece = 0.8e-3f;
constexpr std::uint64_t kBlockVertices = 1u << 17, kBlockIndices = 3u << 18;

std::int16_t snorm16(float v) {
  return static_cast<std::int16_t>(std::lround(std::clamp(v, -1.0f, 1.0f) * 32767.0f));
}
GpuVertex pack(const Vertex& v) {
  static_assert(kMatterCount <= 16, "four bits name a tissue");
  // Packs a tissue into the low four bits and a fraction (0..15) into the high four.
  const auto with = [](Tissue tissue, float fraction) {
    return static_cast<std::uint8_t>(static_cast<long>(tissue) | std::lround(std::clamp(fraction, 0.0f, 1.0f) * 15.0f)
                                                                     << 4);
  };
  const auto byte = [](float fraction) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(fraction, 0.0f, 1.0f) * 255.0f));
  };
  const VoxelColor paint = v.paint.w > 0 ? voxel_color(dvec3(v.paint)) : kTissueColor;
  return {
      {v.p.x, v.p.y, v.p.z},
      {snorm16(v.n.x), snorm16(v.n.y), snorm16(v.n.z), snorm16(v.difference / kDifferenceRange)},
      {with(v.tissue[0], v.cut), with(v.tissue[1], v.thin), byte(v.second), with(v.under, v.shows)},
      {byte(v.lesion), static_cast<std::uint8_t>(paint & 255), static_cast<std::uint8_t>(paint >> 8), byte(v.paint.w)}};
}

/// Computes box and normal cone of a brick, for culling.
void measure(Brick& brick, const MeshUpdate& u) {
  brick.lo = glm::vec3(1e9f);
  brick.hi = glm::vec3(-1e9f);
  for (const Vertex& v : u.vertices) {
    brick.lo = glm::min(brick.lo, v.p);
    brick.hi = glm::max(brick.hi, v.p);
  }
  // The cone contains normals of triangles, not of vertices: a triangle's own normal decides whether it faces away.
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
  if (least > 0.05f && !u.two_sided) brick.cone_cutoff = std::sqrt(1 - least * least);
}

BrickKind kind_of(const MeshUpdate& u) {
  if (u.two_sided) return BrickKind::kTwoSided;
  bool gum = true, enamel = true, sound = true;
  for (const Vertex& v : u.vertices)
    for (const Tissue t : v.tissue) {
      if (t == Tissue::kAmalgam) return BrickKind::kMetal;
      const bool soft = t == Tissue::kGingiva || t >= kMucosa;
      gum = gum && soft && v.tissue[0] == v.tissue[1];
      enamel = enamel && t == Tissue::kEnamel;
      sound = sound && t != Tissue::kCaries && !soft;
    }
  return gum ? BrickKind::kGum : enamel ? BrickKind::kEnamel : sound ? BrickKind::kSound : BrickKind::kAny;
}

/// Views for teaching use one shader for all bricks; kDifference uses a second one for two-sided bricks.
BrickKind kind_in(View view, const Brick& b) {
  const bool own_code = view == View::kLook || (view == View::kDifference && b.kind == BrickKind::kTwoSided);
  return own_code ? b.kind : BrickKind::kAny;
}

glm::dmat4 matrix(const Pose& X) {
  glm::dmat4 m(glm::mat3_cast(X.R));
  m[3] = glm::dvec4(X.p, 1);
  return m;
}

BoxInWorld in_world(const Pose& X_WM, const Brick& b) {
  BoxInWorld box{glm::dvec3(1e9), glm::dvec3(-1e9)};
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p =
        X_WM * glm::dvec3(corner & 1 ? b.hi.x : b.lo.x, corner & 2 ? b.hi.y : b.lo.y, corner & 4 ? b.hi.z : b.lo.z);
    box.lo = glm::min(box.lo, p);
    box.hi = glm::max(box.hi, p);
  }
  return box;
}

struct Planes {
  std::array<glm::vec4, 6> plane;
};

Planes planes(const glm::dmat4& clip_from_mesh) {
  Planes p;
  std::ranges::transform(frustum_planes(clip_from_mesh), p.plane.begin(),
                         [](const glm::dvec4& v) { return glm::vec4(v); });
  return p;
}

bool outside(const Planes& p, const Brick& b) {
  for (const glm::vec4& plane : p.plane) {
    const glm::vec3 farthest(plane.x > 0 ? b.hi.x : b.lo.x, plane.y > 0 ? b.hi.y : b.lo.y,
                             plane.z > 0 ? b.hi.z : b.lo.z);
    if (glm::dot(glm::vec3(plane), farthest) + plane.w < 0) return true;
  }
  return false;
}

/// Returns true if the whole brick is beyond the plane, where another body covers it. With a zero plane, no brick is
/// covered.
bool covered(const glm::vec4& plane, const Brick& b) {
  const glm::vec3 farthest(plane.x > 0 ? b.hi.x : b.lo.x, plane.y > 0 ? b.hi.y : b.lo.y, plane.z > 0 ? b.hi.z : b.lo.z);
  return glm::dot(glm::vec3(plane), farthest) + plane.w < 0;
}

bool faces_away(const Brick& b, const glm::vec3& eye) {
  if (b.cone_cutoff >= 1) return false;
  // As in meshoptimizer: true if the normal cone, with its tip in the middle of the box, faces away from the eye.
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
      return mesh <= kSectionFaceAround;
    case View::kTemperature:
      return mesh == kWorkingTooth || mesh == kSectionFace;
    case View::kXray:
      return mesh == kWorkingTooth || mesh > kSectionFaceAround;
  }
  return true;
}

bool glassy_in(View view, MeshId mesh) {
  return view == View::kXray && (mesh == kWorkingTooth || mesh == kInsideDentin);
}

void BrickStore::update(gpu::Device& device, MeshId id, std::span<const MeshUpdate> updates, std::uint64_t frame) {
  if (updates.empty()) return;
  Mesh& mesh = meshes[id];
  const bool first = mesh.bricks.empty();
  for (const MeshUpdate& u : updates) {
    if (const auto old = mesh.bricks.find(u.brick); old != mesh.bricks.end()) {
      changed.push_back(in_world(mesh.X_WM, old->second));
      retire(old->second, frame);
      mesh.bricks.erase(old);
    }
    ++uploaded;
    if (u.indices.empty()) continue;

    Brick brick;
    brick.vertices = static_cast<std::uint32_t>(u.vertices.size());
    brick.indices = static_cast<std::uint32_t>(u.indices.size());
    measure(brick, u);
    brick.kind = kind_of(u);
    brick.first = first;
    changed.push_back(in_world(mesh.X_WM, brick));
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
    // The space was allocated just now, so no unfinished frame reads it.
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
  ++order;
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

std::optional<SceneBounds> BrickStore::bounds() const {
  glm::dvec3 lo, hi, all_lo, all_hi;
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
  if (all_lo.x > all_hi.x) return std::nullopt;
  if (lo.x > hi.x) {
    lo = all_lo;
    hi = all_hi;
  }
  return SceneBounds{lo, hi, all_lo, all_hi};
}

namespace {

/// Plane of Renderer::cover() in mesh coordinates; unchanged bricks beyond it are inside another body. Zero: no plane.
glm::vec4 cover_of(const std::map<MeshId, glm::dvec4>& covers, MeshId id, View view, const Pose& X_WM) {
  const auto found = covers.find(id);
  if (found == covers.end() || cuts_section(view) || view == View::kXray) return glm::vec4(0);
  return glm::vec4(
      glm::dvec4(inverse(X_WM).rotate(dvec3(found->second)), found->second.w + glm::dot(dvec3(found->second), X_WM.p)));
}

}  // namespace

void BrickStore::mark_changed(const Frame& frame, const shared::FrameData& data, const shared::FrameData& before,
                              const glm::ivec2& size, std::uint64_t eyes, std::array<Tiles, 2>& tiles) {
  const auto views = static_cast<std::size_t>(frame.views);
  std::array<glm::dmat4, 2> clip_from_world;
  for (std::size_t e = 0; e < views; ++e) clip_from_world[e] = frame.eyes[e].projection * frame.eyes[e].view;
  const glm::dmat4 light_from_world(data.light_from_world);
  const bool lit = data.light_size.w > 0;
  const ToolShade shade(data), shade_before(before);
  const bool cursor_moved = data.cursor != before.cursor || data.cursor_down != before.cursor_down;
  std::vector<ShadowMapBox> in_map;
  for (const BoxInWorld& box : changed) {
    const glm::vec3 lo(box.lo), hi(box.hi);
    for (std::size_t e = 0; e < views; ++e) tiles[e].mark(seen_in(clip_from_world[e], lo, hi, size));
    if (!lit) continue;
    ShadowMapBox part = shadow_map_box(light_from_world, lo, hi);
    const float reach = shadow_lookup_reach(data);
    part.lo -= reach;
    part.hi += reach;
    // Parts that touch each other are joined, because they affect mostly the same pixels.
    if (!in_map.empty() && in_map.back().meets(part))
      in_map.back().take(part);
    else
      in_map.push_back(part);
  }
  for (auto& [id, mesh] : meshes) {
    if (!shown_in(frame.view, id)) continue;
    const glm::dmat4 world_from_mesh = matrix(mesh.X_WM);
    const glm::dmat4 light_from_mesh = light_from_world * world_from_mesh;
    const glm::vec4 cover = cover_of(covers, id, frame.view, mesh.X_WM);
    for (auto& [key, b] : mesh.bricks) {
      if (marked_fraction(tiles, frame.views) >= kFullRedrawFraction) return;
      if (b.seen_by != eyes) {
        b.seen_by = eyes;
        for (std::size_t e = 0; e < views; ++e)
          b.seen[e] = seen_in(clip_from_world[e] * world_from_mesh, b.lo, b.hi, size);
      }
      if (b.first && covered(cover, b)) continue;
      const auto lit_otherwise = [&](const glm::vec3& lo, const glm::vec3& hi) {
        const glm::vec3 center(world_from_mesh * glm::dvec4(0.5f * (lo + hi), 1));
        const float radius = 0.5f * glm::length(hi - lo);
        if (shade.reaches(center, radius) || shade_before.reaches(center, radius)) return true;
        if (cursor_moved && (cursor_marks(data, center, radius) || cursor_marks(before, center, radius))) return true;
        if (in_map.empty()) return false;
        const ShadowMapBox own = shadow_map_box(light_from_mesh, lo, hi);
        return std::any_of(in_map.begin(), in_map.end(), [&](const ShadowMapBox& part) { return part.meets(own); });
      };
      if (!std::any_of(b.seen.begin(), b.seen.begin() + frame.views, [](const PixelBox& s) { return s.width > 0; }) ||
          !lit_otherwise(b.lo, b.hi))
        continue;
      // The light may change on only a part of a large brick (for example of the gum), so its pieces are tested.
      const glm::vec3 extent = b.hi - b.lo;
      const glm::ivec3 pieces = glm::clamp(glm::ivec3(glm::ceil(extent / kPiece)), glm::ivec3(1), glm::ivec3(8));
      const glm::vec3 step = extent / glm::vec3(pieces);
      for_each_voxel(pieces, [&](const glm::ivec3& i) {
        const glm::vec3 lo = b.lo + glm::vec3(i) * step, hi = lo + step;
        if (pieces != glm::ivec3(1) && !lit_otherwise(lo, hi)) return;
        for (std::size_t e = 0; e < views; ++e)
          tiles[e].mark(seen_in(clip_from_world[e] * world_from_mesh, lo, hi, size));
      });
    }
  }
}

std::vector<DrawGroup> BrickStore::visible(gpu::Device& device, int slot, const Frame& frame, SlotBuffers& into,
                                           FrameStats& stats, const std::array<Tiles, 2>* tiles) {
  std::size_t count = 0;
  for (const auto& [id, mesh] : meshes) count += mesh.bricks.size();
  gpu::Buffer& buffer =
      into.at_least(device, slot, count * sizeof(VkDrawIndexedIndirectCommand), VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT);
  auto* out = buffer.mapped<VkDrawIndexedIndirectCommand>();
  std::uint32_t written = 0;
  std::vector<DrawGroup> groups;
  std::vector<std::vector<VkDrawIndexedIndirectCommand>> lists(blocks.size() * kBrickKinds);
  for (const auto& [id, mesh] : meshes) {
    if (!shown_in(frame.view, id)) continue;
    const Pose X_MW = inverse(mesh.X_WM);
    std::array<Planes, 2> frusta;
    std::array<glm::vec3, 2> eyes;
    const auto views = static_cast<std::size_t>(frame.views);
    for (std::size_t e = 0; e < views; ++e) {
      frusta[e] = planes(frame.eyes[e].projection * frame.eyes[e].view * matrix(mesh.X_WM));
      eyes[e] = glm::vec3(X_MW * frame.eyes[e].position);
    }
    const glm::vec4 cover = cover_of(covers, id, frame.view, mesh.X_WM);
    for (auto& list : lists) list.clear();
    for (const auto& [key, b] : mesh.bricks) {
      bool out_of_view = true, away = true, unchanged = tiles != nullptr;
      for (std::size_t e = 0; e < views; ++e) {
        out_of_view = out_of_view && outside(frusta[e], b);
        // A section shows back faces, so it also draws bricks that face away.
        away = away && !cuts_section(frame.view) && faces_away(b, eyes[e]);
        unchanged = unchanged && !(*tiles)[e].touch(b.seen[e]);
      }
      if (b.first && covered(cover, b)) {
        ++stats.bricks_covered;
      } else if (out_of_view) {
        ++stats.bricks_culled;
      } else if (away) {
        ++stats.bricks_facing_away;
      } else if (unchanged) {
        ++stats.bricks_unchanged;
      } else {
        ++stats.bricks_drawn;
        stats.triangles += b.indices / 3;
        const auto kind = static_cast<std::size_t>(kind_in(frame.view, b));
        lists[static_cast<std::size_t>(b.block) * kBrickKinds + kind].push_back(
            {b.indices, 1, b.first_index, static_cast<std::int32_t>(b.first_vertex), 0});
      }
    }
    for (std::size_t i = 0; i < lists.size(); ++i) {
      if (lists[i].empty()) continue;
      groups.push_back({id, static_cast<int>(i / kBrickKinds), static_cast<BrickKind>(i % kBrickKinds), written,
                        static_cast<std::uint32_t>(lists[i].size())});
      std::memcpy(out + written, lists[i].data(), lists[i].size() * sizeof(*out));
      written += static_cast<std::uint32_t>(lists[i].size());
    }
  }
  return groups;
}

DrawnKinds BrickStore::drawn_kinds(View view) const {
  DrawnKinds drawn;
  for (const auto& [id, mesh] : meshes) {
    if (!shown_in(view, id)) continue;
    for (const auto& [key, b] : mesh.bricks)
      (glassy_in(view, id) ? drawn.glass : drawn.solid[static_cast<std::size_t>(kind_in(view, b))]) = true;
  }
  return drawn;
}

std::vector<DrawGroup> BrickStore::all(gpu::Device& device, int slot, View view, const glm::dmat4& light_from_world,
                                       const ShadowMapBox& part) {
  std::size_t count = 0;
  for (const auto& [id, mesh] : meshes) count += mesh.bricks.size();
  gpu::Buffer& buffer = shadow_indirect.at_least(device, slot, count * sizeof(VkDrawIndexedIndirectCommand),
                                                 VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT);
  auto* out = buffer.mapped<VkDrawIndexedIndirectCommand>();
  std::uint32_t written = 0;
  std::vector<DrawGroup> groups;
  for (const auto& [id, mesh] : meshes) {
    const glm::dmat4 light_from_mesh = light_from_world * matrix(mesh.X_WM);
    for (std::size_t block = 0; shown_in(view, id) && block < blocks.size(); ++block) {
      const std::uint32_t first = written;
      for (const auto& [key, b] : mesh.bricks)
        if (b.block == static_cast<int>(block) && part.meets(shadow_map_box(light_from_mesh, b.lo, b.hi)))
          out[written++] = {b.indices, 1, b.first_index, static_cast<std::int32_t>(b.first_vertex), 0};
      if (written > first) groups.push_back({id, static_cast<int>(block), BrickKind::kAny, first, written - first});
    }
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
