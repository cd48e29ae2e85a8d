#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "lighting.glsl"
#include "metal.glsl"
#include "filtered.glsl"

layout(location = 0) in vec3 in_position;
layout(location = 1) in vec4 in_normal;
layout(location = 2) in vec4 in_color;
layout(location = 3) in vec3 in_look;
layout(location = 4) in vec2 in_light;
layout(location = 0) out vec4 out_color;

layout(location = 5) in vec3 in_place;

// Same values as Finish in engine/render/tool_mesh.h.
const float kBrushed = 1.0, kGrit = 2.0;
const float kGrain = 0.10e-3;  // m, size of the diamond grains of a medium bur

vec3 hash3(vec3 p) {
  p = fract(p * vec3(0.1031, 0.1030, 0.0973));
  p += dot(p, p.yxz + 33.33);
  return fract((p.xxy + p.yxx) * p.zyx);
}

// Metal that the room lights. Tissue casts shadows on the tool; the tool casts no shadow on itself.
void main() {
  // A partly transparent tool is dithered by interleaved gradient noise (Jimenez 2014), so that its triangles need no
  // sorting.
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  if (noise < object.view.y) discard;
  vec3 n = normalize(in_normal.xyz);
  vec3 v = normalize(frame.eye[VIEW].xyz - in_position);
  vec3 axis = vec3(object.world_row[0].z, object.world_row[1].z, object.world_row[2].z);
  vec3 around = cross(axis, n);
  vec3 groove = normalize(around + 1e-4 * vec3(1.0, 0.7, 0.3));
  groove = normalize(groove - n * dot(n, groove));
  vec3 tint = in_color.rgb;
  if (in_look.y > 0.5 * (kBrushed + kGrit)) {
    // Diamonds in nickel: each grain has one facet with its own direction. Grains smaller than two pixels, and grains
    // blurred by rotation, only make the surface rougher.
    vec3 q = in_place / kGrain;
    float seen = (1.0 - smoothstep(0.25, 0.6, length(fwidth(q)))) * (1.0 - in_look.z);
    vec3 facet = hash3(floor(q));
    n = normalize(n + 1.1 * seen * (facet - 0.5));
    tint *= mix(1.0, mix(0.55, 1.25, facet.x), seen);
  }
  float brushed = abs(in_look.y - kBrushed) < 0.5 ? smoothstep(0.0, 0.3, length(around)) : 0.0;
  vec3 above = in_position + 0.3e-3 * frame.key.xyz;
  vec2 light = kLightPerVertex ? in_light : tissue_visibility(above, normalize(in_normal.xyz), 1.0).xy;
  // With a grid of light, the shadow hides only the lamp, because the grid contains the light of the surfaces nearby.
  float widened = filtered_width(0.0, n), key = kLightGrid ? light.x : 1.0;
  vec3 color = brushed_metal(in_position, n, v, groove, brushed, in_look.x, widened, tint, key);
  if (!kLightGrid) color *= mix(0.45, 1.0, light.x) * mix(0.5, 1.0, light.y);
  out_color = vec4(tone_map(color), 1.0);
}
