// Rays between bodies, in one source for C++ (BodyRays in light_scene.cpp) and for a compute shader
// (shaders/body_rays.comp). No include guard: C++ includes it inside a struct. Before the inclusion, both sides declare
// the arrays `nodes` (a bounding volume hierarchy, from its root) and `surfaces` (the triangles of its leaves).

/// Returns the distance at which a ray enters a node's box; kMissed if it misses the box.
float entry(int node, vec3 from, vec3 inverse) {
  const vec3 a = (nodes[node].lo - from) * inverse, b = (nodes[node].hi - from) * inverse;
  const vec3 first = min(a, b), last = max(a, b);
  const float begin = max(max(first.x, first.y), max(first.z, 0.0f)), end = min(min(last.x, last.y), last.z);
  return begin <= end ? begin : kMissed;
}
/// Intersects a ray with a triangle (Möller & Trumbore 1997). Returns true if the triangle is nearer than `hit`, and
/// updates `hit`.
bool meet(int surface, vec3 from, vec3 direction, INOUT(RayHit) hit) {
  const vec3 along = vec3(surfaces[surface].along), beside = vec3(surfaces[surface].beside);
  const vec3 p = cross(direction, beside);
  const float d = dot(along, p);
  if (d == 0.0f) return false;
  const vec3 s = from - surfaces[surface].corner;
  const float u = dot(s, p) / d;
  if (u < 0.0f || u > 1.0f) return false;
  const vec3 q = cross(s, along);
  const float v = dot(direction, q) / d;
  if (v < 0.0f || u + v > 1.0f) return false;
  const float distance = dot(beside, q) / d;
  if (distance <= 0.0f || distance >= hit.distance) return false;
  hit.met = d < 0.0f ? kBack : surfaces[surface].triangle;
  hit.distance = distance;
  return true;
}
/// Returns where a ray ends: at the first triangle that it meets; with `any`, at the triangle that is found first.
RayHit first_hit(vec3 from, vec3 direction, bool any) {
  vec3 inverse;
  for (int axis = 0; axis < 3; ++axis) inverse[axis] = 1.0f / (direction[axis] == 0.0f ? 1e-20f : direction[axis]);
  RayHit hit;
  hit.met = kNothing;
  hit.distance = kMissed;
  int waiting[kRayDepth];
  float begins[kRayDepth];  // distance at which the ray enters the box of each waiting node
  int count = 1;
  waiting[0] = 0;
  begins[0] = entry(0, from, inverse);
  while (count > 0) {
    --count;
    if (begins[count] >= hit.distance) continue;
    const int node = waiting[count], next = nodes[node].next, leaf = nodes[node].count;
    if (leaf > 0) {
      for (int k = next; k < next + leaf; ++k)
        if (meet(k, from, direction, hit) && any) return hit;
      continue;
    }
    // The child that is nearer to the ray's start is visited first, so it is stored last.
    const float a = entry(node + 1, from, inverse), b = entry(next, from, inverse);
    const bool swapped = a > b;
    const float near = swapped ? b : a, far = swapped ? a : b;
    if (far < hit.distance) {
      waiting[count] = swapped ? node + 1 : next;
      begins[count++] = far;
    }
    if (near < hit.distance) {
      waiting[count] = swapped ? next : node + 1;
      begins[count++] = near;
    }
  }
  return hit;
}
