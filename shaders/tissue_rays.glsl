// The memory of the compute passes for light inside tissue. The rays and walks themselves are in
// engine/render/tissue_rays.h; engine/render/light_passes.cpp fills the buffers.
#include "engine/render/shared.h"
#define INOUT(type) inout type

layout(push_constant) uniform Pass { LightPass pass; };
layout(set = 0, binding = 0, std430) readonly buffer Distances { float distances[]; };
// For each cell: 2 × (its element + 1) + 1 if it belongs to a hard body.
layout(set = 0, binding = 1, std430) readonly buffer Cells { uint cells[]; };
layout(set = 0, binding = 2, std430) readonly buffer Blocks { uint clear_blocks[]; };
layout(set = 0, binding = 3, std430) readonly buffer Elements { LightElement elements[]; };
// Directions of a walk's steps; w: free path in mean free paths.
layout(set = 0, binding = 4, std430) readonly buffer Steps { vec4 steps[]; };
// LightGrid::faces, LightGrid::images
layout(set = 0, binding = 5, std430) readonly buffer Faces { vec4 faces[]; };
layout(set = 0, binding = 6, std430) readonly buffer Images { float images[]; };
layout(set = 0, binding = 7, std430) readonly buffer Listed { int listed[]; };
layout(set = 0, binding = 12, std430) writeonly buffer Arrivals { LightArrival arrivals[]; };
layout(set = 0, binding = 13, std430) writeonly buffer Met { int met[]; };
layout(set = 0, binding = 14, std430) writeonly buffer Exits { ivec2 exits[]; };

int element_in(int cell) {
  return int(cells[cell] >> 1u) - 1;
}
bool hard(int cell) {
  return (cells[cell] & 1u) != 0u;
}
int clear_of(int block) {
  return int(clear_blocks[block]);
}

// Position in the LightGrid's samples, at the surface with normal n: the lower sample; the fraction to the upper one.
void far_sample(vec3 q, vec3 n, out ivec3 low, out vec3 f) {
  vec3 at = clamp(pass.far_origin.xyz + pass.far_origin.w * q + 0.5 * n, vec3(0.0), vec3(pass.far_size.xyz - 1));
  low = min(ivec3(at), max(pass.far_size.xyz - 2, 0));
  f = at - vec3(low);
}
// As light_at(LightGrid).w in engine/render/light_scene.cpp
float far_lamp(vec3 q, vec3 n) {
  ivec3 low, size = pass.far_size.xyz;
  vec3 f;
  far_sample(q, n, low, f);
  float sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    int face = 2 * axis + (n[axis] < 0.0 ? 1 : 0);
    for (int k = 0; k < 8; ++k) {
      ivec3 bit = ivec3(k & 1, (k >> 1) & 1, k >> 2), i = min(low + bit, size - 1);
      vec3 w = mix(1.0 - f, f, vec3(bit));
      sum += n[axis] * n[axis] * w.x * w.y * w.z * faces[((face * size.x + i.x) * size.y + i.y) * size.z + i.z].w;
    }
  }
  return sum;
}
// As mirrored_at(LightGrid) in engine/render/light_scene.cpp
vec3 far_light(vec3 q, vec3 r) {
  ivec3 low, size = pass.far_size.xyz;
  vec3 f;
  far_sample(q, r, low, f);
  vec3 d = r / (abs(r.x) + abs(r.y) + abs(r.z));
  vec2 folded = (1.0 - abs(d.yx)) * vec2(d.x < 0.0 ? -1.0 : 1.0, d.y < 0.0 ? -1.0 : 1.0);
  vec2 at = (0.5 + 0.5 * (d.z < 0.0 ? folded : d.xy)) * float(kImageSide - 1);
  ivec2 node = min(ivec2(at), kImageSide - 2);
  vec2 u = at - vec2(node);
  vec3 sum = vec3(0.0);
  for (int k = 0; k < 32; ++k) {
    ivec3 bit = ivec3(k & 1, (k >> 1) & 1, (k >> 2) & 1), i = min(low + bit, size - 1);
    ivec2 side = ivec2((k >> 3) & 1, k >> 4), m = node + side;
    vec3 w = mix(1.0 - f, f, vec3(bit));
    vec2 v = mix(1.0 - u, u, vec2(side));
    int first = 3 * ((((i.x * kImageSide + m.x) * size.y + i.y) * kImageSide + m.y) * size.z + i.z);
    sum += w.x * w.y * w.z * v.x * v.y * vec3(images[first], images[first + 1], images[first + 2]);
  }
  return sum;
}

#include "engine/render/tissue_rays.h"
