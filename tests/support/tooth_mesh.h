// A body like a tooth for tests of pictures: cusps, an enamel cap over dentin, and a cavity with caries in its floor.
// It is computed from formulas, so it is the same on every machine.
#pragma once

#include <vector>

#include "engine/render/renderer.h"

namespace typodont::test {

/// Returns the body as bricks of 3 mm. `cavity`: depth of the cavity, m; 0: no cavity. The crown points up along +z and
/// is about 10 mm wide. The origin is in its middle.
std::vector<render::MeshUpdate> tooth_mesh(double cavity, double cell = 0.25e-3);

/// Returns a ball as one brick.
render::MeshUpdate ball(std::uint64_t brick, glm::vec3 center, float radius, Tissue tissue, int steps = 24);

}  // namespace typodont::test
