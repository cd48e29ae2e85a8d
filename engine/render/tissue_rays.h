// Rays and random walks of the light inside tissue, in one source for C++ (TissueRays in tissue_light.cpp) and for
// compute shaders (shaders/tissue_rays.glsl). No include guard: C++ includes it inside a struct. Before the inclusion,
// both sides declare the variables `pass`, `distances`, `elements`, `steps`, `arrivals` and `met`, and the functions
// `element_in`, `hard`, `clear_of`, `far_lamp` and `far_light`. Positions q are in cells.

/// Returns a number x with 0 <= x < 1.
float fraction_of(uint bits) {
  return float(bits >> 8) / 16777216.0f;
}
/// Returns three random numbers for three numbers (pcg3d of Jarzynski & Olano 2020, Hash Functions for GPU Rendering).
uvec3 random_of(uint x, uint y, uint z) {
  uvec3 v = uvec3(x, y, z) * 1664525u + 1013904223u;
  v.x += v.y * v.z;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v = v ^ (v >> 16u);
  v.x += v.y * v.z;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  return v;
}

/// Returns a unit vector that is perpendicular to n.
vec3 beside(vec3 n) {
  return normalize(cross(abs(n.x) < 0.8f ? vec3(1, 0, 0) : vec3(0, 1, 0), n));
}
/// Returns a direction around n with a density that is proportional to its cosine. s: 0..1
vec3 cosine_direction(vec3 n, vec2 s) {
  const vec3 a = beside(n), b = cross(n, a);
  const float r = sqrt(s.x), turn = 6.28318531f * s.y;
  return r * cos(turn) * a + r * sin(turn) * b + sqrt(max(1.0f - s.x, 0.0f)) * n;
}
/// Returns point i of a sequence that fills the unit square evenly (Roberts 2018, R2), moved by `start`.
vec2 spread(int i, vec2 start) {
  const vec2 p = start + vec2(0.7548776662f, 0.5698402910f) * float(i);
  return p - floor(p);
}

int cell_index(ivec3 i) {
  return (i.x * pass.size.y + i.y) * pass.size.z + i.z;
}
/// Returns the cell below the point q that has neighbours above it. The limits make q positive, so the conversion
/// rounds down.
ivec3 cell_below(vec3 q) {
  return ivec3(min(max(vec3(0.0f), q), vec3(ivec3(pass.size) - 2)));
}
/// Returns the cell with the centre nearest to q.
ivec3 cell_nearest(vec3 q) {
  const vec3 inside = min(max(vec3(0.0f), q), vec3(ivec3(pass.size) - 1));
  const ivec3 below = ivec3(inside);
  return below + ivec3(greaterThanEqual(inside - vec3(below), vec3(0.5f)));
}
/// Returns the distance (m) to the nearest surface at q, interpolated between the cells.
float distance_at(vec3 q) {
  const ivec3 low = cell_below(q);
  const vec3 f = clamp(q - vec3(low), 0.0f, 1.0f);
  const int at = cell_index(low), dy = pass.size.z, dx = pass.size.y * pass.size.z;
  const float a0 = distances[at], b0 = distances[at + dy], c0 = distances[at + dx], d0 = distances[at + dx + dy];
  const float a = a0 + f.z * (distances[at + 1] - a0), b = b0 + f.z * (distances[at + dy + 1] - b0);
  const float c = c0 + f.z * (distances[at + dx + 1] - c0), d = d0 + f.z * (distances[at + dx + dy + 1] - d0);
  const float ab = a + f.y * (b - a), cd = c + f.y * (d - c);
  return ab + f.x * (cd - ab);
}
bool in_box(vec3 q) {
  const vec3 last = vec3(ivec3(pass.size) - 1);
  return q.x >= 0.0f && q.y >= 0.0f && q.z >= 0.0f && q.x <= last.x && q.y <= last.y && q.z <= last.z;
}

