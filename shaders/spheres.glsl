// The spheres of a tissue and the geometry of two spheres. Same computation as in haptics/contact/packing:
// sphere_pair.h, sphere_tissue.cpp. Every operation has the same order as there and is `precise`, so that a device with
// IEEE doubles gives the same bits.

// Same layout as CutSphere in haptics/sphere_passes.h.
struct Sphere {
  double bx, by, bz, base_radius, volume, ax, ay, az, overlap, tool, whole_radius, whole_volume;
};
// A ball of the tool with the radius r. It moves from a to b; in pass 1, b is the displacement from a instead. Only
// spheres near the line from a to n are examined; n lies at b or beyond it.
struct Ball {
  double ax, ay, az, bx, by, bz, nx, ny, nz, r, curve;
};
struct Overlap {
  uint ball, sphere;
  double volume;
};
layout(push_constant) uniform Pass {
  vec4 around;  // ball around the tool's whole motion; xyz: centre relative to the origin, m; w: radius, m
  double ox, oy, oz;  // m, W, origin of the positions in single precision
  float rounding_margin;  // m, increase of the bounds that covers the rounding of single precision
  uint spheres, balls;
  uint capacity;  // largest number of results in the list
  uint printed;        // 1: the volumes are computed by eq. 6 exactly as printed in S2
} pass;
// xyz: centre relative to the origin, m; w: radius plus slack, m, negative if the sphere has disappeared
layout(set = 0, binding = 1, std430) buffer Bounds { vec4 bounds[]; };
layout(set = 0, binding = 2, std430) readonly buffer Balls { Ball balls[]; };

const double kPi = 3.14159265358979323846LF;
const double kMin = 1e-3LF;
const double kSameSide = 0.5LF;
const double kTouching = 1e-13LF;

// Returns false only if the sphere cannot come near any ball of the tool.
bool may_be_near(uint i) {
  vec4 b = bounds[i];
  float reach = b.w + pass.around.w;
  vec3 off = b.xyz - pass.around.xyz;
  return b.w >= 0.0 && dot(off, off) <= reach * reach;
}

double radius_of(Sphere s) {
  precise double left = s.base_radius - 0.5LF * s.overlap;
  return left > 0.0LF ? left : 0.0LF;
}
// Returns the sphere's radius as the CPU's search tree stores it: 0 if the sphere has disappeared.
double tree_radius(Sphere s) {
  double r = radius_of(s);
  precise double least = kMin * s.base_radius;
  return r > least ? r : 0.0LF;
}
dvec3 center_of(Sphere s) {
  precise double half_overlap = 0.5LF * s.overlap;
  precise double x = s.bx + half_overlap * s.ax, y = s.by + half_overlap * s.ay, z = s.bz + half_overlap * s.az;
  return dvec3(x, y, z);
}
double dot3(dvec3 a, dvec3 b) {
  precise double d = a.x * b.x + a.y * b.y + a.z * b.z;
  return d;
}
dvec3 minus(dvec3 a, dvec3 b) {
  precise dvec3 d = a - b;
  return d;
}

// Returns the point on the segment from a to b that is nearest to p.
dvec3 nearest_on(dvec3 a, dvec3 b, dvec3 p) {
  dvec3 ab = minus(b, a);
  double length2 = dot3(ab, ab);
  if (!(length2 > 0.0LF)) return a;
  precise double fraction = dot3(minus(p, a), ab) / length2;
  fraction = fraction < 0.0LF ? 0.0LF : fraction > 1.0LF ? 1.0LF : fraction;
  precise dvec3 at = a + fraction * ab;
  return at;
}

// Returns the volume of the overlap of two spheres (paper S2, eq. 2, with a correction).
double lens_volume(double r1, double r2, double d) {
  precise double reach = r1 + r2, off = r1 - r2;
  if (!(d < reach)) return 0.0LF;
  double least = r2 < r1 ? r2 : r1;
  if (d <= abs(off)) {
    precise double whole = 4.0LF / 3.0LF * kPi * least * least * least;
    return whole;
  }
  precise double depth = reach - d;
  precise double volume = kPi * depth * depth * (d * d + 2.0LF * d * reach - 3.0LF * off * off) / (12.0LF * d);
  return volume;
}

double ball_volume(double r) {
  precise double volume = 4.0LF / 3.0LF * kPi * r * r * r;
  return volume;
}
