#include "engine/app/surroundings/soft_gum.h"

#include "engine/app/surroundings/surroundings.h"

namespace typodont {

namespace {

// Half the size of the soft region along the arch, across it and upwards, m.
constexpr double kAlong = 11e-3, kAcross = 10e-3, kUp = 6e-3;

}  // namespace

std::shared_ptr<const haptics::SoftSurface> soft_gum(const std::optional<SurroundingsPlan>& plan) {
  if (!plan || !plan->soft) return nullptr;
  const SurroundingsShape shape(*plan);
  const dvec3 across = glm::cross(plan->crown, plan->arch);
  const dvec3 half = kAlong * glm::abs(plan->arch) + kAcross * glm::abs(across) + kUp * glm::abs(plan->crown);
  return std::make_shared<const haptics::SoftSurface>(
      *plan->soft, plan->margin - half, plan->margin + half, [&](const dvec3& p) { return shape.gum(p); },
      [&](const dvec3& p) { return shape.tooth(p) < 0 || shape.neighbour(p) < 0; });
}

}  // namespace typodont
