#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "lighting.glsl"

const float kBrushed = 1.0;  // same value as in Finish (engine/render/tool_mesh.h)
const vec3 kSteel = vec3(0.56, 0.57, 0.58);  // reflectance of steel, as in tests/reference/tissues.json

layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
layout(location = 2) in vec3 in_hull_position;
layout(location = 3) in vec3 in_hull_normal;
// x: 1 if the vertex rotates with the spindle; y: roughness; z: 1 on a depth mark; w: Finish
layout(location = 4) in vec4 in_look;

layout(location = 0) out vec3 out_position;
layout(location = 1) out vec4 out_normal;
layout(location = 2) out vec4 out_color;
layout(location = 3) out vec3 out_look;  // x: roughness; y: Finish; z: blur
layout(location = 4) out vec2 out_light;
layout(location = 5) out vec3 out_place;  // m, position in the mesh

void main() {
  // At fast rotation the flutes are blurred into their hull. At slow rotation they are drawn as they turn.
  float blur = in_look.x * frame.tool_motion.y;
  vec3 m = mix(in_position, in_hull_position, blur), k = normalize(mix(in_normal, in_hull_normal, blur));
  float c = cos(in_look.x * frame.tool_motion.x), s = sin(in_look.x * frame.tool_motion.x);
  m.xy = vec2(c * m.x - s * m.y, s * m.x + c * m.y);
  k.xy = vec2(c * k.x - s * k.y, s * k.x + c * k.y);
  // Computes the size (m) of a pixel at the vertex, as in particle.vert. A neck is drawn at least one pixel wide,
  // because a thinner neck would have gaps.
  vec3 axis = vec3(object.world_row[0].z, object.world_row[1].z, object.world_row[2].z) * m.z +
              vec3(object.world_row[0].w, object.world_row[1].w, object.world_row[2].w);
  mat4 clip = frame.clip_from_world[VIEW];
  float least = 0.75 * frame.picture.x * (clip * vec4(axis, 1.0)).w / length(vec3(clip[0][0], clip[1][0], clip[2][0]));
  float radius = length(m.xy);
  if (radius > 0.0) m.xy *= max(least / radius, 1.0);
  vec4 p = vec4(m, 1.0);
  vec3 world = vec3(dot(object.world_row[0], p), dot(object.world_row[1], p), dot(object.world_row[2], p));
  gl_Position = frame.clip_from_world[VIEW] * vec4(world, 1.0);
  gl_ClipDistance[0] = dot(frame.clip, vec4(world, 1.0));
  out_position = world;
  out_normal = vec4(dot(object.world_row[0].xyz, k), dot(object.world_row[1].xyz, k), dot(object.world_row[2].xyz, k), 1.0);
  // The grooves between the blades are dark. If they are blurred by rotation, they darken the hull slightly and make it
  // rougher. Neck and shank are surfaces of revolution, which look the same when they rotate.
  if (in_look.w == kBrushed) blur = 0.0;
  float groove = length(in_hull_position - in_position) / max(length(in_hull_position.xy), 1e-6);
  float dark = mix(1.0 - clamp(3.0 * groove, 0.0, 0.55), 0.62, blur) * mix(1.0, 0.12, in_look.z);
  out_color = vec4(kSteel * dark, 0.0);
  out_look = vec3(mix(in_look.y, 0.38, blur), in_look.w, blur);
  out_place = in_hull_position;
  // Tissue casts shadows on the tool. The lookup is displaced towards the lamp, away from the touched surface.
  out_light = kLightPerVertex ? tissue_visibility(world + 0.3e-3 * frame.key.xyz, out_normal.xyz, 1.0).xy : vec2(1.0);
}
