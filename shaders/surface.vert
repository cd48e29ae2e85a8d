#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "lighting.glsl"


layout(location = 0) in vec3 in_position;
layout(location = 1) in vec4 in_normal;  // w: occlusion
layout(location = 2) in vec4 in_color;   // sRGB; w: translucency
layout(location = 3) in vec4 in_look;    // roughness, metal, wetness

layout(location = 0) out vec3 out_position;
layout(location = 1) out vec4 out_normal;
layout(location = 2) out vec4 out_color;
layout(location = 3) out vec3 out_look;
layout(location = 4) out vec2 out_light;

void main() {
  vec4 p = vec4(in_position, 1.0);
  vec3 world = vec3(dot(object.world_row[0], p), dot(object.world_row[1], p), dot(object.world_row[2], p));
  vec3 n = vec3(dot(object.world_row[0].xyz, in_normal.xyz), dot(object.world_row[1].xyz, in_normal.xyz),
                dot(object.world_row[2].xyz, in_normal.xyz));
  gl_Position = frame.clip_from_world[VIEW] * vec4(world, 1.0);
  out_position = world;
  out_normal = vec4(n, in_normal.w);
  out_color = vec4(pow(in_color.rgb, vec3(2.2)), in_color.a);
  out_look = in_look.xyz;
  out_light = kLightPerVertex ? visibility(world, n) : vec2(1.0);
}
