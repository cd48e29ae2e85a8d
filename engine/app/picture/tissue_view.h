// Changed bricks as triangles for the renderer: a mesh's own (mesh_lod, vertex), or meshed from the distance field. The
// tissue's thread only.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "engine/app/picture/label_blocks.h"
#include "engine/app/picture/solid_blocks.h"
#include "engine/app/tissue/brick_update.h"
#include "engine/app/tissue/drawn_as.h"
#include "engine/render/renderer.h"
#include "engine/surface/mesh_export.h"
#include "engine/surface/surface_mesher.h"
#include "haptics/carver.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// With shared vertices. `tolerance`: voxels. `progress`: 0..1, may throw to stop.
surface::WholeMesh whole_surface(const haptics::TissueVolume& volume, float tolerance,
                                 const std::function<void(double)>& progress = {});
/// From TissueSurface::mesh. Voxels of `frame`.
surface::WholeMesh whole_surface(const haptics::TissueMesh& mesh, const VoxelFrame& frame);

/// Can be saved while the carver goes on.
struct TissueCopy {
  haptics::TissueVolume volume;
  std::optional<haptics::TissueMesh> own;  // if it is a mesh
};
TissueCopy copy_of(haptics::Carver& carver);
/// `file` (.vdb), and for a mesh NAME_surface.stl in mm beside it. Throws Error.
void save_tissue(const TissueCopy& tissue, const std::filesystem::path& file);

class TissueView {
 public:
  /// `tolerance`: voxels from the surface. `drawn_as`: look of each tissue, to hide a lesion.
  explicit TissueView(float tolerance = 0.1f, const DrawnAs& drawn_as = {});

  /// All bricks first, later the changed ones. m from the volume's origin.
  std::vector<render::MeshUpdate> update(haptics::TissueVolume& volume);
  /// The same for the carver's tissue, with its own triangles if it is a mesh.
  std::vector<render::MeshUpdate> update(haptics::Carver& carver);

  /// Later updates mesh some existing bricks again.
  void set_tolerance(float tolerance);
  float tolerance() const { return tolerance_; }

 private:
  std::vector<render::MeshUpdate> update(haptics::TissueSurface& surface);
  void put(const haptics::TissueVolume& volume, const glm::ivec3& key);
  void find_tissue_below(const haptics::TissueVolume& volume, render::MeshUpdate& update);
  /// Vertex::lesion. Voxels of the present label blocks; `inward`: unit vector.
  float nearness_of_caries(const haptics::TissueVolume& volume, const glm::vec3& start, const glm::vec3& inward,
                           float reach);
  /// Vertex::cut and Vertex::thin.
  void find_cuts_and_edges(const haptics::TissueVolume& volume, render::MeshUpdate& update);

  DrawnAs drawn_as_;
  LabelBlocks labels_;  // around the present update's bricks
  SolidBlocks solid_;   // the same: which samples are in tissue
  surface::SurfaceMesher mesher_;
  FieldBrick brick_;
  bool started_ = false;
  float tolerance_;
  bool another_tolerance_ = false;    // changed since the last update
  std::vector<glm::ivec3> outdated_;  // not yet at the new tolerance
  std::vector<glm::ivec3> stained_;   // bricks with Vertex::lesion
  std::vector<glm::ivec3> stale_;     // of these, with changed neighbours
};

}  // namespace typodont
