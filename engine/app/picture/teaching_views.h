// What the views for teaching show beside the tooth's surface: the face of a cut through it, the tissues inside it, and
// how far it is from an ideal preparation. Made from the volume when a view is asked for; the carver's thread.
#pragma once

#include <vector>

#include "engine/app/field/tooth_field.h"
#include "engine/render/renderer.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// The face that a plane cuts through the tissue, coloured by tissue: of what lies where normal · p > offset, seen from
/// the other side. Positions relative to the volume's origin.
std::vector<render::MeshUpdate> section_face(const haptics::TissueVolume& volume, const dvec3& normal, double offset);

/// The surface of one tissue inside the tooth, smoothed over a voxel; of dentin the outer one alone. Positions relative
/// to the volume's origin.
std::vector<render::MeshUpdate> tissue_inside(const haptics::TissueVolume& volume, Tissue tissue);

/// The surface of what is left when the tissues of these bits (1 << tissue) are taken away.
std::vector<render::MeshUpdate> tissues_left(const haptics::TissueVolume& volume, std::uint32_t hidden);

/// Sets every corner's `difference` from the ideal tooth: how far it stands out of it (still to remove, > 0) or lies
/// within it (gone and should have stayed, < 0). `origin`: of the updates' positions, m, W.
void mark_difference(const haptics::TissueVolume& ideal, const dvec3& origin, std::vector<render::MeshUpdate>& updates);
/// The same; the ideal's field reaches as far as differences are told apart.
void mark_difference(const ToothField& ideal, const dvec3& origin, std::vector<render::MeshUpdate>& updates);

}  // namespace typodont
