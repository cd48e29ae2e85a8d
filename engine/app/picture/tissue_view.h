// From the carver's tissue to what the renderer takes: the bricks that changed, as triangles. Of a body that consists
// of triangles (contact models mesh_lod and vertex) these are its own, else those of its distance field. Carver's
// thread.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "engine/app/field/brick_update.h"
#include "engine/app/picture/label_blocks.h"
#include "engine/app/tissue/drawn_as.h"
#include "engine/render/renderer.h"
#include "engine/surface/mesh_export.h"
#include "engine/surface/surface_mesher.h"
#include "haptics/carver.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// The whole surface at once, corners shared. `tolerance`: how far triangles may lie from it, voxels; `progress`: told
/// its share, 0..1; what that throws ends the work.
surface::WholeMesh whole_surface(const haptics::TissueVolume& volume, float tolerance,
                                 const std::function<void(double)>& progress = {});
/// A body's own triangles (TissueSurface::mesh) in the same form: voxels of this frame.
surface::WholeMesh whole_surface(const haptics::TissueMesh& mesh, const VoxelFrame& frame);

/// The tissue as it is, to be saved while the carver goes on.
struct TissueCopy {
  haptics::TissueVolume volume;
  std::optional<haptics::TissueMesh> own;  // the body's triangles, where it has them
};
TissueCopy copy_of(haptics::Carver& carver);
/// Writes the volume to `file` (.vdb) and the body's own triangles beside it as NAME_surface.stl, in millimetres.
/// Throws Error.
void save_tissue(const TissueCopy& tissue, const std::filesystem::path& file);

class TissueView {
 public:
  /// `tolerance`: how far the triangles may lie from the surface, voxels. `drawn_as`: the scene's.
  explicit TissueView(float tolerance = 0.1f, const DrawnAs& drawn_as = {});

  /// All bricks, the first time; afterwards those that changed since the last call. Positions are metres from the
  /// volume's origin: place the mesh there.
  std::vector<render::MeshUpdate> update(haptics::TissueVolume& volume);
  /// The same of a carver's tissue: the body's own triangles where it has them.
  std::vector<render::MeshUpdate> update(haptics::Carver& carver);

  /// Another tolerance from now on: bricks made with the last one are made anew, some with each update().
  void set_tolerance(float tolerance);
  float tolerance() const { return tolerance_; }

  /// Of the field's surface; empty where only a body's own triangles were asked for.
  const surface::SurfaceMesher& mesher() const { return mesher_; }

 private:
  std::vector<render::MeshUpdate> update(haptics::TissueSurface& surface);
  void put(const haptics::TissueVolume& volume, const glm::ivec3& key);
  void look_beneath(const haptics::TissueVolume& volume, render::MeshUpdate& update);

  DrawnAs drawn_as_;
  LabelBlocks labels_;  // of this update
  surface::SurfaceMesher mesher_;
  FieldBrick brick_;
  bool started_ = false;
  float tolerance_;
  bool another_tolerance_ = false;    // since the last update
  std::vector<glm::ivec3> outdated_;  // bricks, yet to be made with this tolerance
};

}  // namespace typodont
