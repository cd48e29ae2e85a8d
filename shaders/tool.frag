#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "lighting.glsl"
#include "metal.glsl"

layout(location = 0) in vec3 in_position;
layout(location = 1) in vec4 in_normal;
layout(location = 2) in vec4 in_color;
layout(location = 3) in vec3 in_look;
layout(location = 4) in vec2 in_light;
layout(location = 0) out vec4 out_color;

// Polished metal lit by the room. The tissue casts shadows on it. It casts no shadow on itself.
void main() {
  // A partly transparent tool is dithered by interleaved gradient noise (Jimenez 2014), so that its triangles need no
  // sorting.
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  if (noise < object.view.y) discard;
  vec3 n = normalize(in_normal.xyz);
  vec3 v = normalize(frame.eye[VIEW].xyz - in_position);
  float rough = in_look.x;
  vec2 light = kLightPerVertex ? in_light : tissue_visibility(in_position + 0.3e-3 * frame.key.xyz, n);
  vec3 r = reflect(-v, n);
  vec3 color = in_color.rgb * (metal_room(r, rough) + 0.10 * frame.key.w * max(dot(n, frame.key.xyz), 0.0));
  vec3 h = normalize(frame.key.xyz + v);
  float a = rough * rough, d = pow(max(dot(n, h), 0.0), 2.0) * (a * a - 1.0) + 1.0;
  color += in_color.rgb * frame.key.w * 0.10 * a * a / (d * d) / max(a, 0.05);
  color *= mix(0.45, 1.0, light.x) * mix(0.5, 1.0, light.y);
  out_color = vec4(tone_map(color), 1.0);
}
