// Fine structure of tooth tissues, drawn where lighting is computed per pixel. Positions are in the tooth's own frame,
// whose z is the tooth's axis, so that the structure stays with the tooth.

// m, distance of the growth lines on the side of a crown; on real teeth 0.03 to 0.15 mm
const float kPerikymata = 0.10e-3;
const float kCrackSpacing = 2.6e-3;  // m, distance of microcracks, which run from the neck to the cusps
// m; cracks are thinner than a pixel, so they are drawn only if four pixels are narrower than this width
const float kCrackSeen = 0.12e-3;
// m, width of the bundles of enamel prisms that a cut shows (Hunter-Schreger bands)
const float kPrismStriae = 0.06e-3;
const float kFlute = 0.09e-3;  // m, width of the marks that the blades of a bur leave on a cut wall
// Reflectance of tubules that a cut has opened along their length. Its value is an estimate.
const float kTubules = 0.25;

/// Returns the tooth's axis in W, which is the z axis of the body.
vec3 object_axis() { return vec3(object.world_row[0].z, object.world_row[1].z, object.world_row[2].z); }

// Values 0..1 of the lattice points (x, y, z).
vec4 hash(vec4 x, vec4 y, vec4 z) {
  x = fract(x * 0.1031);
  y = fract(y * 0.1030);
  z = fract(z * 0.0973);
  vec4 sum = x + y, d = (2.0 * x * y + 33.33 * sum) + z * (z + 33.33);
  return fract((sum + 2.0 * d) * (z + d));
}
/// Returns the values at (0, 0), (1, 0), (0, 1) and (1, 1) of the layer z above p.
vec4 layer(vec3 p, float z) {
  return hash(p.x + vec4(0, 1, 0, 1), p.y + vec4(0, 0, 1, 1), vec4(p.z + z));
}
vec3 smoothed(vec3 f) { return f * f * (3.0 - 2.0 * f); }
float blend(vec4 corners, vec2 f) {
  vec2 line = mix(corners.xy, corners.zw, f.y);
  return mix(line.x, line.y, f.x);
}
float noise(vec3 p) {
  vec3 i = floor(p), f = smoothed(p - i);
  return blend(mix(layer(i, 0.0), layer(i, 1.0), f.z), f.xy);
}
/// Returns the normal of a surface with bumps from noise. `size`: width of the bumps, m; `tilt`: slope, rad.
vec3 bumped(vec3 n, vec3 p, float size, float tilt) {
  // Differences of noise() over `ahead` along each axis, from the cell and the next layer of lattice points per axis.
  const float ahead = 0.35;
  vec3 q = p / size, i = floor(q), f = smoothed(q - i), moved = q - i + ahead;
  vec3 next = step(1.0, moved), g = smoothed(moved - next);
  vec4 back = layer(i, 0.0), front = layer(i, 1.0), middle = mix(back, front, f.z);
  vec3 first = vec3(mix(middle.x, middle.z, f.y), mix(middle.x, middle.y, f.x), blend(back, f.xy));
  vec3 second = vec3(mix(middle.y, middle.w, f.y), mix(middle.z, middle.w, f.x), blend(front, f.xy));
  vec3 third = vec3(blend(hash(vec4(i.x + 2.0), i.y + vec4(0, 1, 0, 1), i.z + vec4(0, 0, 1, 1)), f.yz),
                    blend(hash(i.x + vec4(0, 1, 0, 1), vec4(i.y + 2.0), i.z + vec4(0, 0, 1, 1)), f.xz),
                    blend(layer(i, 2.0), f.xy));
  vec3 slope = mix(mix(first, second, next), mix(second, third, next), g) - mix(first, second, f);
  return normalize(n - tilt * (slope - n * dot(n, slope)) / ahead);
}
/// Returns the fraction of a structure of this period (m) that pixels of this size (m) can show: 1 if a period is at
/// least four pixels wide, 0 below two pixels. So fine structure disappears instead of flickering.
float resolved(float period, float pixel) { return smoothstep(2.0, 4.0, period / max(pixel, 1e-9)); }

/// Returns the colour of sound enamel, with stain in fissures and microcracks. Adds growth lines and ripples of the wet
/// film to the normal `n_gloss`. Cut enamel (`cut`: fraction) shows its prisms instead, as fine striae. `open`:
/// fraction of the room's light that arrives; `pixel`: size of a pixel on the surface, m.
vec3 enamel(vec3 color, vec3 p, vec3 n, float open, float pixel, float cut, inout vec3 n_gloss) {
  vec3 axis = object_axis();
  float along = dot(n, axis), side = 1.0 - along * along;
  if (cut > 0.5) {
    float stria = noise(vec3(p.xy / kPrismStriae, p.z / (8.0 * kPrismStriae)));
    return color * mix(1.0, 0.88 + 0.22 * stria, resolved(kPrismStriae, pixel));
  }
  n_gloss = bumped(n, p, 0.55e-3, 0.02);
  float line = p.z / kPerikymata + 0.6 * noise(p * 1800.0);
  float wave = cos(6.2831853 * line) * 0.035 * side * resolved(kPerikymata, pixel);
  n_gloss = normalize(n_gloss + wave * (axis - n * along));
  float groove = smoothstep(0.72, 0.25, open);
  color *= mix(vec3(1.0), vec3(0.78, 0.62, 0.42), groove);
  color *= 0.97 + 0.06 * noise(p * 900.0);
  // A crack is where a smooth function of the position crosses zero. It scatters light and looks slightly brighter.
  float field = noise(vec3(p.xy / kCrackSpacing, 0.25 * p.z / kCrackSpacing) + 7.0) - 0.5;
  float width = 1.5 * pixel / kCrackSpacing;
  float crack = (1.0 - smoothstep(0.5 * width, 1.5 * width, abs(field))) * smoothstep(0.45, 0.7, noise(p * 500.0 + 3.0));
  return color * (1.0 + 0.07 * crack * side * resolved(kCrackSeen, pixel));
}