/// Returns the squared distance (m²) from p (m, frame W) to an element.
float squared_distance(int element, vec3 p) {
  const vec3 apart = vec3(elements[element].p) - p;
  return dot(apart, apart);
}
/// Returns the element at a point of the surface, or kNone if no surface is within the larger of kSearched and a cell
/// edge.
int element_at(vec3 q) {
  const float spacing = pass.origin.w, reach = max(kSearched, spacing), most = reach * reach;
  const vec3 p = vec3(pass.origin) + spacing * q;
  const int found = element_in(cell_index(cell_nearest(q)));
  if (found >= 0 && squared_distance(found, p) < most) return found;
  const ivec3 low = cell_below(q);
  for (int k = 0; k < 8; ++k) {
    const int other = element_in(cell_index(low + ivec3(k & 1, (k >> 1) & 1, k >> 2)));
    if (other >= 0 && squared_distance(other, p) < most) return other;
  }
  // The sign of some cells is wrong, for example beside a folded triangle. A ray or walk that ends there ends at the
  // nearest surface instead, so that its light is not lost.
  int best = kNone;
  const int farthest = int(ceil(kSearched / spacing));
  for (int around = 1; best == kNone && around <= farthest; ++around) {
    const ivec3 lo = max(low - around, ivec3(0)), hi = min(low + 1 + around, ivec3(pass.size) - 1);
    float least = most;
    for (int x = lo.x; x <= hi.x; ++x)
      for (int y = lo.y; y <= hi.y; ++y)
        for (int z = lo.z; z <= hi.z; ++z) {
          const int other = element_in(cell_index(ivec3(x, y, z)));
          if (other < 0) continue;
          const float d = squared_distance(other, p);
          if (d < least) {
            least = d;
            best = other;
          }
        }
  }
  return best;
}

/// Returns the distance (m) from q along a direction to the border of the box.
float way_to_border(vec3 q, vec3 direction) {
  float way = 1e9f;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0f) continue;
    const float border = direction[axis] > 0.0f ? float(pass.size[axis] - 1) : 0.0f;
    way = min(way, (border - q[axis]) / direction[axis]);
  }
  return max(way, 0.0f) * pass.origin.w;
}
/// Follows a ray outside the bodies. `q`: start; on return, the end. Returns the element that the ray meets, or kFree
/// if it meets none within `longest` (m) or leaves the box.
int follow_outside(INOUT(vec3) q, vec3 direction, float longest) {
  const float spacing = pass.origin.w, all = min(longest, way_to_border(q, direction));
  const vec3 start = q, along = direction / spacing;
  for (float way = 0.0f; way < all;) {
    const float d = distance_at(q);
    if (d <= 0.0f) return element_at(q);
    float ahead = max(d, kMinStep);
    if (d >= pass.lamp.w) {
      const ivec3 block = ivec3(q) / kBlock;
      const int empty = clear_of((block.x * pass.blocks.y + block.y) * pass.blocks.z + block.z);
      ahead = max(ahead, float(kBlock * (empty - 1)) * spacing);
    }
    way += ahead;
    q = start + min(way, all) * along;
  }
  return kFree;
}

/// Computes the light that arrives at an element from the lamp and from outside the box, and the elements that its rays
/// to other surfaces meet, or kFree or kNone. `slot`: index in `arrivals`.
void gather(int element, int slot) {
  const float spacing = pass.origin.w;
  const vec3 p = vec3(elements[element].p), n = vec3(elements[element].n), to_lamp = vec3(pass.toward_lamp);
  const uvec3 random = random_of(uint(int(elements[element].cell)), kRandomOfRays, 0u);
  const vec2 first = vec2(fraction_of(random.x), fraction_of(random.y));
  const vec3 start = (p + n * (0.35f * spacing) - vec3(pass.origin)) / spacing;
  const float facing = dot(n, to_lamp);
  vec3 lamp = vec3(0.0f);
  if (facing > 0.0f) {
    const vec3 a = beside(to_lamp), b = cross(to_lamp, a);
    float seen = 0.0f;
    for (int k = 0; k < kLampRays; ++k) {
      const vec2 s = spread(k, first);
      const float r = pass.toward_lamp.w * sqrt(s.x), turn = 6.28318531f * s.y;
      const vec3 d = normalize(to_lamp + r * (cos(turn) * a + sin(turn) * b));
      vec3 q = start;
      if (follow_outside(q, d, 1.0f) == kFree) seen += far_lamp(q, d);
    }
    lamp = vec3(pass.lamp) * (facing * seen / float(kLampRays));
  }
  vec3 distant = vec3(0.0f);
  for (int k = 0; k < kSurfaceRays; ++k) {
    const vec3 d = cosine_direction(n, spread(k, first));
    vec3 q = start;
    const int end = follow_outside(q, d, kLongestRay);
    met[slot * kSurfaceRays + k] = end;
    if (end == kFree) distant += far_light(q, d);
  }
  arrivals[slot].lamp = vec4(lamp, 0.0f);
  arrivals[slot].outer = vec4(lamp + distant / float(kSurfaceRays), 0.0f);
}

