#include "engine/app/tissue/brick_update.h"

namespace typodont {

/// Packs the three indices, 21 bits each: enough for any volume that fits into memory.
std::uint64_t brick_number(const glm::ivec3& key) {
  const auto part = [](int v) { return static_cast<std::uint64_t>(v + (1 << 20)) & 0x1fffff; };
  return part(key.x) << 42 | part(key.y) << 21 | part(key.z);
}

render::MeshUpdate brick_update(const surface::BrickMesh& mesh, double voxel) {
  render::MeshUpdate update;
  update.brick = brick_number(mesh.key);
  update.vertices.reserve(mesh.vertices.size());
  for (const surface::SurfaceVertex& v : mesh.vertices) {
    render::Vertex& out = update.vertices.emplace_back();
    out.p = v.position * static_cast<float>(voxel);
    out.n = v.normal;
    out.tissue = {v.tissue[0], v.tissue[1]};
    out.second = static_cast<float>(v.second) / 255.0f;
  }
  update.indices = mesh.indices;
  return update;
}

}  // namespace typodont
