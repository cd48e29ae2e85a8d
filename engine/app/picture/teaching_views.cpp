#include "engine/app/picture/teaching_views.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/app/picture/tissue_view.h"
#include "engine/app/tissue/field_mesh.h"
#include "engine/app/tissue/plane_face.h"
#include "engine/app/tissue/tooth_field.h"
#include "engine/base/voxels.h"

namespace typodont {

namespace {

/// Fraction of the 27 points around p, `h` (m) apart, where here(p) is true; with binomial weights.
template <class Here>
double fraction_around(const dvec3& p, double h, const Here& here) {
  double fraction = 0;
  for_each_voxel_between(glm::ivec3(-1), glm::ivec3(1), [&](const glm::ivec3& i) {
    if (here(p + h * dvec3(i))) fraction += (i.x ? 1 : 2) * (i.y ? 1 : 2) * (i.z ? 1 : 2) / 64.0;
  });
  return fraction;
}

}  // namespace

bool can_show(const Scene& scene, render::View view) {
  if (view == render::View::kDifference) return scene.task && scene.task->ideal;
  return view != render::View::kTemperature || scene.heat;
}

render::View next_view(const Scene& scene, render::View view) {
  using render::View;
  constexpr std::array kOrder{View::kLook, View::kSection, View::kXray, View::kDifference, View::kTemperature};
  const auto after = std::find(kOrder.begin(), kOrder.end(), view) + 1;
  const auto next = std::find_if(after, kOrder.end(), [&](View one) { return can_show(scene, one); });
  return next == kOrder.end() ? View::kLook : *next;
}

std::vector<render::MeshUpdate> section_face(const haptics::TissueVolume& volume, const dvec3& normal, double offset) {
  const ToothField field(volume);
  return plane_face(
      {normal, offset}, field.low(), field.high(), field.voxel(), volume.frame().origin,
      [&](const dvec3& p) { return field.distance(p); }, [&](const dvec3& p) { return field.fractions(p); });
}

std::vector<render::MeshUpdate> tissue_inside(const haptics::TissueVolume& volume, Tissue tissue) {
  const ToothField field(volume);
  const double h = field.voxel();
  // Pulp and caries count as dentin. Otherwise the surface of the dentin would include the inner walls of pulp chamber
  // and caries.
  const auto counts = [&](Tissue found) {
    return found == tissue || (tissue == Tissue::kDentin && (found == Tissue::kPulp || found == Tissue::kCaries));
  };
  const auto here = [&](const dvec3& p) { return counts(field.tissue(p)) && field.distance(p) < 0; };
  // The grid begins a whole number of voxels from the volume's origin, so that its points coincide with samples.
  const dvec3 origin = volume.frame().origin;
  const dvec3 lo = origin + h * glm::floor((field.low() - origin) / h);
  glm::dvec3 first(1e9), last(-1e9);
  const glm::ivec3 size(glm::ceil((field.high() - lo) / h));
  for_each_voxel(size + 1, [&](const glm::ivec3& i) {
    const dvec3 p = lo + h * dvec3(i);
    if (!here(p)) return;
    first = glm::min(first, p);
    last = glm::max(last, p);
  });
  if (first.x > last.x) return {};
  first -= 3 * h;
  last += 3 * h;
  std::vector<render::MeshUpdate> updates = mesh_of_field(
      first, last, h, 0.15f, [&](const dvec3& p) { return (0.5 - fraction_around(p, h, here)) * 2 * h; },
      [&](const dvec3&) { return tissue; });
  for (render::MeshUpdate& update : updates)
    for (render::Vertex& vertex : update.vertices) vertex.p += glm::vec3(first - origin);
  return updates;
}

std::vector<render::MeshUpdate> tissues_left(const haptics::TissueVolume& volume, std::uint32_t hidden) {
  const ToothField field(volume);
  const double h = field.voxel();
  const dvec3 origin = volume.frame().origin;
  const dvec3 first = origin + h * glm::floor((field.low() - origin) / h);
  const auto left = [&](Tissue t) { return t != Tissue::kAir && !(hidden >> static_cast<unsigned>(t) & 1u); };
  std::vector<render::MeshUpdate> updates = mesh_of_field(
      first, field.high(), h, 0.15f,
      [&](const dvec3& p) {
        const double whole = field.distance(p);
        if (whole > h) return whole;
        const double fraction = fraction_around(p, h, [&](const dvec3& q) { return left(field.tissue(q)); });
        // Outside the tissue, only few samples have labels, so `fraction` is unreliable. The returned distance is at
        // least `whole`, the distance to the surface of all tissues together.
        return std::max(whole, fraction > 0.999 ? -h : (0.5 - fraction) * 2 * h);
      },
      [&](const dvec3& p) {
        const Tissue here = field.tissue(p);
        if (left(here)) return here;
        std::array<int, kTissueCount> around{};
        for_each_voxel_between(glm::ivec3(-1), glm::ivec3(1), [&](const glm::ivec3& i) {
          if (const Tissue t = field.tissue(p + h * dvec3(i)); left(t)) ++around[static_cast<std::size_t>(t)];
        });
        const auto most = std::max_element(around.begin(), around.end());
        return *most ? static_cast<Tissue>(most - around.begin()) : Tissue::kAir;
      });
  for (render::MeshUpdate& update : updates)
    for (render::Vertex& vertex : update.vertices) vertex.p += glm::vec3(first - origin);
  return updates;
}

std::vector<ViewBody> view_bodies(render::View view, const glm::dvec4& plane, std::uint32_t hidden,
                                  const haptics::TissueVolume& volume) {
  std::vector<ViewBody> bodies;
  if (render::cuts_section(view)) {
    bodies.push_back({render::kSectionFace, section_face(volume, dvec3(plane), -plane.w)});
  } else if (view == render::View::kXray) {
    bodies.push_back({render::kInsidePulp, tissue_inside(volume, Tissue::kPulp)});
    bodies.push_back({render::kInsideCaries, tissue_inside(volume, Tissue::kCaries)});
    bodies.push_back({render::kInsideDentin, tissue_inside(volume, Tissue::kDentin)});
  } else if (hidden != 0) {
    bodies.push_back({render::kWorkingTooth, tissues_left(volume, hidden)});
  }
  for (ViewBody& body : bodies) add_paint(volume, body.bricks);
  return bodies;
}

void mark_difference(const ToothField& ideal, const dvec3& origin, std::vector<render::MeshUpdate>& updates) {
  for (render::MeshUpdate& update : updates)
    for (render::Vertex& vertex : update.vertices)
      vertex.difference = static_cast<float>(ideal.distance(origin + dvec3(vertex.p)));
}

}  // namespace typodont
