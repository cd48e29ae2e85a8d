#version 460
#extension GL_GOOGLE_include_directive : require
// Pass 1 of sphere packings (paper S2 in docs/papers.md, eq. 1). It finds the first contact of a moving tool. Each
// group of shader invocations writes its earliest contact.
#include "shaders/spheres.glsl"
layout(local_size_x = 64) in;

struct Contact {
  double t;  // time of the contact as a fraction of the motion; above 1: no contact
  uint ball, sphere;
};
layout(set = 0, binding = 0, std430) readonly buffer Spheres { Sphere spheres[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Results { Contact results[]; };

shared Contact best[64];

// Returns true if contact a counts as earlier than contact b. Of simultaneous contacts, the contact with the lowest
// ball index, then with the lowest sphere index, counts as the earliest.
bool before(Contact a, Contact b) {
  return a.t != b.t ? a.t < b.t : a.ball != b.ball ? a.ball < b.ball : a.sphere < b.sphere;
}

// Same as contact_time() of sphere_pair.h. Returns 2 if the spheres do not touch during the motion.
double contact_time(dvec3 D, dvec3 m, double R) {
  double nearing = dot3(m, D);
  precise double cx = m.y * D.z - m.z * D.y, cy = m.z * D.x - m.x * D.z, cz = m.x * D.y - m.y * D.x;
  precise double square = R * R;
  precise double discriminant = dot3(m, m) * square - (cx * cx + cy * cy + cz * cz);
  precise double apart = dot3(D, D) - square;
  precise double sum = nearing + sqrt(discriminant < 0.0LF ? 0.0LF : discriminant);
  precise double root = (apart < 0.0LF ? 0.0LF : apart) / (nearing > 0.0LF ? sum : 1.0LF);
  bool touches = nearing > 0.0LF && (apart <= 0.0LF || discriminant >= 0.0LF) && root <= 1.0LF;
  return touches ? root : 2.0LF;
}

void main() {
  Contact own = Contact(2.0LF, 0xffffffffu, 0xffffffffu);
  uint stride = gl_NumWorkGroups.x * 64u;
  for (uint i = gl_GlobalInvocationID.x; i < pass.spheres; i += stride) {
    if (!may_be_near(i)) continue;
    Sphere s = spheres[i];
    double r = tree_radius(s);
    if (!(r > 0.0LF)) continue;
    dvec3 center = center_of(s);
    for (uint k = 0u; k < pass.balls; ++k) {
      Ball ball = balls[k];
      precise double reach = r + ball.r;
      double t = contact_time(minus(center, dvec3(ball.ax, ball.ay, ball.az)), dvec3(ball.bx, ball.by, ball.bz), reach);
      Contact found = Contact(t, k, i);
      if (t <= 1.0LF && before(found, own)) own = found;
    }
  }
  uint lane = gl_LocalInvocationID.x;
  best[lane] = own;
  barrier();
  for (uint half_lanes = 32u; half_lanes > 0u; half_lanes /= 2u) {
    if (lane < half_lanes && before(best[lane + half_lanes], best[lane])) best[lane] = best[lane + half_lanes];
    barrier();
  }
  if (lane == 0u) results[gl_WorkGroupID.x] = best[0];
}
