// The film of water and slurry on the surfaces: how it changes the look of the tissue below. Include after frame.glsl.

layout(constant_id = 9) const bool kFilm = false;  // false: the picture has no film, and its code is compiled out
layout(set = 0, binding = 4) uniform sampler3D film_grid;

/// The film at a point: x: water, 1 − exp(−height / 80 µm); y: opacity of the solids; z: their colour, 0 enamel,
/// 0.5 dentin, 1 caries; w: blood. Zero outside the grid.
vec4 film_at(vec3 world) {
  vec3 q = (world - frame.film_origin.xyz) * frame.film_origin.w + 0.5;  // in samples; texels have z first
  return textureLod(film_grid, (q / frame.film_size.xyz).zyx, 0.0);
}

/// Water makes a surface smooth and slightly darker, because light is reflected inside the film. Solids cover it with
/// their own colour: milky while wet, matt when dry. `look`: roughness, metal, wetness, translucency.
void cover_with_film(vec4 film, inout vec3 color, inout vec4 look) {
  vec3 cream = mix(frame.tissue_color[2].rgb, vec3(0.90, 0.84, 0.70), 0.5);
  vec3 white = mix(frame.tissue_color[1].rgb, vec3(0.95), 0.6);
  vec3 brown = mix(frame.tissue_color[3].rgb, cream, 0.3);  // powder is paler than the tissue
  vec3 solids = film.z < 0.5 ? mix(white, cream, 2.0 * film.z) : mix(cream, brown, 2.0 * film.z - 1.0);
  solids = mix(solids, vec3(0.30, 0.012, 0.014), film.w);
  float wet = smoothstep(0.01, 0.12, film.x);  // a few micrometres of water already shine
  color = mix(color, solids, film.y) * mix(1.0, 0.86, film.x);
  look.x = mix(mix(look.x, 0.95, film.y), 0.05, wet);
  look.z = mix(mix(look.z, 0.0, film.y), 1.0, wet);
  look.w *= 1.0 - 0.8 * film.y;
}

/// Normal of the film: deep water has a level surface. Gravity points along −z of the workbench.
vec3 film_normal(vec4 film, vec3 n) {
  float deep = smoothstep(0.75, 0.98, film.x) * max(n.z, 0.0);
  return normalize(mix(n, vec3(0.0, 0.0, 1.0), 0.85 * deep));
}
