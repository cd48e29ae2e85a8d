// The film of water and slurry on the surfaces, and its effect on the appearance of the tissue below. Include after
// frame.glsl.

// false: the picture has no film, and the shader is compiled without the film's code
layout(constant_id = 9) const bool kFilm = false;
layout(set = 0, binding = 4) uniform sampler3D film_grid;

/// Returns the film at a point: x: water, 1 − exp(−height / 80 µm); y: opacity of the solids; z: colour of the solids,
/// 0 enamel, 0.5 dentin, 1 caries; w: blood. Zero outside the grid.
vec4 film_at(vec3 world) {
  // position in samples; the image's first axis is z
  vec3 q = (world - frame.film_origin.xyz) * frame.film_origin.w + 0.5;
  return textureLod(film_grid, (q / frame.film_size.xyz).zyx, 0.0);
}

/// Returns the fraction of a surface that the film makes smooth and shiny. A few micrometres of water are enough.
float wetness(vec4 film) { return smoothstep(0.01, 0.12, film.x); }

/// Changes colour and look of a surface below the film. Water makes it smooth and slightly darker; solids cover it with
/// their colour, milky if wet, matt if dry. `look`: roughness, dry reflectance, wetness, translucency.
void cover_with_film(vec4 film, inout vec3 color, inout vec4 look) {
  vec3 cream = mix(frame.tissue_color[2].rgb, vec3(0.90, 0.84, 0.70), 0.5);
  vec3 white = mix(frame.tissue_color[1].rgb, vec3(0.95), 0.6);
  vec3 brown = mix(frame.tissue_color[3].rgb, cream, 0.3);  // brown of carious powder, which is paler than the tissue
  vec3 solids = film.z < 0.5 ? mix(white, cream, 2.0 * film.z) : mix(cream, brown, 2.0 * film.z - 1.0);
  solids = mix(solids, vec3(0.30, 0.012, 0.014), film.w);
  float wet = wetness(film);
  color = mix(color, solids, film.y) * mix(1.0, 0.86, film.x);
  look.x = mix(mix(look.x, 0.95, film.y), 0.05, wet);
  look.z = mix(mix(look.z, 0.0, film.y), 1.0, wet);
  look.w *= 1.0 - 0.8 * film.y;
}

/// Returns the normal of the film: deep water has a level surface. Gravity points along −z of the workbench.
vec3 film_normal(vec4 film, vec3 n) {
  float deep = smoothstep(0.75, 0.98, film.x) * max(n.z, 0.0);
  return normalize(mix(n, vec3(0.0, 0.0, 1.0), 0.85 * deep));
}
