// Converts changed bricks to triangles for the renderer. The contact models mesh_lod and vertex supply triangles;
// otherwise, the distance field is meshed. Only for the thread that owns the tissue.
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

/// Makes the surface, with the colours of the voxels, as one mesh with shared vertices. `own`: true makes it from the
/// triangles of volume.mesh(), false from the distance field. `tolerance`: voxels, for the distance field. `progress`:
/// called with 0 to 1; may throw to stop.
surface::WholeMesh whole_surface(const haptics::TissueVolume& volume, bool own, float tolerance,
                                 const std::function<void(double)>& progress = {});
/// Makes one mesh from TissueSurface::mesh, in voxels of `frame`.
surface::WholeMesh whole_surface(const haptics::TissueMesh& mesh, const VoxelFrame& frame);

/// Sets Vertex::paint to the colours of the voxels, or of softened tooth tissue (render::decay_paint). They hide the
/// tissue below and the stain of caries. Positions are relative to the volume's origin. Voxels of a tissue that
/// `drawn_as` replaces are ignored.
void add_paint(const haptics::TissueVolume& volume, std::vector<render::MeshUpdate>& updates,
               const DrawnAs& drawn_as = {});

/// A copy of tissue to save while the carver continues.
struct TissueCopy {
  haptics::TissueVolume volume;
  std::optional<haptics::TissueMesh> own;  // the tissue's own mesh, if the contact model uses one
};
TissueCopy copy_of(haptics::Carver& carver);
/// Saves the tissue in `file` (.vdb), and its own mesh, if it has one, in NAME_surface.stl (mm) beside it. Throws
/// Error.
void save_tissue(const TissueCopy& tissue, const std::filesystem::path& file);

class TissueView {
 public:
  /// `tolerance`: largest distance between mesh and surface, voxels. `drawn_as`: how each tissue is drawn, for example
  /// to hide a lesion.
  explicit TissueView(float tolerance = 0.1f, const DrawnAs& drawn_as = {});

  /// The first call returns all bricks, each later call the changed ones. Positions in m from the volume's origin.
  std::vector<render::MeshUpdate> update(haptics::TissueVolume& volume);
  /// Changed bricks of the carver's tissue. If the contact model has its own mesh, the bricks contain its triangles.
  std::vector<render::MeshUpdate> update(haptics::Carver& carver);

  /// Changes the tolerance. Later updates mesh the existing bricks again, some at a time.
  void set_tolerance(float tolerance);
  float tolerance() const { return tolerance_; }

 private:
  std::vector<render::MeshUpdate> update(haptics::TissueSurface& surface);
  void put(const haptics::TissueVolume& volume, const glm::ivec3& key);
  void find_tissue_below(const haptics::TissueVolume& volume, render::MeshUpdate& update);
  /// Returns Vertex::lesion for a vertex at `start` (voxels in labels_). `inward`: unit normal; `reach`: search radius.
  float nearness_of_caries(const haptics::TissueVolume& volume, const glm::vec3& start, const glm::vec3& inward,
                           float reach);
  /// Sets Vertex::cut and Vertex::thin.
  void find_cuts_and_edges(const haptics::TissueVolume& volume, render::MeshUpdate& update);

  DrawnAs drawn_as_;
  LabelBlocks labels_;  // labels around the bricks of the current update
  SolidBlocks solid_;   // samples in tissue around the bricks of the current update
  surface::SurfaceMesher mesher_;
  FieldBrick brick_;
  bool started_ = false;
  float tolerance_;
  bool another_tolerance_ = false;    // true: the tolerance has changed since the last update
  std::vector<glm::ivec3> outdated_;  // bricks that are not yet meshed with the new tolerance
  std::optional<bool> has_caries_;    // whether the volume may contain caries; empty: not known yet
  std::vector<glm::ivec3> stained_;   // bricks with vertices near caries (Vertex::lesion)
  std::vector<glm::ivec3> stale_;     // bricks near caries (stained_) whose neighbours have changed
};

}  // namespace typodont
