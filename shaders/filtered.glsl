// Specular anti-aliasing for fragment shaders. Include after lighting.glsl.

/// Returns the squared GGX width (alpha²) of a highlight. It is widened by the change of the normal within a pixel, so
/// that the highlight covers whole pixels (Tokuyoshi & Kaplanyan 2019, eq. 14, isotropic).
float filtered_width(float width, vec3 n) {
  vec3 dx = dFdx(n), dy = dFdy(n);
  float variance = 0.15915494 * (dot(dx, dx) + dot(dy, dy));
  return min(width + min(2.0 * variance, 0.18), 1.0);
}
