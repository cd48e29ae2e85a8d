// Converts the changed bricks of the carver's tissue to triangles for the renderer. A body of triangles (contact models
// mesh_lod and vertex) provides its own triangles; other bodies are meshed from the distance field. Carver's thread.
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

/// The whole surface with shared vertices. `tolerance`: voxels, largest distance from the surface; `progress` gets the
/// completed fraction 0..1 and may throw to stop the work.
surface::WholeMesh whole_surface(const haptics::TissueVolume& volume, float tolerance,
                                 const std::function<void(double)>& progress = {});
/// The whole surface of a body from its own triangles (TissueSurface::mesh), in voxels of this frame.
surface::WholeMesh whole_surface(const haptics::TissueMesh& mesh, const VoxelFrame& frame);

/// A copy of the tissue that can be saved while the carver continues.
struct TissueCopy {
  haptics::TissueVolume volume;
  std::optional<haptics::TissueMesh> own;  // the body's own triangles, if it has them
};
TissueCopy copy_of(haptics::Carver& carver);
/// Writes the volume to `file` (.vdb), and the body's own triangles beside it as NAME_surface.stl in millimetres.
/// Throws Error.
void save_tissue(const TissueCopy& tissue, const std::filesystem::path& file);

class TissueView {
 public:
  /// `tolerance`: voxels, largest distance of the triangles from the surface. `drawn_as`: the scene's setting.
  explicit TissueView(float tolerance = 0.1f, const DrawnAs& drawn_as = {});

  /// Returns all bricks at the first call, then the bricks that changed since the last call. Positions are in metres
  /// from the volume's origin.
  std::vector<render::MeshUpdate> update(haptics::TissueVolume& volume);
  /// update() for a carver's tissue; uses the body's own triangles if it has them.
  std::vector<render::MeshUpdate> update(haptics::Carver& carver);

  /// Sets another tolerance. Existing bricks are meshed again, some of them at each update().
  void set_tolerance(float tolerance);
  float tolerance() const { return tolerance_; }

  /// The mesher of the field's surface; empty if update() used only a body's own triangles.
  const surface::SurfaceMesher& mesher() const { return mesher_; }

 private:
  std::vector<render::MeshUpdate> update(haptics::TissueSurface& surface);
  void put(const haptics::TissueVolume& volume, const glm::ivec3& key);
  void find_tissue_below(const haptics::TissueVolume& volume, render::MeshUpdate& update);
  /// Sets Vertex::cut and Vertex::thin.
  void find_cuts_and_edges(const haptics::TissueVolume& volume, render::MeshUpdate& update);

  DrawnAs drawn_as_;
  LabelBlocks labels_;  // labels around the bricks of this update
  SolidBlocks solid_;   // samples in tissue around the bricks of this update
  surface::SurfaceMesher mesher_;
  FieldBrick brick_;
  bool started_ = false;
  float tolerance_;
  bool another_tolerance_ = false;    // the tolerance changed since the last update
  std::vector<glm::ivec3> outdated_;  // bricks that must still be meshed with the new tolerance
};

}  // namespace typodont
