#include "haptics/contact/packing/packing_body.h"
#include "haptics/contact/packing/packing_method.h"
#include "haptics/packing.h"

namespace typodont::haptics {

std::vector<ShownSphere> shown_spheres(const Carver& carver, const ServoSettings& settings) {
  const auto* const body = dynamic_cast<const packing::PackingBody*>(&carver.body());
  const packing::Parameters* const parameters = packing::parameters_of(settings.method);
  if (!body || !parameters) return {};
  const PerTissue density = packing::densities(*parameters, settings.materials);
  const packing::SphereTissue& spheres = body->spheres();
  std::vector<ShownSphere> shown;
  for (int i = 0; i < static_cast<int>(spheres.size()); ++i) {
    const double r = spheres.tree().radius(i);
    if (!(r > 0)) continue;
    shown.push_back(
        {spheres.tree().center(i), r, density[static_cast<std::size_t>(spheres.tissue(i))] * spheres.hardness(i)});
  }
  return shown;
}

}  // namespace typodont::haptics
