#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "lighting.glsl"

layout(location = 0) in vec3 in_position;
layout(location = 1) in vec4 in_normal;   // w: difference, of its range
layout(location = 2) in uvec4 in_tissue;  // the two tissues, the second's share of 255, the one beneath and its share

layout(location = 0) centroid out vec3 out_position;
layout(location = 1) centroid out vec4 out_normal;
layout(location = 2) centroid out vec3 out_light;  // key, ambient; z: share of the second tissue
layout(location = 3) flat out uint out_pair;
layout(location = 4) centroid out vec3 out_mesh_position;
layout(location = 5) centroid out vec4 out_beneath;  // colour, times its share; the share

void main() {
  vec4 p = vec4(in_position, 1.0);
  vec3 world = vec3(dot(object.world_row[0], p), dot(object.world_row[1], p), dot(object.world_row[2], p));
  vec3 n = vec3(dot(object.world_row[0].xyz, in_normal.xyz), dot(object.world_row[1].xyz, in_normal.xyz),
                dot(object.world_row[2].xyz, in_normal.xyz));
  gl_Position = frame.clip_from_world[VIEW] * vec4(world, 1.0);
  gl_ClipDistance[0] = dot(frame.clip, vec4(world, 1.0));
  gl_ClipDistance[1] = dot(frame.section, vec4(world, 1.0));
  out_position = world;
  out_normal = vec4(n, in_normal.w);
  out_light = vec3(kLightPerVertex ? visibility(world, n) : vec2(1.0), float(in_tissue.z) / 255.0);
  out_pair = in_tissue.x | (in_tissue.y << 8);
  out_mesh_position = in_position;
  float shows = float(in_tissue.w >> 4) / 15.0;
  out_beneath = vec4(frame.tissue_color[in_tissue.w & 15u].rgb, 1.0) * shows;
}
