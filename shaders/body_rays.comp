#version 460
#extension GL_GOOGLE_include_directive : require
// Rays between bodies: from each start in each direction. engine/render/light_passes.cpp fills the buffers.
#include "engine/render/shared.h"
#define INOUT(type) inout type
layout(local_size_x = 64) in;

layout(push_constant) uniform Pass { RayPass pass; };
layout(set = 0, binding = 8, std430) readonly buffer Nodes { RayNode nodes[]; };
layout(set = 0, binding = 9, std430) readonly buffer Surfaces { RaySurface surfaces[]; };
layout(set = 0, binding = 10, std430) readonly buffer Starts { vec4 starts[]; };
layout(set = 0, binding = 11, std430) readonly buffer Directions { vec4 directions[]; };
layout(set = 0, binding = 15, std430) writeonly buffer Hits { RayHit hits[]; };

#include "engine/render/body_rays.h"

void main() {
  int at = int(gl_GlobalInvocationID.x), start = at / pass.directions;
  if (start < pass.starts)
    hits[at] = first_hit(starts[start].xyz, directions[at - start * pass.directions].xyz, pass.any != 0);
}
