#version 460
layout(location = 0) in vec2 in_corner;
layout(location = 1) in vec4 in_color;
layout(location = 0) out vec4 out_color;

void main() {
  float r2 = dot(in_corner, in_corner);
  if (r2 > 1.0) discard;
  // Chips are small lit balls. Mist becomes fainter towards its edge.
  float chip = step(0.6, in_color.a);
  float alpha = in_color.a * mix((1.0 - r2) * (1.0 - r2), smoothstep(1.0, 0.7, r2), chip);
  float light = mix(1.0, 0.55 + 0.45 * sqrt(1.0 - r2), chip);
  out_color = vec4(in_color.rgb * light * alpha, alpha);
}