/// Weights of the three colours in ten bits each, because a large grid has tens of millions of walks.
int packed_weight(vec3 weight) {
  const uvec3 parts = uvec3(min(weight, vec3(kMostWeight)) * (1023.0f / kMostWeight) + 0.5f);
  return int(parts.x | parts.y << 10u | parts.z << 20u);
}
/// Follows random walk k from an element until it leaves the tissue. Returns the element where it leaves, or kNone, and
/// its weight for each colour. One colour determines the steps; weights correct the others (Veach & Guibas 1995).
ivec2 walk(int element, int k) {
  const ivec2 lost = ivec2(kNone, 0);
  const vec3 path = vec3(elements[element].path), n = vec3(elements[element].n);
  if (path == vec3(0.0f)) return lost;
  const uint cell = uint(int(elements[element].cell));
  const bool from_hard = hard(int(cell));
  const float spacing = pass.origin.w;
  const vec3 albedo = vec3(elements[element].albedo);
  const float survives = max(max(albedo.x, albedo.y), albedo.z);
  const int leading = k % 3;
  const uvec3 of_element = random_of(cell, kRandomOfWalks, 0u);
  vec3 direction = cosine_direction(-n, spread(k, vec2(fraction_of(of_element.x), fraction_of(of_element.y))));
  uvec3 random = random_of(cell, uint(k), kRandomOfWalks);
  float free_paths = -log(1.0f - (float(k) + fraction_of(random.x)) / (float(pass.size.w) + 1e-4f));
  vec3 q = (vec3(elements[element].p) - n * (0.01f * spacing) - vec3(pass.origin)) / spacing;
  float d = distance_at(q), total = 0.0f;  // m; d: distance to the surface; total: length of the walk so far
  bool astray = false;  // true in a region that counts as outside, but has no surface nearby: its sign is wrong
  for (int scattered = 0; scattered < kMaxSteps; ++scattered) {
    const float left = free_paths * path[leading];
    // The first step leaves the surface, where the interpolated distance may not be negative yet. A walk that is
    // outside after a step has left the tissue before it could be scattered.
    int end = kNone;
    float done = 0.0f;
    for (;;) {
      if (d < 0.0f) {
        astray = false;
      } else if (!astray && (scattered > 0 || done > 0.25f * spacing)) {
        end = element_at(q);
        if (end != kNone) break;
        astray = true;
      }
      if (done >= left) break;
      const float ahead = min(max(-d, kMinStep), left - done);
      q += direction * (ahead / spacing);
      done += ahead;
      if (!in_box(q)) return lost;
      d = distance_at(q);
    }
    total += done;
    if (end != kNone) {
      if (hard(int(elements[end].cell)) != from_hard) return lost;
      // Probability density of this walk for each colour, relative to the largest one. Computed from logarithms,
      // because densities of long walks may exceed the range of float.
      vec3 density = float(scattered) * log(path[leading] / path) + (1.0f / path[leading] - 1.0f / path) * total;
      density = exp(density - max(max(density.x, density.y), density.z));
      const float mean = (density.x + density.y + density.z) / 3.0f;
      // The limits keep 0 out of pow() and of the division.
      const vec3 kept = max(albedo / max(survives, 1e-6f), vec3(1e-6f));
      return ivec2(end, packed_weight(pow(kept, vec3(float(scattered))) * density / mean));
    }
    // Light from a tooth into the gum counts as lost, because the gum absorbs most of it. Light from the gum into a
    // tooth counts only if it returns to the gum.
    if (from_hard) {
      const int here = cell_index(cell_nearest(q));
      if (!hard(here) && distances[here] < 0.0f) return lost;
    }
    random = random_of(cell, uint(k), uint(scattered));
    if (fraction_of(random.x) >= survives) return lost;
    direction = vec3(steps[random.y >> kStepShift]);
    free_paths = steps[random.z >> kStepShift].w;
  }
  return lost;
}
