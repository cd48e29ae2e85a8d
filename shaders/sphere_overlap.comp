#version 460
#extension GL_GOOGLE_include_directive : require
// Pass 2 of sphere packings (paper S2 in docs/papers.md, eq. 2). It finds all overlapping pairs of a tool sphere and a
// tissue sphere, and the volume of their overlap (a lens).
#include "shaders/spheres.glsl"
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
    double r = tree_radius(s);
    if (!(r > 0.0LF)) continue;
    dvec3 center = center_of(s);
    for (uint k = 0u; k < pass.balls; ++k) {
      Ball ball = balls[k];
      dvec3 off = minus(dvec3(ball.ax, ball.ay, ball.az), center);
      double v = lens_volume(ball.r, r, sqrt(dot3(off, off)));
      if (!(v > 0.0LF)) continue;
      uint at = atomicAdd(count, 1u);
      if (at < pass.capacity) overlaps[at] = Overlap(k, i, v);
    }
  }
}
