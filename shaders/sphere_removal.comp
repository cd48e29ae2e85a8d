#version 460
#extension GL_GOOGLE_include_directive : require
// Pass 3 of sphere packings (paper S2 in docs/papers.md, eq. 6). The tool's balls, one after the other, shrink and move
// the spheres on their paths.
#include "shaders/spheres.glsl"
#include "shaders/removal.glsl"
layout(local_size_x = 64) in;

struct Change {
  uint ball, sphere;
  Sphere after;
};
layout(set = 0, binding = 0, std430) buffer Spheres { Sphere spheres[]; };
layout(set = 0, binding = 3, std430) buffer Results {
  uint count;
  uint unused;
  Change changes[];
};

void main() {
  uint stride = gl_NumWorkGroups.x * 64u;
  for (uint i = gl_GlobalInvocationID.x; i < pass.spheres; i += stride) {
    if (!may_be_near(i)) continue;
    Sphere s = spheres[i];
    bool changed = false;
    for (uint k = 0u; k < pass.balls; ++k) {
      Sphere cut = s;
      if (!is_near(s, balls[k]) || !after_cut(cut, balls[k])) continue;
      s = cut;
      changed = true;
      uint at = atomicAdd(count, 1u);
      if (at < pass.capacity) changes[at] = Change(k, i, s);
    }
    if (!changed) continue;
    spheres[i] = s;
    double r = tree_radius(s);
    vec3 place = vec3(center_of(s) - dvec3(pass.ox, pass.oy, pass.oz));
    bounds[i] = vec4(place, r > 0.0LF ? float(r) + pass.rounding_margin : -1.0);
  }
}
