// Surface of gum and of the matter of engine/render/drawn_matter.h, in pictures that are lit per pixel. Needs layer(),
// noise() and bumped().
const uint kGingiva = 7u, kTongue = 11u, kSkin = 12u, kRubber = 13u, kAcrylic = 14u, kPlastic = 15u;

/// Returns fine blood vessels, 0..1: thin bright lines of a noise function.
float vessels(vec3 p) {
  float a = abs(noise(p * 900.0) - 0.5), b = abs(noise(p * 2100.0 + 7.0) - 0.5);
  return max(1.0 - a / 0.05, 0.0) * 0.7 + max(1.0 - b / 0.06, 0.0) * 0.3;
}

/// Returns the normal of a surface with dimples like orange peel: one in each cell of a cubic grid, reaching at most
/// into the next cell. `spacing`: m, edge of a cell; `tilt`: steepest slope, rad.
vec3 dimpled(vec3 n, vec3 p, float spacing, float tilt) {
  vec3 q = p / spacing, first = floor(q - 0.5), slope = vec3(0);
  for (int z = 0; z < 2; ++z) {
    vec4 a = layer(first + 0.37, z), b = layer(first + 17.37, z), c = layer(first + 41.37, z);
    vec4 radius = 0.28 + 0.22 * fract(a * 7.0), height = 0.4 + 0.6 * fract(b * 7.0);
    for (int i = 0; i < 4; ++i) {
      vec3 cell = first + vec3(i & 1, i >> 1, z);
      vec3 from = (q - cell - 0.5 - 0.5 * (vec3(a[i], b[i], c[i]) - 0.5)) / radius[i];
      slope += max(1.0 - dot(from, from), 0.0) * height[i] * from;
    }
  }
  // A dimple of depth (1 - d²)² is steepest where (1 - d²) d = 0.385.
  return normalize(n - tilt / 0.385 * (slope - n * dot(n, slope)));
}

/// Returns the visibility 0..1 of the short red fibres in denture acrylic. Each cell of a cubic grid has one straight
/// fibre, which reaches at most into the next cell. `n`: normal.
float fibres(vec3 p, vec3 n) {
  const float spacing = 1.3e-3;  // m, edge of a cell
  const float half_length = 0.38, half_width = 0.028, deepest = 0.3;  // cells
  vec3 q = p / spacing, first = floor(q - 0.5);
  float seen = 0.0;
  for (int z = 0; z < 2; ++z) {
    vec4 a = layer(first + 5.71, z), b = layer(first + 23.71, z), c = layer(first + 47.71, z);
    for (int i = 0; i < 4; ++i) {
      vec3 from = q - first - vec3(i & 1, i >> 1, z) - 0.5 - 0.2 * (vec3(b[i], c[i], a[i]) - 0.5);
      vec3 along = normalize(vec3(a[i], b[i], c[i]) - 0.5 + 1e-3);
      float deep = dot(n, from);
      from -= n * deep;
      along -= n * dot(n, along);
      from -= clamp(dot(from, along) / max(dot(along, along), 1e-4), -half_length, half_length) * along;
      seen = max(seen, (1.0 - smoothstep(0.5 * half_width, half_width, length(from))) *
                           (1.0 - smoothstep(0.0, deepest, abs(deep))));
    }
  }
  return seen;
}

/// Changes the colour, the surface's normal and the wet film's normal. The colour texture has the mean factor 1;
/// tests/reference/draw.py has a copy of it. `p`: m, mesh frame; `mobile`: fraction of mucosa.
void soft_surface(uint matter, vec3 p, float mobile, inout vec3 color, inout vec3 n, inout vec3 gloss_normal) {
  vec3 smooth_normal = n;
  if (matter == kGingiva) {
    // Attached gum is stippled like orange peel. Mucosa is smooth, and vessels are visible in it.
    float attached = 1.0 - smoothstep(0.2, 0.6, mobile);
    color *= mix(vec3(0.93, 0.83, 0.86), vec3(1.07, 1.17, 1.14), noise(p * 420.0));
    if (attached < 1.0) color *= mix(vec3(1.0), vec3(0.90, 0.62, 0.62), 0.25 * (1.0 - attached) * vessels(p));
    if (attached > 0.0) n = dimpled(smooth_normal, p, 0.5e-3, 0.13 * attached);
    gloss_normal = bumped(n, p, 1.1e-3, 0.06);
  } else if (matter == kMucosa) {
    color *= mix(vec3(0.93, 0.84, 0.84), vec3(1.05, 1.06, 1.05), noise(p * 260.0));
    gloss_normal = bumped(smooth_normal, p, 1.6e-3, 0.12);
  } else if (matter == kTongue) {
    // Papillae: pale grains, with redder grains between them.
    float grain = noise(p * 3300.0);
    color *= mix(vec3(0.80, 0.66, 0.66), vec3(1.10, 1.08, 1.07), grain);
    color *= mix(vec3(1.0), vec3(0.96, 0.76, 0.74), smoothstep(0.70, 0.95, noise(p * 1100.0)));
    n = bumped(smooth_normal, p, 0.40e-3, 0.30);
    gloss_normal = bumped(smooth_normal, p, 0.45e-3, 0.28);
  } else if (matter == kSkin) {
    color *= 0.96 + 0.08 * noise(p * 500.0);
    n = bumped(smooth_normal, p, 0.5e-3, 0.02);
    gloss_normal = n;
  } else if (matter == kAcrylic) {
    // Denture acrylic has fine red fibres.
    color *= mix(vec3(1.0), vec3(0.80, 0.36, 0.40), 0.8 * fibres(p, smooth_normal));
    gloss_normal = bumped(smooth_normal, p, 2.0e-3, 0.03);
  }
}