/// Returns the colour of dentin. Cut dentin (`cut`: fraction) has a dull, uneven smear layer and fine ridges along the
/// bur's path. A natural surface is the cementum of a root: matt and finely grained.
vec3 dentin(vec3 color, vec3 p, vec3 n, float pixel, float cut, inout vec3 n_gloss, inout float rough) {
  if (cut < 0.5) {
    n_gloss = bumped(n, p, 0.20e-3, 0.05);
    return color * (0.90 + 0.10 * noise(p * 2200.0) + 0.06 * noise(p * 500.0));
  }
  vec3 axis = object_axis();
  float along = dot(n, axis), side = 1.0 - along * along;
  // On a wall, the ridges are level. On a floor, they run along the path of the bur, which bends slowly.
  float wall = p.z / kFlute, bend = 1.5 * noise(p * 700.0), floor_line = (0.8 * p.x + 0.6 * p.y) / kFlute;
  float ridge = cos(6.2831853 * (mix(floor_line, wall, smoothstep(0.3, 0.7, side)) + bend));
  float shown = resolved(kFlute, pixel) * (0.4 + 0.6 * noise(p * 1500.0));
  vec3 across = mix(vec3(0.8, 0.6, 0.0), axis, smoothstep(0.3, 0.7, side));
  n_gloss = normalize(n + 0.10 * shown * ridge * (across - n * dot(n, across)));
  float smear = noise(p * 1300.0);
  rough = mix(0.42, 0.70, smear);
  return color * (0.94 + 0.09 * smear) * (1.0 + 0.03 * shown * ridge);
}

/// Returns the lamp's light that the tubules of cut dentin reflect as a silky sheen. Approximation: the tubules run
/// along the tooth's axis. `rough`: see dentin(); `key`: fraction of the lamp's light that arrives.
vec3 tubule_sheen(vec3 p, vec3 n, vec3 v, float rough, float key) {
  vec3 bend = vec3(noise(p * 400.0), noise(p * 400.0 + 11.0), noise(p * 400.0 + 23.0)) - 0.5;
  vec3 along = normalize(object_axis() + 0.5 * bend);
  along -= n * dot(n, along);
  float lying = dot(along, along);  // squared sine of the angle between tubule and normal
  // Opened tubules are fine parallel grooves, which scatter light across themselves, as fibres do. A cut across the
  // tubules shows only their ends and has no sheen.
  float across = dot(along, normalize(frame.key.xyz + v));
  float lobe = max(1.0 - across * across / max(lying, 1e-4), 0.0);
  lobe *= lobe * lobe;
  lobe *= lobe;
  // The smear layer hides a part of the sheen.
  float clean = 1.0 - 0.5 * smoothstep(0.42, 0.70, rough);
  float lamp = key * max(dot(n, frame.key.xyz), 0.0) * frame.key.w * 0.3183;
  return (kTubules * lying * lobe * lobe * clean * lamp) * kLampColor;
}

/// Returns the colour of caries: light brown and leathery at its edge, dark, rough and crumbly where it is softest.
/// `inward`: fraction of caries around the point; `shows`: fraction of the lower tissue that is visible.
vec3 caries(vec3 color, vec3 p, float inward, float shows) {
  float grain = 0.65 * noise(p * 2600.0) + 0.35 * noise(p * 9000.0);
  float core = smoothstep(0.2, 1.0, inward - 0.7 * shows + 0.5 * (noise(p * 1400.0) - 0.5) + 0.2 * (grain - 0.5));
  return color * mix(vec3(2.4, 2.9, 3.4), vec3(0.7), core) * mix(0.8, 1.2, grain);
}

/// Returns the colour of living pulp: red with a net of darker vessels, bleeding where it is open, under a wet film.
vec3 pulp(vec3 color, vec3 p, vec3 n, inout vec3 n_gloss) {
  vec3 bend = vec3(noise(p * 1700.0), noise(p * 1700.0 + 9.0), noise(p * 1700.0 + 17.0));
  float vessels = 1.0 - smoothstep(0.0, 0.12, abs(noise(p * 2600.0 + 2.5 * bend) - 0.5));
  float blood = smoothstep(0.45, 0.70, noise(p * 900.0 + 5.0));
  n_gloss = bumped(n, p, 0.25e-3, 0.16);
  color *= mix(vec3(1.0), vec3(0.60, 0.30, 0.32), 0.6 * vessels);
  return mix(color, vec3(0.16, 0.008, 0.006), 0.55 * blood);
}

/// Returns the colour of dentin beside open pulp, which carries some blood of the pulp. `pulp`: fraction of pulp
/// around the point.
vec3 bloody(vec3 color, vec3 p, float pulp) {
  float stain = smoothstep(0.02, 0.45, pulp + 0.25 * (noise(p * 3000.0) - 0.5));
  return color * mix(vec3(1.0), vec3(0.55, 0.16, 0.13), 0.75 * stain);
}
