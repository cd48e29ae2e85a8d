#version 460
#extension GL_GOOGLE_include_directive : require
// Pass 3 of sphere packings without removal. For each ball and each sphere, it computes the volume that this ball would
// remove after the previous balls.
#include "shaders/spheres.glsl"
#include "shaders/removal.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std430) readonly buffer Spheres { Sphere spheres[]; };
layout(set = 0, binding = 3, std430) buffer Results {
  uint count;
  uint unused;
  Overlap overlaps[];
};

void main() {
  uint stride = gl_NumWorkGroups.x * 64u;
  for (uint i = gl_GlobalInvocationID.x; i < pass.spheres; i += stride) {
    if (!may_be_near(i)) continue;
    Sphere s = spheres[i];
    for (uint k = 0u; k < pass.balls; ++k) {
      Sphere cut = s;
      if (!is_near(s, balls[k]) || !after_cut(cut, balls[k])) continue;
      precise double taken = s.volume - cut.volume;
      s = cut;
      uint at = atomicAdd(count, 1u);
      if (at < pass.capacity) overlaps[at] = Overlap(k, i, taken);
    }
  }
}
