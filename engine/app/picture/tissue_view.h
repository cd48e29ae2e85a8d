// Converts the changed bricks (mesh blocks) of the tissue to triangles for the renderer. A tissue that is a triangle
// mesh itself (contact models mesh_lod and vertex) provides its own triangles. Other tissue is meshed from the distance
// field. For the thread that owns the tissue.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "engine/app/field/brick_update.h"
#include "engine/app/picture/label_blocks.h"
#include "engine/app/picture/solid_blocks.h"
#include "engine/app/tissue/drawn_as.h"
#include "engine/render/renderer.h"
#include "engine/surface/mesh_export.h"
#include "engine/surface/surface_mesher.h"
#include "haptics/carver.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Meshes the whole surface, with shared vertices. `tolerance`: voxels, largest distance of the mesh from the surface.
/// `progress` receives the completed fraction 0..1; the function `progress` may throw an exception to stop the meshing.
surface::WholeMesh whole_surface(const haptics::TissueVolume& volume, float tolerance,
                                 const std::function<void(double)>& progress = {});
/// Makes the whole surface from the tissue's own triangles (TissueSurface::mesh). Positions are in voxels of `frame`.
surface::WholeMesh whole_surface(const haptics::TissueMesh& mesh, const VoxelFrame& frame);

/// A copy of the tissue, which can be saved while the carver thread continues to work.
struct TissueCopy {
  haptics::TissueVolume volume;
  std::optional<haptics::TissueMesh> own;  // the tissue's own triangles, if it is a mesh
};
TissueCopy copy_of(haptics::Carver& carver);
/// Writes the volume to `file` (.vdb). If the tissue is a mesh, also writes its triangles in millimetres to a file
/// beside it, NAME_surface.stl. Throws Error.
void save_tissue(const TissueCopy& tissue, const std::filesystem::path& file);

class TissueView {
 public:
  /// `tolerance`: voxels, largest distance of the triangles from the surface. `drawn_as`: states for each tissue as
  /// which tissue it is drawn (a scene can hide a lesion in this way).
  explicit TissueView(float tolerance = 0.1f, const DrawnAs& drawn_as = {});

  /// Returns all bricks (mesh blocks) in the first call, and later the bricks that have changed since the last call.
  /// Positions are in m from the volume's origin.
  std::vector<render::MeshUpdate> update(haptics::TissueVolume& volume);
  /// Returns all bricks (mesh blocks) in the first call, and later the changed bricks. The tissue is that of the carver
  /// (its owner). If the tissue itself is a triangle mesh, the bricks contain its triangles.
  std::vector<render::MeshUpdate> update(haptics::Carver& carver);

  /// Sets another tolerance. Each later call of update() meshes some of the existing bricks (mesh blocks) again.
  void set_tolerance(float tolerance);
  float tolerance() const { return tolerance_; }

 private:
  std::vector<render::MeshUpdate> update(haptics::TissueSurface& surface);
  void put(const haptics::TissueVolume& volume, const glm::ivec3& key);
  void find_tissue_below(const haptics::TissueVolume& volume, render::MeshUpdate& update);
  /// Computes Vertex::cut (the part of the surface that was cut) and Vertex::thin (how thin the tissue below it is).
  void find_cuts_and_edges(const haptics::TissueVolume& volume, render::MeshUpdate& update);

  DrawnAs drawn_as_;
  LabelBlocks labels_;  // tissue labels around the bricks (mesh blocks) of the present update
  SolidBlocks solid_;   // for each sample around the bricks (mesh blocks) of the present update: is it in tissue?
  surface::SurfaceMesher mesher_;
  FieldBrick brick_;
  bool started_ = false;
  float tolerance_;
  bool another_tolerance_ = false;    // true: the tolerance has changed since the last update
  std::vector<glm::ivec3> outdated_;  // bricks (mesh blocks) that are not yet meshed with the new tolerance
};

}  // namespace typodont
