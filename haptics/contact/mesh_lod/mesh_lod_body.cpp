#include "haptics/contact/mesh_lod/mesh_lod_body.h"

#include <limits>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/error.h"

namespace typodont::haptics::mesh_lod {

MeshLodBody::MeshLodBody(TissueVolume tissue, const Parameters& parameters) : volume_(std::move(tissue)) {
  const TissueMesh mesh = surface_mesh(volume_);
  if (mesh.triangles.empty()) throw Error("mesh_lod", "tissue", "a volume without a surface", "tissue");
  levels_ = make_levels(mesh, parameters.levels);
}

void MeshLodBody::carve(const Cut&, bool) {
  TYPODONT_CHECK(false);
}
void MeshLodBody::fill(const Cut&) {
  TYPODONT_CHECK(false);
}

double MeshLodBody::travel() const {
  return std::numeric_limits<double>::infinity();
}

}  // namespace typodont::haptics::mesh_lod
