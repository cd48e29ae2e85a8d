// A tooth-like body to draw: cusps, an enamel cap over dentin, a cavity with caries in its floor. Analytic, so that it
// is the same on every machine.
#pragma once

#include <vector>

#include "engine/render/renderer.h"

namespace typodont::test {

/// `cavity`: its depth in m; 0: no cavity. Bricks of 3 mm. Crown up along +z, about 10 mm wide, origin in its middle.
std::vector<render::MeshUpdate> tooth_mesh(double cavity, double cell = 0.25e-3);

/// A ball as one brick.
render::MeshUpdate ball(std::uint64_t brick, glm::vec3 center, float radius, Tissue tissue, int steps = 24);

}  // namespace typodont::test
