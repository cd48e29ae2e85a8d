// Surface of gum and of the matter of engine/render/drawn_matter.h, in pictures that are lit per pixel. Needs noise() and
// bumped().
const uint kGingiva = 7u, kMucosa = 10u, kTongue = 11u, kSkin = 12u, kRubber = 13u, kAcrylic = 14u, kPlastic = 15u;

/// Returns fine blood vessels, 0..1: thin bright lines of a noise function.
float vessels(vec3 p) {
  float a = abs(noise(p * 900.0) - 0.5), b = abs(noise(p * 2100.0 + 7.0) - 0.5);
  return max(1.0 - a / 0.05, 0.0) * 0.7 + max(1.0 - b / 0.06, 0.0) * 0.3;
}

/// Returns the depth, 0..1, of pits like those of orange peel. `q`: position in units of a pit's size.
float pit(vec3 q) { return smoothstep(0.58, 0.86, noise(q)); }
/// Returns the normal of a surface with pits. `size`: m, width of a pit; `tilt`: slope of its edge, rad.
vec3 pitted(vec3 n, vec3 p, float size, float tilt) {
  vec3 q = p / size;
  float here = pit(q);
  vec3 slope = here - vec3(pit(q + vec3(0.25, 0, 0)), pit(q + vec3(0, 0.25, 0)), pit(q + vec3(0, 0, 0.25)));
  return normalize(n - tilt * (slope - n * dot(n, slope)) / 0.25);
}

/// Changes the colour, the normal of the surface and the normal of the wet film. `p`: m, position in the mesh's frame;
/// `mobile`: fraction of mucosa in the gum, 0..1.
void soft_surface(uint matter, vec3 p, float mobile, inout vec3 color, inout vec3 n, inout vec3 gloss_normal) {
  vec3 smooth_normal = n;
  if (matter == kGingiva) {
    // Attached gum is stippled like orange peel. Mucosa is smooth, and vessels are visible in it.
    float attached = 1.0 - smoothstep(0.2, 0.6, mobile);
    color *= mix(vec3(0.92, 0.78, 0.80), vec3(1.06, 1.09, 1.07), noise(p * 420.0));
    if (attached < 1.0) color *= mix(vec3(1.0), vec3(0.90, 0.62, 0.62), 0.25 * (1.0 - attached) * vessels(p));
    n = pitted(smooth_normal, p, 0.30e-3, 0.08 * attached);
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
    color *= mix(vec3(1.0), vec3(0.86, 0.50, 0.52), 0.5 * max(1.0 - abs(noise(p * vec3(2600.0, 900.0, 2600.0)) - 0.5) / 0.035, 0.0));
    gloss_normal = bumped(smooth_normal, p, 2.0e-3, 0.03);
  }
}
