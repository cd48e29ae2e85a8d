// Colours of the view of temperature. Include after frame.glsl, lighting.glsl and cut_tissue.glsl.
layout(set = 0, binding = 8) uniform sampler3D temperature_grid;

const uint kCorticalBone = 5u, kCancellousBone = 6u;

/// Returns the temperature at a point, K above the body's; 0 without tissue nearby. The image's first axis is z.
float warming_at(vec3 world) {
  vec3 q = (world - frame.temperature_origin.xyz) * frame.temperature_origin.w + 0.5;
  vec2 sum = textureLod(temperature_grid, (q / frame.temperature_size.xyz).zyx, 0.0).xy;
  return sum.y > 1e-3 ? sum.x / sum.y : 0.0;
}

/// Returns the linear colour of a temperature, K above the body's (shared.h).
vec3 temperature_color(float warming) {
  float s = clamp(2.0 * warming / (warming < 0.0 ? kBody - kColdest : kHottest - kBody), -2.0, 2.0);
  vec3 middle = s < 0.0 ? kColdColor : kWarmColor, end = s < 0.0 ? kColdestColor : kHottestColor;
  vec3 c = abs(s) < 1.0 ? mix(kBodyColor, middle, abs(s)) : mix(middle, end, abs(s) - 1.0);
  return linear_light(c);
}

/// Returns the linear colour of working tissue. Black stripes: harmfully warm pulp or bone. `second`: fraction of
/// tissue b, the rest is tissue a. The pulp has a black outline.
vec3 temperature_picture(vec3 world, vec3 n, vec3 v, uint a, uint b, float second) {
  float warming = warming_at(world);
  // The face of the section shows the exact colours of the scale; other surfaces are darker at grazing angles.
  float shade = dot(n, frame.section.xyz) < -0.999 ? 1.0 : mix(0.6, 1.0, abs(dot(n, v)));
  vec3 color = shade * temperature_color(warming);
  uint tissue = second > 0.5 ? b : a;
  bool bone = tissue == kCorticalBone || tissue == kCancellousBone;
  if ((tissue == kPulp && warming > kPulpHarm) || (bone && warming > kBoneHarm))
    color *= step(0.35, fract(dot(world, vec3(1.0, 0.4, 1.0)) / 0.5e-3));
  if (a != b && (a == kPulp || b == kPulp))
    color *= smoothstep(1.0, 2.0, abs(second - 0.5) / max(fwidth(second), 1e-5));
  return color;
}
