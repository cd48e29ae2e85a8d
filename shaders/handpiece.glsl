// Light that a handpiece reflects, computed per pixel or per vertex. Include after metal.glsl.

// false: the light is computed per vertex and there is no knurl, for pictures with few pixels
layout(constant_id = 6) const bool kPerPixel = true;

/// Returns the light that a handpiece reflects at p. `look`: roughness (not used), brushed, metal, glow.
vec3 handpiece_light(vec3 p, vec3 n, vec3 v, vec3 groove, float rough, float widened, vec4 look, vec3 albedo) {
  // Plastic reflects a twentieth of the light specularly and the rest diffusely.
  vec3 color = brushed_metal(p, n, v, groove, look.y, rough, widened, mix(vec3(0.05), albedo, look.z), 1.0);
  color += (1.0 - look.z) * albedo * (0.8 * frame.up.w + 0.3183 * frame.key.w * max(dot(n, frame.key.xyz), 0.0));
  return color + look.w * albedo;
}
