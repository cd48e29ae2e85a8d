// Bodies for the teaching views: face of a section, inner tissues, difference from an ideal shape. Computed from the
// volume on request. For any thread that may read the volume.
#pragma once

#include <vector>

#include "engine/app/scene.h"
#include "engine/app/tissue/tooth_field.h"
#include "engine/render/renderer.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// True if pictures of the scene can show the view: the difference needs an ideal shape, the temperature needs heat.
bool can_show(const Scene& scene, render::View view);
/// Returns the next view that pictures of the scene can show; after the last view, returns View::kLook.
render::View next_view(const Scene& scene, render::View view);

/// Makes the face at which a plane cuts the tissue, coloured by tissue. The part with normal · p > offset is kept; the
/// face is seen from the other side. Positions are relative to the volume's origin.
std::vector<render::MeshUpdate> section_face(const haptics::TissueVolume& volume, const dvec3& normal, double offset);

/// Makes the surface of one tissue inside the tooth, smoothed over a voxel. For dentin, it is only the outer surface.
/// Positions are relative to the volume's origin.
std::vector<render::MeshUpdate> tissue_inside(const haptics::TissueVolume& volume, Tissue tissue);

/// Makes the surface of the tissue that remains if some tissues are hidden. `hidden`: bits 1 << tissue.
std::vector<render::MeshUpdate> tissues_left(const haptics::TissueVolume& volume, std::uint32_t hidden);

/// A body that a view shows in addition to the tissue's surface, or in place of it.
struct ViewBody {
  render::MeshId mesh;
  std::vector<render::MeshUpdate> bricks;
};
/// Makes the bodies of a view: the face of the section at `plane`, the inner tissues of an X-ray, or the tissue that
/// remains without the `hidden` tissues.
std::vector<ViewBody> view_bodies(render::View view, const glm::dvec4& plane, std::uint32_t hidden,
                                  const haptics::TissueVolume& volume);

/// Largest distance between tissue and target shape that the difference view shows, m.
inline constexpr double kDifferenceReach = 3e-3;
/// Sets `difference` of every vertex to its distance (m) from the target shape `ideal`, sampled with kDifferenceReach:
/// positive outside (tissue must still be removed), negative inside (too much was removed). `origin`: origin of the
/// positions in `updates`, m, frame W.
void mark_difference(const ToothField& ideal, const dvec3& origin, std::vector<render::MeshUpdate>& updates);

}  // namespace typodont
